"""--module NAME: a person's word for this conversation, refused where something speaks against it."""

import argparse

from app.modules.names import Remembered, remembered, what_speaks_against
from app.store.fact_store import Facts
from app.terminal.command_journal import Records
from app.terminal.connection import OpenPort
from app.terminal.console import Refused, note, notify
from app.text.i18n import tr
from app.text.messages import UserMessage, clean
from app.text.sentences import join_names, join_sentences
from app.text.user_error import ErrorCode, UserError
from app.trigger_records.filing import PossiblyOther, TriggersReading, file_triggers
from app.trigger_records.kept import Visit


def name_given(args: argparse.Namespace) -> str:
    """What --module says; empty without it."""
    return clean((args.module or "").strip())


def refuse_another(opened: OpenPort, records: Records, args: argparse.Namespace) -> None:
    """Raises `Refused` where something speaks against the name, unless a person says --same-module. Of a store that
    cannot be used nothing is known, so nothing speaks against it; why is said at the end."""
    name = name_given(args)
    if not name or args.same_module:
        return

    def find(facts: Facts) -> Remembered | None:
        return remembered(facts, name)

    known = records.ask(find)
    against = () if known is None else what_speaks_against(known, opened.conversation)
    if against:
        raise Refused(other_module(against), ErrorCode.REFUSED)


def other_module(against: tuple[UserMessage, ...]) -> str:
    differences = join_names(one.translated() for one in against)
    other = tr("This may be another module: {differences}.", differences=differences)
    return join_sentences((other, tr("Nothing was done. Add {option} to do it.", option="--same-module")))


def store_visit(reading: TriggersReading, records: Records, args: argparse.Namespace) -> bool:
    """Store the records of this reading under the name; False if they do not follow those of its last visit, or the
    store cannot be used. Errors are printed, never raised."""
    name = name_given(args)

    def keep(facts: Facts) -> Visit | PossiblyOther:
        return file_triggers(
            facts,
            reading,
            name,
            port=records.port,
            adapter=records.find_adapter(),
            is_same_module=args.same_module,
        )

    try:
        visit = records.store.write(keep).result()
    except UserError:
        notify(tr("Not kept."))  # why is said at the end
        return False
    if isinstance(visit, PossiblyOther):
        notify(other_module((visit.why,)))
        return False
    new = visit.records if visit.new is None else visit.new
    note(tr("{module}: {new} new; records: {count}.", module=name, new=len(new), count=len(visit.records)))
    return True

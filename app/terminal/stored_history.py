"""Stores trigger records under the name of their module and reports new ones."""

from collections.abc import Iterable
from contextlib import closing

from app.engine.identity import IdentityEvidence
from app.procedures.settings_reading import read_settings
from app.records.trigger_filing import PossiblyOther, TriggersReading, file_triggers, refuted_by
from app.store.database import StoreTrouble
from app.store.store import Store
from app.terminal.command_journal import open_store_or_notify
from app.terminal.connection import Conversation
from app.terminal.console import note, notify
from app.text.i18n import tr
from app.text.messages import clean
from app.text.sentences import join_names, join_sentences


def may_be_another(conversation: Conversation, store: Store | None, module: str) -> bool:
    """Whether its readings refute that it is the module of this name, which is reported. Sends queries only."""
    try:
        against = [] if store is None else differences_from(conversation, store, module)
    except StoreTrouble as error:
        notify(error.sentence)
        return True
    if against:
        _notify_other_module(against)
    return bool(against)


def differences_from(conversation: Conversation, store: Store, module: str) -> list[str]:
    """What refutes that it is the module of this name, in the language in use. Raises `StoreTrouble`."""
    return refuted(conversation, evidence_of(store, clean(module.strip())))


def evidence_of(store: Store, name: str) -> IdentityEvidence | None:
    """None: there is no module of this name. Raises `StoreTrouble`."""
    return store.evidence(name) if store.module_named(name) is not None else None


def refuted(conversation: Conversation, known: IdentityEvidence | None) -> list[str]:
    return [] if known is None else refuted_by(known, conversation.run(read_settings()).evidence)


def store_visit(reading: TriggersReading, module: str, *, port: str, is_same_module: bool) -> bool:
    """Store the records of this reading; False if the module may be another one, or the store cannot be used. Errors
    are printed, never raised. `is_same_module`: confirmed by a person."""
    name, store = clean(module.strip()), open_store_or_notify(tr("Not kept."))
    if store is None:
        return False
    try:
        with closing(store):
            visit = file_triggers(store, reading, name, port=port, is_same_module=is_same_module)
    except StoreTrouble as error:
        notify(join_sentences((error.sentence, tr("Not kept."))))
        return False
    if isinstance(visit, PossiblyOther):
        _notify_other_module(visit.differences)
        return False
    new = visit.records if visit.new is None else visit.new
    note(tr("{module}: {new} new; records: {count}.", module=name, new=len(new), count=len(visit.records)))
    return True


def _notify_other_module(differences: Iterable[str]) -> None:
    other = tr("This may be another module: {differences}.", differences=join_names(differences))
    notify(join_sentences((other, tr("Nothing was done. Add {option} to do it.", option="--same-module"))))

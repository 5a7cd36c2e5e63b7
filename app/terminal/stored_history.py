"""Stores trigger records under the name of their module and reports new ones."""

from collections.abc import Iterable
from functools import partial

from app.engine.identity import IdentityEvidence
from app.procedures.settings_reading import read_settings
from app.store.fact_store import Facts, Store
from app.store.modules import evidence_of, module_named
from app.store.trouble import StoreTrouble
from app.terminal.command_journal import opened_store
from app.terminal.connection import Conversation
from app.terminal.console import note, notify
from app.text.i18n import tr
from app.text.messages import clean
from app.text.sentences import join_names, join_sentences
from app.trigger_records.filing import PossiblyOther, TriggersReading, file_triggers, refuted_by


def may_be_another(conversation: Conversation, store: Store, module: str) -> bool:
    """Whether its readings refute that it is the module of this name, which is reported. Sends queries only. Of a store
    that cannot be used nothing is known, so nothing speaks against it."""
    try:
        known = store.read(partial(known_evidence, name=clean(module.strip())))
    except StoreTrouble:
        return False  # why is said at the end
    against = refuted(conversation, known)
    if against:
        _notify_other_module(against)
    return bool(against)


def known_evidence(facts: Facts, name: str) -> IdentityEvidence | None:
    """None: there is no module of this name."""
    return IdentityEvidence(*evidence_of(facts, name)) if module_named(facts, name) is not None else None


def refuted(conversation: Conversation, known: IdentityEvidence | None) -> list[str]:
    """What refutes that it is the module of which this is known, in the language in use."""
    return [] if known is None else refuted_by(known, conversation.run(read_settings()).evidence)


def store_visit(reading: TriggersReading, module: str, *, port: str, is_same_module: bool) -> bool:
    """Store the records of this reading; False if the module may be another one, or the store cannot be used. Errors
    are printed, never raised. `is_same_module`: confirmed by a person."""
    name = clean(module.strip())
    filing = partial(file_triggers, reading=reading, name=name, port=port, is_same_module=is_same_module)
    with opened_store() as (store, _troubles):
        try:
            visit = store.write(filing).result()
        except StoreTrouble:
            notify(tr("Not kept."))  # why is said at the end
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

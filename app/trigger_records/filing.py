"""Reads the trigger records of a module, and files them under the name that a person said in that conversation."""

from collections.abc import Mapping
from typing import NamedTuple

from app.engine.procedure import EngineView, Inspect, Procedure
from app.modules.names import remember, remembered
from app.procedures.history import History, read_history
from app.store.fact_store import Facts
from app.store.fired import claim_fired
from app.text.messages import UserMessage, message
from app.trigger_records.kept import KeptTriggers, Visit
from protocol.fields import Value
from protocol.translatable import marked


class TriggersReading(NamedTuple):
    """The records on the module, and what else was known of it in the conversation of this number."""

    history: History
    conversation: int
    boot_count: int | None
    # By key, in the field's unit.
    settings: Mapping[str, Value]


def read_triggers() -> Procedure[TriggersReading]:
    """Sends queries only."""
    history = yield from read_history()
    view: EngineView = yield Inspect()
    known = view.conversation
    return TriggersReading(history, known.number, known.boot_count, known.settings(view.now))


class PossiblyOther(NamedTuple):
    """It may be another module than the one of that name, so nothing was kept."""

    why: UserMessage


def file_triggers(
    facts: Facts, reading: TriggersReading, name: str, *, port: str, adapter: str = "", is_same_module: bool = False
) -> Visit | PossiblyOther:
    """`is_same_module`: a person said so although the records do not follow. Within `Store.write`."""
    history, kept = reading.history, KeptTriggers(facts)
    slots = [record.raw for record in history.records]
    if kept.is_kept_apart(name, port):
        return PossiblyOther(message(marked("simulated")))
    do_follow = kept.do_follow(name, slots, is_confirmed=history.is_confirmed)
    if remembered(facts, name) is not None and not do_follow and not is_same_module:
        return PossiblyOther(message(marked("the records do not follow those of its last visit")))
    remember(facts, name, adapter=adapter, boot_count=reading.boot_count, settings=reading.settings)
    claim_fired(facts, name, port=port, adapter=adapter)
    return kept.store_visit(name, slots, port=port, boot_count=reading.boot_count, is_confirmed=history.is_confirmed)

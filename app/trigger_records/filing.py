"""Reads trigger records, and files them unless they may be another module's."""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from itertools import chain
from typing import NamedTuple

from app.engine.identity import Identity, IdentityEvidence, Trust, same_module
from app.engine.procedure import EngineView, Inspect, Procedure
from app.procedures.history import History, read_history
from app.procedures.settings_reading import is_another
from app.procedures.write import read_back
from app.settings.identity_words import differences
from app.store.fact_store import Facts
from app.store.fired import claim_fired
from app.store.modules import evidence_of, last_booted, module_named, register_module, store_evidence
from app.text.i18n import tr
from app.text.user_error import UserError
from app.trigger_records.kept import KeptTriggers, Visit
from protocol.catalogue import BOOT_COUNT
from protocol.fields import Value
from protocol.translatable import marked

ANOTHER = marked("The module restarted. Read again.")
"""Or another one answered."""


def say_new(facts: Facts, names: Iterable[str]) -> None:
    """Keeps a person's word that these modules are new and have no records. Within `Store.write`."""
    for name in names:
        register_module(facts, name)
        KeptTriggers(facts).say_new(name)


@dataclass(frozen=True, slots=True)
class TriggersReading:
    """The records on the module. `boot_count` is None where it did not answer; `settings`: what was read of them."""

    history: History
    boot_count: int | None
    settings: Mapping[str, Value] = field(default_factory=dict)
    breaks: int = 0
    """How often the conversation had broken when it ended."""


def read_triggers() -> Procedure[TriggersReading]:
    """Only sends queries. Raises `UserError` if another module answered meanwhile."""
    begin: EngineView = yield Inspect()
    history = yield from read_history()
    boots = (yield from read_back(BOOT_COUNT)).raw
    if history.is_line_dead:
        return TriggersReading(history, boots)
    is_other = yield from is_another(begin)
    end: EngineView = yield Inspect()
    is_asked_about = end.device.breaks != begin.device.breaks and not end.is_settled
    if is_asked_about or end.device.restarts != begin.device.restarts or is_other:
        raise UserError(ANOTHER)
    return TriggersReading(history, boots, breaks=end.device.breaks)


class PossiblyOther(NamedTuple):
    """It may be another module, so nothing was stored."""

    differences: tuple[str, ...] = ()
    """In the language in use."""


def file_triggers(
    facts: Facts,
    reading: TriggersReading,
    name: str,
    *,
    port: str,
    is_same_module: bool,
    is_compared: bool = False,
    adapter: str = "",
) -> Visit | PossiblyOther:
    """`is_same_module`: confirmed by a person. `is_compared`: boot count and settings were compared when it got its
    name; only its records are. Within `Store.write`."""
    history, kept = reading.history, KeptTriggers(facts)
    slots = [record.raw for record in history.records]
    now = IdentityEvidence(reading.boot_count, reading.settings)
    if kept.is_kept_apart(name, port):
        return PossiblyOther((tr("simulated"),))
    if history.may_be_of_two and not is_same_module:
        return PossiblyOther((tr("readings differ"),))
    if module_named(facts, name) is not None and not is_same_module:
        do_follow = kept.do_follow(name, slots, is_confirmed=history.is_confirmed)
        booted = last_booted(facts, name)
        of_visit = IdentityEvidence(None if booted is None else booted.boot_count)
        last = IdentityEvidence(*evidence_of(facts, name))
        befores = (now,) if is_compared else (of_visit, last)
        against = [refuted_by(before, now, do_records_follow=do_follow) for before in befores]
        if any(against):
            return PossiblyOther(tuple(dict.fromkeys(chain(*against))))
    register_module(facts, name, adapter)
    claim_fired(facts, name, port=port, adapter=adapter)
    if now.is_complete:
        store_evidence(facts, name, now)
    return kept.store_visit(name, slots, port=port, boot_count=reading.boot_count, is_confirmed=history.is_confirmed)


def refuted_by(before: IdentityEvidence, now: IdentityEvidence, *, do_records_follow: bool = True) -> list[str]:
    """What refutes a person's word that it is the same module, in the language in use; empty where nothing does."""
    trust = same_module(before, now, do_records_follow=do_records_follow, is_said=True)
    if trust is Trust.PROVEN:
        return []
    words = differences(Identity(trust, before, now))
    return words if do_records_follow else [*words, tr("the records do not follow those of its last visit")]

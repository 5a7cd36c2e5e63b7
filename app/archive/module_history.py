"""History of one module over all stations: its events and its measured values over time."""

from collections.abc import Mapping
from dataclasses import dataclass

from app.archive.chains import record_of
from app.archive.facts import Fact, FactKind
from app.archive.fleet_state import SIMULATED, check_line
from app.archive.local_facts import LocalFacts
from app.archive.module_names import KnownModule, module_of_fact
from app.guided.results import TITLES, VERDICT_WORDS, GuidedKind, GuidedVerdict
from app.records.check_store import measured_in
from app.text.messages import UserMessage, clean, message
from app.trigger_records.history import JUDGEMENT_WORDS, Judgement, sentence
from app.trigger_records.history import record_of as trigger_record_of
from protocol.translatable import marked


@dataclass(frozen=True, slots=True)
class HistoryEvent:
    """One fact about a module as a sentence."""

    fact: Fact
    text: UserMessage


@dataclass(frozen=True, slots=True)
class ValuePoint:
    """A value that a check measured."""

    at: str
    station: str
    value: float


@dataclass(frozen=True, slots=True)
class ModuleHistory:
    """Oldest event first."""

    module: KnownModule
    events: tuple[HistoryEvent, ...]
    values: Mapping[str, tuple[ValuePoint, ...]]


def module_history(facts: LocalFacts, module: KnownModule) -> ModuleHistory:
    """Raises `ArchiveTrouble`."""
    members = set(module.members)
    found = [
        fact
        for kind in FactKind
        for name in sorted({one.name for one in members})
        for fact in facts.of_kind(kind, name)
        if module_of_fact(fact) in members
    ]
    found.sort(key=lambda one: (one.made_at, one.id))
    values: dict[str, list[ValuePoint]] = {}
    for fact in found:
        record = record_of(fact) if fact.kind == FactKind.CHECK.value else None
        for name, value in measured_in(record or {}).items():
            values.setdefault(name, []).append(ValuePoint(fact.made_at, fact.station, value))
    points = {name: tuple(some) for name, some in sorted(values.items())}
    return ModuleHistory(module, tuple(HistoryEvent(fact, fact_text(fact)) for fact in found), points)


def fact_text(fact: Fact) -> UserMessage:
    """A fact as text; for an unknown kind only its kind."""
    try:
        return _fact_text(FactKind(fact.kind), fact)
    except (ValueError, KeyError, TypeError, AttributeError):
        return UserMessage(fact.kind)


def _fact_text(kind: FactKind, fact: Fact) -> UserMessage:
    content = fact.content
    match kind:
        case FactKind.MODULE:
            return message(marked("Named {name}."), name=_text(fact, "module"))
        case FactKind.TRIGGER_RECORD:
            what = sentence(trigger_record_of(bytes.fromhex(_text(fact, "raw"))))
            return message(marked("Trigger record: {what}"), what=what)
        case FactKind.JUDGEMENT:
            return _judgement(fact)
        case FactKind.SNAPSHOT:
            settings = content.get("settings")
            listed = sorted(settings.items()) if isinstance(settings, dict) else ()
            text = ", ".join(f"{clean(str(name))} {value}" for name, value in listed)
            return message(marked("Settings: {settings}."), settings=clean(text, longest=300))
        case FactKind.CHECK:
            line = check_line(fact, record_of(fact) or {})
            who = UserMessage(line.who) if line.who else message(marked("not named"))
            text = marked("Pre-flight check {number}: {verdict}, checked by {who}.")
            return message(text, number=line.number, verdict=line.words, who=who)
        case FactKind.GUIDED_TEST:
            verdict = message(VERDICT_WORDS[GuidedVerdict(_text(fact, "verdict"))])
            if content.get("is_simulated") is True:
                verdict = message(SIMULATED, verdict=verdict)
            test = message(TITLES[GuidedKind(_text(fact, "test"))])
            return message(marked("Guided test {test}: {verdict}."), test=test, verdict=verdict)
        case FactKind.AUDIT:
            entry = content["entry"]
            if not isinstance(entry, list):
                raise TypeError(entry)
            act, outcome = (clean(str(one)) for one in (entry[5], entry[9] or "begun"))
            return message(marked("Audit log: {act}, {outcome}."), act=act, outcome=outcome)
        case FactKind.SETTLEMENT:
            return message(marked("A person settled which module this is."))


def _judgement(fact: Fact) -> UserMessage:
    value = fact.content.get("judgement")
    if value is None:
        return message(marked("Judgement taken back."))
    note = _text(fact, "note")
    text = marked("Judged: {judgement}; “{note}”.") if note else marked("Judged: {judgement}.")
    return message(text, judgement=message(JUDGEMENT_WORDS[Judgement(value)]), note=note)


def _text(fact: Fact, key: str) -> str:
    value = fact.content.get(key)
    if not isinstance(value, str):
        raise TypeError(key)
    return clean(value)

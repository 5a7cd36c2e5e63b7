"""History of one module over all stations: its events and its measured values over time."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Final

from app.archive.chains import record_of
from app.archive.content import FactKind
from app.archive.facts import Fact
from app.archive.fleet_state import SIMULATED, check_line
from app.archive.local_facts import LocalFacts
from app.archive.module_names import KnownModule, decided_by, decision_text, module_of_fact, settlement_of
from app.guided.results import TITLES as TEST_TITLES
from app.guided.results import VERDICT_WORDS, GuidedKind, GuidedVerdict
from app.records.check_store import measured_in
from app.safety.acts import TITLES, Act
from app.safety.journal import Outcome
from app.settings.profiles import SETTINGS_BY_KEY
from app.settings.values import field_of, fitting
from app.store.audit_chain import AuditRow
from app.text.messages import UserMessage, clean, joined, message
from app.text.user_error import UserError
from app.trigger_records.history import JUDGEMENT_WORDS, Judgement, sentence
from app.trigger_records.history import record_of as trigger_record_of
from protocol.fields import Flag
from protocol.frame import decode_request
from protocol.translatable import marked

MAX_SETTINGS: Final = 20
"""A module has eight."""
_OUTCOMES: Final[Mapping[Outcome, str]] = {
    Outcome.CONFIRMED: marked("confirmed"),
    Outcome.REFUSED: marked("refused"),
    Outcome.UNKNOWN: marked("may have been carried out"),
    Outcome.NOT_SENT: marked("not sent"),
}


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
    """Raises `UserError`."""
    members = set(module.members)
    found = [
        fact
        for kind in FactKind
        for name in sorted({one.name for one in members})
        for fact in facts.of_kind(kind, name)
        if module_of_fact(fact) in members
    ]
    decisions = facts.of_kind(FactKind.SETTLEMENT)
    found += [fact for fact in decisions if members.intersection(settlement_of(fact).pair)]
    found = _ended(found)
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
    except (UserError, ValueError, LookupError, TypeError, AttributeError):
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
            settings = sorted(content["settings"].items())[:MAX_SETTINGS]
            listed = joined([_setting(key, value) for key, value in settings])
            return message(marked("Settings: {settings}."), settings=listed)
        case FactKind.CHECK:
            line = check_line(fact, record_of(fact) or {})
            who = UserMessage(line.who) if line.who else message(marked("not named"))
            text = marked("Pre-flight check {number}: {verdict}, checked by {who}.")
            return message(text, number=line.number, verdict=line.words, who=who)
        case FactKind.GUIDED_TEST:
            verdict = message(VERDICT_WORDS[GuidedVerdict(_text(fact, "verdict"))])
            if content.get("is_simulated") is True:
                verdict = message(SIMULATED, verdict=verdict)
            test = message(TEST_TITLES[GuidedKind(_text(fact, "test"))])
            return message(marked("Guided test {test}: {verdict}."), test=test, verdict=verdict)
        case FactKind.AUDIT:
            row = fact.audit_row
            if row is None:
                raise TypeError(content)
            outcome = message(_OUTCOMES[Outcome(row.outcome) if row.outcome else Outcome.UNKNOWN])
            return message(marked("{act}: {outcome}."), act=_act(row), outcome=outcome)
        case FactKind.SETTLEMENT:
            settlement = settlement_of(fact)
            who, station = decided_by(settlement)
            text = marked("{decision} Decided by {who} at station {station}.")
            return message(text, decision=decision_text(settlement), who=who, station=station)


def _ended(facts: Sequence[Fact]) -> list[Fact]:
    """Of the two facts of an act only that of its outcome, where it has one."""
    acts = {fact: (fact.station, str(row.id), str(row.at)) for fact in facts if (row := fact.audit_row) is not None}
    ended = {act for fact, act in acts.items() if _is_ended(fact)}
    return [fact for fact in facts if acts.get(fact) not in ended or _is_ended(fact)]


def _is_ended(fact: Fact) -> bool:
    row = fact.audit_row
    return row is not None and row.settled_at is not None


def _act(row: AuditRow) -> UserMessage:
    """A setting with its value."""
    act, request = Act(row.act), decode_request(bytes.fromhex(str(row.frame)))
    if act not in (Act.WRITE, Act.CHANGE_BAUD) or request.command.write is None:
        return message(TITLES[act])
    return _setting(request.command.key, request.command.write.decode(request.data))


def _setting(key: str, value: object) -> UserMessage:
    """A setting with its value and unit; one that this version does not know by its key."""
    command = SETTINGS_BY_KEY.get(key)
    if command is None:
        return UserMessage(clean(f"{key} {value}"))
    field = field_of(command)
    if isinstance(field, Flag):
        shown = marked("Enabled") if value is True else marked("Disabled")
    else:
        shown = field.text(field.encode(fitting(field, value)))
    return message("{name} {value}", name=message(command.title), value=message(shown))


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

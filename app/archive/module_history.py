"""History of one module over all stations: its events and its measured values over time."""

from collections.abc import Mapping, Sequence
from typing import Final, NamedTuple

from app.archive.archive import Archive
from app.archive.facts import Fact
from app.archive.fleet_state import fired_in, line_of
from app.archive.module_names import KnownModule, decided_by, decision_text, module_of_fact, settlement_of
from app.guided.results import TITLES as TEST_TITLES
from app.guided.results import VERDICT_WORDS, GuidedKind, GuidedVerdict
from app.limits.service import service_of
from app.records.check_store import measuring, noted
from app.safety.acts import TITLES, Act
from app.safety.journal import Outcome
from app.settings.profiles import SETTINGS_BY_KEY
from app.settings.setting_texts import value_message
from app.settings.values import field_of, fitting
from app.store.facts import FORMER_ENTRY, FactKind
from app.store.fired import Fired
from app.store.store import AuditEntry, audit_entry, former_entry
from app.text.messages import UserMessage, clean, joined, message
from app.text.user_error import UserError
from app.trigger_records.history import JUDGEMENT_WORDS, Judgement, sentence
from app.trigger_records.history import record_of as trigger_record_of
from protocol.frame import decode_request
from protocol.translatable import marked

MAX_SETTINGS: Final = 20
"""A module has eight."""
_OF_ACTS: Final = (FactKind.ACT.value, FactKind.OUTCOME.value, FactKind.AUDIT.value)
_EVENTS: Final = [kind for kind in FactKind if kind not in (FactKind.VISIT, FactKind.SAID_NEW)]
_OUTCOMES: Final[Mapping[Outcome, str]] = {
    Outcome.CONFIRMED: marked("confirmed"),
    Outcome.REFUSED: marked("refused"),
    Outcome.UNKNOWN: marked("may have been carried out"),
    Outcome.NOT_SENT: marked("not sent"),
}


class HistoryEvent(NamedTuple):
    """One fact about a module as a sentence."""

    fact: Fact
    text: UserMessage


class ValuePoint(NamedTuple):
    """A value that a check measured."""

    at: str
    station: str
    value: float


class ModuleHistory(NamedTuple):
    """Oldest event first."""

    module: KnownModule
    events: tuple[HistoryEvent, ...]
    values: Mapping[str, tuple[ValuePoint, ...]]


def module_history(archive: Archive, module: KnownModule) -> ModuleHistory:
    """Raises `UserError`."""
    members = set(module.members)
    history = [
        fact
        for kind in _EVENTS
        for name in sorted({member.name for member in members})
        for fact in archive.of_kind(kind, name)
        if module_of_fact(fact) in members
    ]
    decisions = archive.of_kind(FactKind.SETTLEMENT)
    history += [fact for fact in decisions if members.intersection(settlement_of(fact).pair)]
    acts, fired = _acts(history), fired_in(history)
    history = [fact for fact in history if fact.kind not in _OF_ACTS or fact in acts]
    order = {kind.value: place for place, kind in enumerate(FactKind)}  # of what was recorded at once
    history.sort(key=lambda fact: (fact.made_at, order[fact.kind], fact.id))
    values: dict[str, list[ValuePoint]] = {}
    lines = [line_of(fact) for fact in history if fact.kind == FactKind.CHECK.value]
    for check in measuring([line for line in lines if line is not None]):
        for name, value in check.measured.items():
            values.setdefault(name, []).append(ValuePoint(check.at, check.station, value))
    points = {name: tuple(series) for name, series in sorted(values.items())}
    return ModuleHistory(module, tuple(HistoryEvent(fact, fact_text(fact, acts, fired)) for fact in history), points)


def fact_text(fact: Fact, acts: Mapping[Fact, AuditEntry | None], fired: Sequence[Fired] = ()) -> UserMessage:
    """A fact as text; for an unknown kind only its kind. `fired`: when the module may have."""
    try:
        return _fact_text(FactKind(fact.kind), fact, acts.get(fact), fired)
    except (UserError, ValueError, LookupError, TypeError, AttributeError):
        return UserMessage(fact.kind)


def _fact_text(kind: FactKind, fact: Fact, act: AuditEntry | None, fired: Sequence[Fired]) -> UserMessage:
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
            return message(marked("{value}: {why}."), value=message(marked("Settings")), why=listed)
        case FactKind.CHECK:
            line = line_of(fact, fired)
            if line is None:
                raise TypeError(content)
            who = UserMessage(line.who) if line.who else message(marked("not named"))
            return message(marked("Pre-flight check: {verdict}, checked by: {who}."), verdict=line.words, who=who)
        case FactKind.GUIDED_TEST:
            verdict = message(VERDICT_WORDS[GuidedVerdict(_text(fact, "verdict"))])
            if content.get("is_simulated") is True:
                verdict = noted(verdict, marked("simulated"))
            test = message(TEST_TITLES[GuidedKind(_text(fact, "test"))])
            return message(marked("Guided test {test}: {verdict}."), test=test, verdict=verdict)
        case FactKind.ACT | FactKind.AUDIT:
            if act is None:
                raise TypeError(content)
            return message(marked("{value}: {why}."), value=_act(act), why=message(_OUTCOMES[act.outcome]))
        case FactKind.FIRED:
            return message(marked("It reported TRIGGERED, or was told to fire before it had this name."))
        case FactKind.SERVICE:
            return service_of(content).summary()
        case FactKind.SETTLEMENT:
            settlement = settlement_of(fact)
            who, station = decided_by(settlement)
            text = marked("{decision} Decided by {who} at station {station}.")
            return message(text, decision=decision_text(settlement), who=who, station=station)
        case _:
            return UserMessage(fact.kind)


def _acts(facts: Sequence[Fact]) -> dict[Fact, AuditEntry | None]:
    """Each act once, with what came of it; None for one that this version cannot read."""
    outcomes = {(fact.station, fact.content["of"]): fact for fact in facts if fact.kind == FactKind.OUTCOME.value}
    acts: dict[object, tuple[Fact, AuditEntry | None]] = {}
    for fact in facts:
        if fact.kind == FactKind.ACT.value:
            end = outcomes.get((fact.station, fact.hash))
            acts[fact.id] = (fact, _read_act(fact, end))
        elif fact.kind == FactKind.AUDIT.value:
            entry = fact.content["entry"]
            key = (fact.station, str(entry[0]), str(entry[FORMER_ENTRY.index("at")]))
            if key not in acts or entry[FORMER_ENTRY.index("settled_at")] is not None:
                acts[key] = (fact, _read_act(fact, None))
    return dict(acts.values())


def _read_act(fact: Fact, end: Fact | None) -> AuditEntry | None:
    try:
        if fact.kind == FactKind.AUDIT.value:
            return former_entry(fact.content["entry"])
        return audit_entry(0, fact.made_at, fact.content, end.content if end else {})
    except (UserError, ValueError, LookupError, TypeError, AttributeError):
        return None


def _act(act: AuditEntry) -> UserMessage:
    request = decode_request(act.frame)
    if act.act not in (Act.WRITE, Act.CHANGE_BAUD) or request.command.write is None:
        return message(TITLES[act.act])
    return _setting(request.command.key, request.command.write.decode(request.data))


def _setting(key: str, value: object) -> UserMessage:
    """A setting with its value and unit; one that this version does not know by its key."""
    command = SETTINGS_BY_KEY.get(key)
    if command is None:
        return UserMessage(clean(f"{key} {value}"))
    shown = value_message(command, fitting(field_of(command), value))
    return message("{name} {value}", name=message(command.title), value=shown)


def _judgement(fact: Fact) -> UserMessage:
    value = fact.content.get("judgement")
    if value is None:
        return message(marked("Judgement taken back."))
    judged = message(marked("Judged: {judgement}."), judgement=message(JUDGEMENT_WORDS[Judgement(value)]))
    note = _text(fact, "note")
    return joined((judged, UserMessage(f"“{note}”")), " ") if note else judged


def _text(fact: Fact, key: str) -> str:
    value = fact.content.get(key)
    if not isinstance(value, str):
        raise TypeError(key)
    return clean(value)

"""The state of all modules of all stations today: last check, trigger records, guided tests and what is due."""

from collections.abc import Sequence
from dataclasses import dataclass, field
from datetime import datetime
from enum import Enum
from typing import Final

from app.archive.chains import record_of
from app.archive.facts import Fact
from app.archive.local_facts import LocalFacts
from app.archive.module_names import KnownModule, ModuleNames, module_of_fact
from app.guided.results import RETIRED_KINDS, TITLES, GuidedVerdict
from app.limits.service import ServiceKind, due_services
from app.preflight.verdict import VERDICT_WORDS, Verdict, verdict_named
from app.records.record import Record
from app.records.verification import RecordState, verify
from app.store.facts import FactKind
from app.system.wall_clock import age_days
from app.text.messages import UserMessage, clean, message
from protocol.translatable import marked

CHECK_DAYS: Final = 30
TEST_DAYS: Final = 180
SIMULATED: Final = marked("{verdict} (simulated)")


class DueKind(Enum):
    """The value is used in JSON."""

    NO_CHECK = "no_check"
    NO_GO = "no_go"
    OLD_CHECK = "old_check"
    TRIGGER_RECORDS = "trigger_records"
    TEST = "test"
    OLD_TEST = "old_test"
    SERVICE = "service"
    CONFLICT = "conflict"


@dataclass(frozen=True, slots=True)
class Due:
    """What a module needs."""

    kind: DueKind
    text: UserMessage


@dataclass(frozen=True, slots=True)
class CheckLine:
    """One check according to its record."""

    at: str
    station: str
    number: int
    verdict: str
    is_void: bool
    is_simulated: bool
    who: str
    aircraft: str
    fingerprint: str | None
    hash: str
    is_altered: bool = False
    """The record differs from what was sealed."""

    @property
    def words(self) -> UserMessage:
        """Its verdict and what limits it."""
        word = message(VERDICT_WORDS[verdict_named(self.verdict)])
        if self.is_altered:
            return message(marked("{verdict} (record ALTERED)"), verdict=word)
        if self.is_simulated:
            return message(SIMULATED, verdict=word)
        return message(marked("{verdict} (void)"), verdict=word) if self.is_void else word

    @property
    def holds(self) -> bool:
        return not self.is_void and not self.is_altered and self.verdict in (Verdict.GO.value, Verdict.READY.value)


@dataclass(frozen=True, slots=True)
class GuidedLine:
    """The last result of one guided test."""

    kind: str
    verdict: str
    at: str


@dataclass(slots=True)
class ModuleToday:
    """One module today. `last_at`: time of the newest fact; `unjudged`: trigger records without a judgement;
    `since_repack`: those first read since it was last repacked, None where no repack is known."""

    module: KnownModule
    last_at: str = ""
    checks: int = 0
    last_check: CheckLine | None = None
    trigger_records: int = 0
    unjudged: int = 0
    since_repack: int | None = None
    tests: list[GuidedLine] = field(default_factory=list)
    due: list[Due] = field(default_factory=list)

    @property
    def counted(self) -> UserMessage:
        """Its trigger records, and how many of them came since the repack."""
        count = UserMessage(str(self.trigger_records))
        text = marked("{count}, first read since the repack: {since}")
        return count if self.since_repack is None else message(text, count=count, since=self.since_repack)


def fleet_state(
    facts: LocalFacts, names: ModuleNames, now: datetime, *, check_days: int = CHECK_DAYS, test_days: int = TEST_DAYS
) -> list[ModuleToday]:
    """By name. Raises `UserError`."""
    found = [ModuleToday(module) for module in names.modules]
    about = _by_module(facts, names)
    for state in found:
        mine = {kind: about.get((state.module, kind), []) for kind in FactKind}
        everything = [fact for some in mine.values() for fact in some]
        state.last_at = max((fact.made_at for fact in everything), default="")
        checks = [(fact, record) for fact in mine[FactKind.CHECK] if (record := record_of(fact)) is not None]
        state.checks = len(checks)
        last = _last_check(checks)
        state.last_check = check_line(*last) if last is not None else None
        records = {fact.content.get("raw") for fact in mine[FactKind.TRIGGER_RECORD]}
        state.trigger_records = len(records)
        state.unjudged = len(records - _judged(mine[FactKind.JUDGEMENT]))
        state.tests = _last_tests(mine[FactKind.GUIDED_TEST])
        state.due = _due(state, names, now, check_days, test_days)
        done = sorted(mine[FactKind.SERVICE], key=lambda fact: (fact.content["on"], fact.made_at, fact.id))
        due = due_services((fact.content for fact in done), now.astimezone().date())
        state.since_repack = _since_repack(mine[FactKind.TRIGGER_RECORD], done)
        state.due += [Due(DueKind.SERVICE, service.text) for service in due]
    return found


def check_line(fact: Fact, record: Record) -> CheckLine:
    def text(key: str) -> str:
        value = record.get(key)
        return clean(value) if isinstance(value, str) else ""

    return CheckLine(
        at=fact.made_at, station=fact.station, number=_number(record), verdict=text("verdict"),
        is_void=record.get("void") is not None, is_simulated=record.get("is_simulated") is True, who=text("who"),
        aircraft=text("aircraft"), fingerprint=text("fingerprint") or None, hash=text("hash"),
        is_altered=verify(record).state in (RecordState.ALTERED, RecordState.UNREADABLE),
    )  # fmt: skip


def _by_module(facts: LocalFacts, names: ModuleNames) -> dict[tuple[KnownModule, FactKind], list[Fact]]:
    modules = {member: module for module in names.modules for member in module.members}
    found: dict[tuple[KnownModule, FactKind], list[Fact]] = {}
    for kind in FactKind:
        for fact in facts.of_kind(kind):
            member = module_of_fact(fact)
            if member is not None and member in modules:
                found.setdefault((modules[member], kind), []).append(fact)
    return found


def _last_check(checks: Sequence[tuple[Fact, Record]]) -> tuple[Fact, Record] | None:
    """The check with the highest number of each station, independent of its clock; of these the newest. A simulated
    check only if there is no other."""
    real = [one for one in checks if one[1].get("is_simulated") is not True] or checks
    last: dict[str, tuple[Fact, Record]] = {}
    for fact, record in sorted(real, key=lambda one: _number(one[1])):
        last[fact.station] = (fact, record)
    return max(last.values(), key=lambda one: one[0].made_at, default=None)


def _number(record: Record) -> int:
    number = record.get("number")
    return number if type(number) is int else 0


def _judged(judgements: Sequence[Fact]) -> set[object]:
    """The last judgement of each record counts; it may revoke an earlier one."""
    last: dict[object, Fact] = {}
    for fact in judgements:
        raw = fact.content.get("raw")
        if raw not in last or (last[raw].made_at, last[raw].id) < (fact.made_at, fact.id):
            last[raw] = fact
    return {raw for raw, fact in last.items() if fact.content.get("judgement") is not None}


def _since_repack(records: Sequence[Fact], services: Sequence[Fact]) -> int | None:
    """By when a record was first read: it has no date of its own. `services`: the oldest first."""
    repack = next((fact for fact in reversed(services) if fact.content["service"] == ServiceKind.REPACK.value), None)
    if repack is None:
        return None
    day = str(repack.content["on"])
    # What was read on that day came before a repack entered on it; of one entered later nobody knows, so it counts.
    after = (day, repack.made_at if _local_day(repack) == day else "")
    first: dict[object, Fact] = {}
    for fact in sorted(records, key=lambda fact: fact.made_at):
        first.setdefault(fact.content.get("raw"), fact)
    return sum((_local_day(fact), fact.made_at) > after for fact in first.values())


def _local_day(fact: Fact) -> str:
    return datetime.fromisoformat(fact.made_at).astimezone().date().isoformat()


def _last_tests(tests: Sequence[Fact]) -> list[GuidedLine]:
    last: dict[str, GuidedLine] = {}
    for fact in sorted(tests, key=lambda one: (one.made_at, one.id)):
        kind, verdict = (fact.content.get(key) for key in ("test", "verdict"))
        if isinstance(kind, str) and isinstance(verdict, str) and fact.content.get("is_simulated") is not True:
            last[kind] = GuidedLine(clean(kind), clean(verdict), fact.made_at)
    return [last[kind] for kind in sorted(last)]


def _due(state: ModuleToday, names: ModuleNames, now: datetime, check_days: int, test_days: int) -> list[Due]:
    due, check = [], state.last_check
    if check is None or check.is_simulated:
        due.append(Due(DueKind.NO_CHECK, message(marked("No pre-flight check yet."))))
    elif not check.holds:
        due.append(Due(DueKind.NO_GO, message(marked("The last check is not GO."))))
    elif (age := age_days(check.at, now)) is None or age > check_days:
        text = marked("No check within the last {days} days.")
        due.append(Due(DueKind.OLD_CHECK, message(text, days=check_days)))
    if state.unjudged:
        text = marked("Unjudged trigger records: {count}.")
        due.append(Due(DueKind.TRIGGER_RECORDS, message(text, count=state.unjudged)))
    titles = {kind.value: title for kind, title in TITLES.items()}
    retired = {kind.value for kind in RETIRED_KINDS}
    for test in state.tests:
        if test.kind in retired:
            continue
        title = message(titles.get(test.kind, test.kind))
        if test.verdict != GuidedVerdict.PASSED.value:
            due.append(Due(DueKind.TEST, message(marked("Guided test not passed: {test}."), test=title)))
        elif (age := age_days(test.at, now)) is None or age > test_days:
            text = marked("Guided test not within the last {days} days: {test}.")
            due.append(Due(DueKind.OLD_TEST, message(text, days=test_days, test=title)))
    members = set(state.module.members)
    open_questions = [one.question() for one in names.conflicts if members & set(one.pair)]
    return [*due, *(Due(DueKind.CONFLICT, question) for question in open_questions)]

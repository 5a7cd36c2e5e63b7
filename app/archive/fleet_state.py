"""The state of all modules of all stations today: last check, trigger records, guided tests and what is due."""

from collections import Counter
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from datetime import datetime
from enum import Enum
from typing import Final, NamedTuple

from app.archive.archive import Archive
from app.archive.chains import in_chain_order
from app.archive.facts import Fact
from app.archive.module_names import KnownModule, ModuleNames, module_of_fact
from app.engine.target import is_simulated
from app.guided.results import TITLES, VERDICT_WORDS, GuidedVerdict, StoredTest, stored_test
from app.limits.service import ServiceKind, due_services, repack_due
from app.records.check_store import CheckLine, check_line, check_of
from app.safety.acts import Act
from app.safety.journal import Outcome
from app.store.facts import FactKind
from app.store.fired import Fired
from app.system.wall_clock import age_days
from app.text.messages import UserMessage, message
from app.text.sentences import join_sentences
from protocol.translatable import marked

CHECK_DAYS: Final = 30
TEST_DAYS: Final = 180


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


class Due(NamedTuple):
    """What a module needs."""

    kind: DueKind
    text: UserMessage


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
    tests: list[StoredTest] = field(default_factory=list)
    due: list[Due] = field(default_factory=list)

    @property
    def due_words(self) -> str:
        """In the language in use."""
        return join_sentences(due.text.translated() for due in self.due)

    @property
    def counted(self) -> UserMessage:
        """Its trigger records, and how many of them came since the repack."""
        count = UserMessage(str(self.trigger_records))
        text = marked("{count}, first read since the repack: {since}")
        return count if self.since_repack is None else message(text, count=count, since=self.since_repack)


def fleet_state(
    archive: Archive, names: ModuleNames, now: datetime, *, check_days: int = CHECK_DAYS, test_days: int = TEST_DAYS
) -> list[ModuleToday]:
    """By name. Raises `UserError`."""
    states = [ModuleToday(module) for module in names.modules]
    about, today = _by_module(archive, names), now.astimezone().date()
    for state in states:
        mine = {kind: about.get((state.module, kind.value), []) for kind in FactKind}
        everything = [fact for group in mine.values() for fact in group]
        state.last_at = max((fact.made_at for fact in everything), default="")
        state.checks = len(mine[FactKind.CHECK])
        last, fired = _last_check(mine[FactKind.CHECK]), fired_in(everything)
        state.last_check = line_of(last, fired) if last is not None else None
        records = _records(mine[FactKind.TRIGGER_RECORD])
        state.trigger_records = len(set(records.values()))
        state.unjudged = len(set(records.values()) - _judged(mine[FactKind.JUDGEMENT], records))
        state.tests = _last_tests(mine[FactKind.GUIDED_TEST])
        state.due = _due(state, names, now, check_days, test_days)
        done = sorted((fact for fact in mine[FactKind.SERVICE] if fact.content["on"] <= today.isoformat()),
                      key=lambda fact: (fact.content["on"], fact.made_at, fact.id))  # fmt: skip
        due = due_services((fact.content for fact in done), today)
        state.since_repack = _since_repack(mine[FactKind.TRIGGER_RECORD], records, done)
        services = [(fact.made_at, fact.content) for fact in done]
        repack = repack_due(max((one.at for one in fired if not one.is_simulated), default=None), services)
        state.due += [Due(DueKind.SERVICE, service.text) for service in (*filter(None, (repack,)), *due)]
    return states


def fired_in(facts: Iterable[Fact]) -> list[Fired]:
    """When a deploy left or a TRIGGERED was seen, of all facts about one module."""
    facts = list(facts)
    outcomes = [fact for fact in facts if fact.kind == FactKind.OUTCOME.value]
    not_sent = {(fact.station, fact.content["of"]) for fact in outcomes
                if fact.content["outcome"] == Outcome.NOT_SENT.value}  # fmt: skip
    fired = []
    for fact in facts:
        is_deploy = fact.kind == FactKind.ACT.value and fact.content["act"] == Act.DEPLOY.value
        has_left = is_deploy and (fact.station, fact.hash) not in not_sent
        if has_left or fact.kind == FactKind.FIRED.value:
            fired.append(Fired(fact.made_at, is_simulated(str(fact.content.get("port")))))
    return fired


def line_of(fact: Fact, fired: Iterable[Fired] = ()) -> CheckLine | None:
    """Of a fact `CHECK`, whose record was verified when it came in; None for one that this version cannot read.
    `fired`: when the module may have."""
    check = check_of(fact.content)
    return None if check is None else check_line(check, fact.module, fact.made_at, station=fact.station).after(fired)


def _by_module(archive: Archive, names: ModuleNames) -> dict[tuple[KnownModule, str], list[Fact]]:
    modules = {member: module for module in names.modules for member in module.members}
    grouped: dict[tuple[KnownModule, str], list[Fact]] = {}
    for fact in in_chain_order(archive.of_kind(None)):
        member = module_of_fact(fact)
        if member is not None and member in modules:
            grouped.setdefault((modules[member], fact.kind), []).append(fact)
    return grouped


def _last(facts: Iterable[Fact], about: Callable[[Fact], object]) -> dict[object, Fact]:
    """By what it is `about`: of each station the one that it recorded last, independent of its clock; of these the
    newest. `facts`: of each station in order."""
    of_stations = {(about(fact), fact.station): fact for fact in facts}
    in_time = sorted(of_stations.items(), key=lambda last: (last[1].made_at, last[1].id))
    return {thing: fact for (thing, _station), fact in in_time}


def _last_check(checks: Sequence[Fact]) -> Fact | None:
    """A simulated check only if there is no other."""
    real = [fact for fact in checks if not fact.content.get("is_simulated")] or checks
    return _last(real, lambda _fact: None).get(None)


_Records = Mapping[tuple[str | None, ...], tuple[str, int]]
"""By station, name and place there: the bytes of a trigger record, and which of those of equal bytes it is."""


def _records(facts: Sequence[Fact]) -> _Records:
    """Two triggers may have equal bytes; what two stations read of one module is the same record."""
    records, counts = dict[tuple[str | None, ...], tuple[str, int]](), Counter[object]()
    for place, raw in {_place(fact): str(fact.content["raw"]) for fact in facts}.items():
        records[place] = raw, counts[*place[:-1], raw]
        counts[*place[:-1], raw] += 1
    return records


def _place(fact: Fact) -> tuple[str | None, ...]:
    return fact.station, fact.module, str(fact.content.get("place"))


def _judged(judgements: Sequence[Fact], records: _Records) -> set[object]:
    """The last judgement of each record counts; it may revoke an earlier one."""
    last = _last(judgements, lambda fact: records.get(_place(fact)))
    return {record for record, fact in last.items() if fact.content.get("judgement") is not None}


def _since_repack(facts: Sequence[Fact], records: _Records, services: Sequence[Fact]) -> int | None:
    """By when a record was first read: it has no date of its own. `services`: the oldest first."""
    repack = next((fact for fact in reversed(services) if fact.content["service"] == ServiceKind.REPACK.value), None)
    if repack is None:
        return None
    day = str(repack.content["on"])
    # What was read on that day came before a repack entered on it; of one entered later nobody knows, so it counts.
    after = (day, repack.made_at if _local_day(repack) == day else "")
    latest_first = sorted(facts, key=lambda fact: (fact.made_at, fact.id), reverse=True)
    first = {records[_place(fact)]: fact for fact in latest_first}
    return sum((_local_day(fact), fact.made_at) > after for fact in first.values())


def _local_day(fact: Fact) -> str:
    return datetime.fromisoformat(fact.made_at).astimezone().date().isoformat()


def _last_tests(facts: Sequence[Fact]) -> list[StoredTest]:
    """Without those of newer versions, which nobody here could do."""
    tests = {fact: test for fact in facts if (test := stored_test(fact.content, fact.made_at)) is not None}
    last = _last((fact for fact in tests if not tests[fact].is_simulated), lambda fact: tests[fact].kind.value)
    return sorted((tests[fact] for fact in last.values()), key=lambda test: test.kind.value)


def _due(state: ModuleToday, names: ModuleNames, now: datetime, check_days: int, test_days: int) -> list[Due]:
    due, check = [], state.last_check
    if check is None or check.is_simulated:
        due.append(Due(DueKind.NO_CHECK, message(marked("No pre-flight check yet."))))
    elif not check.holds:
        since = marked("Since the last check it fired, or was told to.")
        text = since if check.is_fired_since else marked("The last check is not GO.")
        due.append(Due(DueKind.NO_GO, message(text)))
    elif (age := age_days(check.at, now)) is None or age > check_days:
        text = marked("No check within the last {days} days.")
        due.append(Due(DueKind.OLD_CHECK, message(text, days=check_days)))
    if state.unjudged:
        text = marked("Unjudged trigger records: {count}.")
        due.append(Due(DueKind.TRIGGER_RECORDS, message(text, count=state.unjudged)))
    for test in state.tests:
        title = message(TITLES[test.kind])
        if test.verdict is not GuidedVerdict.PASSED:
            text, verdict = marked("Guided test {test}: {verdict}."), message(VERDICT_WORDS[test.verdict])
            due.append(Due(DueKind.TEST, message(text, test=title, verdict=verdict)))
        elif (age := age_days(test.at, now)) is None or age > test_days:
            text = marked("Guided test not within the last {days} days: {test}.")
            due.append(Due(DueKind.OLD_TEST, message(text, days=test_days, test=title)))
    members = set(state.module.members)
    open_questions = [conflict.question() for conflict in names.conflicts if members & set(conflict.pair)]
    return [*due, *(Due(DueKind.CONFLICT, question) for question in open_questions)]

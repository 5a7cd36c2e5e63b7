"""All modules of all stations today: the last check, trigger records, guided tests, and what is due.

For people: it warns and shows. No verdict and no condition of an act rests on it, as others may have written anything.
"""

from datetime import datetime, timedelta
from enum import StrEnum
from itertools import pairwise
from typing import NamedTuple

from msgspec import Struct, field

from app.archive.archive import Archive
from app.guided.guided_store import last_tests
from app.guided.results import TITLES, VERDICT_WORDS, GuidedVerdict, StoredTest
from app.modules.service import COUNTS_ANEW, service_due
from app.records.filing import CheckLine, check_line
from app.store.acts import all_fired
from app.store.fact_store import Facts
from app.store.rows import (
    KIND_OF,
    ModuleVisited,
    PreflightCheck,
    Serviced,
    TriggerRecordJudged,
    TriggerRecordSeen,
    time_text,
)
from app.system.clock import age_days
from app.text.messages import UserMessage, join_sentences, message
from protocol.catalogue import BOOTS
from protocol.translatable import marked

CHECK_DAYS = 30
# The clocks of two stations may differ by this much.
CLOCKS = timedelta(minutes=15)
# A contradiction that is older is history: nobody can answer for it any more.
DOUBT_DAYS = 180


class DueKind(StrEnum):
    """What a module may need. The value is the word in JSON."""

    NO_CHECK = "no_check"
    NO_GO = "no_go"
    OLD_CHECK = "old_check"
    TRIGGER_RECORDS = "trigger_records"
    TEST = "test"
    SERVICE = "service"
    TWO_MODULES = "two_modules"


class Due(NamedTuple):
    kind: DueKind
    text: UserMessage


class ModuleToday(Struct, kw_only=True):
    """`checks`: how many. `unjudged`: trigger records without a judgement. `two_modules`: contradictions, as if two
    modules had this name."""

    name: str
    last_at: str
    checks: int
    last_check: CheckLine | None
    trigger_records: int
    unjudged: int
    tests: list[StoredTest]
    two_modules: list[UserMessage]
    due: list[Due] = field(default_factory=list)

    @property
    def due_words(self) -> str:
        """In the language in use."""
        return join_sentences(due.text.translated() for due in self.due)


def report(archive: Archive, now: datetime) -> list[ModuleToday]:
    """By name. Takes up to two seconds. Raises `UserError`."""

    def read(facts: Facts) -> list[ModuleToday]:
        last_at: dict[str, str] = {}
        for file in ("main", "own"):  # each by its index: of both together the whole would be read
            query = f"SELECT module, max(made_at) FROM {file}.facts WHERE module IS NOT NULL GROUP BY module"  # noqa: S608
            for name, at in facts.connection.execute(query):
                last_at[name] = max(at, last_at.get(name, ""))
        return [_today(facts, name, last_at[name], now) for name in sorted(last_at)]

    return archive.read(read)


def _today(facts: Facts, name: str, last_at: str, now: datetime) -> ModuleToday:
    # None of the checks but the last is read: they are large.
    query = "SELECT count(*) FROM facts WHERE kind = ? AND module = ?"
    checks = facts.connection.execute(query, (KIND_OF[PreflightCheck], name)).fetchone()[0]
    # What two stations read of one module is the same record. The last word about it counts, whose it ever is.
    seen = {kept.content.raw for kept in facts.of_module(TriggerRecordSeen, name)}
    judgements = facts.of_module(TriggerRecordJudged, name)
    last_word = {kept.content.raw: kept.content.judgement for kept in judgements}
    tests = last_tests(facts, name, counts_simulated=False)
    state = ModuleToday(
        name=name,
        last_at=last_at,
        checks=checks,
        last_check=_last_check(facts, name),
        trigger_records=len(seen),
        unjudged=sum(last_word.get(raw) is None for raw in seen),
        tests=sorted(tests.values(), key=lambda test: test.kind.value),
        two_modules=_two_modules(facts, name, now),
    )
    state.due += _check_due(state.last_check, now)
    if state.unjudged:
        text = marked("Unjudged trigger records: {count}.")
        state.due.append(Due(DueKind.TRIGGER_RECORDS, message(text, count=state.unjudged)))
    for test in state.tests:
        if test.verdict is not GuidedVerdict.PASSED:
            text, word = marked("Guided test {test}: {verdict}."), message(VERDICT_WORDS[test.verdict])
            state.due.append(Due(DueKind.TEST, message(text, test=message(TITLES[test.kind]), verdict=word)))
    state.due += [Due(DueKind.SERVICE, due.text) for due in service_due(facts, name, now.astimezone())]
    state.due += [Due(DueKind.TWO_MODULES, text) for text in state.two_modules[-1:]]
    return state


def _last_check(facts: Facts, name: str) -> CheckLine | None:
    """A simulated one only if there is no other."""
    checks = facts.back_from_newest(PreflightCheck, name)
    real = next((check for check in checks if not check.content.is_simulated), None)
    last = real or facts.newest(PreflightCheck, name)
    return None if last is None else check_line(last).after(all_fired(facts, name))


def _check_due(check: CheckLine | None, now: datetime) -> list[Due]:
    if check is None or check.is_simulated:
        return [Due(DueKind.NO_CHECK, message(marked("No pre-flight check yet.")))]
    if check.is_fired_since:
        return [Due(DueKind.NO_GO, message(marked("Since the last check it fired, or was told to.")))]
    if not check.holds:
        return [Due(DueKind.NO_GO, message(marked("The last check is not GO.")))]
    age = age_days(check.at, now)
    if age is None or age > CHECK_DAYS:
        return [Due(DueKind.OLD_CHECK, message(marked("No check within the last {days} days."), days=CHECK_DAYS))]
    return []


def _two_modules(facts: Facts, name: str, now: datetime) -> list[UserMessage]:
    """Where the boot count went back within half a year. The time of two stations may differ by minutes, so what they
    read so close together contradicts nothing. An exchange of parts that a person entered later has explained it."""
    parts = [kept.content.on for kept in facts.of_module(Serviced, name) if kept.content.service in COUNTS_ANEW]
    explained = max(parts).isoformat() if parts else ""
    since = time_text(now - timedelta(days=DOUBT_DAYS))
    visits: list[tuple[str, str, int]] = []
    for visit in facts.back_from_newest(ModuleVisited, name):
        if visit.at < since:
            break
        if visit.content.boot_count is not None:
            visits.append((visit.at, visit.row.station, visit.content.boot_count))
    visits.reverse()
    found = []
    for (at_before, station_before, before), (at, station, count) in pairwise(visits):
        has_gone_back = (count - before) % BOOTS >= BOOTS // 2
        if not has_gone_back or at[:10] <= explained:
            continue
        apart = datetime.fromisoformat(at) - datetime.fromisoformat(at_before)
        if station == station_before or apart > CLOCKS:
            text = marked("Two modules? Boot count {before} on {then}, {now} on {day}.")
            found.append(message(text, before=before, then=at_before[:10], now=count, day=at[:10]))
    return found

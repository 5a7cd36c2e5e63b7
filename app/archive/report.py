"""All modules of all stations today: the last check, trigger records, guided tests, and what is due.

For people: it warns and shows. No verdict and no condition of an act rests on it, as others may have written anything.
"""

from collections import Counter
from collections.abc import Iterable, Sequence
from datetime import datetime, timedelta
from typing import NamedTuple

import msgspec
from msgspec import Struct, field

from app.archive.archive import Archive
from app.archive.due import Due, DueKind
from app.guided.guided_store import told_test
from app.guided.results import TITLES, VERDICT_WORDS, GuidedVerdict, StoredTest
from app.modules.service import COUNTS_ANEW, ServiceKind, all_due
from app.records.checks import CheckLine, check_line
from app.store.fact_store import Facts, Kept
from app.store.fired import Fired, all_fired
from app.store.kinds import (
    KIND_OF,
    GuidedTestDone,
    ModuleVisited,
    PreflightCheck,
    Serviced,
    TriggerRecordJudged,
    TriggerRecordSeen,
)
from app.store.modules import went_back
from app.store.rows import AHEAD, time_text
from app.system.wall_clock import age_days
from app.text.messages import UserMessage, message
from app.text.sentences import join_sentences
from protocol.translatable import marked

CHECK_DAYS = 30
TEST_DAYS = 180
CLOCKS = timedelta(minutes=15)
"""The clocks of two stations may differ by this much."""
DOUBT_DAYS = 180
"""A contradiction that is older is history: nobody can answer for it any more."""


class ModuleToday(Struct, kw_only=True):
    """`unjudged`: trigger records without a judgement; `since_repack`: those first read since it was last repacked,
    None where no repack is known; `two_modules`: contradictions, as if two modules had this name."""

    name: str
    last_at: str = ""
    stations: list[str] = field(default_factory=list)
    """The keys of those that checked it."""
    checks: int = 0
    last_check: CheckLine | None = None
    trigger_records: int = 0
    unjudged: int = 0
    since_repack: int | None = None
    tests: list[StoredTest] = field(default_factory=list)
    due: list[Due] = field(default_factory=list)
    two_modules: list[UserMessage] = field(default_factory=list)

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


def report(
    archive: Archive, now: datetime, *, check_days: int = CHECK_DAYS, test_days: int = TEST_DAYS
) -> list[ModuleToday]:
    """By name. Takes up to two seconds. Raises `UserError`."""

    def read(facts: Facts) -> list[ModuleToday]:
        last_at = _last_times(facts)
        return [module_today(facts, name, last_at[name], now, check_days, test_days) for name in sorted(last_at)]

    return archive.read(read)


def module_today(
    facts: Facts, name: str, last_at: str, now: datetime, check_days: int = CHECK_DAYS, test_days: int = TEST_DAYS
) -> ModuleToday:
    """Each kind by the index, and of the many only the last: a fleet has hundreds of thousands of facts."""
    today = now.astimezone().date()
    state = ModuleToday(name=name, last_at=last_at)
    fired = all_fired(facts, name)
    state.checks, state.stations = _checks(facts, name)
    state.last_check = last_check(facts, name, fired)
    seen = facts.of_module(TriggerRecordSeen, name)
    judged = facts.of_module(TriggerRecordJudged, name)
    state.trigger_records = len(_numbered(seen))
    state.unjudged = _unjudged(seen, judged)
    state.tests = _last_tests(facts.of_module(GuidedTestDone, name))
    services = [kept for kept in facts.of_module(Serviced, name) if kept.content.on <= today]
    services.sort(key=lambda kept: (kept.content.on, kept.at))
    state.since_repack = _since_repack(seen, services)
    state.due = [*_check_due(state, now, check_days), *_test_due(state.tests, now, test_days)]
    really_fired = max((one.at for one in fired if not one.is_simulated), default=None)
    for service in all_due(really_fired, services, today):
        state.due.append(Due(DueKind.SERVICE, service.text))
    state.two_modules = two_modules(_boots(facts, name, now), services)
    state.due += [Due(DueKind.TWO_MODULES, text) for text in state.two_modules[-1:]]
    return state


def last_check(facts: Facts, name: str, fired: Iterable[Fired]) -> CheckLine | None:
    """A simulated one only if there is no other."""
    last: Kept[PreflightCheck] | None = None
    for check in facts.back_from_newest(PreflightCheck, name):
        if not check.content.is_simulated:
            return check_line(check).after(fired)
        last = last or check
    return None if last is None else check_line(last).after(fired)


class Boot(NamedTuple):
    """What one station read."""

    at: str
    station: str
    boot_count: int


def two_modules(boots: Iterable[Boot], services: Sequence[Kept[Serviced]]) -> list[UserMessage]:
    """Where the boot count went back. It is one byte, so 0 follows 255, and back is by less than half of the way round.
    The time of two stations may differ by minutes, so what they read so close together contradicts nothing. An exchange
    of parts that a person entered later has explained it."""
    explained = max(
        (kept.content.on.isoformat() for kept in services if kept.content.service in COUNTS_ANEW), default=""
    )
    found = []
    before: Boot | None = None
    for boot in boots:
        if before is not None and went_back(before.boot_count, boot.boot_count):
            apart = datetime.fromisoformat(boot.at) - datetime.fromisoformat(before.at)
            if (boot.station == before.station or apart > CLOCKS) and boot.at[:10] > explained:
                text = marked("Two modules? Boot count {before} on {then}, {now} on {day}.")
                days = {"then": before.at[:10], "day": boot.at[:10]}
                found.append(message(text, before=before.boot_count, now=boot.boot_count, **days))
        before = boot
    return found


def _boots(facts: Facts, name: str, now: datetime) -> list[Boot]:
    """Of the last half year, the oldest first. Of a visit only this is read: there are many."""
    query = (
        "SELECT made_at, station, content FROM facts "
        "WHERE kind = ? AND module = ? AND made_at BETWEEN ? AND ? ORDER BY made_at"
    )
    since, until = time_text(now - timedelta(days=DOUBT_DAYS)), time_text(now + AHEAD)
    found = []
    for at, station, content in facts.connection.execute(query, (KIND_OF[ModuleVisited], name, since, until)):
        try:
            count = _BOOTED.decode(content).boot_count
        except msgspec.DecodeError:
            continue  # changed in place
        if count is not None:
            found.append(Boot(at, station, count))
    return found


class _Booted(Struct):
    boot_count: int | None


_BOOTED = msgspec.json.Decoder(_Booted)


def _last_times(facts: Facts) -> dict[str, str]:
    """The newest fact of each module. Each file by its index: a view of both is slower."""
    last: dict[str, str] = {}
    for file in ("main", "own"):
        query = f"SELECT module, max(made_at) FROM {file}.facts WHERE module IS NOT NULL GROUP BY module"  # noqa: S608
        for name, at in facts.connection.execute(query):
            last[name] = max(at, last.get(name, ""))
    return last


def _checks(facts: Facts, name: str) -> tuple[int, list[str]]:
    """How many, and whose."""
    query = "SELECT station, count(*) FROM facts WHERE kind = ? AND module = ? GROUP BY station ORDER BY station"
    found = facts.connection.execute(query, (KIND_OF[PreflightCheck], name)).fetchall()
    return sum(count for _station, count in found), [station for station, _count in found]


Record = tuple[str, int]
"""The bytes of a trigger record, and which of those of equal bytes it is."""


def _numbered(seen: Sequence[Kept[TriggerRecordSeen]]) -> dict[Record, Kept[TriggerRecordSeen]]:
    """Two triggers may have equal bytes; what two stations read of one module is the same record. Of each the first
    time that it was read."""
    of_station: Counter[tuple[str, str]] = Counter()
    places: set[tuple[str, int]] = set()
    first: dict[Record, Kept[TriggerRecordSeen]] = {}
    for kept in seen:
        place = (kept.row.station, kept.content.place)
        if place in places:
            continue  # a visit that was broken off was written again
        places.add(place)
        raw = kept.content.raw
        first.setdefault((raw, of_station[kept.row.station, raw]), kept)
        of_station[kept.row.station, raw] += 1
    return first


def _unjudged(seen: Sequence[Kept[TriggerRecordSeen]], judged: Sequence[Kept[TriggerRecordJudged]]) -> int:
    """The last word about a record of a station counts; whoever judged it, it is judged."""
    last: dict[tuple[str, int], TriggerRecordJudged] = {}
    for kept in judged:
        last[kept.row.station, kept.content.place] = kept.content
    count: Counter[str] = Counter(word.raw for word in last.values() if word.judgement is not None)
    return sum(number >= count[raw] for raw, number in _numbered(seen))


def _since_repack(seen: Sequence[Kept[TriggerRecordSeen]], services: Sequence[Kept[Serviced]]) -> int | None:
    """By when a record was first read: it has no date of its own."""
    repacks = [kept for kept in services if kept.content.service == ServiceKind.REPACK.value]
    if not repacks:
        return None
    day = repacks[-1].content.on.isoformat()
    # What was read on that day came before a repack entered on it; of one entered later nobody knows, so it counts.
    after = (day, repacks[-1].at if _local_day(repacks[-1].at) == day else "")
    return sum((_local_day(kept.at), kept.at) > after for kept in _numbered(seen).values())


def _local_day(at: str) -> str:
    return datetime.fromisoformat(at).astimezone().date().isoformat()


def _last_tests(tests: Sequence[Kept[GuidedTestDone]]) -> list[StoredTest]:
    """Without those of newer versions, which nobody here could do."""
    last = {}
    for kept in tests:
        test = told_test(kept)
        if test is not None and not test.is_simulated:
            last[test.kind] = test
    return sorted(last.values(), key=lambda test: test.kind.value)


def _check_due(state: ModuleToday, now: datetime, check_days: int) -> list[Due]:
    check, due = state.last_check, []
    if check is None or check.is_simulated:
        due.append(Due(DueKind.NO_CHECK, message(marked("No pre-flight check yet."))))
    elif not check.holds:
        since = marked("Since the last check it fired, or was told to.")
        text = since if check.is_fired_since else marked("The last check is not GO.")
        due.append(Due(DueKind.NO_GO, message(text)))
    elif (age := age_days(check.at, now)) is None or age > check_days:
        due.append(Due(DueKind.OLD_CHECK, message(marked("No check within the last {days} days."), days=check_days)))
    if state.unjudged:
        text = marked("Unjudged trigger records: {count}.")
        due.append(Due(DueKind.TRIGGER_RECORDS, message(text, count=state.unjudged)))
    return due


def _test_due(tests: Iterable[StoredTest], now: datetime, test_days: int) -> list[Due]:
    due = []
    for test in tests:
        title = message(TITLES[test.kind])
        if test.verdict is not GuidedVerdict.PASSED:
            text, verdict = marked("Guided test {test}: {verdict}."), message(VERDICT_WORDS[test.verdict])
            due.append(Due(DueKind.TEST, message(text, test=title, verdict=verdict)))
        elif (age := age_days(test.at, now)) is None or age > test_days:
            text = marked("Guided test not within the last {days} days: {test}.")
            due.append(Due(DueKind.OLD_TEST, message(text, days=test_days, test=title)))
    return due

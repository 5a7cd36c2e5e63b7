"""Reads the trigger records in several passes, since their number and end are not specified (E6).

    query until two clean passes in a row agree with everything seen -> is the line good? -> `History`

No record of any pass is discarded: one in two passes is certain; one in a single pass, or after its query was given up,
is listed as seen once. Without an answer the records are unknown, not "none". A lost frame leaves no trace in a pass,
so heartbeats test at the end whether the line loses or doubles frames.
"""

from collections import Counter
from collections.abc import Sequence
from typing import NamedTuple

from app.engine.procedure import Ask, EngineView, Inspect, Procedure, Report, ask_value
from protocol.catalogue import BOOT_COUNT, HEARTBEAT, MAX_RECORDS, TRIGGER_RECORDS
from protocol.events import Answered, Counters, Role
from protocol.messages import Message, TriggerRecord
from protocol.translatable import marked

# After so many passes the union of all is returned as incomplete.
MAX_PASSES = 5
# After this many passes without an answer the module does not know the query.
UNANSWERED_PASSES = 3
LINE_HEARTBEATS = 20


class History(NamedTuple):
    """Records in the order in which the module sent them. `records` are certain: they came in at least two passes."""

    records: tuple[TriggerRecord, ...] = ()
    empty_slots: int = 0
    # Complete: two clean passes in a row are equal, no other pass has more, and the line loses nothing.
    is_confirmed: bool = False
    # In a single pass: lost in the others, or damaged.
    seen_once: tuple[TriggerRecord, ...] = ()
    # The module answered the query at least once; else nothing is known about its records.
    is_answered: bool = False

    @property
    def all(self) -> tuple[TriggerRecord, ...]:
        """The certain ones first."""
        return self.records + self.seen_once


class Pass(NamedTuple):
    """The replies to one query. `is_clean`: nothing was rejected, doubled or unasked meanwhile, any of which may have
    been a record."""

    messages: tuple[Message, ...]  # records and empty slots
    is_clean: bool = False

    @property
    def records(self) -> tuple[TriggerRecord, ...]:
        return tuple(message for message in self.messages if isinstance(message, TriggerRecord))

    @property
    def counts(self) -> Counter[TriggerRecord]:
        """The module may hold equal records."""
        return Counter(self.records)


def read_history() -> Procedure[History]:
    begin: EngineView = yield Inspect()
    passes: list[Pass] = []
    is_confirmed = False
    for turn in range(MAX_PASSES):
        yield Report(turn, MAX_PASSES, marked("Reading the trigger records"))
        passes.append((yield from _read_once()))
        if _agree(passes) and (yield from _is_line_good()):
            is_confirmed = True
            break
        if turn + 1 >= UNANSWERED_PASSES and not any(answer.messages for answer in passes):
            break
    yield from ask_value(BOOT_COUNT)  # all of it was one module's, or this ends it
    end: EngineView = yield Inspect()
    strays = end.conversation.stray_records[len(begin.conversation.stray_records) :]
    return _combined(passes, strays, is_confirmed=is_confirmed)


def _read_once() -> Procedure[Pass]:
    before: EngineView = yield Inspect()
    outcome = yield Ask(TRIGGER_RECORDS.query())
    after: EngineView = yield Inspect()
    answer = Pass(outcome.messages if isinstance(outcome, Answered) else ())
    counts = answer.counts.values()
    is_doubled = bool(counts) and all(count % 2 == 0 for count in counts)  # as on a line that doubles frames
    return answer._replace(is_clean=not is_doubled and _is_clean(after.link.counters - before.link.counters))


def _is_clean(counted: Counters) -> bool:
    # The boot count that the link asks behind a query counts as late: it is no sign of a lost record.
    strays = counted.by_role[Role.DUPLICATE] + counted.by_role[Role.UNSOLICITED]
    return not (counted.rejected or counted.time_outs or counted.retries or strays)


def _agree(passes: Sequence[Pass]) -> bool:
    """Whether the last two are clean and equal, and contain the records of all passes."""
    last = passes[-1]
    if len(passes) < 2 or not last.messages or not last.is_clean or passes[-2] != last:
        return False
    return all(answer.counts <= last.counts for answer in passes)


def _is_line_good() -> Procedure[bool]:
    """Test with heartbeats whether the line loses or doubles frames."""
    before: EngineView = yield Inspect()
    for _ in range(LINE_HEARTBEATS):
        yield Ask(HEARTBEAT.query())
    after: EngineView = yield Inspect()
    return _is_clean(after.link.counters - before.link.counters)


def _combined(passes: Sequence[Pass], strays: Sequence[TriggerRecord], *, is_confirmed: bool) -> History:
    """All that came, in the order of the fullest pass. `strays`: came outside an answer."""
    fullest_first = sorted(passes, key=lambda answer: len(answer.messages), reverse=True)
    most: Counter[TriggerRecord] = Counter()
    for answer in fullest_first:
        most |= answer.counts
    news = tuple(stray for stray in dict.fromkeys(strays) if stray not in most)
    if is_confirmed:
        records, seen_once = passes[-1].records, news
    else:
        # An equal second one is not certain, as a line may double frames.
        records = tuple(record for record in most if sum(record in answer.counts for answer in passes) > 1)
        seen_once = (*(most - Counter(records)).elements(), *news)
    empty = max(len(answer.messages) - len(answer.records) for answer in passes)
    empty = min(empty, max(0, MAX_RECORDS - len(records) - len(seen_once)))  # that pass may lack a record
    is_answered = bool(news) or any(answer.messages for answer in passes)
    return History(records, empty, is_confirmed and not news, seen_once, is_answered)

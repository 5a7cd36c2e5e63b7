"""Reads the trigger records in several passes, since their number and end are not specified (E6).

    query until two clean passes in a row agree with everything seen -> is the line good? -> `History`

No record of any pass is discarded: one in two passes is certain; one in a single pass, or after its query was given up,
is listed as seen once. Without an answer the records are unknown, not "none". A lost frame leaves no trace in a pass,
so heartbeats test at the end whether the line loses or doubles frames.
"""

from collections import Counter
from collections.abc import Sequence
from itertools import combinations
from typing import NamedTuple

from app.engine.procedure import Ask, EngineView, Inspect, Procedure, Report, is_alive
from protocol.catalogue import MAX_RECORDS, TRIGGER_RECORDS
from protocol.events import Answered, Role
from protocol.messages import EmptySlot, TriggerRecord
from protocol.translatable import marked

MAX_SEARCH_LENGTH = 5
"""Passes after which the union of all is returned as incomplete."""
UNANSWERED_PASSES = 3
"""After this many passes without an answer the module does not know the query."""
LINE_HEARTBEATS = 20


class History(NamedTuple):
    """Records in the order in which the module sent them."""

    records: tuple[TriggerRecord, ...] = ()
    """Certain: in at least two passes."""
    empty_slots: int = 0
    is_confirmed: bool = False
    """Complete: two clean passes in a row are equal, no other pass has more, and the line loses nothing."""
    is_line_dead: bool = False
    seen_once: tuple[TriggerRecord, ...] = ()
    """In a single pass: lost in the others, or damaged."""
    is_answered: bool = False
    """The module answered the query at least once; else nothing is known about its records."""
    may_be_of_two: bool = False
    """Two clean passes hold each what the other lacks: lost without a trace, or another module answered."""

    @property
    def all(self) -> tuple[TriggerRecord, ...]:
        """The certain ones first."""
        return self.records + self.seen_once


class Pass(NamedTuple):
    """The replies to one query."""

    messages: tuple[TriggerRecord | EmptySlot, ...]
    is_clean: bool = False
    """Nothing was rejected, late, doubled, unasked or timed out meanwhile, any of which may have been a record."""

    @property
    def is_doubled(self) -> bool:
        """Whether every record came an even number of times, as on a line that doubles frames."""
        counts = self.counts
        return bool(counts) and all(count % 2 == 0 for count in counts.values())

    @property
    def counts(self) -> Counter[TriggerRecord]:
        return Counter(message for message in self.messages if isinstance(message, TriggerRecord))


def read_history() -> Procedure[History]:
    begin: EngineView = yield Inspect()
    history = yield from _read_passes()
    end: EngineView = yield Inspect()
    return _with_strays(history, end.device.stray_records[len(begin.device.stray_records) :])


def _with_strays(history: History, strays: Sequence[TriggerRecord]) -> History:
    """Add the records received outside an answer that no pass has."""
    news = tuple(
        stray for stray in dict.fromkeys(strays) if stray not in history.all and not _is_damaged_slot(stray.raw)
    )
    if not news:
        return history
    return history._replace(seen_once=history.seen_once + news, is_confirmed=False, is_answered=True)


def _read_passes() -> Procedure[History]:
    passes: list[Pass] = []
    for turn in range(MAX_SEARCH_LENGTH):
        yield Report(turn, MAX_SEARCH_LENGTH, marked("Reading the trigger records"))
        answer = yield from _read_once()
        if not answer.messages and not (yield from is_alive(None)):
            return history_of(passes, is_line_dead=True)
        passes.append(answer)
        if _agree(passes) and (yield from _is_line_good()):
            return history_of(passes, is_confirmed=True)
        if turn + 1 >= UNANSWERED_PASSES and not any(answer.messages for answer in passes):
            break
    return history_of(passes)


def _read_once() -> Procedure[Pass]:
    before: EngineView = yield Inspect()
    outcome = yield Ask(TRIGGER_RECORDS.query())
    messages = outcome.messages if isinstance(outcome, Answered) else ()
    seen = tuple(
        message
        for message in messages
        if isinstance(message, TriggerRecord | EmptySlot) and not _is_damaged_slot(message.raw)
    )
    after: EngineView = yield Inspect()
    answer = Pass(seen, is_clean=len(seen) == len(messages) and _is_clean(before, after))
    return answer._replace(is_clean=False) if answer.is_doubled else answer


def _is_damaged_slot(raw: bytes) -> bool:
    """Whether it is an unused slot with one flipped bit and a flipped bit in the sum: a real record differs from an
    unused slot in many bits."""
    differing = [sum((byte ^ fill).bit_count() for byte in raw[4:-1]) for fill in (0x00, 0xFF)]
    return min(differing) == 1


def _is_clean(before: EngineView, after: EngineView) -> bool:
    old, new = before.link.counters, after.link.counters
    stray = (Role.LATE, Role.DUPLICATE, Role.UNSOLICITED)
    is_quiet = (old.rejected, old.time_outs, old.retries) == (new.rejected, new.time_outs, new.retries)
    return is_quiet and all(old.by_role[role] == new.by_role[role] for role in stray)


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
        yield from is_alive()
        after: EngineView = yield Inspect()
        if not _is_clean(before, after):
            return False
    return True


def history_of(passes: Sequence[Pass], *, is_confirmed: bool = False, is_line_dead: bool = False) -> History:
    """Combine the passes, the records of the fullest pass first. The module may hold equal records. The second answer
    is certain only in a confirmed history, as a line may double frames."""
    seen: Counter[TriggerRecord] = Counter()
    for answer in passes:
        seen |= answer.counts
    records: list[TriggerRecord] = []
    seen_once: list[TriggerRecord] = []
    for record in _in_order(passes):
        passes_with = sum(record in answer.counts for answer in passes)
        certain = seen[record] if is_confirmed else int(passes_with > 1)
        records += [record] * certain
        seen_once += [record] * (seen[record] - certain)
    if is_confirmed:  # as the module sent them, equal ones too
        records = [message for message in passes[-1].messages if isinstance(message, TriggerRecord)]
    empty = max((sum(isinstance(message, EmptySlot) for message in answer.messages) for answer in passes), default=0)
    empty = min(empty, max(0, MAX_RECORDS - len(records) - len(seen_once)))  # that pass may lack a record
    is_answered = any(answer.messages for answer in passes)
    clean = [answer.counts for answer in passes if answer.is_clean]
    may_be_of_two = any(not (one <= other or other <= one) for one, other in combinations(clean, 2))
    return History(tuple(records), empty, is_confirmed, is_line_dead, tuple(seen_once), is_answered, may_be_of_two)


def _in_order(passes: Sequence[Pass]) -> tuple[TriggerRecord, ...]:
    """Each record once, in the order of the fullest pass, then those of other passes."""
    ordered = sorted(passes, key=lambda answer: len(answer.messages), reverse=True)
    return tuple(dict.fromkeys(m for answer in ordered for m in answer.messages if isinstance(m, TriggerRecord)))

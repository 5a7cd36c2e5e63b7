"""Reads the trigger records in several passes, since their number and end are not specified (E6).

    ask, until two clean passes in a row agree with all that was ever seen -> is the line good? -> `History`

What came in any pass is never thrown away: a record that came in two passes is certain, one that came in a single pass,
or after its query had been given up, is listed as seen once. A query that was never answered is unknown, not "none".
Frames that are lost as a whole leave no trace in a pass, so heartbeats show at the end whether the line loses or
doubles frames.
"""

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import NamedTuple

from app.engine.procedure import Ask, EngineView, Inspect, Procedure, Report
from protocol.catalogue import HEARTBEAT, RECORDS_KEPT, TRIGGER_RECORDS
from protocol.events import Answered, Role
from protocol.messages import EmptySlot, TriggerRecord
from protocol.translatable import marked

LONGEST_SEARCH = 5
"""Passes after which the union of all is handed on as incomplete."""
UNANSWERED_PASSES = 3
"""After so many passes without any answer the module does not answer this query."""
LINE_HEARTBEATS = 20
HEARTBEAT_WAITS_S = (1.0,)


@dataclass(frozen=True, slots=True)
class History:
    """Records in the order in which the module sent them."""

    records: tuple[TriggerRecord, ...] = ()
    """Certain: each came in at least two passes."""
    empty_slots: int = 0
    is_confirmed: bool = False
    """Complete: two clean passes in a row brought the same, no other pass brought more, and the line loses nothing."""
    is_line_dead: bool = False
    seen_once: tuple[TriggerRecord, ...] = ()
    """Came in a single pass: lost in the others, or never there."""
    is_answered: bool = False
    """The module answered the query at least once; without, nothing is known about its records."""

    @property
    def all(self) -> tuple[TriggerRecord, ...]:
        """The certain ones first."""
        return self.records + self.seen_once


class Pass(NamedTuple):
    """What one query brought."""

    messages: tuple[TriggerRecord | EmptySlot, ...]
    is_clean: bool = False
    """Nothing was rejected, late, doubled, timed out or out of turn meanwhile: any of it may have been a record."""

    @property
    def is_doubled(self) -> bool:
        """Every record came an even number of times, as on a line that doubles what it carries."""
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
    """What came outside an answer belongs to no pass: it is listed where no pass brought it."""
    news = tuple(one for one in dict.fromkeys(strays) if one not in history.all and not _is_damaged_slot(one.raw))
    if not news:
        return history
    return replace(history, seen_once=history.seen_once + news, is_confirmed=False, is_answered=True)


def _read_passes() -> Procedure[History]:
    passes: list[Pass] = []
    for turn in range(LONGEST_SEARCH):
        yield Report(turn, LONGEST_SEARCH, marked("Reading the trigger records"))
        one = yield from _read_once()
        if not one.messages:
            alive = yield Ask(HEARTBEAT.query())
            if not isinstance(alive, Answered):
                return history_of(passes, is_line_dead=True)
        passes.append(one)
        if _agree(passes) and (yield from _is_line_good()):
            return history_of(passes, is_confirmed=True)
        if turn + 1 >= UNANSWERED_PASSES and not any(one.messages for one in passes):
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
    one = Pass(seen, is_clean=len(seen) == len(messages) and _is_clean(before, after))
    return one._replace(is_clean=False) if one.is_doubled else one


def _is_damaged_slot(raw: bytes) -> bool:
    """A slot never used of which one bit was flipped on the line, and one of the sum so that it fits: the settings and
    voltages of a true record differ from such a slot in many bits."""
    differing = [sum((byte ^ fill).bit_count() for byte in raw[4:-1]) for fill in (0x00, 0xFF)]
    return min(differing) == 1


def _is_clean(before: EngineView, after: EngineView) -> bool:
    old, new = before.link.counters, after.link.counters
    stray = (Role.LATE, Role.DOUBLED, Role.UNASKED)
    is_quiet = (old.rejected, old.time_outs, old.retries) == (new.rejected, new.time_outs, new.retries)
    return is_quiet and all(old.by_role[role] == new.by_role[role] for role in stray)


def _agree(passes: Sequence[Pass]) -> bool:
    """Whether the last two are clean and equal, and hold all that any pass brought."""
    last = passes[-1]
    if len(passes) < 2 or not last.messages or not (last.is_clean and passes[-2].is_clean) or passes[-2] != last:
        return False
    return all(one.counts <= last.counts for one in passes)


def _is_line_good() -> Procedure[bool]:
    """Whether frames are neither lost nor doubled, as far as some heartbeats tell."""
    before: EngineView = yield Inspect()
    for _ in range(LINE_HEARTBEATS):
        yield Ask(HEARTBEAT.query(), HEARTBEAT_WAITS_S)
        after: EngineView = yield Inspect()
        if not _is_clean(before, after):
            return False
    return True


def history_of(passes: Sequence[Pass], *, is_confirmed: bool = False, is_line_dead: bool = False) -> History:
    """All records seen, those of the fullest pass first.

    Equal records are counted: the module may hold two. A second copy is certain only in a confirmed history, because a
    line may double frames.
    """
    seen: Counter[TriggerRecord] = Counter()
    for one in passes:
        seen |= one.counts
    records: list[TriggerRecord] = []
    seen_once: list[TriggerRecord] = []
    for record in _in_order(passes):
        passes_with = sum(record in one.counts for one in passes)
        certain = seen[record] if is_confirmed else int(passes_with > 1)
        records += [record] * certain
        seen_once += [record] * (seen[record] - certain)
    if is_confirmed:  # as the module sent them, equal ones too
        records = [message for message in passes[-1].messages if isinstance(message, TriggerRecord)]
    empty = max((sum(isinstance(message, EmptySlot) for message in one.messages) for one in passes), default=0)
    empty = min(empty, max(0, RECORDS_KEPT - len(records) - len(seen_once)))  # a record may be missing in that pass
    is_answered = any(one.messages for one in passes)
    return History(tuple(records), empty, is_confirmed, is_line_dead, tuple(seen_once), is_answered)


def _in_order(passes: Sequence[Pass]) -> tuple[TriggerRecord, ...]:
    """Each record once: as the fullest pass brought them, then what only others had."""
    ordered = sorted(passes, key=lambda one: len(one.messages), reverse=True)
    return tuple(dict.fromkeys(m for one in ordered for m in one.messages if isinstance(m, TriggerRecord)))

"""The trigger records. The table says neither how many come nor when they end (E6), so one pass proves little."""

from dataclasses import dataclass

from app.procedure import Ask, Look, Procedure, Report, Sight
from protocol.catalogue import HEARTBEAT, TRIGGER_RECORDS
from protocol.events import Answered, Role
from protocol.messages import EmptySlot, TriggerRecord
from protocol.text import marked

LONGEST_SEARCH = 5
"""Passes after which the union of all is handed on as incomplete."""


@dataclass(frozen=True, slots=True)
class History:
    """`records` in the order in which the module sent them."""

    records: tuple[TriggerRecord, ...] = ()
    empty_slots: int = 0
    is_confirmed: bool = False
    """Two clean passes in a row brought the same: nothing was lost on the line."""
    is_line_dead: bool = False


@dataclass(frozen=True, slots=True)
class _Pass:
    messages: tuple[TriggerRecord | EmptySlot, ...]

    @property
    def is_twice_the_same(self) -> bool:
        """As on a line that doubles what it carries, and hardly ever in a module's memory."""
        half = len(self.messages) // 2
        has_records = any(isinstance(message, TriggerRecord) for message in self.messages)
        return has_records and self.messages[:half] == self.messages[half:]


def read_history() -> Procedure[History]:
    passes: list[_Pass] = []
    was_clean = False
    for turn in range(LONGEST_SEARCH):
        yield Report(turn, LONGEST_SEARCH, marked("Reading the trigger records"))
        before: Sight = yield Look()
        outcome = yield Ask(TRIGGER_RECORDS.query())
        messages = outcome.messages if isinstance(outcome, Answered) else ()
        if not messages:
            alive = yield Ask(HEARTBEAT.query())
            if not isinstance(alive, Answered):
                return _history(passes, is_line_dead=True)
        now_seen = _Pass(tuple(message for message in messages if isinstance(message, TriggerRecord | EmptySlot)))
        after: Sight = yield Look()
        is_clean = _is_clean(before, after) and not now_seen.is_twice_the_same
        if is_clean and was_clean and passes[-1] == now_seen:
            return _history([now_seen], is_confirmed=True)
        passes.append(now_seen)
        was_clean = is_clean
    return _history(passes)


def _is_clean(before: Sight, after: Sight) -> bool:
    """Nothing was rejected, late, doubled or out of turn meanwhile: any of it may have been a record."""
    old, new = before.link.counters, after.link.counters
    stray = (Role.LATE, Role.DOUBLED, Role.UNASKED)
    return old.rejected == new.rejected and all(old.by_role[role] == new.by_role[role] for role in stray)


def _history(passes: list[_Pass], *, is_confirmed: bool = False, is_line_dead: bool = False) -> History:
    """All records seen: those of the fullest pass, then what only the others had."""
    if not passes:
        return History(is_line_dead=is_line_dead)
    ordered = sorted(passes, key=lambda one: len(one.messages), reverse=True)
    records: list[TriggerRecord] = []
    for one in ordered:
        seen = list(records)
        for message in one.messages:
            if not isinstance(message, TriggerRecord):
                continue
            if message in seen:
                seen.remove(message)  # the module may hold two equal records
            else:
                records.append(message)
    empty = max(sum(isinstance(message, EmptySlot) for message in one.messages) for one in passes)
    return History(tuple(records), empty, is_confirmed, is_line_dead)

"""Reads the trigger records in several passes, since their number and end are not specified (E6).

    query until two clean passes in a row agree with everything seen -> is the line good? -> `History`

No record of any pass is discarded: one in two passes is certain; one in a single pass is listed as seen once. Without
an answer the records are unknown, not "none". A lost frame leaves no trace in a pass, so heartbeats test at the end
whether the line loses or doubles frames.
"""

from collections import Counter
from typing import NamedTuple

from app.engine.procedure import Ask, Procedure, Report, ask_value
from protocol.catalogue import BOOT_COUNT, HEARTBEAT, MAX_RECORDS, TRIGGER_RECORDS
from protocol.events import Answered, Reply
from protocol.messages import Message, TriggerRecord
from protocol.translatable import marked

# After so many passes the union of all is returned as incomplete.
MAX_PASSES = 5
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


def read_history() -> Procedure[History]:
    passes: list[tuple[Message, ...]] = []  # records and empty slots
    counts: list[Counter[TriggerRecord]] = []  # the module may hold equal records
    is_confirmed = was_clean = False
    while not is_confirmed and len(passes) < MAX_PASSES:
        yield Report(len(passes), MAX_PASSES, marked("Reading the trigger records"))
        outcome = yield Ask(TRIGGER_RECORDS.query())
        passes.append(outcome.messages if isinstance(outcome, Answered) else ())
        counts.append(Counter(one for one in passes[-1] if isinstance(one, TriggerRecord)))
        last = counts[-1]
        is_doubled = bool(last) and all(count % 2 == 0 for count in last.values())  # as on a line that doubles frames
        is_clean = _is_clean(outcome) and not is_doubled
        is_same = is_clean and was_clean and passes[-1] == passes[-2]
        is_confirmed = is_same and all(earlier <= last for earlier in counts)
        was_clean = is_clean
        if is_confirmed:
            # A pass does not show a record that was lost in each. So whether the line loses or doubles frames is tested
            # with heartbeats; the boot count comes behind every copy of one.
            for command in (HEARTBEAT,) * LINE_HEARTBEATS + (BOOT_COUNT,):
                is_confirmed &= _is_clean((yield Ask(command.query())))
    yield from ask_value(BOOT_COUNT)  # all of it was one module's, or this ends it
    most: Counter[TriggerRecord] = Counter()
    for earlier in sorted(counts, key=Counter.total, reverse=True):  # in the order of the fullest pass
        most |= earlier
    records = tuple(most.elements()) if is_confirmed else ()
    if not is_confirmed:
        # An equal second one is not certain, as a line may double frames.
        records = tuple(record for record in most if sum(record in earlier for earlier in counts) > 1)
    seen_once = tuple((most - Counter(records)).elements())
    empty = max(len(one) - count.total() for one, count in zip(passes, counts, strict=True))
    empty = min(empty, max(0, MAX_RECORDS - len(records) - len(seen_once)))  # that pass may lack a record
    return History(records, empty, is_confirmed, seen_once, any(map(bool, passes)))


def _is_clean(outcome: Reply) -> bool:
    """Whether nothing was lost, rejected, doubled or unasked on the way, any of which may have been a record."""
    return isinstance(outcome, Answered) and outcome.attempts == 1 and not (outcome.rejected or outcome.strays)

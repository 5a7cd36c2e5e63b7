"""Merged history of a module's trigger records, and records as sentences.

A module keeps nine records. `merge` adds those on the module to those seen before. Records have no number, and two
triggers may have equal bytes, so records are aligned and counted, never identified by their bytes alone.
"""

from collections import Counter
from collections.abc import Sequence
from enum import Enum
from typing import NamedTuple

from app.limits.out_of_limits import record_outside
from app.text.i18n import tr
from app.text.messages import UserMessage, joined, message
from app.text.sentences import in_brackets
from app.trigger_records.fields import source_message
from protocol.catalogue import BOOTS, MAX_RECORDS, RECORD_PART
from protocol.messages import EmptySlot, TriggerRecord, decode_record
from protocol.translatable import marked

MAX_UPTIME_S = 65535
"""Largest value of the counter ("最高记录65535秒")."""


class Judgement(Enum):
    """A person's judgement of a record; the value is stored."""

    BENCH_TEST = "bench test"
    REAL = "real"
    FALSE = "false"
    REVIEWED = "reviewed"
    """Looked at, and known; also the word with which a person passes a pre-flight check."""


JUDGEMENT_WORDS = {
    Judgement.BENCH_TEST: marked("bench test"),
    Judgement.REAL: marked("real"),
    Judgement.FALSE: marked("false trigger"),
    Judgement.REVIEWED: marked("reviewed"),
}


class Merged(NamedTuple):
    """`new`: the records that were not known, oldest first. `is_continuation` is False where the records do not
    continue those of the last visit, as if it were another module."""

    new: tuple[bytes, ...]
    is_continuation: bool = True


def merge(
    known: Sequence[bytes],
    last_slots: Sequence[bytes],
    slots: Sequence[bytes],
    *,
    boot_count: int | None = None,
    is_confirmed: bool = True,
) -> Merged:
    """`known`: all records seen before. `last_slots` and `slots`: the records at the last visit and now, as sent:
    oldest first, newest first or from the middle (E6). `boot_count`: the present one, to order across its wrap.

    `is_confirmed` False: some of `slots` may be missing, so nothing is concluded from absent ones.
    """
    if not known:
        return Merged(in_order(slots, boot_count))
    fresh = _lined_up(last_slots, slots)
    if fresh is None:
        fresh = _counted(last_slots, slots)
    kept = len(slots) - len(fresh)
    # Once all nine slots are full, each new record replaces one.
    room = MAX_RECORDS - len(last_slots)
    expected = len(last_slots) - max(0, len(fresh) - room)
    is_continuation = not is_confirmed or kept >= min(expected, len(last_slots))
    return Merged(in_order(fresh, boot_count), is_continuation)


def _lined_up(last: Sequence[bytes], now: Sequence[bytes]) -> list[bytes] | None:
    """The fewest new records that explain `now` in order of time; None where it is in no such order."""
    candidates = []
    for turned in (1, -1):
        before, after = list(last)[::turned], list(now)[::turned]
        least = max(0, len(after) - MAX_RECORDS)
        for pushed_out in range(least, len(before) + 1):
            left = before[pushed_out:]
            fresh = after[len(left) :]
            is_room_needed = len(before) + len(fresh) - MAX_RECORDS
            if left and after[: len(left)] == left and pushed_out == max(0, is_room_needed):
                candidates.append(fresh)
                break
    return min(candidates, key=len, default=None)


def _counted(last: Sequence[bytes], now: Sequence[bytes]) -> list[bytes]:
    """The new records regardless of order: those that occur more often than before."""
    rest = Counter(last)
    fresh = []
    for raw in now:
        if rest[raw]:
            rest[raw] -= 1
        else:
            fresh.append(raw)
    return fresh


def in_order(raws: Sequence[bytes], boot_count: int | None) -> tuple[bytes, ...]:
    """Oldest first: by boot count, relative to `boot_count` because it wraps at 256, then by uptime. Stable."""

    def age(raw: bytes) -> tuple[int, int]:
        boots = RECORD_PART["boot_count"].raw(raw)
        return boots if boot_count is None else -((boot_count - boots) % BOOTS), RECORD_PART["uptime_s"].raw(raw)

    return tuple(sorted(raws, key=age))


def record_of(raw: bytes) -> TriggerRecord:
    """Decodes a stored record. Raises `ValueError`."""
    if len(raw) != 16:
        raise ValueError(raw.hex())
    record = decode_record(raw)
    if isinstance(record, EmptySlot):
        raise ValueError(raw.hex())
    return record


# Sentences


def sentence(record: TriggerRecord) -> UserMessage:
    """ "tipped past 60° 1 min 48 s after power-on of boot 1, serial link connected, 4.70 V (implausible)" """
    return message(
        marked("{what} {uptime} after power-on of boot {boot}, {link}, {voltage}"),
        what=cause_message(record),
        uptime=uptime_message(record),
        boot=str(record.boot_count),
        link=message(
            marked("serial link connected") if record.serial_connected else marked("serial link not connected")
        ),
        voltage=_voltage(record),
    )


def uptime_message(record: TriggerRecord) -> UserMessage:
    """ "1 min 48 s"; the counter stops at its largest value, which is shown as "at least"."""
    minutes, seconds = divmod(record.uptime_s, 60)
    hours, minutes = divmod(minutes, 60)
    if hours:
        text = message(marked("{hours} h {minutes} min {seconds} s"), hours=hours, minutes=minutes, seconds=seconds)
    elif minutes:
        text = message(marked("{minutes} min {seconds} s"), minutes=minutes, seconds=seconds)
    else:
        text = message(marked("{value} s"), value=seconds)
    return message("≥ {time}", time=text) if record.uptime_s >= MAX_UPTIME_S else text


def cause_message(record: TriggerRecord) -> UserMessage:
    """ "tipped past 60° + fell (below 0.5 g for 1.60 s)" """
    parts = [_cause(source, record) for source in record.sources]
    if not parts:
        return message(marked("no cause stated"))
    return joined(parts, " + ")


def _cause(source: str, record: TriggerRecord) -> UserMessage:
    match source:
        case "attitude":
            return message(marked("tipped past {threshold}"), threshold=f"{record.attitude_threshold_deg}°")
        case "freefall":
            return message(
                marked("fell (below {acceleration} for {seconds})"),
                acceleration=f"{record.freefall_acceleration_g:.1f} g",
                seconds=f"{record.freefall_time_s:.2f} s",
            )
        case _:
            return message(marked("fired by {source}"), source=source_message(source))


def _voltage(record: TriggerRecord) -> UserMessage:
    volts = f"{record.cell_voltage_v:.2f} V"
    if record.charging:
        return message(marked("on external power, {voltage}"), voltage=volts)
    if "cell_voltage_v" in record.implausible:
        return message(marked("{text} (implausible)"), text=volts)
    outside = record_outside(record)
    if outside is None:
        return UserMessage(volts)
    return message(marked("{value}, {fault}"), value=volts, fault=message(outside.fault.value))


def cell_text(record: TriggerRecord) -> str:
    """Its cell voltage with what is wrong with it, in the language in use."""
    volts, outside = f"{record.cell_voltage_v:.2f} V", record_outside(record)
    if outside is not None:
        return f"{volts}{in_brackets(tr(outside.fault.value))}"
    return tr("{text} (implausible)", text=volts) if record.implausible else volts

"""Where in a flight log a trigger record may have been made: the moments at which the log meets the record's cause.

A record has no time of day and the log's clock is another one, so a moment is a proposal that a person confirms.
"""

from collections.abc import Sequence
from typing import Final, NamedTuple

import numpy as np

from app.firing.judge import TriggerLimits
from app.flight_analysis.curves import JudgedFlight, LogFiring, judge_flight
from app.flight_analysis.summary import moment_text
from app.flight_logs.flight_log import FlightLog
from app.flight_logs.module_view import RuleReading
from app.text.messages import UserMessage, joined, message
from app.trigger_records.history import MAX_UPTIME_S, cause_message
from protocol.messages import Source, TriggerRecord
from protocol.translatable import marked

IN_LOGS: Final = {"attitude": Source.ATTITUDE, "freefall": Source.FREEFALL}
"""The sources whose cause a flight log shows; a serial or PWM command leaves no trace in it."""
MAX_MOMENTS: Final = 20
SAME_S: Final = 1.0
"""Two readings of the rule that fire within this time mean the same moment."""
BEFORE_S: Final = 5.0
"""A trigger that the record does not name counts as an objection if it fires within this time before."""


class Moment(NamedTuple):
    """A moment of the log at which the record's sources fire with the record's settings."""

    firing: LogFiring
    readings: frozenset[RuleReading]
    """Those of the vendor's rule under which it fires."""
    unnamed_s: float | None
    """When the other trigger would have fired just before; the record does not name it. None: it would not have."""


class RecordMatch(NamedTuple):
    """`moments` in order of time, the first `MAX_MOMENTS`. `why_none` says why there is none."""

    moments: tuple[Moment, ...] = ()
    has_more: bool = False
    why_none: UserMessage | None = None

    @property
    def likeliest(self) -> Moment | None:
        """The moment with the fewest objections, the earliest of those."""
        return min(self.moments, key=lambda moment: (moment.unnamed_s is not None, -len(moment.readings)), default=None)


def record_limits(record: TriggerRecord) -> TriggerLimits:
    """The settings in the record. It does not say which triggers were enabled, so both count as enabled."""
    return TriggerLimits(record.attitude_threshold_deg, record.freefall_acceleration_g, record.freefall_time_s)


def match_record(record: TriggerRecord, log: FlightLog) -> RecordMatch:
    """Takes about 20 ms for a flight of ten minutes."""
    limits = record_limits(record)
    named = Source(0)
    for name in record.sources:
        named |= IN_LOGS.get(name, Source(0))
    why_none = _why_hopeless(record, named, log)
    if why_none is not None:
        return RecordMatch(why_none=why_none)
    judged = {reading: judge_flight(log, limits, reading) for reading in RuleReading}
    moments: list[Moment] = []
    for reading in RuleReading:
        for firing, unnamed_s in _firings(judged[reading].firings, named, limits):
            same = next((moment for moment in moments if abs(moment.firing.at_s - firing.at_s) <= SAME_S
                         and reading not in moment.readings), None)  # fmt: skip
            if same is None:
                moments.append(Moment(firing, frozenset({reading}), unnamed_s))
            else:
                moments[moments.index(same)] = Moment(same.firing, same.readings | {reading}, same.unnamed_s)
    moments.sort(key=lambda moment: moment.firing.at_s)
    if moments:
        return RecordMatch(tuple(moments[:MAX_MOMENTS]), has_more=len(moments) > MAX_MOMENTS)
    return RecordMatch(why_none=_why_none(log, named, judged[RuleReading.DIRECT]))


def _firings(
    firings: Sequence[LogFiring], named: Source, limits: TriggerLimits
) -> list[tuple[LogFiring, float | None]]:
    """Firings of all named sources at about the same time, each with the time of an unnamed one just before."""
    matching = []
    others = [other for other in firings if other.sources & ~named]
    together_s = limits.freefall_time_s + SAME_S  # while it falls that long it may tip over as well
    for firing in firings:
        have = firing.sources & named
        for before in firings:
            if have and before.at_s <= firing.at_s <= before.at_s + together_s:
                have |= before.sources & named
        if have == named and firing.sources & named:
            unnamed = [other.at_s for other in others if other.at_s <= firing.at_s <= other.at_s + BEFORE_S]
            matching.append((firing._replace(sources=named), unnamed[-1] if unnamed else None))
    return matching


def _why_hopeless(record: TriggerRecord, named: Source, log: FlightLog) -> UserMessage | None:
    if not named:
        return message(marked("No flight log shows this cause: {cause}."), cause=cause_message(record))
    if Source.ATTITUDE in named and not np.isfinite(log.tilt_deg).any():
        return message(marked("No attitude: attitude trigger not judged."))
    if Source.FREEFALL in named and not np.isfinite(log.specific_force_g).any():
        return message(marked("No acceleration: free-fall trigger not judged."))
    if not log.is_judged.any():
        return message(marked("No flight in this log."))
    return None


def _why_none(log: FlightLog, named: Source, judged: JudgedFlight) -> UserMessage:
    """How near the log comes to what the record names."""
    missing = named
    for firing in judged.firings:
        missing &= ~firing.sources
    parts = []
    if Source.ATTITUDE in missing:
        tilts = log.tilt_deg[log.is_judged & np.isfinite(log.tilt_deg)]
        parts.append(message(marked("tilt at most {tilt:.0f}°"), tilt=max(tilts.tolist(), default=0.0)))
    if Source.FREEFALL in missing:
        parts.append(
            message(marked("longest free fall below {force:.1f} g: {seconds:.2f} s"),
                    force=judged.limits.freefall_acceleration_g, seconds=judged.longest_miss_s)
        )  # fmt: skip
    if not parts:
        parts.append(message(marked("tilt and free fall never together")))
    return message(marked("No moment of this log matches: {what}."), what=joined(parts))


# Sentences


def moment_message(moment: Moment, record: TriggerRecord) -> UserMessage:
    """What speaks for the moment and what against it, and when the module was then powered on."""
    firing, sentences = moment.firing, []
    sentences.append(message(marked("Proposal: at {time} the log shows {what}."),
                        time=moment_text(firing.at_s), what=measured_text(firing)))  # fmt: skip
    powered_s = firing.at_s - record.uptime_s
    if record.uptime_s < MAX_UPTIME_S:
        sentences.append(
            message(marked("The module was then powered on at {seconds:.0f} s of the log."), seconds=powered_s)
        )
    if moment.unnamed_s is not None:
        words = marked("At {time} the other trigger was met; the record does not name it.")
        sentences.append(message(words, time=moment_text(moment.unnamed_s)))
    if len(moment.readings) < len(RuleReading):
        (reading,) = moment.readings
        sentences.append(message(marked("Only if the rule is read so: {reading}."), reading=message(reading.value)))
    return joined(sentences, " ")


def measured_text(firing: LogFiring) -> str:
    """ "63° · 0.2 g": what the log measured of the sources."""
    values = ((Source.ATTITUDE, firing.tilt_deg, f"{firing.tilt_deg:.0f}°"),
              (Source.FREEFALL, firing.acceleration_g, f"{firing.acceleration_g:.1f} g"))  # fmt: skip
    return " · ".join(text for source, value, text in values if source in firing.sources and np.isfinite(value))

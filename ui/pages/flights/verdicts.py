"""Verdict on a flight with the chosen thresholds, with its icon and colour."""

from enum import Enum

from app.flight_analysis.flight_set import FlightGroup, FlightOutcome
from ui.style.icons import Icon, Look
from ui.style.theme import Meaning


class Verdict(Enum):
    """Verdict on a flight with the chosen thresholds."""

    UNREAD = 0
    DIFFERS = 1
    """The two readings of the vendor's rule disagree."""
    LATE = 2
    """Only after the impact."""
    FIRES = 3
    HOLDS = 4


def verdict_of(outcome: FlightOutcome | None) -> Verdict:
    if outcome is None:
        return Verdict.UNREAD
    if outcome.is_different:
        return Verdict.DIFFERS
    if not outcome.direct.sources:
        return Verdict.HOLDS
    return Verdict.FIRES if outcome.direct.is_in_time or outcome.group is not FlightGroup.MUST else Verdict.LATE


def appearance_of(group: FlightGroup, verdict: Verdict) -> Look:
    """Only what is not as expected has a meaning."""
    match verdict:
        case Verdict.UNREAD:
            return Look(Icon.WARNING, Meaning.ATTENTION)
        case Verdict.DIFFERS:
            return Look(Icon.UNKNOWN, Meaning.ATTENTION)
        case Verdict.LATE:
            return Look(Icon.CLOCK, Meaning.DANGER)
        case Verdict.FIRES:
            return Look(Icon.PARACHUTE, None if group is FlightGroup.MUST else Meaning.DANGER)
        case Verdict.HOLDS if group is FlightGroup.MUST:
            return Look(Icon.CROSS, Meaning.DANGER)
        case _:
            return Look(Icon.NOT_TRIGGERED, None)


def order_of(group: FlightGroup, outcome: FlightOutcome | None) -> float:
    """Sort key: what is not as expected first, then by time."""
    is_fine = appearance_of(group, verdict_of(outcome)).meaning is None
    at_s = _NEVER_S if outcome is None else min(outcome.direct.at_s, outcome.damped.at_s, _NEVER_S)
    return (10 * _NEVER_S if is_fine else 0.0) + at_s


_NEVER_S = 1e8

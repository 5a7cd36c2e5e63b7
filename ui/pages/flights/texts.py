"""Verdicts and texts of the Flight logs page."""

import math
from collections.abc import Mapping
from enum import Enum
from pathlib import Path
from typing import Final

from app.firing.judge import TriggerLimits
from app.flight_analysis.fire_map import FlightGroup, FlightOutcome
from app.flight_analysis.summary import FirstFire, moment_text
from app.flight_logs.module_view import RuleReading
from app.settings.profiles import SETTINGS_BY_KEY
from app.text.durations import stopwatch
from app.text.i18n import tr
from app.text.messages import clean
from app.text.sentences import capitalised, in_brackets, join_names, join_sentences, labelled
from protocol.fields import Value
from protocol.messages import Source
from protocol.translatable import marked
from ui.pages.flights.controller import FlightRow
from ui.style.icons import Icon, StateStyle
from ui.style.theme import Meaning

READING_WORDS: Final = {
    RuleReading.DIRECT: marked("Triggers at once"),
    RuleReading.DAMPED: marked("Triggers after 0.2 s"),
}
THRESHOLD_KEYS: Final = TriggerLimits._fields[:3]
"""Of the settings, in the order of the sliders."""
_TRIGGER_KEYS: Final = ("attitude_trigger", "freefall_trigger")
MOVE_WORD: Final = marked("Move to the other list")
OTHER_LIST: Final = {FlightGroup.MUST_NOT: FlightGroup.MUST, FlightGroup.MUST: FlightGroup.MUST_NOT}


def assumed_text(values: Mapping[str, Value]) -> str:
    """Of a module's settings, by key, that are tried: what is judged without them, or against them."""
    unknown = [tr(SETTINGS_BY_KEY[key].title) for key in THRESHOLD_KEYS if key not in values]
    disabled = [tr(SETTINGS_BY_KEY[key].title) for key in _TRIGGER_KEYS if values.get(key) is False]
    parts = []
    if unknown:
        parts.append(tr("Unknown, default tried: {names}.", names=join_names(unknown)))
    if disabled:
        parts.append(tr("Judged as enabled: {names}.", names=join_names(disabled)))
    return join_sentences(parts)


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


def appearance_of(group: FlightGroup, verdict: Verdict) -> StateStyle:
    """Only what is not as expected has a meaning."""
    match verdict:
        case Verdict.UNREAD:
            return StateStyle(Icon.WARNING, Meaning.ATTENTION)
        case Verdict.DIFFERS:
            return StateStyle(Icon.UNKNOWN, Meaning.ATTENTION)
        case Verdict.LATE:
            return StateStyle(Icon.CLOCK, Meaning.DANGER)
        case Verdict.FIRES:
            return StateStyle(Icon.PARACHUTE, None if group is FlightGroup.MUST else Meaning.DANGER)
        case Verdict.HOLDS if group is FlightGroup.MUST:
            return StateStyle(Icon.CROSS, Meaning.DANGER)
        case _:
            return StateStyle(Icon.NOT_TRIGGERED, None)


def order_of(group: FlightGroup, outcome: FlightOutcome | None) -> float:
    """Sort key: what is not as expected first, then by time."""
    is_fine = appearance_of(group, verdict_of(outcome)).meaning is None
    at_s = _NEVER_S if outcome is None else min(outcome.direct.at_s, outcome.damped.at_s, _NEVER_S)
    return (10 * _NEVER_S if is_fine else 0.0) + at_s


_NEVER_S = 1e8


_WORDS: Final = {
    Verdict.UNREAD: marked("not read"), Verdict.DIFFERS: marked("unclear"), Verdict.LATE: marked("too late"),
    Verdict.HOLDS: marked("no"),
}  # fmt: skip


def verdict_text(outcome: FlightOutcome | None) -> str:
    verdict = verdict_of(outcome)
    return f"{outcome.direct.at_s:.1f} s" if outcome and verdict is Verdict.FIRES else tr(_WORDS[verdict])


def short_name(name: str) -> str:
    return clean(Path(name).stem or name, longest=80)


def sources_text(sources: Source) -> str:
    words = [
        tr(word)
        for source, word in ((Source.ATTITUDE, marked("attitude")), (Source.FREEFALL, marked("free fall")))
        if source in sources
    ]
    return " · ".join(words)


def fire_text(fire: FirstFire) -> str:
    """When and why it fires under one reading, how late and how much lower."""
    if not fire.sources:
        return capitalised(tr("no trigger"))
    text = tr("Fires at {time}: {why}", time=moment_text(fire.at_s), why=sources_text(fire.sources))
    late = fire.late_text if fire.is_in_time else tr("after the impact")
    return join_names(filter(None, (text, late)))


def outcome_lines(outcome: FlightOutcome) -> tuple[str, ...]:
    """One line, or one per reading where they disagree."""
    if not outcome.is_different:
        return (fire_text(outcome.direct),)
    return (
        tr("The readings of the rule differ:"),
        *(
            labelled(tr(READING_WORDS[reading]), fire_text(fire))
            for reading, fire in ((RuleReading.DIRECT, outcome.direct), (RuleReading.DAMPED, outcome.damped))
        ),
    )


def row_text(row: FlightRow) -> str:
    """The row as text, for the tooltip and screen readers."""
    name = clean(row.name, longest=200)
    if row.flight.why_not is not None:
        return labelled(name, row.flight.why_not.translated())
    lines = [f"{name}{in_brackets(tr(row.flight.group.value))}"]
    if row.outcome is not None:
        lines.append(labelled(tr("Duration"), stopwatch(row.outcome.flight.duration_s)))
        lines += [*outcome_lines(row.outcome), *(problem.translated() for problem in row.outcome.flight.problems)]
    return "\n".join(lines)


def problem_count(row: FlightRow) -> int:
    return 1 if row.outcome is None else len(row.outcome.flight.problems)


# Captions


def list_caption(group: FlightGroup, outcomes: list[FlightOutcome]) -> tuple[str, Meaning | None]:
    """Caption of a list; where the readings disagree, the worse one counts."""
    total, name = len(outcomes), capitalised(tr(group.value))
    if not total:
        return name, None
    if group is FlightGroup.MUST_NOT:
        count = sum(bool(outcome.direct.sources or outcome.damped.sources) for outcome in outcomes)
        text, is_bad = tr("{count} of {total} fire", count=count, total=total), count > 0
    else:
        count = sum(outcome.direct.is_in_time and outcome.damped.is_in_time for outcome in outcomes)
        text, is_bad = tr("{count} of {total} fire in time", count=count, total=total), count < total
    return labelled(name, text), Meaning.DANGER if is_bad else None


def list_detail(group: FlightGroup, outcomes: list[FlightOutcome]) -> str:
    """How many flights depend on the reading, and the largest delay."""
    if not outcomes:
        return tr("Select flights and press M")
    parts = []
    different = sum(outcome.is_different for outcome in outcomes)
    if different:
        parts.append(labelled(tr("unclear"), different))
    if group is FlightGroup.MUST:
        fires = [fire for outcome in outcomes for fire in (outcome.direct, outcome.damped) if fire.is_in_time]
        delays = [fire.delay_s for fire in fires if math.isfinite(fire.delay_s)]
        drops = [fire.drop_m for fire in fires if math.isfinite(fire.drop_m)]
        if delays and max(delays) >= 0:
            latest = FirstFire(math.nan, Source(0), True, max(delays), max(drops, default=math.nan))
            parts.append(tr("latest {late}", late=latest.late_text))
    return " · ".join(parts)


def limits_text(limits: TriggerLimits) -> str:
    angle, force_g, time_s = limits.attitude_threshold_deg, limits.freefall_acceleration_g, limits.freefall_time_s
    return f"{angle:.0f}° · {force_g:.1f} g · {time_s:.2f} s"

"""Texts of "Would it have fired?": verdict, margins, what was not judged."""

from collections.abc import Callable
from enum import Enum
from typing import Final, NamedTuple

from app.firing.judge import ASSUMPTIONS, RULES, Firing
from app.firing.what_if import NearFall, NearTilt, WhatIfFinding
from app.firing.what_if_drafts import ATTITUDE_THRESHOLD, ATTITUDE_TRIGGER, FREEFALL_TRIGGER, TITLES, Question
from app.text.durations import duration
from app.text.i18n import tr
from app.text.sentences import labelled
from protocol.catalogue import Command
from protocol.messages import Source
from protocol.translatable import marked

Clock = Callable[[float], str]
"""Formats a monotonic time as time of day."""

_CLOSE: Final = marked("{time} too close to tell: {what}")
_NEAR: Final = marked("{time} near miss: {what}")
_SHORT_FALLS: Final = 0.5
"""Falls shorter than this fraction of the free-fall time are no near miss."""
ABOUT: Final = (
    *RULES,
    *ASSUMPTIONS,
    marked("Margins below 1°, 0.1 g or one report do not count."),
    marked("After a real trigger the parachute is open."),
)  # fmt: skip
"""Sentences on how it is judged."""


class WhatIfKind(Enum):
    """Kind of an answer; the window has an icon and a colour for each."""

    JUDGING = "judging"
    UNJUDGED = "unjudged"
    UNANSWERED = "unanswered"
    """A threshold is missing."""
    UNCERTAIN = "doubtful"
    FIRES = "fires"
    HOLDS = "holds"
    NEAR = "near"


class WhatIfVerdict(NamedTuple):
    """Translated texts."""

    kind: WhatIfKind
    head: str
    lines: tuple[str, ...] = ()


class WhatIfRow(NamedTuple):
    """An event that can be shown in the plots."""

    at_s: float
    kind: WhatIfKind
    text: str


def verdict(finding: WhatIfFinding | None, question: Question, *, clock: Clock) -> WhatIfVerdict:
    """`finding` is None while it is being judged."""
    if finding is None:
        return WhatIfVerdict(WhatIfKind.JUDGING, tr("Judging…"))
    limits = finding.limits
    lines = tuple(
        line
        for line in (
            _attitude_line(finding, question, clock),
            _freefall_line(finding, question, clock),
            *_unjudged_lines(finding, question, clock),
        )
        if line
    )
    if not finding.report_count:
        return WhatIfVerdict(WhatIfKind.UNJUDGED, tr("Nothing to judge."), lines)
    if not (limits.attitude_is_enabled or limits.freefall_is_enabled):
        if question.unknown:
            return WhatIfVerdict(WhatIfKind.UNANSWERED, tr("Enter the thresholds."), lines)
        return WhatIfVerdict(WhatIfKind.UNCERTAIN, tr("Both triggers are disabled."), lines)
    if finding.firing_count:
        head = tr("Would have fired {count}×.", count=finding.firing_count)
        return WhatIfVerdict(WhatIfKind.FIRES, head, lines)
    if not finding.is_judged:
        return WhatIfVerdict(WhatIfKind.UNJUDGED, tr("Not judged: reports over 0.5 s apart."), lines)
    judged = duration(finding.judged_s)
    if _is_close(finding):
        head = tr("Too close to tell ({time} judged).", time=judged)
        return WhatIfVerdict(WhatIfKind.UNCERTAIN, head, lines)
    head = tr("Would not have fired ({time} judged).", time=judged)
    return WhatIfVerdict(WhatIfKind.HOLDS, head, lines)


def rows(finding: WhatIfFinding | None, *, clock: Clock) -> tuple[WhatIfRow, ...]:
    """Firings and near misses, oldest first."""
    if finding is None:
        return ()
    shown = [
        WhatIfRow(
            firing.sample.at_s, WhatIfKind.FIRES,
            tr("{time} would fire: {why}", time=clock(firing.sample.at_s), why=firing_text(firing)),
        )
        for firing in finding.firings
    ]  # fmt: skip
    least_s = _SHORT_FALLS * finding.limits.freefall_time_s
    near: list[tuple[float, str, NearTilt | NearFall]] = [
        *((miss.at_s, _tilt_text(miss), miss) for miss in finding.near_tilts),
        *((fall.ended_s, _fall_text(fall), fall) for fall in finding.near_falls if fall.lasted_s >= least_s),
    ]
    for at_s, what, miss in near:
        kind, text = (WhatIfKind.UNCERTAIN, _CLOSE) if miss.may_have_fired else (WhatIfKind.NEAR, _NEAR)
        shown.append(WhatIfRow(at_s, kind, tr(text, time=clock(at_s), what=what)))
    return tuple(sorted(shown, key=lambda row: (row.at_s, row.text)))


def firing_text(firing: Firing) -> str:
    """ "Attitude, 63°"."""
    sample = firing.sample
    parts = []
    if Source.ATTITUDE in firing.sources:
        parts.append(tr("attitude, {tilt:.0f}°", tilt=sample.tilt_deg))
    if Source.FREEFALL in firing.sources:
        parts.append(tr("free fall, {weight:.1f} g", weight=sample.acceleration_g))
    return " + ".join(parts)


def _tilt_text(near: NearTilt) -> str:
    return tr("{value}, {margin} below", value=f"{near.tilt_deg:.0f}°", margin=f"{near.margin_deg:.0f}°")


def _fall_text(near: NearFall) -> str:
    return tr("{value}, {margin} below", value=f"{near.lasted_s:.2f} s", margin=f"{near.margin_s:.2f} s")


def _is_close(finding: WhatIfFinding) -> bool:
    return any(tilt.may_have_fired for tilt in finding.near_tilts) or any(
        fall.may_have_fired for fall in finding.near_falls
    )


def _attitude_line(finding: WhatIfFinding, question: Question, clock: Clock) -> str:
    if not finding.limits.attitude_is_enabled:
        is_open = ATTITUDE_THRESHOLD in question.unknown
        return _off(ATTITUDE_TRIGGER, is_open=is_open)
    near = finding.nearest_tilt
    if near is None:
        return ""
    return tr("Attitude: nearest {what} at {time}.", what=_tilt_text(near), time=clock(near.at_s))


def _freefall_line(finding: WhatIfFinding, question: Question, clock: Clock) -> str:
    limits, fall, lowest = finding.limits, finding.longest_fall, finding.lowest
    if not limits.freefall_is_enabled:
        is_open = any(command is not ATTITUDE_THRESHOLD for command in question.unknown)
        return _off(FREEFALL_TRIGGER, is_open=is_open)
    if fall is not None:
        return tr("Free fall: nearest {what} at {time}.", what=_fall_text(fall), time=clock(fall.ended_s))
    if lowest is None or lowest.acceleration_g < limits.freefall_acceleration_g:
        return ""
    return tr("Free fall: none; lowest {weight:.1f} g at {time}.", weight=lowest.acceleration_g,
              time=clock(lowest.at_s))  # fmt: skip


def _off(trigger: Command, *, is_open: bool) -> str:
    return labelled(tr(trigger.title), tr("not judged") if is_open else tr("disabled"))


def _unjudged_lines(finding: WhatIfFinding, question: Question, clock: Clock) -> list[str]:
    lines = [labelled(tr(TITLES[command.key]), tr("enter a value")) for command in question.unknown]
    for trigger in question.assumed:
        is_judged = {
            ATTITUDE_TRIGGER: finding.limits.attitude_is_enabled, FREEFALL_TRIGGER: finding.limits.freefall_is_enabled,
        }[trigger]  # fmt: skip
        if is_judged:
            lines.append(labelled(tr(trigger.title), tr("assumed enabled")))
    lines += [labelled(tr(TITLES[command.key]), tr("may have changed")) for command in question.stale]
    if finding.firing_count > len(finding.firings):
        lines.append(tr("First {count} only.", count=len(finding.firings)))
    if finding.pauses.count:
        pauses = finding.pauses
        lines.append(
            tr("Not judged: pauses, {time} in all, longest {longest} at {at}.", time=duration(pauses.total_s),
               longest=duration(pauses.longest_s), at=clock(pauses.longest_at_s))
        )  # fmt: skip
    if not finding.is_whole and finding.first_s is not None:
        lines.append(tr("Not judged: before {time}.", time=clock(finding.first_s)))
    if finding.locked_s:
        locked = duration(finding.locked_s)
        lines.append(
            tr("Locked for {time}: judged as active.", time=locked)
            if finding.counts_locked
            else tr("Not judged: locked for {time}.", time=locked)
        )
    return lines

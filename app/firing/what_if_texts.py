"""Texts of "Would it have fired?": verdict, margins, what was not judged."""

from collections.abc import Callable
from enum import Enum
from typing import Final, NamedTuple

from app.diagnosis.link_state import duration
from app.firing.judge import ASSUMPTIONS, RULES, Firing
from app.firing.near_misses import NearFall, NearTilt
from app.firing.what_if_drafts import ATTITUDE_THRESHOLD, ATTITUDE_TRIGGER, FREEFALL_TRIGGER, Question
from app.firing.would_fire import Pauses, WhatIfFinding
from app.text.i18n import tr
from protocol.messages import Source
from protocol.translatable import marked

Clock = Callable[[float], str]
"""The time of day of a monotonic time."""

_SHORT_FALLS: Final = 0.5
"""Falls shorter than this part of the free-fall time are no near miss."""
ABOUT: Final = (
    *RULES,
    *ASSUMPTIONS,
    marked("The module looks at its sensor oftener and finer than it reports: a margin below 1°, 0.1 g or the time "
           "between two reports is none."),
    marked("What was measured after a real trigger was measured under an open parachute."),
)  # fmt: skip
"""How it is judged, sentence by sentence."""


class WhatIfKind(Enum):
    """What kind of answer it is; the window has a look for each."""

    JUDGING = "judging"
    UNJUDGED = "unjudged"
    UNANSWERED = "unanswered"
    """A threshold has to be named first."""
    DOUBTFUL = "doubtful"
    FIRES = "fires"
    HOLDS = "holds"
    NEAR = "near"
    UNREADABLE = "unreadable"


class WhatIfVerdict(NamedTuple):
    """In the language in use."""

    kind: WhatIfKind
    head: str
    lines: tuple[str, ...] = ()


class WhatIfRow(NamedTuple):
    """Something that can be looked at in the plots."""

    at_s: float
    kind: WhatIfKind
    text: str


def verdict(finding: WhatIfFinding | None, question: Question, *, clock: Clock, progress: float = 0.0) -> WhatIfVerdict:
    """`finding` is None while it is being judged."""
    if finding is None:
        return WhatIfVerdict(WhatIfKind.JUDGING, tr("Judging… {percent} %", percent=f"{100 * progress:.0f}"))
    limits = finding.limits
    said = tuple(
        line
        for line in (
            _attitude_line(finding, question, clock),
            _freefall_line(finding, question, clock),
            *_unjudged_lines(finding, question, clock),
        )
        if line
    )
    if not finding.report_count:
        return WhatIfVerdict(WhatIfKind.UNJUDGED, tr("There is nothing to judge yet."), said)
    if not (limits.attitude_is_enabled or limits.freefall_is_enabled):
        is_open = bool(question.unknown or question.invalid)
        head = tr("Nothing to judge: both triggers are disabled.")
        if is_open:
            head = tr("Not judged: name the thresholds.")
        return WhatIfVerdict(WhatIfKind.UNANSWERED if is_open else WhatIfKind.DOUBTFUL, head, said)
    if finding.firing_count:
        count = finding.firing_count
        head = tr("Would have fired {count} times.", count=count) if count > 1 else tr("Would have fired once.")
        return WhatIfVerdict(WhatIfKind.FIRES, head, said)
    if not finding.is_judged:
        return WhatIfVerdict(WhatIfKind.UNJUDGED, tr("Not judged: the reports are more than 0.5 s apart."), said)
    judged = duration(finding.judged_s)
    if _is_close(finding):
        head = tr("Too close to tell in the {time} that were judged.", time=judged)
        return WhatIfVerdict(WhatIfKind.DOUBTFUL, head, said)
    head = tr("Would not have fired in the {time} that were judged.", time=judged)
    return WhatIfVerdict(WhatIfKind.HOLDS, head, said)


def rows(finding: WhatIfFinding | None, *, clock: Clock) -> tuple[WhatIfRow, ...]:
    """Firings and near misses, oldest first."""
    if finding is None:
        return ()
    found = [_firing_row(one, clock) for one in finding.firings]
    found += [_tilt_row(one, clock) for one in finding.near_tilts]
    after_s = finding.limits.freefall_time_s
    found += [_fall_row(one, clock) for one in finding.near_falls if one.lasted_s >= _SHORT_FALLS * after_s]
    return tuple(sorted(found, key=lambda row: (row.at_s, row.text)))


def firing_text(firing: Firing) -> str:
    """ "Attitude, 63°"."""
    sample = firing.sample
    said = []
    if Source.ATTITUDE in firing.sources:
        said.append(tr("attitude, {tilt:.0f}°", tilt=sample.tilt_deg))
    if Source.FREEFALL in firing.sources:
        said.append(tr("free fall, {weight:.1f} g", weight=sample.acceleration_g))
    return " + ".join(said)


def _firing_row(firing: Firing, clock: Clock) -> WhatIfRow:
    at_s = firing.sample.at_s
    text = tr("{time} would fire: {why}", time=clock(at_s), why=firing_text(firing))
    return WhatIfRow(at_s, WhatIfKind.FIRES, text)


def _tilt_row(near: NearTilt, clock: Clock) -> WhatIfRow:
    values = {"time": clock(near.at_s), "tilt": near.tilt_deg, "margin": near.margin_deg}
    if near.may_have_fired:
        text = tr("{time} too close to tell: {tilt:.0f}°, {margin:.0f}° below", **values)
        return WhatIfRow(near.at_s, WhatIfKind.DOUBTFUL, text)
    text = tr("{time} near miss: {tilt:.0f}°, {margin:.0f}° below", **values)
    return WhatIfRow(near.at_s, WhatIfKind.NEAR, text)


def _fall_row(near: NearFall, clock: Clock) -> WhatIfRow:
    at_s = near.since_s + near.lasted_s
    values = {"time": clock(at_s), "lasted": near.lasted_s, "margin": near.margin_s}
    if near.may_have_fired:
        text = tr("{time} too close to tell: fell {lasted:.2f} s, {margin:.2f} s short", **values)
        return WhatIfRow(at_s, WhatIfKind.DOUBTFUL, text)
    text = tr("{time} near miss: fell {lasted:.2f} s, {margin:.2f} s short", **values)
    return WhatIfRow(at_s, WhatIfKind.NEAR, text)


def _is_close(finding: WhatIfFinding) -> bool:
    near_tilts = any(one.may_have_fired for one in finding.near_tilts)
    return near_tilts or any(one.may_have_fired for one in finding.near_falls)


def _attitude_line(finding: WhatIfFinding, question: Question, clock: Clock) -> str:
    if not finding.limits.attitude_is_enabled:
        is_open = ATTITUDE_THRESHOLD in (*question.unknown, *question.invalid)
        return tr("Attitude: not judged.") if is_open else tr("Attitude: disabled.")
    near = finding.nearest_tilt
    if near is None:
        return ""
    return tr(
        "Attitude: nearest without firing {tilt:.0f}° at {time}, {margin:.0f}° below the threshold.",
        tilt=near.tilt_deg, time=clock(near.at_s), margin=near.margin_deg,
    )  # fmt: skip


def _freefall_line(finding: WhatIfFinding, question: Question, clock: Clock) -> str:
    limits, fall, lowest = finding.limits, finding.longest_fall, finding.lowest
    if not limits.freefall_is_enabled:
        is_open = any(one is not ATTITUDE_THRESHOLD for one in (*question.unknown, *question.invalid))
        return tr("Free fall: not judged.") if is_open else tr("Free fall: disabled.")
    if fall is not None:
        return tr(
            "Free fall: longest without firing {lasted:.2f} s until {time}, {margin:.2f} s short.",
            lasted=fall.lasted_s, time=clock(fall.since_s + fall.lasted_s), margin=fall.margin_s,
        )  # fmt: skip
    if lowest is None or lowest.acceleration_g < limits.freefall_acceleration_g:
        return ""
    return tr(
        "Free fall: none; lowest {weight:.1f} g at {time}, {margin:.1f} g above the threshold.",
        weight=lowest.acceleration_g, time=clock(lowest.at_s),
        margin=lowest.acceleration_g - limits.freefall_acceleration_g,
    )  # fmt: skip


def _unjudged_lines(finding: WhatIfFinding, question: Question, clock: Clock) -> list[str]:
    lines = [tr("{setting}: what was typed is no value.", setting=tr(one.title)) for one in question.invalid]
    lines += [tr("{setting}: not known, type one.", setting=tr(one.title)) for one in question.unknown]
    for trigger in question.assumed:
        is_judged = {
            ATTITUDE_TRIGGER: finding.limits.attitude_is_enabled, FREEFALL_TRIGGER: finding.limits.freefall_is_enabled,
        }[trigger]  # fmt: skip
        if is_judged:
            lines.append(tr("{setting}: not known, judged as enabled.", setting=tr(trigger.title)))
    lines += [tr("{setting}: as last read, may have changed.", setting=tr(one.title)) for one in question.stale]
    if finding.firing_count > len(finding.firings):
        lines.append(tr("Only the first {count} are listed.", count=len(finding.firings)))
    if finding.pauses.count:
        lines.append(_pauses_line(finding.pauses, clock))
    if not finding.is_whole and finding.first_s is not None:
        lines.append(
            tr("Not judged: what was before {time}; only lowest and highest values are left of it.",
               time=clock(finding.first_s))
        )  # fmt: skip
    if finding.locked_s:
        locked = duration(finding.locked_s)
        lines.append(
            tr("It was locked for {time}: judged as if it had been active.", time=locked)
            if finding.counts_locked
            else tr("Not judged: {time} in which it was locked.", time=locked)
        )
    return lines


def _pauses_line(pauses: Pauses, clock: Clock) -> str:
    longest, at = duration(pauses.longest_s), clock(pauses.longest_at_s)
    if pauses.count == 1:
        return tr("Not judged: a pause of {longest} without reports at {at}.", longest=longest, at=at)
    return tr(
        "Not judged: {count} pauses without reports, {time} in all, the longest {longest} at {at}.",
        count=pauses.count, time=duration(pauses.total_s), longest=longest, at=at,
    )  # fmt: skip

"""What the Flight logs page says: verdicts, sentences about a flight, captions, the proposal."""

import math
from pathlib import Path
from typing import Final, NamedTuple

from app.firing.judge import TriggerLimits
from app.flight_analysis.flight_set import FlightGroup, FlightOutcome
from app.flight_analysis.proposal import FlightMargin, ThresholdProposal
from app.flight_analysis.summary import FirstFire
from app.flight_logs.module_view import RuleReading
from app.text.durations import stopwatch
from app.text.i18n import tr
from app.text.messages import clean
from protocol.messages import Source
from protocol.translatable import marked
from ui.pages.flights.controller import FlightRow
from ui.pages.flights.verdicts import Verdict, verdict_of
from ui.style.icons import Icon
from ui.style.theme import Meaning

READING_WORDS: Final = {
    RuleReading.DIRECT: marked("Triggers at once"),
    RuleReading.DAMPED: marked("Triggers after 0.2 s"),
}
OTHER_LIST: Final = {FlightGroup.MUST_NOT: FlightGroup.MUST, FlightGroup.MUST: FlightGroup.MUST_NOT}


def verdict_text(outcome: FlightOutcome | None) -> str:
    """For a narrow column."""
    match verdict_of(outcome):
        case Verdict.UNREAD:
            return tr("not read")
        case Verdict.DIFFERS:
            return tr("unclear")
        case Verdict.LATE:
            return tr("too late")
        case Verdict.HOLDS:
            return tr("no")
        case _:
            return tr("{seconds:.1f} s", seconds=math.nan if outcome is None else outcome.direct.at_s)


def short_name(name: str) -> str:
    """The file's, without its folders and its ending."""
    return clean(Path(name).stem or name, longest=80)


def sources_text(sources: Source) -> str:
    words = [
        tr(word)
        for source, word in ((Source.ATTITUDE, marked("attitude")), (Source.FREEFALL, marked("free fall")))
        if source in sources
    ]
    return " · ".join(words)


def fire_text(fire: FirstFire) -> str:
    """Of one reading: whether and when, why, how late and how much lower."""
    if not fire.sources:
        return tr("No trigger")
    text = tr("Fires at {time} by {why}", time=moment_text(fire.at_s), why=sources_text(fire.sources))
    if not fire.is_in_time:
        return tr("{what}, after the impact", what=text)
    if math.isnan(fire.delay_s):
        return text
    if fire.delay_s < 0:
        text = tr("{what}, {seconds:.1f} s before control was lost", what=text, seconds=-fire.delay_s)
    else:
        text = tr("{what}, {seconds:.1f} s after control was lost", what=text, seconds=fire.delay_s)
    return text if math.isnan(fire.drop_m) else tr("{what}, {metres:.0f} m lower", what=text, metres=fire.drop_m)


def moment_text(at_s: float) -> str:
    """Since the beginning of the log: "12.3 s", "3:07.2"."""
    if at_s < 60:
        return tr("{seconds:.1f} s", seconds=at_s)
    return f"{stopwatch(at_s)}.{int(at_s * 10) % 10}"


def outcome_lines(outcome: FlightOutcome) -> tuple[str, ...]:
    """One line, or one for each reading where they disagree."""
    if not outcome.is_different:
        return (fire_text(outcome.direct),)
    return (
        tr("The vendor's rule can be read in two ways, and they disagree:"),
        *(
            tr("{reading}: {what}", reading=tr(READING_WORDS[reading]), what=fire_text(fire))
            for reading, fire in ((RuleReading.DIRECT, outcome.direct), (RuleReading.DAMPED, outcome.damped))
        ),
    )


def told(row: FlightRow) -> str:
    """The row as sentences."""
    name = clean(row.name, longest=200)
    if row.unread is not None:
        return tr("{name}: not read. {why}", name=name, why=row.unread.why.in_words())
    lines = [f"{name} ({tr(row.group.value)})"]
    if row.outcome is not None:
        lines.append(tr("Duration: {time}", time=stopwatch(row.outcome.flight.duration_s)))
        lines += [*outcome_lines(row.outcome), *(one.in_words() for one in row.outcome.flight.problems)]
    return "\n".join(lines)


def problem_count(row: FlightRow) -> int:
    return 1 if row.outcome is None else len(row.outcome.flight.problems)


# Captions


def list_caption(group: FlightGroup, outcomes: list[FlightOutcome]) -> tuple[str, Meaning | None]:
    """Above a list. Where the readings disagree the worse one counts."""
    total = len(outcomes)
    if not total:
        return tr("Must fire: none yet") if group is FlightGroup.MUST else tr("Must not fire: none yet"), None
    if group is FlightGroup.MUST_NOT:
        count = sum(bool(one.direct.sources or one.damped.sources) for one in outcomes)
        meaning = Meaning.DANGER if count else None
        return tr("Must not fire: {count} of {total} fire", count=count, total=total), meaning
    count = sum(one.direct.is_in_time and one.damped.is_in_time for one in outcomes)
    meaning = Meaning.DANGER if count < total else None
    return tr("Must fire: {count} of {total} fire in time", count=count, total=total), meaning


def list_detail(group: FlightGroup, outcomes: list[FlightOutcome]) -> str:
    """What depends on the reading, how late the latest is."""
    if not outcomes:
        return tr("Move flights here: choose them, press M")
    parts = []
    different = sum(one.is_different for one in outcomes)
    if different:
        parts.append(tr("{count} unclear", count=different))
    if group is FlightGroup.MUST:
        fires = [fire for one in outcomes for fire in (one.direct, one.damped) if fire.is_in_time]
        delays = [one.delay_s for one in fires if math.isfinite(one.delay_s)]
        drops = [one.drop_m for one in fires if math.isfinite(one.drop_m)]
        if delays and drops:
            parts.append(
                tr("latest after {seconds:.1f} s, {metres:.0f} m lower", seconds=max(delays), metres=max(drops))
            )
        elif delays:
            parts.append(tr("latest after {seconds:.1f} s", seconds=max(delays)))
    return " · ".join(parts)


# Proposal


class ProposalText(NamedTuple):
    icon: Icon
    meaning: Meaning | None
    head: str
    lines: tuple[str, ...] = ()


def limits_text(limits: TriggerLimits) -> str:
    return tr(
        "{tilt:.0f}° · {acceleration:.1f} g · {time:.2f} s",
        tilt=limits.attitude_threshold_deg,
        acceleration=limits.freefall_acceleration_g,
        time=limits.freefall_time_s,
    )


def proposal_text(proposal: ThresholdProposal | None, *, is_busy: bool, counts: tuple[int, int]) -> ProposalText:
    """`counts`: flights that must not fire, and that must."""
    if is_busy:
        return ProposalText(Icon.CLOCK, None, tr("Looking for thresholds…"))
    if proposal is None or not any(counts):
        return ProposalText(Icon.INFORMATION, None, tr("No proposal yet"))
    if proposal.limits is None:
        lines = [tr("{name}: {why}", name=short_name(one.name), why=one.why.in_words()) for one in proposal.conflicts]
        head = tr("No thresholds separate these two lists") if counts[1] else tr("No thresholds let all of these pass")
        return ProposalText(Icon.WARNING, Meaning.ATTENTION, head, tuple(lines))
    lines = [
        _margin_text(margin)
        for group in (FlightGroup.MUST_NOT, FlightGroup.MUST)
        if (margin := proposal.nearest(group)) is not None
    ]
    if not counts[1]:
        lines.append(tr("No flight that must fire: only false triggers count."))
    if not counts[0]:
        lines.append(tr("No flight that must not fire: only missing triggers count."))
    head = tr("Proposal: {limits}", limits=limits_text(proposal.limits))
    return ProposalText(Icon.CHECK, None, head, tuple(lines))


def _margin_text(margin: FlightMargin) -> str:
    """How far the nearest flight of a list is from the other side."""
    name = short_name(margin.name)
    if margin.group is FlightGroup.MUST_NOT:
        return tr(
            "Must not fire: {degrees}° and {seconds:.2f} s to spare ({name})",
            degrees=margin.attitude_deg, seconds=margin.freefall_s, name=name,
        )  # fmt: skip
    parts = []
    if margin.attitude_deg >= 0:
        parts.append(tr("{degrees}° above the threshold", degrees=margin.attitude_deg))
    if margin.freefall_s >= 0:
        parts.append(tr("{seconds:.2f} s longer than the free-fall time", seconds=margin.freefall_s))
    return tr("Must fire: {what} ({name})", what=" · ".join(parts), name=name)

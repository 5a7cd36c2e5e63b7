"""`dps-s fired LOG…`: would these thresholds have fired in flight logs and recordings?

Exit code 0 if none would have fired, 2 if a log cannot be read, 4 if one or more would have fired.
"""

import argparse
import math
from collections.abc import Collection, Sequence
from pathlib import Path

from app.cli.commands import THRESHOLDS
from app.flights.columns import NO_TIME, parse_choice
from app.flights.curves import JudgedFlight, LogFiring
from app.flights.fire_map import FlightGroup
from app.flights.judge import TriggerLimits
from app.flights.many_logs import LogOrder, SummarisedLog, summarise_logs
from app.flights.proposal import defaults_result
from app.flights.read_log import find_logs
from app.flights.summary import FlightSummary
from app.terminal import console
from app.terminal.setting_words import parse_settings, typed
from app.text.i18n import tr
from app.text.messages import UserMessage, message
from app.text.sentences import join_names, join_sentences, labelled
from protocol.messages import Source
from protocol.translatable import marked

MAX_ACCELERATION_G = 1.5
SAME_WITHIN_S = 0.25
"""Readings of the rule that fire within this time of each other agree; one of them waits for 0.2 s."""
_LATER = marked("{reading}: would first fire at {time:.2f} s.")
_NEVER = marked("{reading}: would not fire.")


def run(args: argparse.Namespace) -> int:
    known = [word for word in args.thresholds if word.partition("=")[0] in THRESHOLDS]
    others = [word for word in args.thresholds if word not in known]  # --thresholds NAME=VALUE LOG
    for word in others:
        name, equals, _ = word.partition("=")
        if equals and not Path(word).exists():  # else the flights would be judged without it
            names = tr("expected {expected}", expected="|".join(THRESHOLDS))
            raise console.Refused(f"{name}: {names}{console.did_you_mean(name, THRESHOLDS)}")
    limits = parse_limits(known)
    judged_with = _judged_with(limits, {word.partition("=")[0] for word in known})
    paths = _found([*args.logs, *others])
    columns = parse_choice(args.column) if args.column else None
    logs = _judged(paths, LogOrder(columns, limits))
    read = [(log, log.flight) for log in logs if log.flight is not None]
    if args.json:
        console.note(judged_with)
        console.write_lines([console.as_json(json_of(log, flight)) for log, flight in read])
    elif read:
        console.write_lines([*_page(read, is_must=args.must), "", *judged_with.splitlines()])
    for log in logs:
        if log.why_not is not None:
            why = log.why_not.translated()
            if NO_TIME in log.why_not.in_english():
                why = join_sentences((why, "--column time_s=NAME"))
            console.notify(labelled(log.path, why))
    if args.must or args.must_not:
        proposal = _proposal_lines([flight for _, flight in read], is_must=args.must)
        if args.json:
            console.notify("\n".join(proposal))
        else:
            console.write_lines(proposal)
    if len(read) < len(logs):
        return console.USAGE_ERROR
    return console.PARTIAL if any(log.judged[0].firings for log, _ in read) else console.SUCCESS


def parse_limits(words: Sequence[str]) -> TriggerLimits:
    """The vendor's defaults, replaced by these. Raises `Refused` with all errors."""
    values = {wish.command.key: wish.value for wish in parse_settings(words)}
    usual = TriggerLimits()
    limits = TriggerLimits(
        float(values.get("attitude_threshold_deg", usual.attitude_threshold_deg)),
        float(values.get("freefall_acceleration_g", usual.freefall_acceleration_g)),
        float(values.get("freefall_time_s", usual.freefall_time_s)),
        bool(values.get("attitude_trigger", True)),
        bool(values.get("freefall_trigger", True)),
    )
    if limits.freefall_acceleration_g > MAX_ACCELERATION_G:
        expected = tr("expected {expected}", expected=f"≤ {MAX_ACCELERATION_G}")
        raise console.Refused(f"freefall_acceleration_g: {expected}")
    return limits


def _judged_with(limits: TriggerLimits, given: Collection[str]) -> str:
    """The thresholds, and which of them are nobody's word: a module may hold others."""
    values = dict(zip(THRESHOLDS, limits, strict=True))
    words = " ".join(f"{name}={typed(value)}" for name, value in values.items())
    usual = join_names(name for name in THRESHOLDS if name not in given)
    text = tr("Judged with: {values}", values=words)
    return f"{text}\n{tr('Vendor defaults, not of a module: {names}', names=usual)}" if usual else text


def _found(words: Sequence[str]) -> list[Path]:
    try:
        paths = list(find_logs(map(Path, words)))
    except (OSError, ValueError):  # ValueError: a NUL in the name
        paths = [Path(word) for word in words]
    if not paths:
        raise console.Refused(tr("No flight log."))
    return paths


def _judged(paths: Sequence[Path], order: LogOrder) -> list[SummarisedLog]:
    """In the order of `paths`."""
    place = {path: number for number, path in reversed(list(enumerate(paths)))}
    logs = []
    for log in summarise_logs(paths, order):
        logs.append(log)
        console.show_progress(f"{len(logs)}/{len(paths)}")
    console.clear_progress()
    return sorted(logs, key=lambda log: place[log.path])


# What is printed


def json_of(log: SummarisedLog, flight: FlightSummary) -> dict[str, object]:
    """Always in English."""
    return {
        "log": str(log.path),
        "fires": [fire for firing in log.judged[0].firings for fire in _fires(firing)],
        "tilt_max_deg": _number(flight.tilt_max_deg, 1),
        "longest_fall_s": _number(max(0.0, flight.longest_fall_s(log.judged[0].limits)), 2),
        "not_judged_s": _number(flight.not_judged_s, 2),
        "problems": [problem.in_english() for problem in _problems(log, flight)],
    }


def _fires(firing: LogFiring) -> list[dict[str, object]]:
    names = {Source.ATTITUDE: "attitude", Source.FREEFALL: "freefall"}
    tilt_deg = _number(firing.tilt_deg, 0)
    return [
        {"t_s": round(firing.at_s, 3), "source": name, "tilt_deg": None if tilt_deg is None else int(tilt_deg)}
        for source, name in names.items()
        if source in firing.sources
    ]


def _number(value: float, digits: int) -> float | None:
    return round(value, digits) if math.isfinite(value) else None


def _problems(log: SummarisedLog, flight: FlightSummary) -> list[UserMessage]:
    """Includes a difference between the readings of the vendor's rule."""
    direct, damped = log.judged
    problems = list(flight.problems)
    first_s, other_s = (judged.firings[0].at_s if judged.firings else math.inf for judged in (direct, damped))
    if first_s != other_s and not abs(first_s - other_s) <= SAME_WITHIN_S:
        text = _NEVER if other_s == math.inf else _LATER
        problems.append(message(text, reading=message(damped.reading.value), time=other_s))
    return problems


def _page(read: Sequence[tuple[SummarisedLog, FlightSummary]], *, is_must: bool) -> list[str]:
    head = (tr("Log"), tr("Fires"), tr("Largest tilt"), tr("Longest fall"), tr("Not judged"))
    rows = [
        (
            log.path.name,
            _verdict(log.judged[0], flight, is_must=is_must),
            f"{flight.tilt_max_deg:.0f}°" if math.isfinite(flight.tilt_max_deg) else "–",
            f"{max(0.0, flight.longest_fall_s(log.judged[0].limits)):.2f} s",
            f"{flight.not_judged_s:.1f} s",
        )
        for log, flight in read
    ]
    fired = sum(bool(log.judged[0].firings) for log, _ in read)
    problems = [
        labelled(log.path.name, problem.translated()) for log, flight in read for problem in _problems(log, flight)
    ]
    counted = tr("{count} of {total} fire.", count=fired, total=len(read))
    return [*console.columns([head, *rows]), "", counted, *(["", *problems] if problems else [])]


def _verdict(judged: JudgedFlight, flight: FlightSummary, *, is_must: bool) -> str:
    if not judged.firings:
        return tr("no")
    first = judged.firings[0]
    why = [tr("attitude, {tilt:.0f}°", tilt=first.tilt_deg)] if Source.ATTITUDE in first.sources else []
    if Source.FREEFALL in first.sources:
        why.append(tr("free fall, {weight:.1f} g", weight=first.acceleration_g))
    text = tr("at {time:.2f} s: {why}", time=first.at_s, why=" + ".join(why))
    fire = flight.first_fire(judged.limits)
    if not is_must or not math.isfinite(fire.delay_s):
        return text
    return f"{text}; {fire.late_text}" if fire.is_in_time else f"{text}; {fire.late_text}; {tr('after the impact')}"


def _proposal_lines(flights: Sequence[FlightSummary], *, is_must: bool) -> list[str]:
    """What the vendor's defaults do in these flights. Flights of one side alone propose no thresholds."""
    if not flights:
        return []
    result = defaults_result(flights, FlightGroup.MUST if is_must else FlightGroup.MUST_NOT)
    count, total = len(result.unexpected), result.total
    lines = ["", "\n".join(result.unexpected)]
    if is_must and count:
        lines[0] = tr("The vendor's defaults miss {count} of {total}", count=count, total=total)
    elif is_must:
        lines[0] = tr("The vendor's defaults fire in all {total}", total=total)
    elif count:
        lines[0] = tr("The vendor's defaults fire in {count} of {total}", count=count, total=total)
        lines.append(tr("Did it crash? Then it must fire."))
    elif result.not_judged:
        lines[0] = tr("The vendor's defaults fire in 0 of {total}, as far as judged", total=total)
    else:
        lines[0] = tr("The vendor's defaults hold: they fire in 0 of {total}", total=total)
    if result.not_judged:
        names = join_names(result.not_judged)
        lines.append(tr("Without attitude or acceleration: {names}", names=names))
    return ["", *filter(None, lines)]

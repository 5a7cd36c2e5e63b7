"""`dps-s fired LOG…`: would these thresholds have fired in flight logs and recordings?

Exit code 4 if one or more would have fired, else 2 if one cannot be read or not be judged, else 0.
"""

import argparse
import math
from collections.abc import Mapping, Sequence
from typing import Annotated, Any, Literal

from msgspec import Meta

from app.flights.judge import TriggerLimits
from app.flights.judging import Answer, FlightGroup, defaults_result
from app.flights.read_log import SummarisedLog, distinct_names, find_logs, summarise_log
from app.flights.table import parse_choice
from app.terminal import console
from app.terminal.results import Result
from app.terminal.setting_words import parse_settings, typed
from app.text.i18n import tr
from app.text.messages import UserMessage, join_names, join_sentences, labelled
from protocol.messages import Source

# As `TriggerLimits` orders them.
THRESHOLDS = (
    *("attitude_threshold_deg", "freefall_acceleration_g", "freefall_time_s"),
    *("attitude_trigger", "freefall_trigger"),
)
MAX_ACCELERATION_G = 1.5
_SOURCES: Mapping[Source, Literal["attitude", "freefall"]] = {Source.ATTITUDE: "attitude", Source.FREEFALL: "freefall"}


class FireJson(Result):
    """`t_s`: seconds since the beginning of the log."""

    t_s: float
    source: Literal["attitude", "freefall"]
    tilt_deg: Annotated[int, Meta(ge=0)] | None


class FiredJson(Result):
    """`fires` has the first firing of each trigger, and is null where nobody can know whether it fires. `not_judged_s`
    covers the whole length of the log."""

    log: str
    fires: list[FireJson] | None
    tilt_max_deg: float | None
    longest_fall_s: float | None
    not_judged_s: float | None
    problems: list[str]
    answer: Answer


def add_arguments(parser: argparse.ArgumentParser) -> None:
    console.add_file(parser, "logs", metavar="LOG", help="flight log, recording or folder", nargs="*")
    parser.add_argument("--thresholds", nargs="+", action="extend", metavar="NAME=VALUE", help=", ".join(THRESHOLDS))
    parser.add_argument("--column", action="append", metavar="ROLE=COLUMN", help="of a table: roll_deg=ATT.Roll")
    side = parser.add_mutually_exclusive_group()
    side.add_argument("--must-not", action="store_true", help="do the vendor's defaults fire in none of them?")
    side.add_argument("--must", action="store_true", help="do the vendor's defaults fire in all of them, in time?")


def run(args: argparse.Namespace) -> int:
    given = {wish.command.key: wish.value for wish in parse_settings(args.thresholds or (), THRESHOLDS)}
    limits = limits_of(given)
    columns = parse_choice(args.column) if args.column else None
    paths = list(find_logs(args.logs))
    if not paths:
        raise console.Refused(tr("No flight log."))
    logs = [summarise_log(path, columns) for path in paths]
    judged = [_judged(log, limits) for log in logs]
    values = " ".join(f"{name}={typed(value)}" for name, value in zip(THRESHOLDS, limits, strict=True))
    said = [tr("Judged with: {values}", values=values)]
    # Which of them are nobody's word: a module may hold others.
    usual = join_names(name for name in THRESHOLDS if name not in given)
    if usual:
        said.append(tr("Vendor defaults, not of a module: {names}.", names=usual))
    if args.must or args.must_not:
        said += ["", *_defaults_lines(logs, is_must=args.must)]
    if args.json:
        console.write_lines(console.as_json(result) for result, _ in judged)
        console.note("\n".join(said))
    elif any(log.flight is not None for log in logs):
        console.write_lines([*_page(distinct_names(paths), judged), "", *said])
    for log in logs:
        if log.why_not is not None:
            console.notify(labelled(log.path, log.why_not.translated()))
    # One that fires outweighs all that were not read: it is certain.
    answers = {result.answer for result, _ in judged}
    if Answer.FIRES in answers:
        return console.PARTIAL
    return console.SUCCESS if answers == {Answer.DOES_NOT_FIRE} else console.USAGE_ERROR


def limits_of(given: Mapping[str, Any]) -> TriggerLimits:
    """The vendor's defaults, replaced by these. Raises `Refused`."""
    fields = dict(zip(THRESHOLDS, TriggerLimits._fields, strict=True))
    limits = TriggerLimits()._replace(**{fields[name]: value for name, value in given.items()})
    if limits.freefall_acceleration_g > MAX_ACCELERATION_G:
        expected = tr("expected {expected}", expected=f"≤ {MAX_ACCELERATION_G}")
        raise console.Refused(f"freefall_acceleration_g: {expected}")
    return limits


def _judged(log: SummarisedLog, limits: TriggerLimits) -> tuple[FiredJson, list[UserMessage]]:
    """The answer in English, and its problems: why it cannot be read or not be judged."""
    flight, why_not = log.flight, log.why_not
    result = FiredJson(str(log.path), None, None, None, None, [], Answer.UNREADABLE)
    problems = [] if flight is None else list(flight.problems)
    if flight is not None:
        result.answer, why_not, *_ = flight.outcome(limits)
        result.not_judged_s = round(flight.not_judged_s, 2)
        if math.isfinite(flight.tilt_max_deg):
            result.tilt_max_deg = round(flight.tilt_max_deg, 1)
        if flight.has_acceleration:
            result.longest_fall_s = max(0.0, round(flight.longest_fall_s(limits), 2))
        if result.answer is not Answer.NOT_JUDGED:
            result.fires = [
                FireJson(round(at_s, 3), _SOURCES[source], int(tilt_deg) if math.isfinite(tilt_deg) else None)
                for at_s, source, tilt_deg in flight.firings(limits)
            ]
    if why_not is not None:
        problems.append(why_not)
    result.problems = [problem.in_english() for problem in problems]
    return result, problems


def _page(names: Sequence[str], judged: Sequence[tuple[FiredJson, list[UserMessage]]]) -> list[str]:
    rows: list[tuple[str, ...]] = [(tr("Log"), tr("Fires"), tr("Largest tilt"), tr("Longest fall"), tr("Not judged"))]
    remarks: list[str] = []
    for name, (result, problems) in zip(names, judged, strict=True):
        fires = {Answer.UNREADABLE: tr("not read"), Answer.NOT_JUDGED: tr("not judged")}.get(result.answer, tr("no"))
        if result.fires:
            first = result.fires[0]
            tilted = tr("attitude, {tilt:.0f}°", tilt=first.tilt_deg or 0)
            why = tilted if first.source == "attitude" else tr("free fall")
            fires = tr("at {time:.2f} s: {why}", time=first.t_s, why=why)
        figures = ((result.tilt_max_deg, "°"), (result.longest_fall_s, " s"), (result.not_judged_s, " s"))
        rows.append((name, fires, *("–" if value is None else f"{value:g}{unit}" for value, unit in figures)))
        if result.answer is not Answer.UNREADABLE:
            remarks += [labelled(name, problem.translated()) for problem in problems]
    firing = sum(bool(result.fires) for result, _ in judged)
    unknown = sum(result.fires is None for result, _ in judged)
    counted = [tr("{count} of {total} fire.", count=firing, total=len(judged))]
    if unknown:
        counted.append(tr("{count} of {total} not judged.", count=unknown, total=len(judged)))
    lines = [*console.columns(rows), "", join_sentences(counted)]
    return [*lines, "", *remarks] if remarks else lines


def _defaults_lines(logs: Sequence[SummarisedLog], *, is_must: bool) -> list[str]:
    # What the vendor's defaults do in these flights, and in which not what they should. Flights of one side alone
    # propose no thresholds.
    flights = [log.flight for log in logs if log.flight is not None]
    total, unread = len(logs), len(logs) - len(flights)
    if unread:  # a folder that was thinned out proves nothing
        return [tr("{count} of {total} not read: no statement on the vendor's defaults.", count=unread, total=total)]
    unexpected, not_judged = defaults_result(flights, FlightGroup.MUST if is_must else FlightGroup.MUST_NOT)
    wrong = len(unexpected)
    line = tr("The vendor's defaults fire in {count} of {total}", count=wrong, total=total)
    if is_must:
        line = tr("The vendor's defaults miss {count} of {total}", count=wrong, total=total)
    lines = [line, *unexpected]
    if not_judged:
        lines.append(tr("Not judged: {names}", names=join_names(not_judged)))
    return lines

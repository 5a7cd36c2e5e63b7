"""The list's columns, and the verdicts on logs in words."""

import math
from datetime import datetime
from enum import IntEnum
from pathlib import Path
from typing import Final, NamedTuple

from PySide6.QtGui import QFontMetrics, QIcon
from PySide6.QtWidgets import QPushButton

from app.flights.judge import TriggerLimits
from app.flights.judging import Answer, FlightGroup, FlightOutcome, FlightSummary
from app.recordings.library import entry_text
from app.text.i18n import tr
from app.text.messages import capitalised, clean, in_brackets, join_names, labelled, stopwatch
from protocol.messages import Source
from protocol.translatable import marked
from ui.forms.tables import TableColumn
from ui.pages.logs.work import LogRow
from ui.style.icons import Icon, icon, set_icon_size
from ui.style.theme import IconSize, Meaning, font
from ui.widgets.controls import named


class Side(NamedTuple):
    """How a person puts logs on a side."""

    word: str
    tip: str
    key: str
    picture: Icon


SIDES: Final = {
    FlightGroup.MUST_NOT: Side(
        marked("Must not fire"), marked("An ordinary flight: it must not fire."), "N", Icon.NOT_TRIGGERED
    ),
    FlightGroup.MUST: Side(marked("Must fire"), marked("It crashed: it must fire."), "M", Icon.PARACHUTE),
    FlightGroup.UNSORTED: Side(marked("Not sorted"), marked("On neither side"), "U", Icon.UNKNOWN),
}


class Verdict(NamedTuple):
    """On a log with the chosen thresholds; only what is not as expected has a meaning."""

    # Marked.
    word: str
    icon: Icon
    meaning: Meaning | None = None


_UNREAD: Final = Verdict(marked("not read"), Icon.WARNING, Meaning.ATTENTION)
# It does not fire, but the log holds too little to say so.
_NOT_JUDGED: Final = Verdict(marked("not judged"), Icon.UNKNOWN, Meaning.ATTENTION)
# Only after the impact.
_LATE: Final = Verdict(marked("too late"), Icon.CLOCK, Meaning.DANGER)
_FIRES: Final = Verdict(marked("fires"), Icon.PARACHUTE)
_HOLDS: Final = Verdict(marked("no"), Icon.NOT_TRIGGERED)


def verdict_of(outcome: FlightOutcome, group: FlightGroup) -> Verdict:
    must = group is FlightGroup.MUST
    match outcome.answer:
        case Answer.FIRES if must:
            return _FIRES if outcome.is_before_impact else _LATE
        case Answer.FIRES:
            return _FIRES._replace(meaning=Meaning.DANGER) if group is FlightGroup.MUST_NOT else _FIRES
        case Answer.DOES_NOT_FIRE:
            return _HOLDS._replace(icon=Icon.CROSS, meaning=Meaning.DANGER) if must else _HOLDS
        case _:
            return _NOT_JUDGED


def short_name(name: str) -> str:
    return clean(Path(name).stem or name, longest=80)


def moment_text(at_s: float) -> str:
    """Time since the beginning of the log: "12.3 s", "3:07.2"."""
    return f"{at_s:.1f} s" if at_s < 60 else f"{stopwatch(at_s)}.{int(at_s * 10) % 10}"


def outcome_text(flight: FlightSummary, outcome: FlightOutcome) -> str:
    """When and why it fires, and how late; or why that is not known."""
    if outcome.why_not is not None:
        return labelled(capitalised(tr("not judged")), outcome.why_not.translated())
    if not outcome.sources:
        return capitalised(tr("no trigger"))
    words = {Source.ATTITUDE: tr("attitude"), Source.FREEFALL: tr("free fall")}
    why = " · ".join(word for source, word in words.items() if source in outcome.sources)
    parts = [tr("Fires at {time}: {why}", time=moment_text(outcome.at_s), why=why)]
    if not outcome.is_before_impact:
        parts.append(tr("after the impact"))
    elif flight.loss_s is not None and outcome.at_s < flight.loss_s:
        # It flew on: nothing tells that control was lost when it fired.
        parts.append(tr("then calm again until {time}", time=moment_text(flight.loss_s)))
    elif flight.loss_s is not None:
        parts.append(tr("{delay:.2f} s after the loss of control", delay=outcome.at_s - flight.loss_s))
    return join_names(parts)


def row_text(row: LogRow) -> str:
    """The row as text, for the tooltip, search and screen readers."""
    lines = [clean(row.name, longest=200) + in_brackets(tr(row.log.group.value))]
    if row.entry is not None:
        lines.append(entry_text(row.entry))
    elif row.log.changed_at is not None:
        lines.append(tr("File of {time}", time=_time_text(row.log.changed_at)))
    if row.why_not is not None:
        lines.append(row.why_not.translated())
    flight = row.log.flight
    if flight is not None and row.outcome is not None:
        lines.append(outcome_text(flight, row.outcome))
        if not math.isnan(flight.tilt_max_deg):
            lines.append(labelled(tr("Tilt"), f"{flight.tilt_max_deg:.0f}°"))
        lines += [problem.translated() for problem in flight.problems]
    return "\n".join(lines)


def sides_text(rows: list[LogRow]) -> tuple[str, bool]:
    """How many fire on each side, and whether that is not as it must be."""
    texts, is_bad = [], False
    for group in (FlightGroup.MUST_NOT, FlightGroup.MUST):
        outcomes = [row.outcome for row in rows if row.outcome is not None and row.log.group is group]
        total = len(outcomes)
        if not total:
            continue
        if group is FlightGroup.MUST:
            count = sum(outcome.is_before_impact for outcome in outcomes)
            text = tr("{count} of {total} fire in time", count=count, total=total)
            is_bad = is_bad or count < total
        else:
            count = sum(outcome.answer is Answer.FIRES for outcome in outcomes)
            text = tr("{count} of {total} fire", count=count, total=total)
            is_bad = is_bad or count > 0
        texts.append(labelled(capitalised(tr(group.value)), text))
    return " · ".join(texts), is_bad


def limits_text(limits: TriggerLimits) -> str:
    angle, force_g, time_s = limits.attitude_threshold_deg, limits.freefall_acceleration_g, limits.freefall_time_s
    return f"{angle:.0f}° · {force_g:.1f} g · {time_s:.2f} s"


def button(name: str, text: str, picture: Icon, slot: object, role: str = "") -> QPushButton:
    made = named(QPushButton(icon(picture, is_on_primary=role == "primary"), text), name, role)
    set_icon_size(made, IconSize.TEXT)
    made.clicked.connect(slot)
    return made


# Columns


class LogColumn(IntEnum):
    NAME = 0
    WHEN = 1
    LENGTH = 2
    ANSWER = 3
    SIDE = 4


def _time_text(when: datetime | None) -> str:
    return "—" if when is None else f"{when.astimezone():%Y-%m-%d %H:%M}"


def _when(row: LogRow) -> datetime | None:
    return row.log.changed_at if row.entry is None else row.entry.started_at


def _length_s(row: LogRow) -> float:
    """-1 where it is unknown."""
    if row.log.flight is not None:
        return row.log.flight.duration_s
    return -1.0 if row.entry is None or row.entry.trouble is not None else row.entry.duration_s


def _kind_icon(row: LogRow) -> QIcon:
    """A recording, or a flight log; what a recording is besides."""
    entry = row.entry
    if entry is None:
        return icon(Icon.MAP)
    if entry.trouble is not None or entry.was_cut_off:
        return icon(Icon.WARNING, Meaning.ATTENTION)
    if entry.is_running:
        return icon(Icon.RECORD)
    return icon(Icon.SIMULATOR if entry.is_simulated else Icon.RECORDINGS)


def _verdict(row: LogRow) -> Verdict | None:
    """Nothing is said of a recording that was not read yet."""
    if row.outcome is not None:
        return verdict_of(row.outcome, row.log.group)
    return None if row.why_not is None else _UNREAD


def _answer(row: LogRow) -> str:
    verdict = _verdict(row)
    if row.outcome is not None and verdict is not None and verdict.word == _FIRES.word:
        return moment_text(row.outcome.at_s)
    return "" if verdict is None else tr(verdict.word)


def _answer_order(row: LogRow) -> float:
    """What is not as expected first, then by time; what is not known last."""
    verdict = _verdict(row)
    if verdict is None:
        return 1e10
    at_s = 1e8 if row.outcome is None else min(row.outcome.at_s, 1e8)
    return at_s if verdict.meaning is not None else 1e9 + at_s


def _widest_answer() -> str:
    words = (tr(verdict.word) for verdict in (_UNREAD, _NOT_JUDGED, _LATE, _FIRES, _HOLDS))
    return max((*words, "8:88:88.8"), key=QFontMetrics(font()).horizontalAdvance)


COLUMNS: Final = (
    TableColumn[LogRow](
        marked("Log"),
        lambda row: clean(row.label, longest=80),
        picture=_kind_icon,
        widest=lambda: "survey-00.csv",
        stretches=True,
    ),
    TableColumn[LogRow](
        marked("Time"),
        lambda row: _time_text(_when(row)),
        lambda row: 0.0 if (when := _when(row)) is None else when.timestamp(),
        widest=lambda: "0000-00-00 00:00",
    ),
    TableColumn[LogRow](
        marked("Duration"),
        lambda row: "—" if _length_s(row) < 0 else stopwatch(_length_s(row)),
        _length_s,
        is_right=True,
        widest=lambda: "88:88",
        is_spare=True,
    ),
    TableColumn[LogRow](
        marked("Fires"),
        _answer,
        _answer_order,
        picture=lambda row: None if (verdict := _verdict(row)) is None else icon(verdict.icon, verdict.meaning),
        ink=lambda row: None if (verdict := _verdict(row)) is None else verdict.meaning,
        widest=_widest_answer,
    ),
    TableColumn[LogRow](
        marked("Side"),
        lambda row: "" if row.log.group is FlightGroup.UNSORTED else tr(SIDES[row.log.group].word),
        picture=lambda row: None if row.log.group is FlightGroup.UNSORTED else icon(SIDES[row.log.group].picture),
        widest=lambda: tr("Must not fire"),
    ),
)

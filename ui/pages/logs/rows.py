"""The list's columns, and the verdicts on logs in words."""

import math
from datetime import datetime
from enum import IntEnum
from pathlib import Path
from typing import Final, NamedTuple

from PySide6.QtGui import QFontMetrics, QIcon
from PySide6.QtWidgets import QPushButton

from app.flights.judge import TriggerLimits
from app.flights.judging import Answer, FirstFire, RuleReading, moment_text
from app.flights.thresholds import FlightGroup, FlightOutcome
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

READING_WORDS: Final = {
    RuleReading.DIRECT: marked("Triggers at once"),
    RuleReading.DAMPED: marked("Triggers after 0.2 s"),
}


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


# Verdicts


class Verdict(NamedTuple):
    """On a log with the chosen thresholds; only what is not as expected has a meaning."""

    # Marked.
    word: str
    icon: Icon
    meaning: Meaning | None = None


_UNREAD: Final = Verdict(marked("not read"), Icon.WARNING, Meaning.ATTENTION)
_DIFFERS: Final = Verdict(marked("unclear"), Icon.UNKNOWN, Meaning.ATTENTION)
# It does not fire, but the log holds too little to say so.
_NOT_JUDGED: Final = Verdict(marked("not judged"), Icon.UNKNOWN, Meaning.ATTENTION)
# Only after the impact.
_LATE: Final = Verdict(marked("too late"), Icon.CLOCK, Meaning.DANGER)
_FIRES: Final = Verdict(marked("fires"), Icon.PARACHUTE)
_HOLDS: Final = Verdict(marked("no"), Icon.NOT_TRIGGERED)
_VERDICTS: Final = (_UNREAD, _DIFFERS, _NOT_JUDGED, _LATE, _FIRES, _HOLDS)


def verdict_of(outcome: FlightOutcome | None) -> Verdict:
    if outcome is None:
        return _UNREAD
    if outcome.is_different:
        return _DIFFERS
    if outcome.answer is Answer.NOT_JUDGED:
        return _NOT_JUDGED
    must = outcome.group is FlightGroup.MUST
    if not outcome.direct.sources:
        return _HOLDS._replace(icon=Icon.CROSS, meaning=Meaning.DANGER) if must else _HOLDS
    if must and not outcome.direct.is_in_time:
        return _LATE
    return _FIRES._replace(meaning=Meaning.DANGER) if outcome.group is FlightGroup.MUST_NOT else _FIRES


def short_name(name: str) -> str:
    return clean(Path(name).stem or name, longest=80)


def fire_text(fire: FirstFire) -> str:
    """When and why it fires under one reading, and how late."""
    if not fire.sources:
        return capitalised(tr("no trigger"))
    words = {Source.ATTITUDE: tr("attitude"), Source.FREEFALL: tr("free fall")}
    why = " · ".join(word for source, word in words.items() if source in fire.sources)
    text = tr("Fires at {time}: {why}", time=moment_text(fire.at_s), why=why)
    late = fire.late_text if fire.is_in_time else tr("after the impact")
    return join_names(filter(None, (text, late)))


def outcome_lines(outcome: FlightOutcome) -> list[str]:
    """One line, or one per reading where they disagree."""
    if outcome.is_different:
        fires = {RuleReading.DIRECT: outcome.direct, RuleReading.DAMPED: outcome.damped}
        lines = [labelled(tr(READING_WORDS[reading]), fire_text(fire)) for reading, fire in fires.items()]
        return [tr("The readings of the rule differ:"), *lines]
    if outcome.answer is Answer.NOT_JUDGED and outcome.why_not_judged is not None:
        return [labelled(capitalised(tr("not judged")), outcome.why_not_judged.translated())]
    return [fire_text(outcome.direct)]


def row_text(row: LogRow) -> str:
    """The row as text, for the tooltip, search and screen readers."""
    lines = [clean(row.name, longest=200) + in_brackets(tr(row.group.value))]
    if row.entry is not None:
        lines.append(entry_text(row.entry))
    elif row.log is not None and row.log.changed_at is not None:
        lines.append(tr("File of {time}", time=_time_text(row.log.changed_at)))
    if row.why_not is not None:
        lines.append(row.why_not.translated())
    if row.outcome is not None:
        flight = row.outcome.flight
        lines += outcome_lines(row.outcome)
        if not math.isnan(flight.tilt_max_deg):
            lines.append(labelled(tr("Tilt"), f"{flight.tilt_max_deg:.0f}°"))
        lines += [problem.translated() for problem in flight.problems]
    return "\n".join(lines)


def sides_text(rows: list[LogRow]) -> tuple[str, Meaning | None]:
    """How many fire on each side; where the readings disagree, the worse one counts."""
    texts, is_bad = [], False
    for group in (FlightGroup.MUST_NOT, FlightGroup.MUST):
        outcomes = [row.outcome for row in rows if row.outcome is not None and row.group is group]
        total = len(outcomes)
        if not total:
            continue
        if group is FlightGroup.MUST:
            count = sum(outcome.direct.is_in_time and outcome.damped.is_in_time for outcome in outcomes)
            text = tr("{count} of {total} fire in time", count=count, total=total)
            is_bad = is_bad or count < total
        else:
            count = sum(bool(outcome.direct.sources or outcome.damped.sources) for outcome in outcomes)
            text = tr("{count} of {total} fire", count=count, total=total)
            is_bad = is_bad or count > 0
        texts.append(labelled(capitalised(tr(group.value)), text))
    return " · ".join(texts), Meaning.DANGER if is_bad else None


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


def _time_text(when: datetime) -> str:
    return f"{when.astimezone():%Y-%m-%d %H:%M}"


def _when_text(row: LogRow) -> str:
    when = _when(row)
    return "—" if when is None else _time_text(when)


def _when(row: LogRow) -> datetime | None:
    if row.entry is not None:
        return row.entry.started_at
    return None if row.log is None else row.log.changed_at


def _length_s(row: LogRow) -> float:
    """-1 where it is unknown."""
    if row.outcome is not None:
        return row.outcome.flight.duration_s
    return -1.0 if row.entry is None or row.entry.trouble is not None else row.entry.duration_s


def _kind_icon(row: LogRow) -> QIcon | None:
    """A recording, or a flight log; what a recording is besides."""
    entry = row.entry
    if entry is None:
        return icon(Icon.MAP)
    if entry.trouble is not None or entry.was_cut_off:
        return icon(Icon.WARNING, Meaning.ATTENTION)
    if entry.is_running:
        return icon(Icon.RECORD)
    if entry.is_pinned:
        return icon(Icon.BOOKMARK)
    return icon(Icon.SIMULATOR if entry.is_simulated else Icon.RECORDINGS)


def _verdict(row: LogRow) -> Verdict | None:
    """Nothing is said of a recording that was not read yet."""
    return None if row.outcome is None and row.why_not is None else verdict_of(row.outcome)


def _answer(row: LogRow) -> str:
    verdict = _verdict(row)
    if row.outcome is not None and verdict is not None and verdict.word == _FIRES.word:
        return moment_text(row.outcome.direct.at_s)
    return "" if verdict is None else tr(verdict.word)


def _answer_order(row: LogRow) -> float:
    """What is not as expected first, then by time; what is not known last."""
    verdict, at_s = _verdict(row), 1e8
    if row.outcome is not None:
        at_s = min(row.outcome.direct.at_s, row.outcome.damped.at_s, at_s)
    if verdict is None:
        return 1e10
    return at_s if verdict.meaning is not None else 1e9 + at_s


def _widest_answer() -> str:
    words = (tr(verdict.word) for verdict in _VERDICTS)
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
        _when_text,
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
        lambda row: "" if row.group is FlightGroup.UNSORTED else tr(SIDES[row.group].word),
        picture=lambda row: None if row.group is FlightGroup.UNSORTED else icon(SIDES[row.group].picture),
        widest=lambda: tr("Must not fire"),
    ),
)

"""Verdicts on flights, and the two lists: opened, moved to the other list, removed by mouse and keyboard."""

import math
from collections.abc import Callable, Mapping, Sequence
from enum import Enum, IntEnum
from functools import partial
from pathlib import Path
from typing import Final, NamedTuple

from PySide6.QtCore import Qt, Signal
from PySide6.QtGui import QAction, QFontMetrics, QResizeEvent
from PySide6.QtWidgets import QBoxLayout, QLabel, QPushButton, QSizePolicy, QWidget

from app.flights.judge import TriggerLimits
from app.flights.judging import Answer, RuleReading
from app.flights.summary import FirstFire, moment_text
from app.flights.thresholds import FlightGroup, FlightOutcome
from app.settings.profiles import SETTINGS_BY_KEY
from app.text.durations import stopwatch
from app.text.i18n import tr
from app.text.messages import clean
from app.text.sentences import capitalised, in_brackets, join_names, join_sentences, labelled
from protocol.fields import Value
from protocol.messages import Source
from protocol.translatable import marked
from ui.forms.rows_table import RowsTable
from ui.forms.table_kit import TableColumn
from ui.pages.flights.controller import GROUPS, FlightRow
from ui.style.icons import Icon, StateStyle, icon
from ui.style.theme import Meaning, Space, font
from ui.widgets.controls import control, named
from ui.widgets.labels import ElidedLabel, IconLabel
from ui.widgets.layouts import in_column, in_row

READING_WORDS: Final = {
    RuleReading.DIRECT: marked("Triggers at once"),
    RuleReading.DAMPED: marked("Triggers after 0.2 s"),
}
THRESHOLD_KEYS: Final = TriggerLimits._fields[:3]
"""Of the settings, in the order of the sliders."""
_TRIGGER_KEYS: Final = ("attitude_trigger", "freefall_trigger")


class Side(NamedTuple):
    """How a person puts flights on a side."""

    word: str
    tip: str
    key: str
    picture: Icon


SIDES: Final = {
    FlightGroup.UNSORTED: Side(marked("Not sorted"), marked("On neither side"), "U", Icon.UNKNOWN),
    FlightGroup.MUST_NOT: Side(
        marked("Must not fire"), marked("An ordinary flight: it must not fire."), "N", Icon.NOT_TRIGGERED
    ),
    FlightGroup.MUST: Side(marked("Must fire"), marked("It crashed: it must fire."), "M", Icon.PARACHUTE),
}


def assumed_text(values: Mapping[str, Value]) -> str:
    """Of a module's settings, by key, that are tried: what is judged without them, or against them."""
    unknown = [tr(SETTINGS_BY_KEY[key].title) for key in THRESHOLD_KEYS if key not in values]
    disabled = [tr(SETTINGS_BY_KEY[key].title) for key in _TRIGGER_KEYS if values.get(key) is False]
    parts = []
    if unknown:
        parts.append(tr("Vendor defaults, not of a module: {names}.", names=join_names(unknown)))
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
    NOT_JUDGED = 5
    """It does not fire, but the log holds too little to say so."""


def verdict_of(outcome: FlightOutcome | None) -> Verdict:
    if outcome is None:
        return Verdict.UNREAD
    if outcome.is_different:
        return Verdict.DIFFERS
    if outcome.answer is Answer.NOT_JUDGED:
        return Verdict.NOT_JUDGED
    if not outcome.direct.sources:
        return Verdict.HOLDS
    return Verdict.FIRES if outcome.direct.is_in_time or outcome.group is not FlightGroup.MUST else Verdict.LATE


def appearance_of(group: FlightGroup, verdict: Verdict) -> StateStyle:
    """Only what is not as expected has a meaning."""
    match verdict:
        case Verdict.UNREAD:
            return StateStyle(Icon.WARNING, Meaning.ATTENTION)
        case Verdict.DIFFERS | Verdict.NOT_JUDGED:
            return StateStyle(Icon.UNKNOWN, Meaning.ATTENTION)
        case Verdict.LATE:
            return StateStyle(Icon.CLOCK, Meaning.DANGER)
        case Verdict.FIRES:
            return StateStyle(Icon.PARACHUTE, Meaning.DANGER if group is FlightGroup.MUST_NOT else None)
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
    Verdict.HOLDS: marked("no"), Verdict.NOT_JUDGED: marked("not judged"),
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
        if outcome.answer is Answer.NOT_JUDGED and outcome.why_not_judged is not None:
            return (labelled(capitalised(tr("not judged")), outcome.why_not_judged.translated()),)
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
    if group is not FlightGroup.MUST:
        count = sum(bool(outcome.direct.sources or outcome.damped.sources) for outcome in outcomes)
        text = tr("{count} of {total} fire", count=count, total=total)
        is_bad = group is FlightGroup.MUST_NOT and count > 0
    else:
        count = sum(outcome.direct.is_in_time and outcome.damped.is_in_time for outcome in outcomes)
        text, is_bad = tr("{count} of {total} fire in time", count=count, total=total), count < total
    return labelled(name, text), Meaning.DANGER if is_bad else None


def list_detail(group: FlightGroup, outcomes: list[FlightOutcome]) -> str:
    """How many flights depend on the reading, and the largest delay."""
    if not outcomes:
        return tr("Select flights and press {key}", key=SIDES[group].key)
    parts = []
    different = sum(outcome.is_different for outcome in outcomes)
    if different:
        parts.append(labelled(tr("unclear"), different))
    not_judged = sum(outcome.answer is Answer.NOT_JUDGED for outcome in outcomes)
    if not_judged:
        parts.append(labelled(tr("not judged"), not_judged))
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


_NAMES: Final = {
    FlightGroup.UNSORTED: "flights_unsorted",
    FlightGroup.MUST_NOT: "flights_must_not",
    FlightGroup.MUST: "flights_must",
}
_ICON_PX: Final = 16
_ROW_PX: Final = 28


class FlightColumn(IntEnum):
    NAME = 0
    FIRES = 1
    TILT = 2
    FALL = 3
    DURATION = 4
    PROBLEMS = 5


def _style(row: FlightRow) -> StateStyle:
    return appearance_of(row.flight.group, verdict_of(row.outcome))


def _tilt(row: FlightRow) -> float:
    return math.nan if row.outcome is None else row.outcome.flight.tilt_max_deg


def _duration(row: FlightRow) -> float:
    return -1.0 if row.outcome is None else row.outcome.flight.duration_s


COLUMNS: Final = (
    TableColumn[FlightRow](
        marked("Log"), lambda row: clean(row.label, longest=80), widest=lambda: "survey-0000", stretches=True
    ),
    TableColumn[FlightRow](
        marked("Fires"),
        lambda row: verdict_text(row.outcome),
        lambda row: order_of(row.flight.group, row.outcome),
        picture=lambda row: icon(_style(row).icon, _style(row).meaning),
        ink=lambda row: _style(row).meaning,
        widest=lambda: max((*map(tr, _WORDS.values()), "8888.8 s"), key=QFontMetrics(font()).horizontalAdvance),
    ),
    TableColumn[FlightRow](
        marked("Tilt"),
        lambda row: "—" if math.isnan(_tilt(row)) else f"{_tilt(row):.0f}°",
        lambda row: -1.0 if math.isnan(_tilt(row)) else _tilt(row),
        is_right=True,
        widest=lambda: "180°",
    ),
    TableColumn[FlightRow](
        marked("Fall"),
        lambda row: "—" if row.longest_fall_s < 0 else f"{row.longest_fall_s:.2f} s",
        lambda row: row.longest_fall_s,
        is_right=True,
        widest=lambda: "88.88 s",
    ),
    TableColumn[FlightRow](
        marked("Duration"),
        lambda row: "—" if row.outcome is None else stopwatch(_duration(row)),
        _duration,
        is_right=True,
        widest=lambda: "88:88",
        is_spare=True,
    ),
    TableColumn[FlightRow](
        marked("Problems"),
        lambda row: str(problem_count(row)) if problem_count(row) else "",
        lambda row: float(problem_count(row)),
        picture=lambda row: icon(Icon.WARNING, Meaning.ATTENTION) if problem_count(row) else None,
        ink=lambda row: Meaning.ATTENTION if problem_count(row) else None,
        widest=lambda: "88",
        is_beside=True,
    ),
)


class FlightList(QWidget):
    opened = Signal(object)
    """`FlightRow`."""
    move_wanted = Signal(object, object)
    """Names, and the target list."""
    remove_wanted = Signal(object)
    """Names."""

    def __init__(self, group: FlightGroup) -> None:
        super().__init__()
        name = _NAMES[group]
        self.setObjectName(f"{name}_list")
        self.group = group
        self.table = table = RowsTable(
            f"{name}_table",
            tr(group.value),
            COLUMNS,
            lambda row: row.name,
            row_text,
            row_px=_ROW_PX,
            sorted_by=FlightColumn.FIRES,
            order=Qt.SortOrder.AscendingOrder,
        )
        table.setAlternatingRowColors(True)
        table.setTextElideMode(Qt.TextElideMode.ElideMiddle)  # file names mostly differ at the end
        table.setMinimumHeight(3 * _ROW_PX)
        self.picture = IconLabel(f"{name}_icon", _ICON_PX)
        self.caption = named(QLabel(), f"{name}_caption", "strong")
        self.detail = named(ElidedLabel(), f"{name}_detail", "small")
        targets = [target for target in SIDES if target is not group]
        self.move_buttons: dict[FlightGroup, QPushButton] = {}
        title = in_row(self.picture, self.caption, spacing=Space.XS)
        title.addSpacing(Space.XS)
        title.addWidget(self.detail, 1)
        buttons = in_row(1, spacing=Space.XS)
        for target in targets:
            side = SIDES[target]
            button = control(
                QPushButton(tr(side.word)),
                f"{name}_to_{target.name.lower()}",
                tip=tr(side.tip),
                key=side.key,
                slot=partial(self.move_chosen, target),
            )
            self.move_buttons[target] = button
            buttons.addWidget(button)
        head = named(QWidget(), f"{name}_head")
        head.setSizePolicy(QSizePolicy.Policy.Ignored, QSizePolicy.Policy.Fixed)
        self._head = in_row((title, 1), buttons, of=head, spacing=Space.XS, margins=0)
        in_column(head, (self.table, 1), of=self, spacing=Space.XS, margins=0)
        table.opened.connect(self._open)
        table.remove_wanted.connect(self._remove)
        self.opening = self._add_action("open", marked("Open"), Icon.LIVE, self._open)
        self.moving: list[QAction] = []
        for target in targets:
            side = SIDES[target]
            move = partial(self.move_chosen, target)
            action = self._add_action(f"to_{target.name.lower()}", side.word, side.picture, move)
            action.setShortcut(side.key)
            action.setAutoRepeat(False)
            action.setShortcutContext(Qt.ShortcutContext.WidgetShortcut)
            self.moving.append(action)
        self.removing = self._add_action("remove", marked("Remove"), Icon.CROSS, self._remove)
        table.setContextMenuPolicy(Qt.ContextMenuPolicy.ActionsContextMenu)
        table.selectionModel().selectionChanged.connect(self._refresh_actions)
        self._refresh_actions()

    def _add_action(self, word: str, english: str, picture: Icon, slot: Callable[[], None]) -> QAction:
        action = named(self.table.addAction(icon(picture), ""), f"{self.table.objectName()}_menu_{word}")
        action.setText(tr(english))
        action.triggered.connect(slot)
        return action

    def fit(self) -> None:
        """Has the buttons below the caption where they do not fit beside it."""
        parts = self.picture, self.caption, *self.move_buttons.values()
        needed_px = sum(part.sizeHint().width() for part in parts) + Space.XS * (len(parts) + 1)
        direction = QBoxLayout.Direction
        self._head.setDirection(direction.LeftToRight if needed_px <= self.width() else direction.TopToBottom)

    def resizeEvent(self, event: QResizeEvent) -> None:
        super().resizeEvent(event)
        self.fit()

    def show_rows(self, rows: Sequence[FlightRow]) -> None:
        self.table.show_rows(rows)
        outcomes = [row.outcome for row in rows if row.outcome is not None]
        text, meaning = list_caption(self.group, outcomes)
        self.caption.setText(text)
        self.detail.setText(list_detail(self.group, outcomes))
        good = SIDES[self.group].picture
        bad = Icon.PARACHUTE if self.group is FlightGroup.MUST_NOT else Icon.CROSS
        self.picture.show_icon(good if meaning is None else bad, meaning)
        self.fit()
        self._refresh_actions()

    def move_chosen(self, target: FlightGroup) -> None:
        names = self._names()
        if names:
            self.move_wanted.emit(names, target)

    def _names(self) -> list[str]:
        return [row.name for row in self.table.chosen()]

    def _open(self) -> None:
        chosen = self.table.chosen()
        if len(chosen) == 1:
            self.opened.emit(chosen[0])

    def _remove(self) -> None:
        self.remove_wanted.emit(self._names())

    def _refresh_actions(self) -> None:
        count = len(self.table.chosen())
        self.opening.setEnabled(count == 1)
        for action in (*self.moving, self.removing):
            action.setEnabled(count > 0)
        for button in self.move_buttons.values():
            button.setEnabled(count > 0)


class FlightLists(QWidget):
    def __init__(self) -> None:
        super().__init__()
        self.setObjectName("flights_lists")
        self.of: dict[FlightGroup, FlightList] = {group: FlightList(group) for group in GROUPS}
        in_column(*((part, 1) for part in self.of.values()), of=self, spacing=Space.S, margins=0)

    def show_rows(self, rows: dict[FlightGroup, list[FlightRow]]) -> None:
        has_problems = any(problem_count(row) for of_group in rows.values() for row in of_group)
        for group, part in self.of.items():
            part.show_rows(rows[group])
            # The same columns in both; without a problem in any flight the names take the column's room.
            if has_problems is part.table.isColumnHidden(FlightColumn.PROBLEMS):
                part.table.setColumnHidden(FlightColumn.PROBLEMS, not has_problems)
                part.table.measure()

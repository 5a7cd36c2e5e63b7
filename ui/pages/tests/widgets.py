"""Widgets of the Tests page and what they say: picture, list of steps, current value, result."""

from pathlib import Path
from typing import ClassVar, Final, NamedTuple

from PySide6.QtCore import QRectF, QSize, Qt
from PySide6.QtGui import QColor, QPaintEvent
from PySide6.QtSvg import QSvgRenderer
from PySide6.QtWidgets import QGridLayout, QLabel, QSizePolicy, QWidget

from app.guided.results import VERDICT_WORDS, GuidedKind, GuidedResult, GuidedVerdict, MeasuredValue, StoredTest
from app.system.wall_clock import DAY, local_time
from app.text.i18n import tr
from app.text.messages import UserMessage
from app.text.sentences import capitalised
from app.text.user_error import UserError
from protocol.translatable import marked
from ui.forms.rows_table import RowsTable
from ui.forms.table_kit import TableColumn
from ui.session.guided import Guided, Stage
from ui.session.ports import Ports
from ui.style.icons import MEANING_ICONS, Icon, icon, themed_svg
from ui.style.painted_widget import PaintedWidget, pen
from ui.style.theme import Meaning, Size, Space, current, scaled
from ui.widgets.controls import named, set_role
from ui.widgets.labels import IconLabel, text_label
from ui.widgets.layouts import in_column, in_row
from ui.widgets.readout import Readout

_MARK_PX: Final = 18
_MAX_STEPS: Final = 6


def step_pictures() -> QSvgRenderer:
    """`steps.svg` in the theme's colours, with thick lines in sunlight."""
    theme = current()
    return themed_svg(
        Path(__file__).parent / "steps.svg", **{meaning.value: theme.tint(meaning).ink for meaning in Meaning},
        text=theme.text, muted=theme.muted, border=theme.border, surface=theme.surface, raised=theme.raised,
        wash=theme.information.wash, line=theme.line_px + 1, thick=theme.line_px + 2,
        size=scaled(Size.SMALL), side=tr("from the side"), behind=tr("from behind"),
    )  # fmt: skip


class GuidedPicture(PaintedWidget):
    usual: ClassVar = QSize(280, 170)

    def __init__(self) -> None:
        super().__init__()
        named(self, "tests_picture")
        self._kind, self.step = GuidedKind.TILT, 0
        self.setSizePolicy(QSizePolicy.Policy.Fixed, QSizePolicy.Policy.Fixed)

    def show_step(self, kind: GuidedKind, step: int, what: str) -> None:
        """`what`: the step in words, for screen readers."""
        self._kind, self.step = kind, step
        self.announce(tr("Picture: {what}", what=what))

    def paintEvent(self, _event: QPaintEvent) -> None:
        theme = current()
        painter = self.begin_paint()
        painter.setPen(pen(theme.divider, theme.border_px))
        painter.setBrush(QColor(theme.surface))
        box = QRectF(self.rect()).adjusted(1, 1, -1, -1)
        painter.drawRoundedRect(box, 8, 8)
        step_pictures().render(painter, f"{self._kind.value}-{self.step}", box)
        painter.end()


class StepList(QWidget):
    """Numbered steps, marked as done, current or still to do."""

    def __init__(self) -> None:
        super().__init__()
        named(self, "tests_steps")
        grid = QGridLayout(self)
        grid.setContentsMargins(0, 0, 0, 0)
        grid.setHorizontalSpacing(Space.S)
        grid.setVerticalSpacing(Space.XS)
        grid.setColumnStretch(1, 1)
        self.rows: list[tuple[IconLabel, QLabel]] = []
        for number in range(_MAX_STEPS):
            mark = IconLabel(f"tests_step_{number}_mark", _MARK_PX)
            mark.setFixedWidth(_MARK_PX)
            text = text_label(f"tests_step_{number}")
            grid.addWidget(mark, number, 0, Qt.AlignmentFlag.AlignTop)
            grid.addWidget(text, number, 1)
            self.rows.append((mark, text))
        grid.setRowStretch(_MAX_STEPS, 1)

    def show_steps(self, steps: tuple[str, ...], step: int, *, is_running: bool) -> None:
        """`steps`: translated; those before `step` are done."""
        for number, (mark, label) in enumerate(self.rows):
            is_there = number < len(steps)
            mark.setVisible(is_there)
            label.setVisible(is_there)
            if not is_there:
                continue
            is_done, is_now = number < step, is_running and number == step
            state = tr("done") if is_done else tr("now") if is_now else tr("to do")
            text = f"{number + 1}. {steps[number]}"
            if label.text() != text:
                label.setText(text)
            label.setAccessibleName(f"{text} ({state})")
            set_role(label, "strong" if is_now else "" if is_done else "muted")
            if is_done:
                mark.show_icon(Icon.CHECK)  # over, however it ended
            elif is_now:
                mark.show_icon(Icon.CHEVRON_RIGHT, Meaning.INFORMATION)
            else:
                mark.clear_icon()


VERDICT_MEANINGS = {
    GuidedVerdict.PASSED: Meaning.GOOD,
    GuidedVerdict.FAILED: Meaning.DANGER,
    GuidedVerdict.UNCLEAR: Meaning.ATTENTION,
}


def instruction(work: Guided) -> str:
    if work.stage in (Stage.PREPARING, Stage.MEASURING):
        if work.report is None:
            return tr("Asking the module…")
        values = {name: value.translated() if isinstance(value, UserMessage) else value
                  for name, value in work.report.values}  # fmt: skip
        return tr(work.report.doing, **values)
    return work.test.steps[work.step].translated() if work.stage is Stage.CONFIRMING else ""


def last_text(last: StoredTest | None) -> str:
    if last is None:
        return tr("not tested")
    return f"{tr(VERDICT_WORDS[last.verdict])} {local_time(last.at, DAY)}, {last.who or '—'}"


class _Watched(NamedTuple):
    """What a test watches: caption, key and unit of the value, and the key of its limit."""

    caption: str
    key: str
    unit: str
    decimals: int
    limit_key: str


_WATCHED: Final = {
    GuidedKind.TILT: _Watched(marked("Tilt"), "tilt_deg", "°", 0, "attitude_threshold_deg"),
    GuidedKind.FREE_FALL: _Watched(marked("Acceleration"), "acceleration_g", " g", 1, "freefall_acceleration_g"),
    GuidedKind.BAY: _Watched(marked("Light"), "light_v", " V", 1, "light_threshold_v"),
}
_LOST: Final = marked("lost")


def live_caption(kind: GuidedKind) -> str:
    return tr(_WATCHED[kind].caption if kind in _WATCHED else _LOST)


def show_live(live: Readout, work: Guided, ports: Ports) -> None:
    """The current value beside its limit; of the link how many requests were lost."""
    watched = _WATCHED.get(work.kind)
    if watched is None:
        values = dict(work.report.values) if work.report is not None else {}
        asked, lost = values.get("asked"), values.get("lost")
        live.set_limit("")
        if asked is None or lost is None:
            live.show_unknown()
        else:
            live.show_value(f"{lost} / {asked}")
        return
    view, now = ports.module.view, ports.clock()
    shown = [
        "" if value is None else f"{float(value):.{watched.decimals}f}{watched.unit}"
        for value in (view.fresh(watched.key, now), view.fresh(watched.limit_key, now))
    ]
    live.set_limit(shown[1])
    has_fired = view.fresh("triggered", now) if work.kind is GuidedKind.TILT else None
    note = "" if has_fired is None else tr("TRIGGERED") if has_fired else tr("not triggered")
    if shown[0]:
        live.show_value(shown[0], note=note)
    else:
        live.show_unknown()


_ROW_PX: Final = 28

COLUMNS: Final[tuple[TableColumn[MeasuredValue], ...]] = (
    TableColumn(marked("Quantity"), lambda row: row.name.translated()),
    TableColumn(marked("Measured"), lambda row: row.shown.translated(), stretches=True),
    TableColumn(marked("Tolerance"), lambda row: row.tolerance.translated(), stretches=True),
    TableColumn(
        marked("Result"),
        lambda row: tr(VERDICT_WORDS[row.verdict]),
        picture=lambda row: icon(MEANING_ICONS[VERDICT_MEANINGS[row.verdict]], VERDICT_MEANINGS[row.verdict]),
        ink=lambda row: VERDICT_MEANINGS[row.verdict],
    ),
)


class ResultView(QWidget):
    def __init__(self) -> None:
        super().__init__()
        named(self, "tests_result")
        self.mark, self.verdict = IconLabel("tests_verdict_mark", 24), text_label("tests_verdict", "heading")
        self.advice = text_label("tests_advice")
        self.table = RowsTable(
            "tests_table",
            tr("Measured values"),
            COLUMNS,
            lambda row: row.name,
            _row_sentence,
            row_px=_ROW_PX,
            is_single=True,
        )
        self.table.setVerticalScrollBarPolicy(Qt.ScrollBarPolicy.ScrollBarAlwaysOff)
        head = in_row(self.mark, (self.verdict, 1), spacing=Space.S)
        in_column(head, self.advice, self.table, 1, of=self, spacing=Space.S, margins=0)

    def show_outcome(self, outcome: GuidedResult | UserError | None) -> None:
        meaning, text, role, measured, advice = Meaning.ATTENTION, "", "title", tuple[MeasuredValue, ...](), None
        if isinstance(outcome, GuidedResult):
            meaning, text = VERDICT_MEANINGS[outcome.verdict], capitalised(tr(VERDICT_WORDS[outcome.verdict]))
            role, measured, advice = "heading", outcome.measured, outcome.advice
        elif outcome is not None:
            text = outcome.message.translated()
        self.mark.show_icon(MEANING_ICONS[meaning], meaning)
        set_role(self.verdict, role)
        self.verdict.setText(text)
        self.verdict.setAccessibleName(text)
        self.table.show_rows(measured)
        self.table.setVisible(bool(measured))
        self.table.setFixedHeight(self.table.horizontalHeader().sizeHint().height() + _ROW_PX * len(measured) + 4)
        self.advice.setText("" if advice is None else advice.translated())
        self.advice.setVisible(advice is not None)


def _row_sentence(row: MeasuredValue) -> str:
    return ", ".join(column.text(row) for column in COLUMNS)

"""The chosen thresholds: sliders, the map of false and missing triggers, and what is proposed. Nothing is sent: they go
into Settings as edits."""

from collections.abc import Iterable, Sequence
from typing import ClassVar, Final

import numpy as np
import pyqtgraph as pg
from numpy.typing import NDArray
from PySide6.QtCore import QPointF, QRectF, QSize, Qt, Signal
from PySide6.QtGui import QColor, QMouseEvent, QPixmap
from PySide6.QtWidgets import QFrame, QGridLayout, QLabel, QPushButton, QSizePolicy, QWidget

from app.flights.judge import TriggerLimits
from app.flights.judging import LEAST, MOST, TILTS_DEG, TIMES_S, Answer, FlightGroup
from app.text.i18n import tr
from app.text.messages import capitalised, join_names, labelled
from protocol.catalogue import BY_NAME
from ui.pages.logs.rows import LogsWork, limits_text, short_name
from ui.plots.charts import StaticPlot
from ui.services.context import DraftExchange
from ui.style.icons import Icon
from ui.style.theme import IconSize, Meaning, Space, Theme, current, scaled
from ui.widgets.controls import IconLabel, control, in_column, in_row, named, scroll_area, text_label
from ui.widgets.notice_bar import NoticeBar
from ui.widgets.notices import Notice
from ui.widgets.number_line import Dial, NumberKind, label_for


class ThresholdPanel(QWidget):
    """`chosen` has the `TriggerLimits`; `judged`: a number was typed, which can be used unless it `is_wrong`."""

    chosen = Signal(object)
    judged = Signal()

    def __init__(self) -> None:
        super().__init__()
        self.setObjectName("logs_thresholds")
        self.setSizePolicy(QSizePolicy.Policy.Preferred, QSizePolicy.Policy.Fixed)
        self._limits = TriggerLimits()
        # What a module can have; above 1.5 g all would be a fall.
        self.tilt = Dial("logs_tilt", NumberKind.of(0, 180, 1, "°", 0))
        self.acceleration = Dial("logs_acceleration", NumberKind.of(0, 1.5, 0.1, "g", 1))
        self.time = Dial("logs_time", NumberKind.of(0, 2.55, 0.01, "s", 2))
        grid = QGridLayout(self)
        grid.setContentsMargins(0, 0, 0, 0)
        grid.setHorizontalSpacing(Space.S)
        grid.setVerticalSpacing(Space.XS)
        grid.setColumnStretch(1, 1)
        rows = (
            ("attitude_threshold", tr("Attitude"), self.tilt),
            ("freefall_acceleration", tr("Free fall below"), self.acceleration),
            ("freefall_time", tr("Free-fall time"), self.time),
        )
        for row, (name, title, dial) in enumerate(rows):
            dial.describe(tr(BY_NAME[name].title), tr(BY_NAME[name].explanation))
            grid.addWidget(label_for(dial, title), row, 0)
            grid.addWidget(dial, row, 1)
            dial.judged.connect(self.judged)
            dial.turned.connect(self._choose)
        # What may be typed has its own line, with room kept for it: no slider is squeezed, and nothing moves.
        grid.addLayout(in_column(*(dial.range for _, _, dial in rows), spacing=0), len(rows), 0, 1, 2)
        grid.setRowMinimumHeight(len(rows), self.fontMetrics().lineSpacing())

    @property
    def is_wrong(self) -> bool:
        return self.tilt.is_wrong or self.acceleration.is_wrong or self.time.is_wrong

    def show_limits(self, limits: TriggerLimits) -> None:
        self._limits = limits
        self.tilt.set_value(limits.attitude_threshold_deg)
        self.acceleration.set_value(limits.freefall_acceleration_g)
        self.time.set_value(limits.freefall_time_s)

    def _choose(self) -> None:
        values = self.tilt.value, round(self.acceleration.value, 1), round(self.time.value, 2)
        self.chosen.emit(TriggerLimits(*values, *self._limits[3:]))


_SWATCH_PX: Final = 12
_TIME_STEP_S: Final = 0.05
# Lower and upper edge of the cells, by times and by tilts.
_TIME_EDGES_S: Final = (float(TIMES_S[0]) - _TIME_STEP_S / 2, float(TIMES_S[-1]) + _TIME_STEP_S / 2)
_TILT_EDGES_DEG: Final = (float(TILTS_DEG[0]) - 0.5, float(TILTS_DEG[-1]) + 0.5)
Cells = NDArray[np.float64]


def cell_colours(wrong: Cells, missed: Cells, *, has_must: bool) -> NDArray[np.uint8]:
    """Return one pixel a cell, lowest row first: red for false triggers, else blue for missing ones. `wrong` and
    `missed` are the shares of flights that fire and must not, and that do not fire in time and must."""
    theme = current()
    # Red and blue differ for every eye, and in how light they are from what separates.
    pixels = np.empty((*wrong.shape, 3), np.uint8)
    pixels[:] = _rgb(theme.tint(Meaning.GOOD).wash if has_must else theme.surface)
    for share, tint in ((missed, theme.information), (wrong, theme.danger)):
        wash, fill = np.array(_rgb(tint.wash)), np.array(_rgb(tint.fill))
        shades = wash + (fill - wash) * (0.35 + 0.65 * share[:, :, None])
        pixels[share > 0] = shades.astype(np.uint8)[share > 0]
    return pixels


def _rgb(colour: str) -> tuple[int, int, int]:
    ink = QColor(colour)
    return ink.red(), ink.green(), ink.blue()


class FireMapView(StaticPlot):
    """`chosen` has the attitude threshold in degrees and the free-fall time in seconds."""

    chosen = Signal(float, float)
    usual: ClassVar = QSize(240, 200)
    least: ClassVar = usual

    def __init__(self) -> None:
        super().__init__("logs_map")
        self.setCursor(Qt.CursorShape.CrossCursor)
        # What `cell_colours` needs.
        self._map: tuple[Cells, Cells, bool] | None = None
        self.image = pg.ImageItem(axisOrder="row-major")
        # Outlines and lines, so that they contrast with every cell.
        self.cross = [pg.InfiniteLine(angle=angle) for angle in (0, 90, 0, 90)]
        self.handle = pg.TargetItem(size=11, symbol="o", movable=False)
        self._swatches: list[QLabel] = []
        keys = QGridLayout()
        keys.setColumnStretch(1, 1)
        keys.setColumnStretch(3, 1)
        for place, word in enumerate((tr("false trigger"), tr("no trigger"), tr("separates"))):
            self._swatches.append(named(QLabel(), f"logs_map_swatch_{place}"))
            self._swatches[-1].setFrameShape(QFrame.Shape.Box)
            row, column = divmod(place, 2)
            keys.addWidget(self._swatches[-1], row, 2 * column)
            keys.addWidget(named(QLabel(word), "logs_map_word", "small"), row, 2 * column + 1)
        self.column.addLayout(keys)

    def show_map(self, wrong: Cells, missed: Cells, *, has_must: bool) -> None:
        self._map = wrong, missed, has_must
        self.redraw()

    def show_limits(self, limits: TriggerLimits, text: str) -> None:
        """Moves the cross; `text` is the accessible text."""
        self.announce(text)
        tilt, time_s = _on_map(limits.attitude_threshold_deg, limits.freefall_time_s)
        for line in self.cross:
            line.setPos(tilt if line.angle == 0 else time_s)
        self.handle.setPos(time_s, tilt)

    # Drawing

    def draw(self, theme: Theme) -> None:
        self.set_range(_TIME_EDGES_S, _TILT_EDGES_DEG)
        for number, line in enumerate(self.cross):
            is_outline = number < 2
            colour, width = (theme.surface, theme.line_px + 3) if is_outline else (theme.text, theme.line_px + 0.5)
            line.setPen(pg.mkPen(colour, width=width))
        self.handle.setPen(pg.mkPen(theme.surface, width=2))
        self.handle.setBrush(QColor(theme.text))
        self.add(self.image, *self.cross, self.handle)
        tilts, times_s = range(30, 121, 15), (0.5, 1.0, 1.5, 2.0, 2.5)
        self.show_ticks("left", [(tilt, f"{tilt}°") for tilt in tilts], tr("Attitude threshold"))
        self.show_ticks("bottom", [(time_s, f"{time_s:g} s") for time_s in times_s], tr("Free-fall time"))
        self.view.setBorder(pg.mkPen(theme.border, width=theme.border_px))
        if self._map is not None:
            wrong, missed, has_must = self._map
            self.image.setImage(cell_colours(wrong, missed, has_must=has_must), autoLevels=False)
            (first, last), (low, high) = _TIME_EDGES_S, _TILT_EDGES_DEG
            self.image.setRect(QRectF(first, low, last - first, high - low))
        explained = cell_colours(np.array([[0.6, 0.0, 0.0]]), np.array([[0.0, 0.6, 0.0]]), has_must=True)[0]
        for swatch, colour in zip(self._swatches, explained.tolist(), strict=True):
            picture = QPixmap(scaled(_SWATCH_PX), scaled(_SWATCH_PX))
            picture.fill(QColor(*colour))
            swatch.setPixmap(picture)

    # Mouse; the dials beside it have keys

    def choose_at(self, place: QPointF) -> None:
        """Chooses the thresholds at a place: whole degrees, steps of 0.05 s."""
        at = self.view.mapSceneToView(place)
        self.chosen.emit(*_on_map(round(at.y()), round(at.x() / _TIME_STEP_S) * _TIME_STEP_S))

    def mousePressEvent(self, event: QMouseEvent) -> None:
        if event.button() == Qt.MouseButton.LeftButton:
            self.choose_at(event.position())

    def mouseMoveEvent(self, event: QMouseEvent) -> None:
        if event.buttons() & Qt.MouseButton.LeftButton:
            self.choose_at(event.position())


def _on_map(tilt_deg: float, time_s: float) -> tuple[float, float]:
    """The nearest thresholds on the map."""
    tilt, time = np.clip(tilt_deg, TILTS_DEG[0], TILTS_DEG[-1]), np.clip(time_s, TIMES_S[0], TIMES_S[-1])
    return float(tilt), round(float(time), 2)


_LINES: Final = 5


class ProposalBar(QFrame):
    """A notice of the page stands in place of the proposal's text; what is longer scrolls, so that nothing moves."""

    def __init__(self, exchange: DraftExchange, work: LogsWork, thresholds: ThresholdPanel) -> None:
        super().__init__()
        named(self, "logs_proposal", "card")
        self._work, self._exchange, self._thresholds = work, exchange, thresholds
        self.picture = IconLabel("logs_proposal_icon", IconSize.NOTICE)
        self.head = text_label("logs_proposal_head", "strong", is_selectable=True)
        self.lines = text_label("logs_proposal_lines", "small", is_selectable=True)
        self.strip = named(NoticeBar(), "logs_notice")
        self.take = control(QPushButton(tr("Try proposal")), "logs_take", picture=Icon.CHECK, slot=self._try)
        self.use = control(QPushButton(tr("Use in Settings")), "logs_use", picture=Icon.SETTINGS, slot=self._use)
        self.use.setToolTip(tr("Nothing is sent."))
        self._summary = summary = QWidget()
        texts = in_column(self.head, self.lines, 1, spacing=0)
        in_row((self.picture, Qt.AlignmentFlag.AlignTop), (texts, 1), of=summary, margins=(Space.S, 0))
        content = QWidget()
        in_column(summary, self.strip, of=content, spacing=0, margins=0)
        area = scroll_area(content, "logs_proposal_area", tr("Proposal"), is_vertical=True)
        area.setFrameShape(QFrame.Shape.NoFrame)
        for ground in (content, area.viewport()):
            ground.setAutoFillBackground(False)
        area.setFixedHeight(_LINES * self.fontMetrics().lineSpacing() + Space.S)
        in_row((area, 1), in_column(self.take, self.use), of=self, margins=(Space.S, Space.XS))

    def show_notices(self, notices: Sequence[Notice]) -> None:
        """Of the page."""
        self.strip.show_notices(notices)
        self._summary.setVisible(not notices)

    def refresh(self) -> None:
        work, proposal, unread = self._work, self._work.proposal, self._work.unread()
        limits = None if proposal is None or unread else proposal.limits
        if work.proposing.is_running:
            self._say(Icon.CLOCK, tr("Looking for thresholds…"))
        elif unread and (proposal is not None or any(log.group is not FlightGroup.UNSORTED for log in unread)):
            head = tr("No proposal: {count} of {total} not read", count=len(unread), total=len(work.logs))
            lines = [tr("Read or remove: {names}", names=_names(log.name for log in unread))]
            self._say(Icon.WARNING, head, lines, Meaning.ATTENTION)
        elif proposal is None:
            self._say(Icon.INFORMATION, tr("No proposal yet"), [tr("Choose logs, then press N or M.")])
        elif limits is None and not proposal.conflicts:
            empty = FlightGroup.MUST if work.side(FlightGroup.MUST_NOT) else FlightGroup.MUST_NOT
            self._say(Icon.INFORMATION, tr("No proposal: no log is on the side “{side}”.", side=tr(empty.value)))
        elif limits is None:
            words = {FlightGroup.MUST_NOT: tr("false trigger"), FlightGroup.MUST: tr("no trigger")}
            conflicts = proposal.conflicts.items()
            lines = [labelled(capitalised(words[group]), _names(names)) for group, names in conflicts if names]
            self._say(Icon.WARNING, tr("No thresholds separate the sides"), lines, Meaning.ATTENTION)
        else:
            lines = []
            for group, margin in proposal.nearest.items():
                parts = []
                if margin.attitude_deg is not None and margin.attitude_deg >= 0:
                    parts.append(f"{margin.attitude_deg}°")
                if margin.freefall_s is not None and margin.freefall_s >= 0:
                    parts.append(f"{margin.freefall_s:.2f} s")
                side, what, name = capitalised(tr(group.value)), " · ".join(parts), short_name(margin.name)
                lines.append(tr("{group}: {what} to spare ({name})", group=side, what=what, name=name))
            must_not = work.side(FlightGroup.MUST_NOT)
            doubtful = [one.name for one in must_not if one.outcome(limits).answer is Answer.NOT_JUDGED]
            if doubtful:
                lines.append(tr("Not judged: {names}", names=_names(doubtful)))
            self._say(Icon.CHECK, tr("Proposal: {limits}", limits=limits_text(limits)), [*lines, *bounds_lines()])
        self.take.setEnabled(limits is not None and limits != work.limits)
        self.refresh_use()

    def refresh_use(self) -> None:
        # What is typed and cannot be used is not what would be handed over.
        self.use.setEnabled(self._exchange.can_use() and not self._thresholds.is_wrong)

    def _say(self, picture: Icon, head: str, lines: Sequence[str] = (), meaning: Meaning | None = None) -> None:
        self.picture.show_icon(picture, meaning, is_muted=meaning is None)
        self.head.setText(head)
        self.lines.setText("\n".join(lines))

    def _try(self) -> None:
        proposal = self._work.proposal
        if proposal is not None and proposal.limits is not None:
            self._work.choose(proposal.limits)

    def _use(self) -> None:
        limits = self._work.limits
        self._exchange.used.emit(
            {
                "attitude_threshold_deg": round(limits.attitude_threshold_deg),
                "freefall_acceleration_g": round(limits.freefall_acceleration_g, 1),
                "freefall_time_s": round(limits.freefall_time_s, 2),
            }
        )


def _names(names: Iterable[str]) -> str:
    return join_names(map(short_name, names))


def bounds_lines() -> tuple[str, str]:
    """Which limits of a proposal are this program's, and which the vendor's."""
    ours = tr(
        "Limits of this program: {least_tilt}° to {most_tilt}°, {least_force} g to {most_force} g, "
        "{least_fall:.2f} s to {most_fall:.2f} s.",
        least_tilt=LEAST.attitude_threshold_deg,
        most_tilt=MOST.attitude_threshold_deg,
        least_force=LEAST.freefall_acceleration_g,
        most_force=MOST.freefall_acceleration_g,
        least_fall=LEAST.freefall_time_s,
        most_fall=MOST.freefall_time_s,
    )
    return ours, tr("The vendor says: 55° or more, below 0.7 g; defaults 60°, 0.5 g, 1.60 s.")

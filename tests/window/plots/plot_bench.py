"""Time plots in a window, for the tests of this folder."""

import numpy as np
from PySide6.QtCore import QPoint, QPointF, QRectF, Qt
from PySide6.QtGui import QPainter, QPicture, QWheelEvent
from PySide6.QtWidgets import QApplication, QLineEdit, QPushButton, QScrollArea, QToolButton, QVBoxLayout, QWidget
from pytestqt.qtbot import QtBot

from app.samples.samples import Series, StepFunction
from tests.support.window.steps import find
from ui.plots.charts import LabelAxis
from ui.plots.lane_view import LaneView, Shown
from ui.plots.lanes import Lane, Limit, Scale, Span
from ui.plots.time_plot import PlotView, TimePlot
from ui.style import theme
from ui.style.icons import Icon
from ui.style.theme import Meaning
from ui.widgets.readout import StateChip

NOW_S = 5000.0
LEFT = Qt.MouseButton.LeftButton
NONE, CONTROL = Qt.KeyboardModifier.NoModifier, Qt.KeyboardModifier.ControlModifier


def labels_of(axis: LabelAxis) -> list[tuple[str, QRectF]]:
    """What an axis shows, and where on it."""
    picture = QPicture()
    painter = QPainter(picture)
    _, _, labels = axis.generateDrawSpecs(painter)
    painter.end()
    return [(text, room) for room, _, text in sorted(labels, key=lambda label: label[0].left())]


class Bench:
    """A plot of tilt and acceleration in a window, with what it shows at hand."""

    def __init__(self, qtbot: QtBot, *, seconds: float = 120, rate_hz: float = 50, bounds: Span | None = None) -> None:
        self.tilt, self.acc, self.fire = Series(), Series(), StepFunction()
        times = NOW_S - seconds + np.arange(1, int(seconds * rate_hz) + 1) / rate_hz
        self.tilt.append(times, np.full(len(times), 12))
        self.acc.append(times, np.ones(len(times)))
        self.fire.put(NOW_S - seconds, 60)
        self.stale = StepFunction()
        lanes = [
            Lane(
                "Tilt",
                "°",
                self.tilt,
                (Scale(0, 90, 30), Scale(0, 180, 45)),
                (
                    Limit(self.fire, "{value}° fires", Meaning.DANGER),
                    Limit(self.stale, "{value}° fires?", Meaning.DANGER, is_stale=True),
                ),
                weight=3,
            ),
            Lane("Acceleration", "g", self.acc, (Scale(0, 2, 1),), decimals=1, weight=2),
        ]
        self.plot = TimePlot(lanes, wall_offset_s=1_700_000_000.0, bounds=bounds)
        self.area = QScrollArea()
        self.window = QWidget()
        layout = QVBoxLayout(self.window)
        self.other = QLineEdit()
        layout.addWidget(self.other)
        layout.addWidget(self.plot)
        self.area.setWidget(self.window)
        qtbot.addWidget(self.area)
        self.area.resize(830, 560)
        self.window.resize(800, 520)
        with qtbot.waitExposed(self.area):
            self.area.show()
        self.area.activateWindow()
        self.other.setFocus()
        self.plot.draw(NOW_S)

    @property
    def view(self) -> PlotView:
        return find(self.plot, PlotView, "time-plot-canvas")

    @property
    def lane(self) -> LaneView:
        """That of the tilt."""
        return self.view.lanes[0]

    @property
    def state(self) -> str:
        chip = find(self.plot, StateChip, "time-plot-state")
        return "live" if chip.isHidden() else chip.word

    @property
    def written(self) -> list[Shown]:
        """Words and icons in the plots, the most important first."""
        return self.view.overlay.shown

    @property
    def words(self) -> dict[str, QRectF]:
        """What is written into the plots, and where."""
        return {shown.what: shown.room for shown in self.written if isinstance(shown.what, str)}

    @property
    def dots(self) -> list[QPointF]:
        """Those at the cursor."""
        return [place for place, _ in self.view.overlay.dots]

    @property
    def times(self) -> list[str]:
        """The labels below the plots."""
        return [text for text, _ in labels_of(self.view.times)]

    def icon(self, icon: Icon, meaning: Meaning) -> QRectF | None:
        """Where the icon of a mark is."""
        ink = theme.current().ink(meaning)
        return next((shown.room for shown in self.written if (shown.what, shown.ink) == (icon, ink)), None)

    @property
    def lines(self) -> list[float]:
        """The places of the lines of marks and cursor, across."""
        return [x for x, _ in self.view.overlay.lines]

    def button(self, name: str) -> QPushButton | QToolButton:
        button = self.plot.findChild(QPushButton, name) or self.plot.findChild(QToolButton, name)
        assert isinstance(button, QPushButton | QToolButton)
        return button

    def at(self, part: float) -> QPoint:
        """A point of the upper lane at a part of its width."""
        box = self.lane.box
        return QPoint(round(box.left() + part * box.width()), round(box.center().y()))

    def wheel(self, part: float, notches: int, modifiers: Qt.KeyboardModifier = NONE) -> bool:
        """Turn the wheel over the plot; whether it was taken."""
        place = QPointF(self.at(part))
        event = QWheelEvent(
            place,
            QPointF(self.view.mapToGlobal(place)),
            QPoint(),
            QPoint(0, 120 * notches),
            Qt.MouseButton.NoButton,
            modifiers,
            Qt.ScrollPhase.NoScrollPhase,
            False,
        )
        QApplication.sendEvent(self.view.viewport(), event)
        return event.isAccepted()

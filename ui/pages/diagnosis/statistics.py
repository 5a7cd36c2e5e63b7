"""Statistics of the link: figures in a form, and its course over time."""

from collections.abc import Sequence
from typing import ClassVar, Final, NamedTuple

import numpy as np
import pyqtgraph as pg
from PySide6.QtCore import QSize
from PySide6.QtGui import QColor
from PySide6.QtWidgets import QFormLayout, QFrame, QLabel, QWidget

from app.diagnosis.link_statistics import MAX_SECONDS, Slice
from app.text.durations import duration
from app.text.i18n import tr
from app.text.sentences import in_brackets, labelled
from protocol.translatable import marked
from ui.plots.static_plot import StaticPlot
from ui.services.context import Services
from ui.style.theme import Meaning, Space, Theme, current, scaled
from ui.widgets.controls import named, set_role
from ui.widgets.labels import SELECTABLE, TickingLabel
from ui.widgets.layouts import in_column, in_row
from ui.widgets.visibility_timer import VisibilityTimer

REFRESH_EVERY_MS: Final = 500
# The shortest course that is drawn.
SHORTEST_S: Final = 60.0
# The share of requests without reply from which a warning is shown.
LOSS_ATTENTION: Final = 0.01
# The height of the lowest bar as a part of the highest, and its least width.
_LEAST: Final = 0.03
_MIN_PX: Final = 1.5
_FIGURES: Final = (
    ("sent", marked("Requests")),
    ("lost", marked("Without reply")),
    ("trip", marked("Round trip")),
    ("late", marked("95th percentile")),
    ("lag", marked("Lag")),
    ("restarts", marked("Restarts")),
    ("losses", marked("Port lost")),
    ("rejected", marked("Invalid bytes")),
    ("reasons", ""),
)


def percent_text(share: float) -> str:
    """ "0 %", "0.03 %", "12 %"."""
    percent = share * 100
    return f"{percent:.0f} %" if percent >= 10 or not percent else f"{percent:.2g} %"


class Stretch(NamedTuple):
    """The time line from `now_s - length_s` to `now_s`."""

    now_s: float
    length_s: float
    slices: tuple[Slice, ...]


class _Band(NamedTuple):
    """`text` is shown for the highest value."""

    title: str
    text: str
    values: Sequence[float]
    ink: QColor


class OverTime(StaticPlot):
    """Slowest answer, queries without reply and invalid bytes over time, with marks for restarts of the module and lost
    ports."""

    usual: ClassVar = QSize(640, 200)
    least: ClassVar = QSize(260, 150)

    def __init__(self) -> None:
        super().__init__("figures_over_time")
        self._stretch = Stretch(0.0, 600.0, ())

    def show_stretch(self, stretch: Stretch) -> None:
        self._stretch = stretch
        self.announce(
            tr(
                "Over the last {time}: {lanes}; restarts: {restarts}; port lost: {losses}",
                time=duration(stretch.length_s),
                lanes="; ".join(f"{band.title} {band.text}" for band in reversed(self._bands())),
                restarts=f"{sum(part.counters.restarts for part in stretch.slices):,}",
                losses=f"{sum(part.losses for part in stretch.slices):,}",
            )
        )
        self.redraw()

    def _bands(self) -> tuple[_Band, ...]:
        """From below upwards."""
        theme, slices = current(), self._stretch.slices
        slowest, missed = [part.slowest_s or 0.0 for part in slices], [part.counters.time_outs for part in slices]
        rejected, ink = [part.counters.rejected for part in slices], theme.ink(Meaning.ATTENTION)
        worst = f"{max(slowest) * 1000:.1f} ms" if any(slowest) else "—"
        return (
            _Band(tr("Invalid bytes"), f"{sum(rejected):,}", rejected, ink),
            _Band(tr("Without reply"), f"{sum(missed):,}", missed, ink),
            _Band(tr("Slowest answer"), worst, slowest, QColor(theme.curves[0])),
        )

    def draw(self, theme: Theme) -> None:
        stretch, bands = self._stretch, self._bands()
        begins = np.array([part.begins_s for part in stretch.slices]) - stretch.now_s
        widths = np.full(len(begins), max(1.0, _MIN_PX * stretch.length_s / max(1, self.width())))
        for number, band in enumerate(bands):
            self.add(pg.InfiniteLine(number, angle=0, pen=pg.mkPen(theme.divider, width=theme.border_px)))
            values = np.array(band.values, np.float64)
            if values.any():
                heights = np.where(values, np.maximum(values / values.max(), _LEAST), 0) * 0.8
                bars = pg.BarGraphItem(brush=band.ink, pen=None, x0=begins, y0=number, width=widths, height=heights)
                self.add(bars)
        for place, part in zip(begins + 0.5, stretch.slices, strict=True):
            if part.counters.restarts or part.losses:
                ink = theme.ink(Meaning.DANGER if part.losses else Meaning.INFORMATION)
                symbol = "s" if part.losses else "t"  # a square, or a triangle that points down
                mark = pg.ScatterPlotItem([place], [len(bands)], symbol=symbol, size=scaled(8), brush=ink, pen=None)
                self.add(pg.InfiniteLine(place, pen=pg.mkPen(ink, width=theme.line_px, dash=(4, 3))), mark)
        self.set_range((-stretch.length_s, 0.0), (0.0, len(bands) + 0.1))
        self.show_ticks("left", [(n + 0.4, f"{band.title}\n{band.text}") for n, band in enumerate(bands)])
        length = duration(stretch.length_s)
        self.show_ticks("bottom", [(-stretch.length_s, tr("{time} ago", time=length)), (0.0, tr("now"))])


class StatisticsView(QWidget):
    def __init__(self, services: Services) -> None:
        super().__init__()
        self.setObjectName("link_figures_view")
        self._ports = services.ports
        self.setAccessibleName(tr("Statistics"))
        self.over_time = OverTime()
        self.figures: dict[str, QLabel] = {}
        card = named(QFrame(), "figures_card", "card")
        form = QFormLayout(card)
        form.setHorizontalSpacing(Space.XL)
        for key, english in _FIGURES:
            figure = self.figures[key] = named(TickingLabel(), f"figures_{key}")
            figure.setTextInteractionFlags(SELECTABLE)
            figure.setAccessibleName(tr(english) if english else tr("Invalid bytes"))
            form.addRow(named(QLabel(tr(english) if english else ""), f"figures_{key}_name", "muted"), figure)
        time_card = named(QFrame(), "figures_time_card", "card")
        title = named(QLabel(tr("Over time")), "figures_time_title", "caption")
        legend = named(QLabel(tr("▼ restart   ■ port lost")), "figures_legend", "caption")
        head = in_row(title, 1, legend, spacing=Space.XS)
        in_column(head, (self.over_time, 1), of=time_card, spacing=Space.XS, margins=(Space.M, Space.S))
        in_column((time_card, 1), card, of=self, spacing=Space.S, margins=(Space.M, Space.S))
        VisibilityTimer(self, self.refresh, every_ms=REFRESH_EVERY_MS)

    def refresh(self) -> None:
        statistics, lag_s = self._ports.module.statistics, self._ports.module.view.lag_s
        totals = statistics.totals
        share = min(1.0, totals.time_outs / totals.sent) if totals.sent else 0.0
        trips = [statistics.quantile_s(quantile) for quantile in (0.5, 0.95)]
        trip, late = ("—" if trip_s is None else f"{trip_s * 1000:.1f} ms" for trip_s in trips)
        counts = (labelled(tr(why.value), f"{n:,}") for why, n in totals.rejected_bytes.most_common() if n)
        texts = {
            "sent": f"{totals.sent:,}",
            "lost": f"{totals.time_outs:,}{in_brackets(percent_text(share))}" if totals.sent else "—",
            "trip": trip,
            "late": late,
            "lag": "—" if lag_s is None else f"{lag_s:.2f} s",
            "restarts": f"{totals.restarts:,}",
            "losses": f"{statistics.losses:,}",
            "rejected": f"{totals.rejected:,}",
            "reasons": "\n".join(counts),
        }
        for key, text in texts.items():
            self.figures[key].setText(text)
        warned = {"lost": share > LOSS_ATTENTION, "rejected": totals.rejected > 0, "losses": statistics.losses > 0}
        for key, is_warned in warned.items():
            set_role(self.figures[key], "attention" if is_warned else "")
        now, slices = self._ports.clock(), statistics.seconds
        # No longer than there is data.
        past_s = now - slices[0].begins_s if slices else 0.0
        length_s = min(float(MAX_SECONDS), max(SHORTEST_S, past_s))
        self.over_time.show_stretch(Stretch(now, length_s, slices))

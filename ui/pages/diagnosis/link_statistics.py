"""Statistics view: totals, round trips, rejected bytes by reason, and course over time."""

from collections.abc import Sequence
from typing import ClassVar, Final, NamedTuple

import numpy as np
import pyqtgraph as pg
from PySide6.QtCore import QSize, Qt
from PySide6.QtGui import QColor
from PySide6.QtWidgets import QBoxLayout, QFrame, QGridLayout, QLabel, QWidget

from app.diagnosis.link_statistics import MAX_SECONDS, Slice, TripClass
from app.text.durations import duration
from app.text.i18n import tr
from app.text.sentences import in_brackets, labelled
from protocol.frame import Reason
from protocol.translatable import marked
from ui.plots.static_plot import StaticPlot
from ui.services.context import Services
from ui.style.icons import Icon
from ui.style.theme import Meaning, Space, Theme, current, is_text_large, scaled
from ui.widgets.controls import control, named
from ui.widgets.labels import SELECTABLE, IconLabel, TickingLabel, text_label
from ui.widgets.layouts import ScrollArea, in_column, in_row
from ui.widgets.visibility_timer import VisibilityTimer

_TICK_MS: Final = frozenset((1, 4, 16, 64, 250, 1000))
"""Bounds labelled below the histogram; there is no room for all."""
_LEAST: Final = 0.03
"""Height of the lowest bar as a part of the highest."""
_HEAD: Final = 1.3
"""Height of the histogram as a multiple of its highest bar, for the share above that."""
_SHARE_PX: Final = 40
_MIN_PX: Final = 1.5


def percent_text(share: float) -> str:
    """ "0 %", "0.03 %", "12 %"."""
    percent = share * 100
    return f"{percent:.0f} %" if percent >= 10 or not percent else f"{percent:.2g} %"


def _bars(colour: QColor, **places: object) -> pg.BarGraphItem:
    return pg.BarGraphItem(brush=colour, pen=None, **places)


class Histogram(StaticPlot):
    """Histogram of round trips, with shares."""

    def __init__(self) -> None:
        super().__init__("figures_trips")
        self._classes: tuple[TripClass, ...] = ()

    def show_classes(self, classes: tuple[TripClass, ...]) -> None:
        if classes == self._classes:
            return
        self._classes = classes
        total = sum(trips.count for trips in classes)
        parts = "; ".join(f"{_bound(trips)}: {trips.count}" for trips in classes if trips.count)
        self.announce(tr("Round trips: {n}. {classes}", n=total, classes=parts), name=tr("Round trip"))
        self.redraw()

    def draw(self, theme: Theme) -> None:
        counts = np.array([trips.count for trips in self._classes])
        total = counts.sum()
        if not total:
            self.show_nothing(tr("not measured yet"))
            return
        most, middles = counts.max(), np.arange(len(counts)) + 0.5
        heights = np.where(counts, np.maximum(counts, most * _LEAST), 0)
        self.add(_bars(QColor(theme.curves[0]), x=middles, height=heights, width=0.9))
        self.set_range((0.0, len(counts)), (0.0, most * _HEAD))
        # A share that is wider than its bar must not reach into a higher one, or another share.
        reach = scaled(_SHARE_PX) * len(counts) // max(1, self.width())
        for n in np.flatnonzero(counts * 20 >= total).tolist():
            first = max(0, n - reach)
            if first + counts[first : n + reach + 1].argmax() == n:
                self.add_text(percent_text(counts[n] / total), theme.text, (middles[n], heights[n]), (0.5, 1.0))
        bounds = enumerate((trips.up_to_ms for trips in self._classes), 1)
        self.show_ticks("bottom", [(n, f"{ms:g}") for n, ms in bounds if ms in _TICK_MS])


def _bound(trips: TripClass) -> str:
    return tr("longer") if trips.up_to_ms is None else tr("up to {ms} ms", ms=f"{trips.up_to_ms:g}")


class Stretch(NamedTuple):
    """The time line from `now_s - length_s` to `now_s`."""

    now_s: float
    length_s: float
    slices: tuple[Slice, ...]


class _Band(NamedTuple):
    title: str
    text: str
    """Shown for the highest value."""
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
                self.add(_bars(band.ink, x0=begins, y0=number, width=widths, height=heights))
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


REFRESH_EVERY_MS: Final = 500
SHORTEST_S: Final = 60.0
"""The shortest course that is drawn."""
LOSS_ATTENTION: Final = 0.01
"""Share of requests without reply from which a warning is shown."""
_NUMBERS: Final = (
    ("sent", marked("Requests")),
    ("lost", marked("Without reply")),
    ("trip", marked("Round trip")),
    ("late", marked("95th percentile")),
    ("lag", marked("Lag")),
    ("rejected", marked("Invalid bytes")),
    ("restarts", marked("Restarts")),
    ("losses", marked("Port lost")),
)
REASON_WORDS: Final = {
    Reason.NO_HEADER: marked("no frame header"),
    Reason.UNKNOWN_CODE: marked("unknown code"),
    Reason.CONTROL: marked("wrong control byte"),
    Reason.CHECKSUM: marked("wrong checksum"),
    Reason.VALUE: marked("impossible value"),
    Reason.INCOMPLETE: marked("broken off"),
}
_ICON_PX: Final = 16


class Tile(QWidget):
    """A caption above a figure, with an optional warning sign. A figure `is_long` where it may need several words."""

    def __init__(self, name: str, title: str, *, is_long: bool = False) -> None:
        super().__init__()
        self.setObjectName(f"{name}_tile")
        self.figure = control(TickingLabel(), name, says=title, role="strong" if is_long else "title")
        self.figure.setTextInteractionFlags(SELECTABLE)
        self.figure.setWordWrap(is_long)
        self._sign = IconLabel(f"{name}_sign", _ICON_PX)
        caption = named(QLabel(title), f"{name}_name", "small")
        # The figures of a row stand on one baseline.
        row = in_row((self.figure, int(is_long)), self._sign, *(() if is_long else (1,)), spacing=Space.XS)
        in_column(caption, *((1, row) if is_long else (row, 1)), of=self, spacing=0, margins=0)

    def show_figure(self, text: str, *, needs_attention: bool = False) -> None:
        if needs_attention:
            self._sign.show_icon(Icon.WARNING, Meaning.ATTENTION)
        else:
            self._sign.clear_icon()
        self.figure.setText(text)


class LinkStatisticsView(ScrollArea):
    def __init__(self, services: Services) -> None:
        super().__init__()
        self.setObjectName("link_figures_view")
        self.setHorizontalScrollBarPolicy(Qt.ScrollBarPolicy.ScrollBarAlwaysOff)
        self._ports = services.ports
        self.setAccessibleName(tr("Statistics"))
        self.totals = {key: Tile(f"figures_{key}", tr(title)) for key, title in _NUMBERS}
        self.trips, self.over_time = Histogram(), OverTime()
        self.reasons = text_label("figures_reasons", is_selectable=True)
        self.reasons.setAlignment(Qt.AlignmentFlag.AlignTop)
        self._legend = named(QLabel(tr("▼ restart   ■ port lost")), "figures_legend", "caption")
        self._lay_out()
        VisibilityTimer(self, self.refresh, every_ms=REFRESH_EVERY_MS, restyle=self._fit)
        self._fit()

    def _fit(self) -> None:
        """Large text has two rows of numbers, and one chart below the other."""
        is_large, direction = is_text_large(), QBoxLayout.Direction
        columns = 4 if is_large else len(self.totals)
        for number, tile in enumerate(self.totals.values()):
            self._numbers.addWidget(tile, number // columns, number % columns)
        self._pair.setDirection(direction.TopToBottom if is_large else direction.LeftToRight)

    def refresh(self) -> None:
        statistics = self._ports.module.statistics
        totals = statistics.totals
        shown = self.totals
        shown["sent"].show_figure(f"{totals.sent:,}")
        share = min(1.0, totals.time_outs / totals.sent) if totals.sent else 0.0
        lost = f"{totals.time_outs:,}{in_brackets(percent_text(share))}" if totals.sent else "—"
        shown["lost"].show_figure(lost, needs_attention=share > LOSS_ATTENTION)
        for key, quantile in (("trip", 0.5), ("late", 0.95)):
            trip_s = statistics.quantile_s(quantile)
            shown[key].show_figure("—" if trip_s is None else f"{trip_s * 1000:.1f} ms")
        lag_s = self._ports.module.view.lag_s
        shown["lag"].show_figure("—" if lag_s is None else f"{lag_s:.2f} s")
        shown["rejected"].show_figure(f"{totals.rejected:,}", needs_attention=totals.rejected > 0)
        shown["restarts"].show_figure(f"{totals.restarts:,}")
        shown["losses"].show_figure(f"{statistics.losses:,}", needs_attention=statistics.losses > 0)
        self.trips.show_classes(statistics.round_trips())
        counts = (labelled(tr(REASON_WORDS[why]), f"{n:,}") for why, n in totals.rejected_bytes.most_common() if n)
        self.reasons.setText("\n".join(counts) or tr("none"))
        now, slices = self._ports.clock(), statistics.seconds
        # No longer than there is data.
        past_s = now - slices[0].begins_s if slices else 0.0
        length_s = min(float(MAX_SECONDS), max(SHORTEST_S, past_s))
        self.over_time.show_stretch(Stretch(now, length_s, slices))

    # Making

    @staticmethod
    def _card(name: str, *parts: QWidget) -> QFrame:
        card = named(QFrame(), name, "card")
        column = in_column(*parts, of=card, spacing=Space.XS, margins=(Space.M, Space.S))
        column.setStretch(len(parts) - 1, 1)
        return card

    def _lay_out(self) -> None:
        numbers = named(QFrame(), "figures_totals", "card")
        self._numbers = QGridLayout(numbers)
        self._numbers.setContentsMargins(Space.M, Space.S, Space.M, Space.S)
        self._numbers.setHorizontalSpacing(Space.M)
        trips = named(QLabel(tr("Round-trip time, ms")), "figures_trips_title", "caption")
        reasons = named(QLabel(tr("Invalid bytes")), "figures_reasons_title", "caption")
        self._pair = in_row(
            (self._card("figures_trips_card", trips, self.trips), 3),
            (self._card("figures_reasons_card", reasons, self.reasons), 2),
            spacing=Space.S,
        )
        head = named(QWidget(), "figures_time_head")
        title = named(QLabel(tr("Over time")), "figures_time_title", "caption")
        in_row(title, 1, self._legend, of=head, spacing=Space.XS, margins=0)
        content = named(QWidget(), "figures_content")
        in_column(
            numbers,
            (self._card("figures_time_card", head, self.over_time), 1),
            (self._pair, 1),
            of=content,
            spacing=Space.S,
            margins=(Space.M, Space.S),
        )
        self.setWidget(content)

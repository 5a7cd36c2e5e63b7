"""The plots are painted when their picture is another one, while the numbers follow ten to thirty times a second."""

from collections.abc import Iterator

import pytest
from PySide6.QtGui import QPaintEvent
from PySide6.QtWidgets import QApplication
from pytestqt.qtbot import QtBot

from tests.support.window.live_bench import Bench, live_bench
from ui.plots.lanes import Mark
from ui.plots.plot_view import PlotView
from ui.style.icons import Icon
from ui.widgets.readout import StateChip

_TICK_S = 1 / 30
"""As often as batches come."""


class Watched:
    """A Live page whose paints of the plots are counted, on a clock that only `run` moves."""

    def __init__(self, bench: Bench, painted: list[int]) -> None:
        self.bench, self._painted = bench, painted
        self.values: set[str] = set()

    def choose(self, seconds: int) -> None:
        self.bench.click(f"time-plot-window-{seconds}")
        self.tick()  # the row of controls takes its place

    def run(self, seconds: float) -> int:
        """Let time pass, a report with another tilt coming at each tick; how often the plots were painted."""
        bench = self.bench
        before = len(self._painted)
        for number in range(round(seconds / _TICK_S)):
            bench.now_s += _TICK_S
            bench.page.data.tilt.append([bench.now_s], [number % 90])
            bench.page._tick()
            QApplication.processEvents()
            self.values.add(bench.find(StateChip, "time-plot-state").accessibleName())
        return len(self._painted) - before

    def tick(self) -> int:
        """One turn of the page's timer at an instant that stands still; how often the plots were painted."""
        before = len(self._painted)
        for _ in range(3):
            self.bench.page._tick()
            QApplication.processEvents()
        return len(self._painted) - before


@pytest.fixture
def watched(qtbot: QtBot, qapp: QApplication, monkeypatch: pytest.MonkeyPatch) -> Iterator[Watched]:
    painted: list[int] = []
    paint = PlotView.paintEvent

    def counted(view: PlotView, event: QPaintEvent) -> None:
        painted.append(1)
        paint(view, event)

    monkeypatch.setattr(PlotView, "paintEvent", counted)
    with live_bench(qtbot, qapp) as bench:
        bench.say()
        bench.page._timer.stop()
        yield Watched(bench, painted)


@pytest.mark.parametrize(("length_s", "seconds"), [(60, 4.0), (600, 12.0)])
def test_a_paint_for_each_pixel(watched: Watched, length_s: int, seconds: float) -> None:
    watched.choose(length_s)
    pixels = seconds / watched.bench.page.plot.time_range.pixel_s
    assert 4 < pixels < seconds * 20
    assert watched.run(seconds) == pytest.approx(pixels, abs=1.5)


def test_numbers_follow_between_two_paints(watched: Watched, monkeypatch: pytest.MonkeyPatch) -> None:
    watched.choose(600)
    shown: list[object] = []
    monkeypatch.setattr(watched.bench.page.panel, "show_device", lambda *_, **__: shown.append(1))
    assert watched.run(1.0) <= 2
    assert 10 <= len(shown) <= 30


def test_changes_other_than_time_are_painted_at_once(watched: Watched) -> None:
    watched.choose(600)
    bench = watched.bench
    plot = bench.page.plot
    assert watched.tick() == 0
    plot.add_marks([Mark(bench.now_s - 1, "activated", Icon.ACTIVE)])
    assert watched.tick() == 1
    assert watched.tick() == 0
    bench.page.data.fires.put(bench.now_s, 75)
    assert watched.tick() == 1
    bench.page.fired.lines.show(44, None)
    assert watched.tick() == 1
    assert watched.tick() == 0
    plot.reset()
    QApplication.processEvents()
    assert watched.tick() == 0


def test_a_paused_plot_is_not_painted_and_shows_its_delay(watched: Watched) -> None:
    watched.choose(10)
    watched.bench.page.plot.time_range.toggle_pause()
    watched.run(0.2)
    watched.values.clear()
    assert watched.run(2.2) == 0
    assert len(watched.values) >= 2


def test_a_late_report_is_painted_in_a_paused_plot(watched: Watched) -> None:
    watched.choose(10)
    bench = watched.bench
    bench.now_s += 1
    bench.page.plot.draw(bench.now_s)
    bench.page.plot.time_range.toggle_pause()
    QApplication.processEvents()
    bench.page.data.tilt.append([bench.now_s - 0.5], [33])
    assert watched.tick() == 1
    assert watched.tick() == 0

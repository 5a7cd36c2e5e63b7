"""What the Live page paints: its plots when their picture changes, its numbers when a report does, the first paint
first.
"""

from collections.abc import Iterator
from functools import partial
from pathlib import Path
from typing import Any

import pytest
from PySide6.QtCore import QEvent, QObject
from PySide6.QtGui import QPaintEvent
from PySide6.QtWidgets import QApplication, QWidget
from pytestqt.qtbot import QtBot

from app.engine.target import Target
from tests.support.window.fakes_ui import simulated, window
from tests.support.window.live_bench import Bench, live_bench
from tests.support.window.steps import await_child
from ui.plots.lanes import Mark
from ui.plots.plot_view import PlotView
from ui.services.context import PageEntry, Services
from ui.services.page import Page
from ui.shell.main_window import MainWindow
from ui.shell.page_area import PageMaker
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
    bench.page.data.acting.fires.put(bench.now_s, 75)
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


def test_pages_are_made_after_the_first_paint(
    qapp: QApplication, qtbot: QtBot, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    order: list[str] = []
    make = MainWindow.make_pages

    def painted(self: QWidget, _event: QPaintEvent) -> None:
        order.append("painted")

    def made(self: MainWindow) -> None:
        order.append("made")
        make(self)

    monkeypatch.setattr(MainWindow, "paintEvent", painted, raising=False)
    monkeypatch.setattr(MainWindow, "make_pages", made)
    with window(qapp, tmp_path):
        qtbot.waitUntil(lambda: "made" in order)
    assert order[0] == "painted"
    assert order.count("made") == 1


def test_a_window_that_is_never_painted_gets_its_pages(
    qapp: QApplication, qtbot: QtBot, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(MainWindow, "show", lambda self: None)
    with window(qapp, tmp_path) as assembly:
        await_child(qtbot, assembly.window, QWidget, "empty_page")


class Leaf(Page):
    """A page with nothing in it."""

    def __init__(self, _services: Services) -> None:
        super().__init__("leaf")


def leaves(made: list[str], keys: str = "abcd") -> tuple[PageEntry, ...]:
    """An entry a letter; `made` gets the letters in the order in which their pages are made."""

    def make(key: str, services: Services) -> Page:
        made.append(key)
        return Leaf(services)

    return tuple(PageEntry(key, key, Icon.LIVE, partial(make, key)) for key in keys)


def test_a_turn_makes_and_places_one_page(
    qapp: QApplication, qtbot: QtBot, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    made: list[str] = []
    done: list[int] = []
    placed: list[str] = []
    turn, place = PageMaker._make_next, MainWindow._place

    def counted(maker: PageMaker) -> None:
        before = len(made) + len(placed)
        turn(maker)
        done.append(len(made) + len(placed) - before)

    def noted(main: MainWindow, key: str, page: Page) -> None:
        placed.append(key)
        place(main, key, page)

    monkeypatch.setattr(PageMaker, "_make_next", counted)
    monkeypatch.setattr(MainWindow, "_place", noted)
    with window(qapp, tmp_path, entries=leaves(made)) as assembly:
        qtbot.waitSignal(assembly.window.pages_made).wait()
        assert made == placed == list("abcd")
        assert done == [2] * 4 + [0]


def test_a_page_that_is_chosen_before_it_is_made_comes_next(qapp: QApplication, qtbot: QtBot, tmp_path: Path) -> None:
    made: list[str] = []
    with window(qapp, tmp_path, entries=leaves(made)) as assembly:
        assembly.window.go_to("c")
        qtbot.waitSignal(assembly.window.pages_made).wait()
        assert made == list("cabd")
        assert assembly.window.stack.currentWidget() is assembly.window._pages["c"]


def test_a_port_that_was_held_back_for_the_pages_goes_on_though_another_one_is_shown(
    qapp: QApplication, qtbot: QtBot, tmp_path: Path
) -> None:
    with window(qapp, tmp_path, entries=leaves([])) as assembly, simulated("held back"):
        ports, held = assembly.ports, assembly.ports.current
        with qtbot.waitSignal(assembly.window.pages_made):
            assembly.window._maker.hold_batches()
            held.connect_to(Target("sim://held back", 115200))
            ports.choose(ports.add())
            assert ports.current is not held
            assembly.window._maker.hold_batches()
        qtbot.waitUntil(lambda: held.module.is_going)


_NUMBERS = {
    "live_gauge", "live_tilt", "live_acceleration", "live_light", "live_cell", "live_boot_count", "live_stream",
}  # fmt: skip
_BELOW_THEM = {"live_panel", "live_seen", "live_content", "live_page"}


class Paints(QObject):
    """The names of all widgets that were painted."""

    def __init__(self, qapp: QApplication) -> None:
        super().__init__()
        self.names: list[str] = []
        self._qapp = qapp
        qapp.installEventFilter(self)

    def eventFilter(self, watched: QObject, event: QEvent) -> bool:
        if event.type() is QEvent.Type.Paint:
            self.names.append(watched.objectName())
        return False

    def of(self, bench: Bench, **values: Any) -> set[str]:
        """Those that a report of these values leads to, a moment later."""
        bench.now_s += 0.1
        bench.say(**values)
        self._qapp.processEvents()
        found, self.names = set(self.names), []
        return found


@pytest.fixture
def bench(qtbot: QtBot, qapp: QApplication) -> Iterator[Bench]:
    with live_bench(qtbot, qapp) as made:
        made.say()
        made.page._timer.stop()
        qapp.processEvents()
        yield made


@pytest.fixture
def paints(bench: Bench, qapp: QApplication) -> Iterator[Paints]:
    made = Paints(qapp)
    made.of(bench)
    yield made
    qapp.removeEventFilter(made)


def test_equal_reports_paint_no_number(bench: Bench, paints: Paints) -> None:
    for _ in range(10):
        assert not paints.of(bench) & (_NUMBERS | _BELOW_THEM)


@pytest.mark.parametrize(
    ("values", "painted"),
    [
        ({"tilt_deg": 31}, {"live_gauge", "live_tilt"}),
        ({"acceleration_g": 1.3}, {"live_acceleration"}),
        ({"cell_voltage_v": 3.91}, {"live_cell"}),
        ({"light_v": 0.5}, {"live_light"}),
    ],
)
def test_a_number_that_changes_is_painted_and_no_other(
    bench: Bench, paints: Paints, values: dict[str, float], painted: set[str]
) -> None:
    assert paints.of(bench, **values) & _NUMBERS == painted


def test_the_rate_is_painted_twice_a_second_and_its_end_at_once(bench: Bench, paints: Paints) -> None:
    painted = []
    for number in range(20):  # two seconds
        bench.stream_hz = 1440.0 + number % 2 * 3
        painted += [name for name in paints.of(bench) if name == "live_stream"]
    assert len(painted) <= 4
    paints.of(bench)
    assert "live_stream" in paints.of(bench, is_streaming=False)


@pytest.mark.promise("j")
def test_the_numbers_follow_some_batches_and_a_change_of_state_at_once(
    bench: Bench, qapp: QApplication, monkeypatch: pytest.MonkeyPatch
) -> None:
    shown: list[object] = []
    monkeypatch.setattr(bench.page.panel, "show_device", lambda device, *_, **__: shown.append(device.reported))
    bench.page._timer.stop()
    monkeypatch.setattr(bench.page._timer, "restart", int)  # only batches count here, however slow the computer is
    bench.now_s += 0.01
    for _ in range(3):  # too soon for other numbers
        bench.hand_over()
        qapp.processEvents()
    assert shown == []
    bench.hand_over(triggered=True, active=False)
    qapp.processEvents()
    bench.hand_over(triggered=True, active=True)
    qapp.processEvents()
    assert list(dict.fromkeys(shown)) == [(True, False), (True, True)]


@pytest.mark.promise("j")
def test_a_trigger_and_an_activation_are_changes_that_everybody_hears_of(bench: Bench, qapp: QApplication) -> None:
    heard: list[object] = []
    bench.connector.changed.connect(lambda: heard.append(bench.connector.current.module.view.reported))
    for state in ((False, False), (True, False), (True, False), (True, True)):
        bench.hand_over(triggered=state[0], active=state[1])
        qapp.processEvents()
    assert list(dict.fromkeys(heard)) == [(True, False), (True, True)]


def test_a_report_just_after_a_turn_without_one_is_shown_at_once(bench: Bench) -> None:
    """It waited for the next turn: as batches came a little more slowly than turns, each number was one batch late."""
    bench.now_s += 0.1
    bench.page._tick_alone()
    bench.now_s += 0.01
    bench.hand_over(tilt_deg=33)
    QApplication.processEvents()
    assert bench.page.panel.tilt.text == "33"

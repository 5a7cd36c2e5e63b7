"""What a report changes is painted and nothing else; a change of the module's state is shown at once."""

from collections.abc import Iterator
from typing import Any

import pytest
from PySide6.QtCore import QEvent, QObject
from PySide6.QtWidgets import QApplication
from pytestqt.qtbot import QtBot

from tests.support.window.live_bench import Bench, live_bench

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
def test_a_number_that_changes_is_painted_and_nothing_below_it(
    bench: Bench, paints: Paints, values: dict[str, float], painted: set[str]
) -> None:
    assert paints.of(bench, **values) & (_NUMBERS | _BELOW_THEM) == painted


def test_the_rate_is_painted_twice_a_second_and_its_end_at_once(bench: Bench, paints: Paints) -> None:
    painted = []
    for number in range(20):  # two seconds
        bench.stream_hz = 1440.0 + number % 2 * 3
        painted += [name for name in paints.of(bench) if name == "live_stream"]
    assert len(painted) <= 4
    paints.of(bench)
    assert "live_stream" in paints.of(bench, is_streaming=False)


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
    assert shown == [(True, False), (True, True)]


def test_a_trigger_and_an_activation_are_changes_that_everybody_hears_of(bench: Bench, qapp: QApplication) -> None:
    heard: list[object] = []
    bench.connector.changed.connect(lambda: heard.append(bench.connector.current.device.reported))
    for state in ((False, False), (True, False), (True, False), (True, True)):
        bench.hand_over(triggered=state[0], active=state[1])
        qapp.processEvents()
    assert heard == [(True, False), (True, True)]


def test_a_report_just_after_a_turn_without_one_is_shown_at_once(bench: Bench) -> None:
    """It waited for the next turn: as batches came a little more slowly than turns, each number was one batch late."""
    bench.now_s += 0.1
    bench.page._tick_alone()
    bench.now_s += 0.01
    bench.hand_over(tilt_deg=33)
    QApplication.processEvents()
    assert bench.page.panel.tilt.text == "33"

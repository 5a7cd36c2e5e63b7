"""The panel "Simulated module": every control does to the bench what it says, and follows what happens there."""

from collections.abc import Iterator

import pytest
from PySide6.QtCore import QPoint, Qt
from PySide6.QtWidgets import QAbstractSpinBox, QLineEdit, QWidget
from pytestqt.qtbot import QtBot

from app.simulator.bench import SimulatedBench
from tests.support.line.sim_line import FakeClock
from ui.simulator.panel import SimulatorPanel


@pytest.fixture
def clock() -> FakeClock:
    return FakeClock()


@pytest.fixture
def bench(clock: FakeClock) -> SimulatedBench:
    return SimulatedBench(clock=clock)


@pytest.fixture
def panel(qtbot: QtBot, bench: SimulatedBench) -> Iterator[SimulatorPanel]:
    # Inside a window, as in its dock: offscreen, Qt warns of windows that have a smallest size of their own.
    window = QWidget()
    qtbot.addWidget(window)
    panel = SimulatorPanel()
    panel.setParent(window)
    panel.use_bench(bench)
    window.resize(320, 520)
    panel.resize(320, 520)
    window.show()
    window.activateWindow()
    qtbot.waitUntil(window.isActiveWindow)
    yield panel
    window.close()


def click(qtbot: QtBot, button: QWidget) -> None:
    """With the mouse, at the left, where the box of a check box is."""
    qtbot.mouseClick(button, Qt.MouseButton.LeftButton, pos=QPoint(10, button.height() // 2))


def type_into(qtbot: QtBot, box: QAbstractSpinBox | QLineEdit, text: str) -> None:
    box.setFocus()
    box.selectAll()
    qtbot.keyClicks(box, text)
    qtbot.keyClick(box, Qt.Key.Key_Return)


def test_every_control_does_what_it_says(qtbot: QtBot, panel: SimulatorPanel, bench: SimulatedBench) -> None:
    panel.tilt.slider.setFocus()
    qtbot.keyClick(panel.tilt.slider, Qt.Key.Key_Right)
    assert bench.world.tilt_deg == 1
    type_into(qtbot, panel.tilt.box, "70")
    assert (bench.world.tilt_deg, panel.tilt.slider.value()) == (70, 70)
    type_into(qtbot, panel.cell.box, "3.60")
    assert bench.world.cell_v == pytest.approx(3.6)
    for box in (panel.bay, panel.charger, panel.lifelike):
        click(qtbot, box)
    assert (bench.world.bay_is_open, bench.world.has_external_power, bench.world.is_lifelike) == (True, True, True)
    click(qtbot, panel.restart)
    assert bench.module.memory.boot_count == 38
    click(qtbot, panel.unplugged)
    assert not bench.is_plugged_in
    click(qtbot, panel.unplugged)
    assert bench.is_plugged_in
    assert not panel.press.isEnabled()
    bench.power_off()
    panel.refresh()
    click(qtbot, panel.press)
    assert bench.module.is_on


def test_drop(qtbot: QtBot, panel: SimulatorPanel, bench: SimulatedBench, clock: FakeClock) -> None:
    type_into(qtbot, panel.fall_height, "30")
    click(qtbot, panel.drop)
    assert bench.world.is_falling(bench.clock())
    assert not panel.drop.isEnabled()
    clock.now_s += 10
    panel.refresh()
    assert panel.drop.isEnabled()


def test_faults_of_the_line(qtbot: QtBot, panel: SimulatorPanel, bench: SimulatedBench) -> None:
    for name, box in panel.faults.items():
        for is_on in (True, False):
            click(qtbot, box)
            assert bool(getattr(bench.module.setup, name)) is is_on


def test_the_pwm_input_fires_an_active_module(qtbot: QtBot, panel: SimulatorPanel, bench: SimulatedBench) -> None:
    for is_active in (False, True):
        bench.module.activate(is_active=is_active)
        click(qtbot, panel.trigger)
        assert bench.module.is_triggered is is_active


def test_it_follows_what_happens_but_not_under_the_fingers(
    qtbot: QtBot, panel: SimulatorPanel, bench: SimulatedBench
) -> None:
    panel.cell.box.setFocus()
    before = panel.cell.value
    bench.set_world(tilt_deg=33, bay_is_open=True, cell_v=3.2)
    bench.change(mute=True)
    qtbot.waitUntil(lambda: panel.tilt.value == 33 and panel.bay.isChecked())
    assert (panel.faults["mute"].isChecked(), panel.cell.value, bench.world.tilt_deg) == (True, before, 33)
    panel.drop.setFocus()
    panel.refresh()
    assert panel.cell.value == pytest.approx(3.2)


def test_without_a_module_it_says_so_and_is_off(qtbot: QtBot) -> None:
    panel = SimulatorPanel()
    qtbot.addWidget(panel)
    assert (panel.tilt.isEnabled(), panel.summary.text()) == (False, "No simulated module")

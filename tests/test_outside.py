"""What is outside its limit is marked wherever it is shown, with its limit: one judgement for all places."""

from collections import Counter
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest
from PySide6.QtWidgets import QApplication
from pytestqt.qtbot import QtBot

from app.device import DeviceView, How, Known
from app.outside import Fault, LimitsInUse, Outside, bay_outside, cell_outside, line_outside, value_outside
from app.preflight.expectations import Limits
from app.profiles import Profile
from tests.fakes_ui import WAIT_MS, simulated, wait_online, window
from tests.live_bench import Bench, live_bench
from ui.connector import Target
from ui.painted import Freshness
from ui.readout import Readout
from ui.theme import Meaning

NOW = 100.0
OURS = Limits()


@pytest.mark.parametrize(
    ("volts", "is_charging", "fault"),
    [
        (3.80, False, None),
        (3.79, False, Fault.CELL_LOW),
        (3.50, True, Fault.CELL_LOW),
        (3.50, None, Fault.CELL_LOW),
        (4.25, False, None),
        (4.30, False, Fault.CELL_HIGH),
        (4.70, True, None),  # the charger's
        (4.70, None, None),
    ],
)
def test_cell(volts: float, is_charging: bool | None, fault: Fault | None) -> None:
    found = cell_outside(volts, OURS, is_charging=is_charging)
    assert (None if found is None else found.fault) is fault


def test_bay() -> None:
    assert bay_outside(1.7, 1.8) is None
    assert bay_outside(1.8, 1.8) == Outside(Fault.BAY_OPEN, "1.8 V")
    assert bay_outside(1.7, 1.8, is_inverted=True) == Outside(Fault.BAY_OPEN, "1.8 V")
    assert bay_outside(1.9, 1.8, is_inverted=True) is None


def test_line() -> None:
    fine: dict[str, Any] = {"lag_s": 0.1, "round_trip_s": 0.02, "has_damaged": False, "in_use": LimitsInUse()}
    unknown: dict[str, Any] = {"lag_s": None, "round_trip_s": None}
    assert line_outside(**fine) is None
    assert line_outside(**(fine | unknown)) is None
    assert line_outside(**(fine | {"lag_s": 1.1})) == Outside(Fault.LATE, "1 s")
    assert line_outside(**(fine | {"round_trip_s": 0.101})) == Outside(Fault.SLOW, "100 ms")
    found = line_outside(**(fine | {"has_damaged": True}))
    assert found is not None
    assert found.fault is Fault.DAMAGED


def test_the_limit_of_the_chosen_profile_counts() -> None:
    in_use = LimitsInUse()
    device = DeviceView({"cell_voltage_v": Known(3.9, How.READ, NOW), "charging": Known(False, How.READ, NOW)})
    assert value_outside("cell_voltage_v", device, NOW, in_use) is None
    in_use.use(Profile(name="cold", limits={"cell_voltage_min_v": 4.0}))
    assert value_outside("cell_voltage_v", device, NOW, in_use) == Outside(Fault.CELL_LOW, "4.00 V")
    in_use.use(None)
    assert value_outside("cell_voltage_v", device, NOW, in_use) is None


def test_a_threshold_that_is_not_known_judges_nothing() -> None:
    device = DeviceView({"light_v": Known(3.0, How.READ, NOW)})
    assert value_outside("light_v", device, NOW, LimitsInUse()) is None
    assert value_outside("cell_voltage_v", device, NOW, LimitsInUse()) is None


@pytest.fixture
def live(qtbot: QtBot, qapp: QApplication) -> Iterator[Bench]:
    with live_bench(qtbot, qapp) as bench:
        yield bench


def test_live_marks_cell_and_bay(live: Bench) -> None:
    live.say()
    cell, light = live.find(Readout, "live_cell"), live.find(Readout, "live_light")
    assert (cell.accessibleName(), light.accessibleName()) == ("Cell voltage: 3.94 V", "Light: 0.3 V, limit 1.8 V")
    live.say(cell_voltage_v=3.52, light_v=2.1)
    assert cell.accessibleName() == "Cell voltage: 3.52 V, limit 3.80 V, low"
    assert light.accessibleName() == "Light: 2.1 V, limit 1.8 V, bay open"
    assert cell.meaning is Meaning.ATTENTION
    assert light.meaning is Meaning.ATTENTION
    live.pass_time(30.0)
    assert cell.freshness is Freshness.STALE


def test_the_top_bar_and_the_status_line_mark(qtbot: QtBot, qapp: QApplication, tmp_path: Path) -> None:
    with simulated("weak") as bench, window(qapp, tmp_path) as assembly:
        top, line, connector = assembly.window.top_bar, assembly.window.status_line, assembly.connector
        connector.connect_to(Target("sim://weak", 115200))
        wait_online(qtbot, assembly)
        qtbot.waitUntil(lambda: top.cell.word.endswith(" V"), timeout=WAIT_MS)
        assert top.cell.meaning is None
        bench.set_cell(3.5)
        qtbot.waitUntil(lambda: top.cell.word == "3.50 V, low", timeout=WAIT_MS)
        assert top.cell.meaning is Meaning.ATTENTION
        assert "limit 3.80 V" in top.cell.accessibleName()
        last = connector.last
        assert last is not None
        assert last.link is not None
        line._damaged_at = None
        line.take(replace(last, link=replace(last.link, lag_s=0.1, round_trip_median_s=0.02)))
        counters = replace(last.link.counters, rejected_bytes=last.link.counters.rejected_bytes + Counter({"x": 7}))
        line.take(replace(last, at=connector.clock(), link=replace(last.link, counters=counters)))
        line._write()
        assert not line.fault.isHidden()
        assert line.fault.text() == "damaged bytes"
        assert not line.sign.pixmap().isNull()
        line._damaged_at = connector.clock() - 11
        line._write()
        assert line.fault.isHidden()

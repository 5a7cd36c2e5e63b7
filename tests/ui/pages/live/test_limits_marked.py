"""What is outside its limit is marked in the window, with its limit."""

from collections.abc import Iterator
from pathlib import Path

import pytest
from PySide6.QtWidgets import QApplication
from pytestqt.qtbot import QtBot

from app.engine.procedure import LinkView
from app.engine.worker import Batch
from app.text.i18n import CHINESE, ENGLISH
from protocol.events import Counters
from tests.support.records.recordings_desk import made, record
from tests.support.window.fakes_ui import connect, simulated, window
from tests.support.window.live_bench import Bench, live_bench
from tests.support.window.steps import given
from ui.style.painted_widget import Freshness
from ui.style.theme import Meaning
from ui.widgets.readout import Readout


@pytest.mark.parametrize("spoken", [ENGLISH, CHINESE], indirect=True)
@pytest.mark.promise("g")
def test_a_recording_marks_them_under_the_cursor(spoken: str, qtbot: QtBot, qapp: QApplication, tmp_path: Path) -> None:
    made_of = record(tmp_path / "template", seconds=10, cell_voltage_v=3.52)
    with made(qtbot, qapp, tmp_path, made_of) as desk:
        desk.page.open_row(desk.page.work.rows()[0])
        desk.until(lambda: desk.page.view.plot is not None)
        plot = given(desk.page.view.plot)
        plot.time_range.show_instant(1005.0)
        expected = "（!）电压低，限值 3.80" if spoken == CHINESE else " (!) low, limit 3.80"
        assert expected in plot.reading


@pytest.fixture
def live(qtbot: QtBot, qapp: QApplication) -> Iterator[Bench]:
    with live_bench(qtbot, qapp) as bench:
        yield bench


@pytest.mark.promise("g")
def test_live_marks_cell_and_bay(live: Bench) -> None:
    live.say()
    cell, light = live.find(Readout, "live_cell"), live.find(Readout, "live_light")
    assert (cell.accessibleName(), light.accessibleName()) == (
        "Cell voltage: 3.94 V, not charging",
        "Light: 0.3 V, limit 1.8 V, bay closed (assumed)",
    )
    live.say(cell_voltage_v=3.52, light_v=2.1)
    assert cell.accessibleName() == "Cell voltage: 3.52 V, limit 3.80 V, low"
    assert light.accessibleName() == "Light: 2.1 V, limit 1.8 V, bay open (assumed)"
    assert cell.meaning is Meaning.ATTENTION
    assert light.meaning is Meaning.ATTENTION
    live.pass_time(30.0)
    assert cell.freshness is Freshness.STALE


@pytest.mark.promise("g")
def test_the_top_bar_and_the_status_line_mark(qtbot: QtBot, qapp: QApplication, tmp_path: Path) -> None:
    with simulated("weak") as bench, window(qapp, tmp_path) as assembly:
        top, line, connector = assembly.window.top_bar, assembly.window.status_bar, assembly.ports
        connect(qtbot, assembly, "sim://weak")
        qtbot.waitUntil(lambda: top.cell.word.endswith(" V"))
        assert top.cell.meaning is None
        bench.set_world(cell_v=3.5)
        qtbot.waitUntil(lambda: top.cell.word == "3.50 V, low")
        assert top.cell.meaning is Meaning.ATTENTION
        assert "limit 3.80 V" in top.cell.accessibleName()
        port, now = connector.current, connector.clock()
        link = LinkView(Counters(), 0.02, 0.02)
        sound = Batch(now, port.connection, port.module.view, link)
        statistics = port.module.statistics
        statistics.last_invalid_at = None
        line.on_batch(sound)
        assert line.fault.isHidden()
        statistics.last_invalid_at = now
        line.on_batch(sound)
        assert not line.fault.isHidden()
        assert line.fault.text() == "invalid bytes"
        assert not line.sign.pixmap().isNull()
        line.on_batch(sound._replace(at=now + 11))
        assert line.fault.isHidden()

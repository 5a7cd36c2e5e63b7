"""A link with a long delay is reported, and not shown as connected."""

from pathlib import Path

from PySide6.QtWidgets import QApplication
from pytestqt.qtbot import QtBot

from app.diagnosis.link_state import Phase
from tests.support.window.fakes_ui import WAIT_MS, connect, simulated, window


def test_beyond_a_second_of_lag_nothing_is_shown_as_current(qtbot: QtBot, qapp: QApplication, tmp_path: Path) -> None:
    with simulated("bridge") as bench, window(qapp, tmp_path) as assembly:
        connector, main = assembly.connector, assembly.window
        connect(qtbot, assembly, "sim://bridge")
        qtbot.waitUntil(lambda: connector.current.state.phase is Phase.ONLINE, timeout=WAIT_MS)
        qtbot.waitUntil(lambda: "ago" in main.status_bar.age.text(), timeout=WAIT_MS)
        bench.change(stream_at_boot=True, lag_ms=1600.0)
        bench.module.start_stream(bench.clock())
        qtbot.waitUntil(lambda: connector.current.state.phase is Phase.LATE, timeout=WAIT_MS)
        qtbot.waitUntil(lambda: "late" in main.status_bar.age.text(), timeout=WAIT_MS)
        qtbot.waitUntil(lambda: "late" in main.top_bar.port.word, timeout=WAIT_MS)
        assert connector.current.device.fresh("active", connector.clock()) is None
        bench.change(lag_ms=0.0)
        qtbot.waitUntil(lambda: connector.current.state.phase is Phase.ONLINE, timeout=WAIT_MS)

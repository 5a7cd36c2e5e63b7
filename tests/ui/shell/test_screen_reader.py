"""Ticking values send no accessibility events, but screen readers can query them."""

from functools import partial
from pathlib import Path
from types import MappingProxyType
from unittest.mock import patch

from PySide6.QtCore import QTimer
from PySide6.QtWidgets import QApplication
from pytestqt.qtbot import QtBot

from app.engine.device import DeviceView, How, Known, StatusSample
from app.engine.target import Target
from app.engine.worker import Batch, Connection, PortState
from protocol.link_states import Presence
from tests.support.line.sim_line import FakeClock
from tests.support.window.fake_ports import VALUES
from tests.support.window.fakes_ui import window
from tests.support.window.screen_reader import NameChanges, name_of
from ui.main import PAGES, Assembly
from ui.services.port import Ports

USB = "/dev/ttyUSB0"
EACH_PAGE_S = 4
LONGEST_TICK_MS = 2000
MAX_CHANGES = 3
"""A state or two may change in so long a time."""


class Session:
    """A module that answers ten times a second, each time a little different, on a clock that the test moves."""

    def __init__(self, assembly: Assembly, clock: FakeClock) -> None:
        self._clock = clock
        self._connector = assembly.connector
        self._connection = assembly.connector.current
        self._connection._worker.open = lambda *_: 1  # type: ignore[method-assign]
        self._connection._bridge.batch.disconnect()  # what the worker says would come by the computer's clock
        self._connector.connect_to(Target(USB, 115200))

    def hear(self) -> None:
        self._clock.now_s += 0.1
        now_s = self._clock.now_s
        noise = round(now_s * 10) % 7
        values = VALUES | {"tilt_deg": noise, "acceleration_g": 1 + noise / 10, "light_v": noise / 10}
        values["cell_voltage_v"] = 4 + noise / 100
        known = {key: Known(value, How.READ, now_s) for key, value in values.items()}
        known["attitude_threshold_deg"] = Known(60, How.READ, 1000.0)  # its age grows
        view = DeviceView(MappingProxyType(known), Presence.ONLINE, 1000.0, True, 10.0)
        sample = StatusSample(now_s, noise, 1 + noise / 10, False, False)
        opened = Connection(PortState.OPEN, USB, 115200, opening=1)
        self._connection._on_batch(Batch(now_s, opened, view, None, (sample,)))


def test_nothing_that_ticks_is_told(qtbot: QtBot, qapp: QApplication, tmp_path: Path) -> None:
    clock = FakeClock()
    with patch("ui.main.Ports", partial(Ports, clock=clock)), window(qapp, tmp_path, entries=PAGES) as assembly:
        main = assembly.window
        qtbot.waitUntil(lambda: main.stack.count() == len(PAGES))
        session, changes = Session(assembly, clock), NameChanges(main)
        for entry in PAGES:
            main.go_to(entry.key)
            for tick in range(EACH_PAGE_S * 10):
                session.hear()
                if tick % 5 == 0:
                    for timer in main.findChildren(QTimer):  # as each would in that time
                        if timer.isActive() and not timer.isSingleShot() and timer.interval() <= LONGEST_TICK_MS:
                            timer.timeout.emit()
                    QApplication.processEvents()
                    changes.look(counts=tick > 10)  # what a page shows at first is no change
        assert len(changes.found) <= MAX_CHANGES, "\n".join(changes.found)
        assert "4.0" in name_of(main.top_bar.cell)  # who asks is told

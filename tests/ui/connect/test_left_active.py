"""A module that was left ACTIVE is said at the next start, until that module reports LOCKED or a person says so."""

from collections.abc import Iterator
from pathlib import Path

import pytest
from PySide6.QtCore import QObject
from PySide6.QtWidgets import QApplication
from pytestqt.qtbot import QtBot

from app.safety.acts import REQUESTS, Act
from app.safety.journal import Outcome
from app.safety.last_known import keep_away
from app.store.left_active import left_active
from app.store.store import Store, open_store
from tests.support.window.fake_ports import FakePorts
from tests.support.window.fakes_ui import WAIT_MS, window
from ui.connect.left_active import LeftActiveWatch
from ui.services.module_name import ModuleName
from ui.services.storage import Storage

USB = "/dev/ttyUSB0"


def activate(store: Store, module: str, outcome: Outcome | None = Outcome.CONFIRMED) -> None:
    """As before a `kill -9` in the tilt test: activated, and never locked."""
    detail = {"module": module, "run": "before"}
    entry = store.begin(Act.ACTIVATE, REQUESTS[Act.ACTIVATE].encode(), detail, port=USB, origin="window")
    if outcome is not None:
        store.settle(entry, outcome, {})


@pytest.mark.parametrize("outcome", [Outcome.CONFIRMED, None])
def test_it_stands_first_at_the_next_start(
    qtbot: QtBot, qapp: QApplication, tmp_path: Path, outcome: Outcome | None
) -> None:
    store = open_store()
    activate(store, "M-07", outcome)
    store.close()
    with window(qapp, tmp_path, entries=()) as assembly:
        bar = assembly.window.notice_bar
        qtbot.waitUntil(
            lambda: bar.notice is not None and bar.notice.text.startswith("M-07 was left ACTIVE on "), timeout=WAIT_MS
        )
        assert bar.notice is not None
        assert keep_away() in bar.notice.text
        assert assembly.window.panel.isVisible()  # the list of ports is no reason to be silent about it
        button = bar.button("left_active_locked")
        assert button is not None
        qtbot.waitUntil(button.isEnabled, timeout=WAIT_MS)
        assembly.left_active._end(assembly.left_active._left[0])
        qtbot.waitUntil(lambda: bar.notice is None or "ACTIVE" not in bar.notice.text, timeout=WAIT_MS)
    store = open_store()
    assert left_active(store) == ()
    store.close()


class Bench:
    """Fake ports, and a store in which M-07 was left ACTIVE."""

    def __init__(self, folder: Path) -> None:
        self.ports, self.storage, self.naming = FakePorts(), Storage(folder), ModuleName()
        store = self.storage.open_store()
        assert isinstance(store, Store)
        self.store = store
        activate(store, "M-07")
        self.naming.bind(self.ports.connector, self.storage)
        self.parent = QObject()
        self.watch = LeftActiveWatch(self.ports.connector, self.storage, self.naming, self.parent)
        self.watch.load()

    def left(self) -> list[str]:
        self.store.queue.submit(lambda: None).result(5)
        self.store.queue.submit(lambda: None).result(5)
        return [one.module for one in left_active(self.store)]


@pytest.fixture
def bench(qapp: QApplication, tmp_path: Path) -> Iterator[Bench]:
    made = Bench(tmp_path)
    yield made
    made.ports.stop()
    made.storage.close()


def test_only_that_module_ends_it_by_reporting_locked(qtbot: QtBot, bench: Bench) -> None:
    _connection, module = bench.ports.plug_in(USB, active=False)
    qtbot.wait(50)
    assert bench.watch.notice() is not None, "nobody has said which module this is"
    bench.naming.choose("M-08")
    module.say(active=False)
    qtbot.wait(50)
    assert bench.watch.notice() is not None
    assert bench.left() == ["M-07"]
    bench.naming.choose("M-07")
    module.say(active=True)
    qtbot.waitUntil(lambda: bench.watch.notice() is None, timeout=WAIT_MS)  # the top bar says it
    module.unplug()
    qtbot.waitUntil(lambda: bench.watch.notice() is not None, timeout=WAIT_MS)
    module.say(active=False)
    qtbot.waitUntil(lambda: bench.left() == [], timeout=WAIT_MS)
    assert bench.watch.notice() is None


def test_what_was_activated_by_its_switch_is_logged_too(qtbot: QtBot, bench: Bench) -> None:
    _connection, module = bench.ports.plug_in(USB, active=False)
    bench.naming.choose("M-09")
    module.say(active=True)
    qtbot.waitUntil(lambda: "M-09" in bench.left(), timeout=WAIT_MS)
    module.say(active=False)
    qtbot.waitUntil(lambda: bench.left() == ["M-07"], timeout=WAIT_MS)

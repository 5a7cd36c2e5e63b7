"""LOCK from the window: one gesture, as often as it is pressed, and never called done before the module says so."""

from collections.abc import Callable
from pathlib import Path

import pytest
from PySide6.QtCore import Qt
from PySide6.QtWidgets import QApplication, QWidget
from pytestqt.qtbot import QtBot

from app.procedures.lock import Locked
from protocol.catalogue import ACTIVATION
from tests.fakes_ui import WAIT_MS, simulated, wait_online, window
from tests.steps import settle
from ui.connector import Target
from ui.theme import Meaning


def click(qtbot: QtBot, widget: QWidget) -> None:
    settle(widget)
    qtbot.mouseClick(widget, Qt.MouseButton.LeftButton)


@pytest.mark.parametrize("way", ["click", "key"])
def test_lock_is_one_gesture(qtbot: QtBot, qapp: QApplication, tmp_path: Path, way: str) -> None:
    with simulated("lock") as bench, window(qapp, tmp_path) as assembly:
        bench.module.activate(is_active=True)
        assembly.connector.connect_to(Target("sim://lock", 115200))
        wait_online(qtbot, assembly)
        qtbot.waitUntil(assembly.window.top_bar.lock.isEnabled, timeout=WAIT_MS)
        if way == "click":
            click(qtbot, assembly.window.top_bar.lock)
        else:
            qtbot.keyClick(assembly.window, Qt.Key.Key_L, Qt.KeyboardModifier.ControlModifier)
        qtbot.waitUntil(lambda: not bench.state().is_active, timeout=WAIT_MS)
        qtbot.waitUntil(lambda: assembly.window.top_bar.activation.word == "LOCKED", timeout=WAIT_MS)
        qtbot.waitUntil(lambda: "LOCKED" in assembly.window.status_line.passing.text(), timeout=WAIT_MS)


def test_lock_pressed_again_goes_out_again(qtbot: QtBot, qapp: QApplication, tmp_path: Path) -> None:
    with simulated("twice") as bench, window(qapp, tmp_path) as assembly:
        bench.module.activate(is_active=True)
        assembly.connector.connect_to(Target("sim://twice", 115200))
        wait_online(qtbot, assembly)
        write, locks = bench.wire.write, 0

        def lose_the_first(data: bytes, now_s: float) -> None:
            nonlocal locks
            locks += data[2] == ACTIVATION.code
            if data[2] != ACTIVATION.code or locks > 1:
                write(data, now_s)

        bench.wire.write = lose_the_first  # type: ignore[method-assign]
        lock = assembly.window.top_bar.lock
        qtbot.waitUntil(lock.isEnabled, timeout=WAIT_MS)
        click(qtbot, lock)
        click(qtbot, lock)
        qtbot.waitUntil(lambda: "LOCKED" in assembly.window.status_line.passing.text(), timeout=WAIT_MS)
        assert not bench.state().is_active
        assert locks == 2


def test_a_lock_without_answer_is_not_called_locked(qtbot: QtBot, qapp: QApplication, tmp_path: Path) -> None:
    with simulated("deaf") as bench, window(qapp, tmp_path) as assembly:
        bench.module.activate(is_active=True)
        assembly.connector.connect_to(Target("sim://deaf", 115200))
        wait_online(qtbot, assembly)
        bench.change(mute=True)
        click(qtbot, assembly.window.top_bar.lock)
        qtbot.waitUntil(lambda: assembly.window.notice_bar.button("lock_again") is not None, timeout=WAIT_MS)
        notice = assembly.window.notice_bar.notice
        assert notice is not None
        assert notice.meaning is Meaning.DANGER
        assert "ACTIVE" in notice.text


def test_a_lock_that_fails_is_said_though_an_older_one_is_still_under_way(
    qtbot: QtBot, qapp: QApplication, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    with simulated("thrice") as bench, window(qapp, tmp_path) as assembly:
        bench.module.activate(is_active=True)
        assembly.connector.connect_to(Target("sim://thrice", 115200))
        wait_online(qtbot, assembly)
        ends: list[Callable[[Locked | None], None]] = []
        monkeypatch.setattr(assembly.connector, "lock", ends.append)
        attention = assembly.window.attention
        attention.lock()
        attention.lock()
        ends[0](Locked(is_acknowledged=True, is_locked=True))
        attention.lock()
        ends[2](None)
        notice = assembly.window.notice_bar.notice
        assert notice is not None
        assert notice.meaning is Meaning.DANGER
        ends[1](None)

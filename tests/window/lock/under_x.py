"""Run by itself on an X server: opens what may be open above the window, and locks by keys and clicks of the server.

Prints one line for each: its name, and "locked" twice. `xdotool` sends what a keyboard and a mouse would.
"""

import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import Any, cast

from PySide6.QtCore import QPoint
from PySide6.QtWidgets import QApplication, QDialog, QWidget

from tests.support.window.fakes_ui import connect, page_entries, simulated, window
from tests.window.lock.test_lock_everywhere import DIALOGS, Bench
from ui.main import WindowOptions

HELD_S = 1.5


class Waiter:
    """What of pytest-qt's bot is needed here."""

    def waitUntil(self, condition: Callable[[], bool], timeout: int = 0) -> None:
        ends_at = time.monotonic() + max(30.0, timeout / 1000)
        while not condition():
            if time.monotonic() > ends_at:
                raise TimeoutError
            QApplication.processEvents()
            time.sleep(0.005)


def _is_active(widget: QWidget) -> bool:
    return QApplication.activeWindow() is widget


def _send(*words: object) -> None:
    subprocess.run(["xdotool", *map(str, words)], check=True)


def _click(widget: QWidget) -> None:
    place = widget.mapToGlobal(widget.rect().center())
    _send("mousemove", place.x(), place.y(), "click", 1)


def _hold(keys: str) -> None:
    """Long enough for the server to repeat it."""
    _send("keydown", keys)
    ends_at = time.monotonic() + HELD_S
    while time.monotonic() < ends_at:
        QApplication.processEvents()
        time.sleep(0.005)
    _send("keyup", keys)
    QApplication.processEvents()


def _lock_twice(bench: Bench, name: str, keys: str, button: QWidget) -> None:
    done = []
    for act in (lambda: _send("key", keys), lambda: _click(button)):
        bench.activate()
        act()
        bench.await_locked()
        done.append("locked")
    print(name, *done, flush=True)


def main() -> int:
    app = QApplication.instance() or QApplication(sys.argv[:1])
    waiter = cast("Any", Waiter())
    with (
        tempfile.TemporaryDirectory(ignore_cleanup_errors=True) as folder,
        simulated("under_x") as module,
        window(
            cast("QApplication", app),
            Path(folder),
            entries=page_entries("settings", "commands"),
            options=WindowOptions(language="en"),
        ) as made,
    ):
        bench, main = Bench(waiter, made, module), made.window
        waiter.waitUntil(lambda: main.has_pages)
        connect(waiter, made, "sim://under_x")
        for number, (name, show) in enumerate(DIALOGS.items()):
            dialog = show(bench)
            waiter.waitUntil(dialog.isVisible)
            dialog.activateWindow()  # as a window manager would do
            waiter.waitUntil(partial(_is_active, dialog))
            _lock_twice(bench, name, ("ctrl+l", "F12")[number % 2], main.top_bar.lock)
            for widget in main.findChildren(QDialog):
                widget.close()
            main.activateWindow()
            waiter.waitUntil(partial(_is_active, main))
        bench.activate()
        for keys in ("ctrl+l", ""):
            main.main_menu.popup(main.mapToGlobal(QPoint(200, 200)))
            waiter.waitUntil(main.main_menu.isVisible)
            bench.activate()
            if keys:
                _send("key", keys)
            else:
                _click(main.top_bar.lock)
            bench.await_locked()
            main.main_menu.close()
            print("menu", keys or "click", "locked", flush=True)
        bench.activate()
        _hold("ctrl+q")
        print("ctrl+q held", "open" if main.isVisible() else "closed", flush=True)
    return 0


if __name__ == "__main__":
    sys.exit(main())

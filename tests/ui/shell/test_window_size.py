"""The window is never larger than the free part of its screen, at any scale."""

import json
import os
import subprocess
import sys
from pathlib import Path

import pytest
from PySide6.QtCore import QRect

from ui.shell.page_area import fitting

FREE = QRect(0, 24, 960, 490)


@pytest.mark.parametrize(
    ("wanted", "placed"),
    [
        pytest.param(QRect(100, 50, 800, 400), QRect(100, 50, 800, 400), id="fits"),
        pytest.param(QRect(0, 0, 1180, 720), QRect(0, 24, 960, 490), id="too large"),
        pytest.param(QRect(1900, 900, 800, 400), QRect(160, 114, 800, 400), id="on a screen that is gone"),
        pytest.param(QRect(-500, -500, 800, 400), QRect(0, 24, 800, 400), id="beyond the corner"),
    ],
)
def test_a_window_is_moved_onto_the_screen(wanted: QRect, placed: QRect) -> None:
    assert fitting(wanted, FREE) == placed


SHOWN = """
import sys
from pathlib import Path
from PySide6.QtCore import QPoint, QRect, QSize
from PySide6.QtWidgets import QApplication
from ui.core.preferences import Preferences
from ui.main import WindowOptions, assemble
from ui.services.storage import Storage
from ui.style.theme import Choice
app = QApplication([])
folder = Path(sys.argv[1])
screen = app.primaryScreen()
for theme in ("light", "sunlight"):
    for kind in ("larger", "remembered", "first"):
        preferences = Preferences(folder / f"{kind}.ini")
        preferences.theme = theme
        assembly = assemble(app, WindowOptions(language="en"), preferences=preferences, storage=Storage(folder))
        window = assembly.window
        if kind == "larger":
            window.setMinimumSize(0, 0)
            window.setGeometry(0, 0, 3000, 2000)  # as on the large screen of the day before
            preferences = Preferences(folder / "remembered.ini")
            preferences.geometry = window.saveGeometry()
            preferences.save()
            continue
        window.show()
        app.processEvents()
        lock = window.top_bar.lock
        place = QRect(lock.mapToGlobal(QPoint()), lock.size())
        free = screen.availableGeometry()
        assert free.contains(window.geometry()) and free.contains(place), (theme, kind, window.geometry())
        assert window.top_bar.rect().contains(lock.geometry())
        window.hide()
import os
os._exit(0)
"""


def offscreen(folder: Path, width: int, height: int) -> str:
    """What `QT_QPA_PLATFORM` has to be for one screen of so many pixels; written into `folder`."""
    path = folder / f"screen-{width}x{height}.json"
    screen = {"name": "test", "x": 0, "y": 0, "width": width, "height": height,
              "logicalDpi": 96, "logicalBaseDpi": 96, "dpr": 1}  # fmt: skip
    path.write_text(json.dumps({"screens": [screen]}), encoding="utf-8")
    return f"offscreen:configfile={path}"


@pytest.mark.parametrize(("width", "height", "scale"), [(1024, 600, 1.0), (1920, 1080, 2.0)])
def test_lock_is_on_the_screen_at_every_scale(width: int, height: int, scale: float, tmp_path: Path) -> None:
    """At the first start, and where the window was larger when it was last closed."""
    environment = {**os.environ, "QT_QPA_PLATFORM": offscreen(tmp_path, width, height), "QT_SCALE_FACTOR": f"{scale}"}
    command = [sys.executable, "-c", SHOWN, str(tmp_path)]
    ended = subprocess.run(command, env=environment, timeout=120, check=False, capture_output=True, text=True)
    assert ended.returncode == 0, ended.stdout + ended.stderr

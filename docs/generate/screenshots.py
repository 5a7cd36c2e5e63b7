"""Pictures of the real program on the simulated module:  .venv/bin/python docs/generate/screenshots.py

Without arguments it takes those of the user guide (ui/help/guide/images) and of the README (docs/images), in two
minutes; see docs/generate/picture_scenes.py. With `--all FOLDER` it takes one of each page in each theme, language and
scale, for review, at 1024x600, the smallest supported screen.
"""

import argparse
import os
import subprocess
import sys
import tempfile
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
IMAGES = ROOT / "docs" / "images"
GUIDE_IMAGES = ROOT / "ui" / "help" / "guide" / "images"
THEMES = ("light", "dark", "sunlight")
LANGUAGES = ("en", "zh_CN")
SECONDS = 14
WIDTH, HEIGHT = 1024, 600
PRESSED = {"triggers": "triggers_read", "preflight": "preflight_enable"}
"""The button that fills a page with data, by page."""


@dataclass(frozen=True, slots=True)
class Shot:
    """One picture. `page` is the key of a page in the navigation."""

    path: Path
    page: str = "live"
    theme: str = "light"
    language: str = "en"
    scale: float = 1


def all_shots(folder: Path, pages: tuple[str, ...]) -> Iterator[Shot]:
    for page in pages:
        for theme in THEMES:
            for language in LANGUAGES:
                for scale in (1, 2):
                    name = f"{page}-{theme}-{language}-{scale}x.png"
                    yield Shot(folder / name, page, theme, language, scale)


def take(shot: Shot) -> None:
    """Run the window for one picture."""
    shot.path.parent.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory() as home:
        _run_again("--one", str(shot.path), shot.page, shot.theme, shot.language, home, scale=shot.scale)
    print(shot.path)


def take_scenes(language: str) -> None:
    """All pictures of the guide and of the README in one language, in one window."""
    with tempfile.TemporaryDirectory() as home:
        _run_again("--scenes", language, home)


def _run_again(*words: str, scale: float = 1) -> None:
    """Runs this file in another process, because Qt reads the scale only at start."""
    environment = {**os.environ, "QT_QPA_PLATFORM": "offscreen", "QT_SCALE_FACTOR": str(scale)}
    subprocess.run([sys.executable, __file__, *words], cwd=ROOT, env=environment, check=True)


def run_scenes(language: str, home: Path) -> int:
    """See `take_scenes`."""
    sys.path.insert(0, str(ROOT))
    from picture_scenes import run_all

    run_all(language, home, guide=GUIDE_IMAGES, readme=IMAGES)
    return 0


def run_window(path: Path, page: str, theme: str, language: str, home: Path) -> int:
    """The window of one picture, with a module that was tilted and is level again."""
    sys.path.insert(0, str(ROOT))
    from PySide6.QtCore import QTimer
    from PySide6.QtWidgets import QApplication, QPushButton

    from app.simulator import bench
    from ui.core.preferences import Preferences
    from ui.main import WindowOptions, assemble, start
    from ui.services.storage import Storage

    app = QApplication(sys.argv[:1])
    bench.module("demo", {"history": 4, "cell": 4.0})
    preferences = Preferences(home / "window.ini")
    preferences.theme = theme
    options = WindowOptions(demo=True, language=language)
    assembly = assemble(app, options, preferences=preferences, storage=Storage(home))
    window = assembly.window
    window.resize(WIDTH, HEIGHT)
    start(assembly, options)
    window.pages_made.connect(lambda: window.go_to(page))

    def press() -> None:
        button = window.findChild(QPushButton, PRESSED.get(page, "none"))
        if button is not None:
            button.click()

    QTimer.singleShot(3000, window, press)
    # A check needs a still module.
    for second, tilt_deg in ((4, 28), (5, 47), (6.5, 33), (8, 12), (9, 4)) if page != "preflight" else ():
        QTimer.singleShot(round(second * 1000), window, lambda tilt=tilt_deg: bench.module("demo").set_tilt(tilt))
    if page != "preflight":
        QTimer.singleShot(7000, window, lambda: bench.module("demo").drop(3))

    def shoot() -> None:
        window.grab().save(str(path))
        window.close_now()

    QTimer.singleShot(SECONDS * 1000, window, shoot)
    app.exec()
    return 0 if path.exists() else 1


def main(arguments: list[str]) -> int:
    if arguments[:1] == ["--one"]:
        path, page, theme, language, home = arguments[1:]
        return run_window(Path(path), page, theme, language, Path(home))
    if arguments[:1] == ["--scenes"]:
        language, home = arguments[1:]
        return run_scenes(language, Path(home))
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--all", type=Path, metavar="FOLDER", help="every page, theme, language and scale")
    parser.add_argument("--page", action="append", metavar="KEY", help="with --all: only this page (repeatable)")
    parser.add_argument("--language", choices=LANGUAGES, help="without --all: only this language")
    chosen = parser.parse_args(arguments)
    if chosen.all is None:
        for language in (chosen.language,) if chosen.language else LANGUAGES:
            take_scenes(language)
    else:
        for shot in all_shots(chosen.all, tuple(chosen.page or ("live", "diagnosis"))):
            take(shot)
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))

"""Pictures of the real program on the simulated module:  .venv/bin/python packaging/screenshots.py [--all FOLDER]

Without arguments it makes the pictures of the README in docs/images. With `--all` it makes one of each page in each
theme, language and scale, to be looked at: 1024x600 is the smallest screen that the window is made for.
"""

import argparse
import os
import subprocess
import sys
import tempfile
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
IMAGES = ROOT / "docs" / "images"
THEMES = ("light", "dark", "sunlight")
LANGUAGES = ("en", "zh_CN")
SECONDS = 14
WIDTH, HEIGHT = 1024, 600
PRESSED = {"triggers": "triggers_read", "preflight": "preflight_enable"}
"""The button that fills a page, by its key."""


@dataclass(frozen=True, slots=True)
class Shot:
    """One picture. `page` is the key of a page in the navigation."""

    path: Path
    page: str = "live"
    theme: str = "light"
    language: str = "en"
    scale: float = 1


def readme_shots() -> Iterator[Shot]:
    yield Shot(IMAGES / "live.png")
    yield Shot(IMAGES / "live-dark-zh.png", theme="dark", language="zh_CN")


def all_shots(folder: Path, pages: tuple[str, ...]) -> Iterator[Shot]:
    for page in pages:
        for theme in THEMES:
            for language in LANGUAGES:
                for scale in (1, 2):
                    name = f"{page}-{theme}-{language}-{scale}x.png"
                    yield Shot(folder / name, page, theme, language, scale)


def take(shot: Shot) -> None:
    """Run the window once for this picture; a process of its own, because Qt takes the scale only at its start."""
    shot.path.parent.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory() as home:
        words = ["--one", str(shot.path), shot.page, shot.theme, shot.language, home]
        environment = {**os.environ, "QT_QPA_PLATFORM": "offscreen", "QT_SCALE_FACTOR": str(shot.scale)}
        subprocess.run([sys.executable, __file__, *words], cwd=ROOT, env=environment, check=True)
    print(shot.path)


def run_window(path: Path, page: str, theme: str, language: str, home: Path) -> int:
    """The window of one picture: a module that is tipped, rights itself and is then looked at."""
    sys.path.insert(0, str(ROOT))
    from PySide6.QtCore import QTimer
    from PySide6.QtWidgets import QApplication, QPushButton

    from app.simulator import bench
    from ui.application import WindowOptions, assemble, start
    from ui.keeping import Keeping
    from ui.remembered import Remembered

    app = QApplication(sys.argv[:1])
    bench.module("demo", {"history": 4, "cell": 4.0})
    remembered = Remembered(home / "window.ini")
    remembered.theme = theme
    options = WindowOptions(demo=True, language=language)
    assembly = assemble(app, options, remembered=remembered, keeping=Keeping(home))
    window = assembly.window
    window.resize(WIDTH, HEIGHT)
    start(assembly, options)
    window.pages_made.connect(lambda: window.go_to(page))

    def press() -> None:
        button = window.findChild(QPushButton, PRESSED.get(page, "none"))
        if button is not None:
            button.click()

    QTimer.singleShot(3000, window, press)
    # A check wants it left alone.
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
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--all", type=Path, metavar="FOLDER", help="every page, theme, language and scale")
    parser.add_argument("--page", action="append", metavar="KEY", help="with --all: only this page (repeatable)")
    chosen = parser.parse_args(arguments)
    shots = readme_shots() if chosen.all is None else all_shots(chosen.all, tuple(chosen.page or ("live", "diagnosis")))
    for shot in shots:
        take(shot)
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))

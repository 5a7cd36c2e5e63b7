"""Runs the real window, presses buttons, waits for states and takes pictures."""

from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path
from typing import Final, TypeVar

import numpy as np
from PySide6.QtCore import QEventLoop, QPoint, QRect, QTimer
from PySide6.QtGui import QImage
from PySide6.QtWidgets import QAbstractButton, QApplication, QWidget

from app.engine.target import Target
from app.simulator.bench import SimulatedBench
from ui.main import Assembly
from ui.style.theme import Space

WAIT_S: Final = 30.0
_TURN_MS: Final = 20
_COLOURS: Final = 255
_OPAQUE: Final = 0xFF000000
Found = TypeVar("Found", bound=QWidget)


class Stuck(Exception):
    """The program did not reach the state of a picture."""


def turn(milliseconds: int) -> None:
    """Run the event loop as the program does; `QTest.qWait` keeps the threads of the ports waiting meanwhile."""
    loop = QEventLoop()
    QTimer.singleShot(milliseconds, loop.quit)
    loop.exec()


@dataclass(slots=True)
class Studio:
    """The window, its module, and the folder of the pictures."""

    assembly: Assembly
    module: SimulatedBench
    folder: Path
    """For the guide."""
    readme_folder: Path
    language: str
    taken: list[tuple[QImage, Path]] = field(default_factory=list)
    """Written at the end by `save_all`: finding the colours takes a second, in which the conversation would end."""

    @property
    def window(self) -> QWidget:
        return self.assembly.window

    def page(self, key: str, kind: type[Found]) -> Found:
        """Go to a page."""
        self.assembly.window.go_to(key)
        return self.find(kind)

    def find(self, kind: type[Found], name: str = "") -> Found:
        found = self.window.findChild(kind, name) if name else self.window.findChild(kind)
        if found is None:
            raise Stuck(f"there is no {name or kind.__name__}")
        return found

    def press(self, name: str) -> None:
        self.find(QAbstractButton, name).click()

    def until(self, is_so: Callable[[], object], what: str) -> None:
        """Run the event loop until the condition holds."""
        for _ in range(round(WAIT_S * 1000 / _TURN_MS)):
            if is_so():
                return
            turn(_TURN_MS)
        raise Stuck(what)

    def run(self, seconds: float) -> None:
        """Run the event loop for a time."""
        turn(round(seconds * 1000))

    def connect(self, port: str) -> None:
        self.assembly.ports.connect_to(Target(port, 115200))
        self.assembly.window.panel.hide()

    def is_known(self, key: str) -> bool:
        ports = self.assembly.ports
        return ports.module.view.known(key, ports.clock()) is not None

    def take(self, name: str, widget: QWidget | None = None, *, last: QWidget | None = None) -> None:
        """A picture of a widget as it stands in the window; the whole window unless told. `last`: nothing is below."""
        QApplication.processEvents()
        self.taken.append((self.grab(widget, last), self.folder / f"{name}-{self.language}.png"))

    def save_all(self) -> None:
        for image, path in self.taken:
            save(image, path)

    def grab(self, widget: QWidget | None = None, last: QWidget | None = None) -> QImage:
        one = widget or self.window
        area = QRect(one.mapTo(self.window, QPoint()), one.size())
        if last is not None:
            area.setBottom(min(area.bottom(), last.mapTo(self.window, QPoint(0, last.height())).y() + Space.M))
        return self.window.grab(area).toImage()


def save(image: QImage, path: Path) -> None:
    """As a PNG of at most 256 colours: the most frequent ones, the others drawn in the nearest of these."""
    path.parent.mkdir(parents=True, exist_ok=True)
    image = image.convertToFormat(QImage.Format.Format_RGB32)
    pixels = np.frombuffer(image.constBits(), np.uint32).reshape(image.height(), -1)[:, : image.width()] & 0xFFFFFF
    colours, counts = np.unique(pixels, return_counts=True)
    kept = colours[np.argsort(-counts, kind="stable")[:_COLOURS]]
    small = image.convertToFormat(QImage.Format.Format_Indexed8, [int(one) | _OPAQUE for one in kept])
    if not small.save(str(path), quality=0):  # strongest compression
        raise OSError(f"{path} could not be written")

"""Thumbnails of the tilt of recordings, read in the background and cached."""

from collections.abc import Iterable
from pathlib import Path
from typing import TYPE_CHECKING, Final

from PySide6.QtCore import QObject, QPointF, QRectF, Signal
from PySide6.QtGui import QPainter

from ui.core.background_task import BackgroundTask, Running
from ui.style.painted_widget import pen
from ui.style.theme import Theme

if TYPE_CHECKING:  # loads numpy, which would delay the window's first paint
    from app.recordings.library import RecordingEntry

BUCKETS: Final = 96
_AT_ONCE: Final = 8
"""Read at a time."""
_TOP_DEG: Final = 90.0
Outline = tuple[tuple[float, float], ...]


class Outlines(QObject):
    """Cache of outlines. `changed`: more are available."""

    changed = Signal()

    def __init__(self, parent: QObject | None = None) -> None:
        super().__init__(parent)
        self._known: dict[Path, tuple[int, Outline]] = {}
        """With the number of samples then, since a running recording grows."""
        self._reading: BackgroundTask[dict[Path, tuple[int, Outline]]] = BackgroundTask("dps-s outlines", self)

    def of(self, entry: "RecordingEntry") -> Outline:
        """The outline; empty until it is read."""
        return self._known.get(entry.path, (0, ()))[1]

    def read(self, entries: Iterable["RecordingEntry"]) -> None:
        """Reads some missing ones; called repeatedly while the page is visible."""
        if self._reading.is_running:
            return
        missing = [
            entry
            for entry in entries
            if entry.trouble is None and self._known.get(entry.path, (-1, ()))[0] != entry.sample_count
        ][:_AT_ONCE]
        if missing:
            self._reading.run(lambda running: _outlines(missing, running), self._on_read, lambda _error: None)

    def _on_read(self, outlines: dict[Path, tuple[int, Outline]]) -> None:
        self._known |= outlines
        self.changed.emit()


def _outlines(missing: "list[RecordingEntry]", running: Running) -> dict[Path, tuple[int, Outline]]:
    from app.recordings.recording import tilt_outline

    return {
        entry.path: (entry.sample_count, tilt_outline(entry, BUCKETS))
        for entry in missing
        if not running.is_cancelled()
    }


def draw_outline(painter: QPainter, box: QRectF, outline: Outline, theme: Theme) -> None:
    """Draws the tilt from 0 to 90°, or to 180° where it was larger; moves the painter."""
    painter.setPen(pen(theme.divider if theme.border_px == 1 else theme.muted, 1))
    painter.drawLine(box.bottomLeft(), box.bottomRight())
    if not outline:
        return
    top_deg = _TOP_DEG if max(high for _, high in outline) <= _TOP_DEG else 2 * _TOP_DEG
    painter.translate(box.bottomLeft())
    painter.scale(box.width() / len(outline), -box.height() / top_deg)
    line = pen(theme.curves[0], theme.line_px * painter.device().devicePixelRatioF())
    line.setCosmetic(True)  # in device pixels
    painter.setPen(line)
    painter.drawPolyline([QPointF(number + 0.5, value) for number, ends in enumerate(outline) for value in ends])

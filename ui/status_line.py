"""The line at the bottom: how the link does, in figures."""

from PySide6.QtCore import QEvent, Qt
from PySide6.QtWidgets import QFrame, QHBoxLayout, QLabel, QWidget

from app.device import LONGEST_LAG_S
from app.i18n import tr
from app.worker import Batch
from ui.connector import Connector
from ui.elided import ElidedLabel
from ui.link_state import duration
from ui.named import named
from ui.texts import Texts
from ui.theme import Space

RATE_OVER_S = 1.0
WRITE_EVERY_S = 0.3


class StatusLine(QFrame):
    """`take` remembers, `refresh` and `say` write."""

    def __init__(self, connector: Connector, texts: Texts, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self.setObjectName("status_line")
        self.setProperty("role", "bar")
        self._connector = connector
        self._frames = 0
        self._heard_at: float | None = None
        self._counted_at: float | None = None
        self._counted_frames = 0
        self._frames_per_s: float | None = None
        self._written_at = 0.0
        self._passing = ""
        self._passing_until = 0.0
        self.figures = named(QLabel(), "link_figures")
        self.passing = named(ElidedLabel(), "passing_message")
        self.age = named(QLabel(), "last_heard")
        # Described, not named: a name would be read aloud in place of the text.
        texts.bind(self.figures.setAccessibleDescription, "Figures of the link")
        texts.bind(
            self.figures.setToolTip,
            "Frames a second, usual round trip, lag, bytes that were no frame",
        )
        texts.bind(self.passing.setAccessibleDescription, "Message")
        texts.bind(self.age.setAccessibleDescription, "Time since the last frame")
        texts.bind(self.age.setToolTip, "Time since the last frame")
        row = QHBoxLayout(self)
        row.setContentsMargins(Space.M, Space.XS, Space.M, Space.XS)
        row.setSpacing(Space.L)
        row.addWidget(self.figures)
        self.passing.setAlignment(Qt.AlignmentFlag.AlignCenter)
        row.addWidget(self.passing, 1)
        row.addWidget(self.age)
        self._row = row
        for label in (self.figures, self.passing, self.age):
            label.setProperty("role", "small")

    def add(self, widget: QWidget) -> None:
        """Something quiet at the right, before the age."""
        self._row.insertWidget(self._row.indexOf(self.age), widget)

    def say(self, text: str, seconds: float = 6.0) -> None:
        """Show a calm word for a while: something was done, or a fault that needs nobody now."""
        self._passing, self._passing_until = text, self._connector.clock() + seconds
        self._write()

    def take(self, batch: Batch) -> None:
        if batch.link is None:
            self._counted_at, self._frames_per_s, self._heard_at, self._frames = None, None, None, 0
            return
        frames = batch.link.counters.frames
        if frames != self._frames:
            self._frames = frames
            if frames:
                self._heard_at = batch.at
        if self._counted_at is None:
            self._counted_at, self._counted_frames = batch.at, frames
        elif batch.at - self._counted_at >= RATE_OVER_S:
            self._frames_per_s = (frames - self._counted_frames) / (batch.at - self._counted_at)
            self._counted_at, self._counted_frames = batch.at, frames

    def refresh(self) -> None:
        """Write anew, if that is due: figures that change faster than this cannot be read."""
        if self._connector.clock() - self._written_at >= WRITE_EVERY_S:
            self._write()

    def changeEvent(self, event: QEvent) -> None:
        super().changeEvent(event)
        if event.type() == QEvent.Type.LanguageChange:
            self._write()

    def _write(self) -> None:
        last = self._connector.last
        link = None if last is None else last.link
        now = self._written_at = self._connector.clock()
        if link is None:
            figures = tr("Not connected")
        else:
            rate = "–" if self._frames_per_s is None else f"{self._frames_per_s:.0f}"
            trip = link.round_trip_median_s
            lag = "–" if link.lag_s is None else f"{link.lag_s:.2f}"
            figures = " · ".join(
                (
                    tr("{rate} frames/s", rate=rate),
                    tr("{ms} ms", ms="–" if trip is None else f"{trip * 1000:.1f}"),
                    tr("lag {seconds} s", seconds=lag),
                    tr("{n} bytes rejected", n=f"{link.counters.rejected:,}"),
                )
            )
        _write(self.figures, figures)
        heard = "" if self._heard_at is None else tr("{time} ago", time=duration(now - self._heard_at))
        if link is not None and link.lag_s is not None and link.lag_s > LONGEST_LAG_S:
            heard = tr("{time} late", time=duration(link.lag_s))
        _write(self.age, heard)
        _write(self.passing, self._passing if now < self._passing_until else "")


def _write(label: QLabel, text: str) -> None:
    if label.text() != text:
        label.setText(text)

"""Status bar: link statistics, or the notice that needs attention."""

from PySide6.QtCore import Qt
from PySide6.QtGui import QFontMetrics, QResizeEvent
from PySide6.QtWidgets import QAbstractButton, QFrame, QLabel, QWidget

from app.engine.device import MAX_LAG_S
from app.engine.worker import Batch
from app.limits.out_of_limits import DAMAGED_SHOWN_S, LimitsInUse, Outside, line_outside
from app.text.durations import duration
from app.text.i18n import tr
from ui.core.connector import Connector
from ui.core.texts import Texts
from ui.style.icons import Icon
from ui.style.theme import Meaning, Size, Space, font, scaled
from ui.widgets.controls import control
from ui.widgets.labels import ElidedLabel, IconLabel, TickingLabel
from ui.widgets.layouts import in_row
from ui.widgets.naming import named
from ui.widgets.notice_bar import NoticeBar
from ui.widgets.visibility_timer import VisibilityTimer

HEIGHT_PX = 40
"""That of a button with the gaps around it."""
WIDE_PX = 1180
"""Width from which there is room for more than the notice."""
RATE_OVER_S = 1.0
WRITE_EVERY_S = 0.3
_SIGN_PX = 14


class StatusBar(QFrame):
    """Shows link statistics, passing messages, and the time since the last frame.

    A notice or the bar of a played capture takes their place, so that nothing else in the window moves when it appears;
    its height is the same.
    """

    def __init__(
        self,
        connector: Connector,
        texts: Texts,
        in_use: LimitsInUse,
        notice_bar: NoticeBar,
    ) -> None:
        super().__init__()
        named(self, "status_line", "bar")
        self._connector = connector
        connector.invalidated.connect(lambda: self.show_message(""))
        self._in_use = in_use
        self._rejected = 0
        self._damaged_at: float | None = None
        self._frames = 0
        self._received_at: float | None = None
        self._counted_at: float | None = None
        self._counted_frames = 0
        self._frames_per_s: float | None = None
        self._written_at = 0.0
        self._message = ""
        self._message_until = 0.0
        self.figures = control(TickingLabel(), texts, "link_figures", says="Statistics")
        self.sign = IconLabel("line_fault_sign", _SIGN_PX, keeps_place=True)
        self.sign.show_icon(Icon.WARNING, Meaning.ATTENTION)
        self.fault = named(QLabel(), "line_fault", "attention")
        self.passing = named(ElidedLabel(), "passing_message")
        self.age = control(TickingLabel(), texts, "last_heard", says="Time since the last frame")
        # A description, since a name would replace the text for screen readers.
        texts.bind(self.passing.setAccessibleDescription, "Message")
        marked = in_row(self.figures, self.sign, self.fault, spacing=Space.XS)
        self.passing.setAlignment(Qt.AlignmentFlag.AlignCenter)
        self._figures = named(QWidget(), "status_figures")
        in_row(marked, (self.passing, 1), of=self._figures, spacing=Space.L, margins=(Space.M, 0, 0, 0))
        self._notice_bar = notice_bar
        self._ages = named(QWidget(), "status_ages")
        self._ages_row = in_row(self.age, of=self._ages, spacing=Space.L, margins=(0, 0, Space.M, 0))
        self._row = in_row((self._figures, 1), (notice_bar, 1), self._ages, of=self, spacing=0, margins=0)
        notice_bar.changed.connect(self._share)
        for label in (self.figures, self.passing, self.age):
            label.setProperty("role", "small")
        self._show_fault(None)
        self._reserve()
        self._share()
        VisibilityTimer(self, self._write, retranslate=self._retranslate, restyle=self._reserve)

    def _reserve(self) -> None:
        """Reserves room for the longest age, so that nothing beside it moves, and for two lines of a notice."""
        self.setFixedHeight(max(scaled(HEIGHT_PX), 2 * QFontMetrics(font()).lineSpacing() + 2 * Space.XS))
        longest = max((tr("{time} ago", time=duration(99)), tr("{time} ago", time=duration(1.9))), key=len)
        self.age.setMinimumWidth(QFontMetrics(font(Size.SMALL)).horizontalAdvance(longest) + Space.XS)
        self.age.setAlignment(Qt.AlignmentFlag.AlignRight | Qt.AlignmentFlag.AlignVCenter)

    def add(self, widget: QWidget) -> None:
        """Adds `widget` at the right: a control at the end, where it stays, anything else before the age."""
        if isinstance(widget, QAbstractButton):
            self._row.addWidget(widget)
        else:
            self._ages_row.insertWidget(self._ages_row.indexOf(self.age), widget)

    def _share(self) -> None:
        """Shows the notice in place of the figures, and of what is at the right where the window is narrow."""
        is_noticed = self._notice_bar.notice is not None
        self._figures.setVisible(not is_noticed)
        self._ages.setVisible(not is_noticed or self.width() >= scaled(WIDE_PX))

    def resizeEvent(self, event: QResizeEvent) -> None:
        super().resizeEvent(event)
        self._share()

    def show_message(self, text: str, seconds: float = 6.0) -> None:
        """Shows a message for some seconds."""
        self._message, self._message_until = text, self._connector.clock() + seconds
        self._write()

    def on_batch(self, batch: Batch) -> None:
        rejected = 0 if batch.link is None else batch.link.counters.rejected
        if rejected > self._rejected:
            self._damaged_at = batch.at
        elif batch.link is None:
            self._damaged_at = None
        self._rejected = rejected
        if batch.link is None:
            self._counted_at, self._frames_per_s, self._received_at, self._frames = None, None, None, 0
            return
        frames = batch.link.counters.frames
        if frames != self._frames:
            self._frames = frames
            if frames:
                self._received_at = batch.at
        if self._counted_at is None:
            self._counted_at, self._counted_frames = batch.at, frames
        elif batch.at - self._counted_at >= RATE_OVER_S:
            self._frames_per_s = (frames - self._counted_frames) / (batch.at - self._counted_at)
            self._counted_at, self._counted_frames = batch.at, frames

    def refresh(self) -> None:
        """Writes the figures again, at most every `WRITE_EVERY_S` so that they can be read."""
        if self._connector.clock() - self._written_at >= WRITE_EVERY_S:
            self._write()

    def _retranslate(self) -> None:
        self._message = ""  # in the former language
        self._reserve()
        self._write()

    def _write(self) -> None:
        last = self._connector.last
        link = None if last is None else last.link
        now = self._written_at = self._connector.clock()
        if link is None:
            figures = ""
        else:
            rate = "–" if self._frames_per_s is None else f"{self._frames_per_s:.0f}"
            trip = link.round_trip_median_s
            lag = "–" if link.lag_s is None else f"{link.lag_s:.2f}"
            figures = " · ".join(
                (
                    tr("{rate} frames/s", rate=rate),
                    tr("{ms} ms", ms="–" if trip is None else f"{trip * 1000:.1f}"),
                    tr("lag {seconds} s", seconds=lag),
                    tr("invalid bytes: {n}", n=f"{link.counters.rejected:,}"),
                )
            )
        _write(self.figures, figures)
        damaged_at = self._damaged_at
        self._show_fault(
            None
            if link is None
            else line_outside(
                lag_s=link.lag_s,
                round_trip_s=link.round_trip_median_s,
                has_damaged=damaged_at is not None and now - damaged_at < DAMAGED_SHOWN_S,
                in_use=self._in_use,
            )
        )
        heard = "" if self._received_at is None else tr("{time} ago", time=duration(now - self._received_at))
        if link is not None and link.lag_s is not None and link.lag_s > MAX_LAG_S:
            heard = tr("{time} late", time=duration(link.lag_s))
        _write(self.age, heard)
        message = self._message if now < self._message_until else ""
        _write(self.passing, message)
        self._notice_bar.show_note(message)

    def _show_fault(self, outside: Outside | None) -> None:
        _write(self.fault, "" if outside is None else tr(outside.fault.value))
        self.fault.setToolTip("" if outside is None else tr("limit {value}", value=outside.limit))
        for label in (self.sign, self.fault):
            label.setVisible(outside is not None)


def _write(label: QLabel, text: str) -> None:
    if label.text() != text:
        label.setText(text)

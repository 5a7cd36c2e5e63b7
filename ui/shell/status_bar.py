"""Status bar: the age of the last frame and the recording, or what needs attention."""

from collections.abc import Callable
from typing import Final

from PySide6.QtCore import Qt, QTimer, Signal
from PySide6.QtGui import QFontMetrics, QResizeEvent
from PySide6.QtWidgets import QAbstractButton, QFrame, QLabel, QWidget

from app.engine.worker import Batch
from app.limits.out_of_limits import DAMAGED_SHOWN_S, LimitsInUse, Outside, line_outside
from app.text.durations import duration
from app.text.i18n import tr
from ui.session.ports import Ports
from ui.session.recording import RecordingState
from ui.session.shown_module import ShownModule
from ui.style.icons import Icon
from ui.style.theme import Meaning, Size, Space, font, scaled
from ui.widgets.controls import control, named
from ui.widgets.labels import ElidedLabel, IconLabel, TickingLabel
from ui.widgets.layouts import in_row
from ui.widgets.notice_bar import NoticeBar
from ui.widgets.visibility_timer import VisibilityTimer

HEIGHT_PX: Final = 40
"""That of a button with the gaps around it."""
WIDE_PX: Final = 1180
"""Width from which there is room for more than the notice."""
MESSAGE_S: Final = 6.0
TICK_MS: Final = 300
_SIGN_PX: Final = 14
_RECORD_PX: Final = 12


class AgeLabel(TickingLabel):
    """Says how long ago something happened, and ticks while it is visible."""

    def __init__(self, clock: Callable[[], float]) -> None:
        super().__init__()
        self._clock = clock
        self._at: float | None = None
        self._late_s: float | None = None
        VisibilityTimer(self, self._write, every_ms=TICK_MS)

    def show_age(self, at: float | None, *, late_s: float | None = None) -> None:
        """Of what happened `at` this time of the clock; None: nothing has. `late_s`: it is known to be as late."""
        is_other = (self._at is None, self._late_s is None) != (at is None, late_s is None)
        self._at, self._late_s = at, late_s
        if is_other:
            self._write()

    def _write(self) -> None:
        text = "" if self._at is None else tr("{time} ago", time=duration(self._clock() - self._at))
        self.setText(text if self._late_s is None else tr("{time} late", time=duration(self._late_s)))


class StatusBar(QFrame):
    """Shows passing messages, a fault of the line, and the time since the last frame.

    A notice takes their place, so that nothing else in the window moves when it appears; its height is the same.
    """

    def __init__(self, ports: Ports, in_use: LimitsInUse, notice_bar: NoticeBar) -> None:
        super().__init__()
        named(self, "status_line", "bar")
        self._ports, self._in_use = ports, in_use
        self._module: ShownModule | None = None
        self._message_end = QTimer(self, singleShot=True)
        self._message_end.timeout.connect(lambda: self.show_message(""))
        self.sign = IconLabel("line_fault_sign", _SIGN_PX, keeps_place=True)
        self.sign.show_icon(Icon.WARNING, Meaning.ATTENTION)
        self.fault = named(QLabel(), "line_fault", "attention")
        self.passing = named(ElidedLabel(), "passing_message", "small")
        self.age = control(AgeLabel(ports.clock), "last_heard", says=tr("Time since the last frame"), role="small")
        # A description, since a name would replace the text for screen readers.
        self.passing.setAccessibleDescription(tr("Message"))
        self.passing.setAlignment(Qt.AlignmentFlag.AlignCenter)
        self._left = named(QWidget(), "status_message")
        in_row(self.sign, self.fault, (self.passing, 1), of=self._left, spacing=Space.XS, margins=(Space.M, 0, 0, 0))
        self._notice_bar = notice_bar
        self._ages = named(QWidget(), "status_ages")
        self._ages_row = in_row(self.age, of=self._ages, spacing=Space.L, margins=(0, 0, Space.M, 0))
        self._row = in_row((self._left, 1), (notice_bar, 1), self._ages, of=self, spacing=0, margins=0)
        notice_bar.changed.connect(self._share)
        self._show_fault(None)
        self._reserve()
        self._share()
        ports.shown.connect(self._show_module)
        self._show_module(ports.module)
        VisibilityTimer(self, restyle=self._reserve)

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
        """Shows the notice in place of the messages, and of what is at the right where the window is narrow."""
        is_noticed = self._notice_bar.notice is not None
        self._left.setVisible(not is_noticed)
        self._ages.setVisible(not is_noticed or self.width() >= scaled(WIDE_PX))

    def resizeEvent(self, event: QResizeEvent) -> None:
        super().resizeEvent(event)
        self._share()

    def show_message(self, text: str, seconds: float = MESSAGE_S, *, is_noted: bool = True) -> None:
        """`is_noted`: a notice does not hide it."""
        self.passing.setText(text)
        self._notice_bar.show_note(text if is_noted else "")
        if text:
            self._message_end.start(round(seconds * 1000))

    def _show_module(self, module: ShownModule) -> None:
        if self._module is not None:
            self._module.batch.disconnect(self.on_batch)
        self._module = module
        module.batch.connect(self.on_batch)
        self.show_message("")
        self.age.show_age(module.statistics.last_frame_at)
        self._show_fault(None)

    def on_batch(self, batch: Batch) -> None:
        link, line, view = batch.link, self._ports.module.statistics, batch.conversation
        if link is None:
            self.age.show_age(None)
            self._show_fault(None)
            return
        lag_s = view.lag_s if view.is_going else None
        invalid_at = line.last_invalid_at
        self.age.show_age(line.last_frame_at, late_s=lag_s if view.is_slow else None)
        has_damaged = invalid_at is not None and batch.at - invalid_at < DAMAGED_SHOWN_S
        self._show_fault(
            line_outside(
                lag_s=lag_s, round_trip_s=link.round_trip_median_s, has_damaged=has_damaged, in_use=self._in_use
            )
        )

    def _show_fault(self, outside: Outside | None) -> None:
        self.fault.setText("" if outside is None else tr(outside.fault.value))
        self.fault.setToolTip("" if outside is None else tr("limit {value}", value=outside.limit))
        for label in (self.sign, self.fault):
            label.setVisible(outside is not None)


class RecordingSign(QWidget):
    """Shows since when the session is recorded, or that it is not; `find_sign` is called at each `refresh`."""

    troubled = Signal(object)
    """Recording stopped, with the reason; emitted once."""

    def __init__(self, find_sign: Callable[[], RecordingState]) -> None:
        super().__init__()
        self.setObjectName("session_sign")
        self._find_sign = find_sign
        self._picture = IconLabel("session_sign_icon", _RECORD_PX)
        self.label = named(QLabel(), "session_sign_text", "small")
        in_row(self._picture, self.label, of=self, spacing=Space.XS, margins=0)
        self._is_reported = False
        VisibilityTimer(self, self.refresh)
        self.refresh()

    def refresh(self) -> None:
        sign = self._find_sign()
        text = whole = ""
        if sign.trouble is not None:
            text, whole = tr("Not recorded"), sign.trouble.translated()
        elif sign.since is not None:
            text = tr("Recorded since {time}", time=f"{sign.since.astimezone():%H:%M}")
            if sign.dropped:
                text = tr("Recorded since {time}, with gaps", time=f"{sign.since.astimezone():%H:%M}")
                whole = tr("The disk was too slow. Not recorded: {count}.", count=sign.dropped)
        self.label.setText(text)
        self.setToolTip(whole)
        self.setAccessibleName(f"{text}. {whole}".rstrip(". ") if text else tr("Not recorded"))
        self.setVisible(bool(text))
        if sign.trouble is None and not sign.dropped:
            self._picture.show_icon(Icon.RECORD, is_muted=True)
        else:
            self._picture.show_icon(Icon.WARNING, Meaning.ATTENTION)
        was_reported, self._is_reported = self._is_reported, sign.trouble is not None
        if self._is_reported and not was_reported:
            self.troubled.emit(sign.trouble)

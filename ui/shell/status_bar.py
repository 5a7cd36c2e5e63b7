"""Status bar: passing messages, a fault of the line, the age of the last frame and the recording, or what needs
attention."""

from collections.abc import Callable
from typing import Final

from PySide6.QtCore import QTimer
from PySide6.QtGui import QFontMetrics
from PySide6.QtWidgets import QLabel, QSizePolicy, QStatusBar, QWidget

from app.limits.limits import DAMAGED_SHOWN_S, LimitsInUse, line_outside
from app.text.i18n import tr
from app.text.messages import duration
from ui.session.ports import Ports
from ui.session.recording import RecordingState
from ui.session.shown_module import ShownModule
from ui.style.icons import Icon
from ui.style.theme import Meaning, Size, Space, font
from ui.widgets.controls import ElidedLabel, IconLabel, TickingLabel, in_row, named
from ui.widgets.notice_bar import NoticeBar
from ui.widgets.visibility_timer import VisibilityTimer

MESSAGE_S: Final = 6.0
TICK_MS: Final = 300


class StatusBar(QStatusBar):
    """A notice takes the place of what passes, so that nothing else in the window moves when it appears."""

    def __init__(self, ports: Ports, in_use: LimitsInUse, notice_bar: NoticeBar) -> None:
        super().__init__()
        named(self, "status_line", "bar")
        self.setSizeGripEnabled(False)
        self._ports, self._in_use = ports, in_use
        self._beside: list[QWidget] = []
        self._message_end = QTimer(self, singleShot=True)
        self._message_end.timeout.connect(lambda: self.show_message(""))
        self.notice_bar = notice_bar
        self.fault = named(QLabel(), "line_fault", "attention")
        self.passing = named(ElidedLabel(), "passing_message", "small")
        self.passing.setSizePolicy(QSizePolicy.Policy.Expanding, QSizePolicy.Policy.Preferred)
        # A description, since a name would replace the text for screen readers.
        self.passing.setAccessibleDescription(tr("Message"))
        self.age = named(TickingLabel(), "last_heard", "small")
        self.age.setAccessibleName(tr("Time since the last frame"))
        self.sign = IconLabel("line_fault_sign", 14)
        self.sign.show_icon(Icon.WARNING, Meaning.ATTENTION)
        self._line = named(QWidget(), "status_message")
        in_row(self.sign, self.fault, (self.passing, 1), of=self._line, spacing=Space.XS, margins=(Space.M, 0, 0, 0))
        self.addWidget(self._line, 1)
        self.addWidget(notice_bar, 1)
        self.add(self.age)
        # Room for two lines of a notice, for the longest age, and for a button.
        self.setFixedHeight(2 * QFontMetrics(font()).lineSpacing() + 3 * Space.XS)
        longest = max((tr("{time} ago", time=duration(seconds)) for seconds in (99, 1.9)), key=len)
        self.age.setMinimumWidth(QFontMetrics(font(Size.SMALL)).horizontalAdvance(longest) + Space.M)
        notice_bar.changed.connect(self._share)
        self._share()
        ports.shown.connect(self._show_module)
        self.refresh()
        VisibilityTimer(self, self.refresh, every_ms=TICK_MS)

    def add(self, widget: QWidget) -> None:
        """Adds `widget` at the right."""
        self._beside.append(widget)
        self.addPermanentWidget(widget)

    def _share(self) -> None:
        for part in (self._line, *self._beside):
            part.setVisible(self.notice_bar.notice is None)

    def show_message(self, text: str, seconds: float = MESSAGE_S, *, is_noted: bool = True) -> None:
        """`is_noted`: a notice does not hide it."""
        self.passing.setText(text)
        self.notice_bar.show_note(text if is_noted else "")
        if text:
            self._message_end.start(round(seconds * 1000))

    def _show_module(self, _module: ShownModule) -> None:
        self.show_message("")
        self.refresh()

    def refresh(self) -> None:
        """The line of the port that is shown: when its last frame came, and what is wrong with it."""
        port = self._ports.current
        view, line, now = port.module.view, port.module.statistics, port.now_s
        lag_s = view.lag_s if view.is_going else None
        age, outside = "", None
        if port.is_open and port.link is not None:
            if lag_s is not None and view.is_slow:
                age = tr("{time} late", time=duration(lag_s))
            elif line.last_frame_at is not None:
                age = tr("{time} ago", time=duration(now - line.last_frame_at))
            invalid_at = line.last_invalid_at
            has_damaged = invalid_at is not None and now - invalid_at < DAMAGED_SHOWN_S
            outside = line_outside(
                lag_s=lag_s, round_trip_s=port.link.round_trip_median_s, has_damaged=has_damaged, in_use=self._in_use
            )
        self.age.setText(age)
        self.fault.setText("" if outside is None else tr(outside.fault.value))
        self.fault.setToolTip("" if outside is None else tr("limit {value}", value=outside.limit))
        for label in (self.sign, self.fault):
            label.setVisible(outside is not None)


class RecordingSign(QWidget):
    """Shows since when the session is recorded, or that it is not; `find_sign` is called at each `refresh`."""

    def __init__(self, find_sign: Callable[[], RecordingState]) -> None:
        super().__init__()
        self.setObjectName("session_sign")
        self._find_sign = find_sign
        self._picture = IconLabel("session_sign_icon", 12, keeps_place=True)
        self.label = named(QLabel(), "session_sign_text", "small")
        in_row(self._picture, self.label, of=self, spacing=Space.XS, margins=(0, 0, Space.M, 0))
        VisibilityTimer(self, self.refresh)
        self.refresh()

    def refresh(self) -> None:
        sign = self._find_sign()
        text = whole = ""
        if sign.trouble is not None:
            text, whole = tr("Not recorded"), sign.trouble.translated()
        elif sign.since is not None and sign.dropped:
            text = tr("Recorded since {time}, with gaps", time=f"{sign.since.astimezone():%H:%M}")
            whole = tr("The disk was too slow. Not recorded: {count}.", count=sign.dropped)
        elif sign.since is not None:
            text = tr("Recorded since {time}", time=f"{sign.since.astimezone():%H:%M}")
        self.label.setText(text)
        self.setToolTip(whole)
        self.setAccessibleName(f"{text}. {whole}".rstrip(". ") if text else tr("Not recorded"))
        if sign.trouble is not None or sign.dropped:
            self._picture.show_icon(Icon.WARNING, Meaning.ATTENTION)
        elif text:
            self._picture.show_icon(Icon.RECORD, is_muted=True)
        else:
            self._picture.clear_icon()

"""The foot: passing messages, the age of the last frame and the recording, or what needs attention in their place."""

from collections.abc import Callable
from typing import Final

from PySide6.QtCore import QTimer
from PySide6.QtGui import QFontMetrics
from PySide6.QtWidgets import QHBoxLayout, QLabel, QSizePolicy, QStatusBar, QWidget

from app.text.i18n import tr
from app.text.messages import duration
from ui.session.ports import Ports
from ui.session.recording import RecordingState
from ui.style.icons import Icon
from ui.style.theme import Meaning, Size, Space, font
from ui.widgets.controls import ElidedLabel, IconLabel, TickingLabel, named
from ui.widgets.notice_bar import NoticeBar
from ui.widgets.visibility_timer import VisibilityTimer

MESSAGE_S: Final = 6.0
TICK_MS: Final = 300


class StatusBar(QStatusBar):
    """A notice takes the place of what passes, so that nothing else in the window moves when it appears."""

    def __init__(self, ports: Ports, notice_bar: NoticeBar) -> None:
        super().__init__()
        named(self, "status_line", "bar")
        self.setSizeGripEnabled(False)
        self._ports, self.notice_bar = ports, notice_bar
        self._beside: list[QWidget] = []
        self._message_end = QTimer(self, singleShot=True)
        self._message_end.timeout.connect(lambda: self.show_message(""))
        self.passing = named(ElidedLabel(), "passing_message", "small")
        self.passing.setSizePolicy(QSizePolicy.Policy.Expanding, QSizePolicy.Policy.Preferred)
        self.passing.setContentsMargins(Space.M, 0, 0, 0)
        # A description, since a name would replace the text for screen readers.
        self.passing.setAccessibleDescription(tr("Message"))
        self.age = named(TickingLabel(), "last_heard", "small")
        self.age.setAccessibleName(tr("Time since the last frame"))
        self.addWidget(self.passing, 1)
        self.addWidget(notice_bar, 1)
        self.add(self.age)
        # Room for two lines of a notice, for the longest age, and for a button.
        self.setFixedHeight(2 * QFontMetrics(font()).lineSpacing() + 3 * Space.XS)
        longest = max((tr("{time} ago", time=duration(seconds)) for seconds in (99, 1.9)), key=len)
        self.age.setMinimumWidth(QFontMetrics(font(Size.SMALL)).horizontalAdvance(longest) + Space.M)
        notice_bar.changed.connect(self._share)
        self._share()
        ports.shown.connect(lambda: self.show_message(""))
        ports.shown.connect(self.refresh)
        self.refresh()
        VisibilityTimer(self, self.refresh, every_ms=TICK_MS)

    def add(self, widget: QWidget) -> None:
        """Adds `widget` at the right."""
        self._beside.append(widget)
        self.addPermanentWidget(widget)

    def _share(self) -> None:
        for part in (self.passing, *self._beside):
            part.setVisible(self.notice_bar.notice is None)

    def show_message(self, text: str, *, is_noted: bool = True) -> None:
        """`is_noted`: a notice does not hide it."""
        self.passing.setText(text)
        self.notice_bar.show_note(text if is_noted else "")
        if text:
            self._message_end.start(round(MESSAGE_S * 1000))

    def refresh(self) -> None:
        """When the last frame of the port that is shown came."""
        port = self._ports.current
        view, last_at, age = port.module.view, port.module.statistics.last_frame_at, ""
        if port.is_open and view.is_going and view.is_slow and view.lag_s is not None:
            age = tr("{time} late", time=duration(view.lag_s))
        elif port.is_open and last_at is not None:
            age = tr("{time} ago", time=duration(port.now_s - last_at))
        self.age.setText(age)


class RecordingSign(QWidget):
    """Shows since when the session is recorded, or that it is not; `find` is called at each `refresh`."""

    def __init__(self, find: Callable[[], RecordingState]) -> None:
        super().__init__()
        self.setObjectName("session_sign")
        self._find = find
        self._picture = IconLabel("session_sign_icon", 12, keeps_place=True)
        self.label = named(QLabel(), "session_sign_text", "small")
        row = QHBoxLayout(self)
        row.setSpacing(Space.XS)
        row.setContentsMargins(0, 0, Space.M, 0)
        row.addWidget(self._picture)
        row.addWidget(self.label)
        VisibilityTimer(self, self.refresh)
        self.refresh()

    def refresh(self) -> None:
        sign = self._find()
        text = whole = ""
        if sign.trouble is not None:
            text, whole = tr("Not recorded"), sign.trouble.translated()
        elif sign.since is not None:
            since = f"{sign.since.astimezone():%H:%M}"
            text = tr("Recorded since {time}", time=since)
            if sign.dropped:
                text = tr("Recorded since {time}, with gaps", time=since)
                whole = tr("The disk was too slow. Not recorded: {count}.", count=sign.dropped)
        self.label.setText(text)
        self.setToolTip(whole)
        self.setAccessibleName(f"{text}. {whole}".rstrip(". ") if text else tr("Not recorded"))
        if whole:
            self._picture.show_icon(Icon.WARNING, Meaning.ATTENTION)
        elif text:
            self._picture.show_icon(Icon.RECORD, is_muted=True)
        else:
            self._picture.clear_icon()

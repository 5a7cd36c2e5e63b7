"""The foot: passing messages and the recording, or what needs attention in their place."""

from collections.abc import Callable
from typing import Final

from PySide6.QtCore import QTimer
from PySide6.QtGui import QFontMetrics
from PySide6.QtWidgets import QHBoxLayout, QLabel, QSizePolicy, QStatusBar, QWidget

from app.text.i18n import tr
from ui.session.recording import RecordingState
from ui.style.icons import Icon
from ui.style.theme import Meaning, Space, font
from ui.widgets.controls import ElidedLabel, IconLabel, named
from ui.widgets.notice_bar import NoticeBar
from ui.widgets.visibility_timer import VisibilityTimer

MESSAGE_S: Final = 6.0


class StatusBar(QStatusBar):
    """A notice takes the place of what passes, so that nothing else in the window moves when it appears."""

    def __init__(self, notice_bar: NoticeBar, *beside: QWidget) -> None:
        """`beside`: at the right."""
        super().__init__()
        named(self, "status_line", "bar")
        self.setSizeGripEnabled(False)
        self._notice_bar = notice_bar
        self._message_end = QTimer(self, singleShot=True, interval=round(MESSAGE_S * 1000))
        self._message_end.timeout.connect(lambda: self.show_message(""))
        self.passing = named(ElidedLabel(), "passing_message", "small")
        self.passing.setSizePolicy(QSizePolicy.Policy.Expanding, QSizePolicy.Policy.Preferred)
        self.passing.setContentsMargins(Space.M, 0, 0, 0)
        # A description, since a name would replace the text for screen readers.
        self.passing.setAccessibleDescription(tr("Message"))
        self.addWidget(self.passing, 1)
        self.addWidget(notice_bar, 1)
        for widget in beside:
            self.addPermanentWidget(widget)
        # Room for two lines of a notice, and for a button.
        self.setFixedHeight(2 * QFontMetrics(font()).lineSpacing() + 3 * Space.XS)
        self._shared = (self.passing, *beside)
        notice_bar.changed.connect(self._share)
        self._share()

    def _share(self) -> None:
        for part in self._shared:
            part.setVisible(self._notice_bar.notice is None)

    def show_message(self, text: str, *, is_noted: bool = True) -> None:
        """`is_noted`: a notice does not hide it."""
        self.passing.setText(text)
        self._notice_bar.show_note(text if is_noted else "")
        if text:
            self._message_end.start()


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

"""Recording indicator in the status bar."""

from collections.abc import Callable
from typing import Final

from PySide6.QtCore import Qt, Signal
from PySide6.QtWidgets import QLabel, QWidget

from app.text.i18n import tr
from app.text.messages import UserMessage
from ui.services.session_recording import RecordingState
from ui.style.icons import Icon
from ui.style.theme import Meaning, Space
from ui.widgets.labels import IconLabel
from ui.widgets.layouts import in_row
from ui.widgets.naming import named
from ui.widgets.visibility_timer import VisibilityTimer

_ICON_PX: Final = 12


class RecordingSign(QWidget):
    """Shows since when the session is recorded, or that it is not; `find_sign` is called at each `refresh`."""

    troubled = Signal()
    """Recording stopped; emitted once."""

    def __init__(self, find_sign: Callable[[], RecordingState]) -> None:
        super().__init__()
        self.setObjectName("session_sign")
        self._find_sign = find_sign
        self._picture = IconLabel("session_sign_icon", _ICON_PX)
        self.label = named(QLabel(), "session_sign_text", "small")
        self.label.setTextFormat(Qt.TextFormat.PlainText)
        in_row(self._picture, self.label, of=self, spacing=Space.XS, margins=0)
        self._shown: RecordingState | None = None
        self._is_reported = False
        self._last_trouble = UserMessage("")
        VisibilityTimer(self, self._retranslate)
        self.refresh()

    @property
    def last_trouble(self) -> str:
        """Why recording stopped the last time, in the language in use now."""
        return self._last_trouble.translated()

    def refresh(self) -> None:
        sign = self._find_sign()
        before, self._shown = self._shown, sign
        if sign != before:
            self._write(sign)
        if sign.trouble is not None and not self._is_reported:
            self._last_trouble = sign.trouble
            self.troubled.emit()
        self._is_reported = sign.trouble is not None

    def _retranslate(self) -> None:
        self._shown = None
        self.refresh()

    def _write(self, sign: RecordingState) -> None:
        if sign.trouble is not None:
            text, whole = tr("Not recorded"), sign.trouble.translated()
        elif sign.since is None:
            text = whole = ""
        else:
            text = tr("Recorded since {time}", time=f"{sign.since.astimezone():%H:%M}")
            whole = ""
            if sign.dropped:
                text = tr("Recorded since {time}, with gaps", time=f"{sign.since.astimezone():%H:%M}")
                whole = tr("The disk was too slow. Reports missing: {count}.", count=sign.dropped)
        self.label.setText(text)
        self.setToolTip(whole)
        self.setAccessibleName(f"{text}. {whole}".rstrip(". ") if text else tr("Not recorded"))
        self.setVisible(bool(text))
        if sign.trouble is None and not sign.dropped:
            self._picture.show_icon(Icon.RECORD, is_muted=True)
        else:
            self._picture.show_icon(Icon.WARNING, Meaning.ATTENTION)

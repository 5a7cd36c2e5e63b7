"""Banner above the plots while a recording is shown: origin, "not live", way back."""

from typing import Final

from PySide6.QtCore import QEvent, Qt, Signal
from PySide6.QtGui import QPaintEvent, QResizeEvent
from PySide6.QtWidgets import QHBoxLayout, QLabel, QPushButton, QSizePolicy, QWidget

from app.diagnosis.link_state import duration
from app.recordings.entry_texts import remarks, told
from app.recordings.recording import Recording
from app.text.i18n import tr
from ui.core.texts import Texts
from ui.style.icons import Icon, pixmap
from ui.style.painted_widget import paint_banner
from ui.style.theme import Meaning, Space, current
from ui.widgets.controls import control
from ui.widgets.naming import named

_ICON_PX: Final = 16


class RecordedBanner(QWidget):
    """Not there while the module's own values are shown."""

    left = Signal()
    """Back to live."""

    def __init__(self, texts: Texts, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self.setObjectName("recorded_banner")
        self._recording: Recording | None = None
        self._picture = named(QLabel(), "recorded_icon")
        self.label = named(QLabel(), "recorded_label", "strong")
        self.label.setTextFormat(Qt.TextFormat.PlainText)
        self.label.setSizePolicy(QSizePolicy.Policy.Ignored, QSizePolicy.Policy.Preferred)
        self.back = control(QPushButton(), texts, "recorded_back", "Back to live",
                            tip="Close the recording and show the module as it is now", key="Esc", picture=Icon.TO_LIVE,
                            slot=self.left)  # fmt: skip
        row = QHBoxLayout(self)
        row.setContentsMargins(Space.M, Space.XS, Space.S, Space.XS)
        row.setSpacing(Space.S)
        row.addWidget(self._picture)
        row.addWidget(self.label, 1)
        row.addWidget(self.back)
        self.hide()

    @property
    def text(self) -> str:
        """What it says, whole."""
        return self.accessibleName()

    def show_recording(self, recording: Recording | None) -> None:
        """None takes the strip away."""
        self._recording = recording
        self.setVisible(recording is not None)
        self._write()

    @property
    def _meaning(self) -> Meaning:
        is_damaged = self._recording is not None and self._recording.damage is not None
        return Meaning.ATTENTION if is_damaged else Meaning.INFORMATION

    def _write(self) -> None:
        if self._recording is None:
            return
        entry, damage = self._recording.entry, self._recording.damage
        began = tr(
            "Recording of {when}, {length}",
            when=f"{entry.started_at.astimezone():%Y-%m-%d %H:%M}",
            length=duration(entry.duration_s),
        )
        parts = (damage, began, entry.module, entry.port, remarks(entry), tr("not live"))
        text = " · ".join(filter(None, parts))
        self.setAccessibleName(text)
        self.label.setAccessibleName(text)
        self.label.setToolTip("\n".join(filter(None, (damage, told(entry)))))
        self._fit()
        self._dress()

    def _fit(self) -> None:
        room = self.label.width()
        self.label.setText(
            self.label.fontMetrics().elidedText(self.accessibleName(), Qt.TextElideMode.ElideMiddle, room)
        )

    def _dress(self) -> None:
        ink = current().ink(self._meaning)
        picture = Icon.HISTORY if self._meaning is Meaning.INFORMATION else Icon.WARNING
        self._picture.setPixmap(pixmap(picture, _ICON_PX, ink, ratio=self.devicePixelRatioF()))

    # Qt

    def resizeEvent(self, event: QResizeEvent) -> None:
        super().resizeEvent(event)
        self._fit()

    def changeEvent(self, event: QEvent) -> None:
        super().changeEvent(event)
        if event.type() == QEvent.Type.LanguageChange:
            self._write()
        elif event.type() in (QEvent.Type.PaletteChange, QEvent.Type.StyleChange) and hasattr(self, "_picture"):
            self._dress()

    def paintEvent(self, _event: QPaintEvent) -> None:
        paint_banner(self, self._meaning)

"""Banner above the plots while a recording is shown: origin, "not live", way back."""

from PySide6.QtCore import QEvent, Qt, Signal
from PySide6.QtGui import QResizeEvent
from PySide6.QtWidgets import QLabel, QPushButton, QSizePolicy, QWidget

from app.diagnosis.link_state import duration
from app.recordings.entry_texts import remarks, told
from app.recordings.recording import Recording
from app.text.i18n import tr
from ui.core.texts import Texts
from ui.style.icons import Icon
from ui.style.theme import Meaning
from ui.widgets.banner import Banner
from ui.widgets.controls import control
from ui.widgets.naming import named


class RecordedBanner(Banner):
    """Not there while the module's own values are shown."""

    left = Signal()
    """Back to live."""

    def __init__(self, texts: Texts, parent: QWidget | None = None) -> None:
        super().__init__("recorded_banner", "recorded_icon", parent=parent)
        self._recording: Recording | None = None
        self.label = named(QLabel(), "recorded_label", "strong")
        self.label.setTextFormat(Qt.TextFormat.PlainText)
        self.label.setSizePolicy(QSizePolicy.Policy.Ignored, QSizePolicy.Policy.Preferred)
        self.back = control(QPushButton(), texts, "recorded_back", "Back to live", key="Esc", picture=Icon.TO_LIVE,
                            slot=self.left)  # fmt: skip
        self.row.addWidget(self.label, 1)
        self.row.addWidget(self.back)

    @property
    def text(self) -> str:
        """What it says, whole."""
        return self.accessibleName()

    def show_recording(self, recording: Recording | None) -> None:
        """None takes the strip away."""
        self._recording = recording
        self.setVisible(recording is not None)
        self._write()

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
        if damage is None:
            self.show_meaning(Meaning.INFORMATION, Icon.HISTORY)
        else:
            self.show_meaning(Meaning.ATTENTION, Icon.WARNING)

    def _fit(self) -> None:
        room = self.label.width()
        self.label.setText(
            self.label.fontMetrics().elidedText(self.accessibleName(), Qt.TextElideMode.ElideMiddle, room)
        )

    # Qt

    def resizeEvent(self, event: QResizeEvent) -> None:
        super().resizeEvent(event)
        self._fit()

    def changeEvent(self, event: QEvent) -> None:
        super().changeEvent(event)
        if event.type() == QEvent.Type.LanguageChange:
            self._write()

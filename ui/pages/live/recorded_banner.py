"""Banner above the plots while a recording is shown: its origin, "not live", and the way back."""

from PySide6.QtCore import Qt, Signal
from PySide6.QtWidgets import QPushButton

from app.recordings.entry_texts import remarks
from app.recordings.recording import Recording
from app.text.durations import duration
from app.text.i18n import tr
from ui.core.texts import Texts
from ui.style.icons import Icon
from ui.style.theme import Meaning, Space
from ui.widgets.banner import Banner
from ui.widgets.controls import control
from ui.widgets.labels import ElidedLabel
from ui.widgets.naming import named
from ui.widgets.visibility_timer import VisibilityTimer


class RecordedBanner(Banner):
    """Hidden while the module's own values are shown."""

    left = Signal()
    """The user wants to go back to live."""

    def __init__(self, texts: Texts) -> None:
        super().__init__("recorded_banner", "recorded_icon")
        self._recording: Recording | None = None
        self.label = named(ElidedLabel(Qt.TextElideMode.ElideMiddle), "recorded_label", "strong")
        self.back = control(QPushButton(), texts, "recorded_back", "Back to live", key="Esc", picture=Icon.TO_LIVE,
                            slot=self.left)  # fmt: skip
        self.row.setContentsMargins(Space.M, 0, Space.M, 0)  # the plots need the room on a small screen
        self.row.addWidget(self.label, 1)
        self.row.addWidget(self.back)
        VisibilityTimer(self, self._write)

    def show_recording(self, recording: Recording | None) -> None:
        """None hides the banner."""
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
        parts = (
            damage.translated() if damage is not None else "",
            began,
            entry.module,
            entry.port,
            remarks(entry),
            tr("not live"),
        )
        self.label.setText(" · ".join(filter(None, parts)))
        self.setAccessibleName(self.label.text())
        if damage is None:
            self.show_meaning(Meaning.INFORMATION, Icon.HISTORY)
        else:
            self.show_meaning(Meaning.ATTENTION, Icon.WARNING)

"""Buttons of the Recordings page."""

from collections.abc import Sequence

from PySide6.QtWidgets import QPushButton, QWidget

from app.recordings.library import RecordingEntry
from protocol.translatable import marked
from ui.core.texts import Texts
from ui.style.icons import Icon
from ui.style.theme import Space
from ui.widgets.controls import control, rename
from ui.widgets.layouts import in_column, in_row


class RecordingsButtons(QWidget):
    """Buttons for the selected recordings; the page connects them."""

    def __init__(self, texts: Texts) -> None:
        super().__init__()
        self.setObjectName("recordings_buttons")
        self._texts = texts
        self.csv = control(QPushButton(), texts, "recordings_csv", "CSV…", key="Ctrl+S", picture=Icon.TABLE)
        self.mcap = control(QPushButton(), texts, "recordings_mcap", "MCAP…",
                            tip="For PlotJuggler and Foxglove", key="Ctrl+Shift+S", picture=Icon.SAVE)  # fmt: skip
        self.keep = control(QPushButton(), texts, "recordings_keep", "Pin", tip="Never delete automatically",
                            picture=Icon.BOOKMARK)  # fmt: skip
        self.delete = control(QPushButton(), texts, "recordings_delete", "Delete…", key="Del",
                              picture=Icon.ERASE)  # fmt: skip
        self.open = control(QPushButton(), texts, "recordings_open", "Open", key="Enter", picture=Icon.LIVE,
                            role="primary")  # fmt: skip
        exports = in_row((self.csv, 1), (self.mcap, 1), spacing=Space.S)
        marks = in_row((self.keep, 1), (self.delete, 1), spacing=Space.S)
        in_column(self.open, exports, marks, of=self, spacing=Space.S, margins=0)
        self.show_chosen((), is_idle=True)

    def show_chosen(self, chosen: Sequence[RecordingEntry], *, is_idle: bool) -> None:
        """Enables what is possible; nothing while a job runs."""
        is_one = len(chosen) == 1 and chosen[0].trouble is None
        for button in (self.open, self.csv, self.mcap):
            button.setEnabled(is_idle and is_one)
        self.keep.setEnabled(is_idle and bool(chosen))
        self.delete.setEnabled(is_idle and bool(chosen) and not any(one.is_running for one in chosen))
        rename(self.keep, self._texts, marked("Unpin") if chosen and all(one.is_kept for one in chosen) else "Pin")

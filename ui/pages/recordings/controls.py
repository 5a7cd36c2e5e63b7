"""Buttons and empty state of the Recordings page."""

from collections.abc import Sequence

from PySide6.QtCore import QSize
from PySide6.QtWidgets import QHBoxLayout, QPushButton, QWidget

from app.recordings.library import RecordingEntry
from ui.core.texts import Texts
from ui.style.icons import Icon, icon
from ui.style.theme import Space
from ui.widgets.empty_state import EmptyState
from ui.widgets.naming import named


class RecordingsButtons(QWidget):
    """Shows what can be done with what is chosen; what a click does is connected by the page."""

    def __init__(self, texts: Texts) -> None:
        super().__init__()
        self.setObjectName("recordings_buttons")
        self._texts = texts
        self._releases: bool | None = None
        self.csv = _button("recordings_csv", Icon.TABLE)
        self.mcap = _button("recordings_mcap", Icon.SAVE)
        self.keep = _button("recordings_keep", Icon.BOOKMARK)
        self.delete = _button("recordings_delete", Icon.ERASE)
        self.open = _button("recordings_open", Icon.LIVE)
        self.open.setProperty("role", "primary")
        self.open.setIcon(icon(Icon.LIVE, is_on_primary=True))
        texts.bind(self.csv.setText, "Export CSV …")
        texts.bind(self.csv.setAccessibleName, "Export the recording as CSV")
        texts.bind(self.csv.setToolTip, "All of it as a table, CSV (Ctrl+S)")
        texts.bind(self.mcap.setText, "Export MCAP …")
        texts.bind(self.mcap.setAccessibleName, "Export the recording as MCAP")
        texts.bind(
            self.mcap.setToolTip, "All of it with the bytes of the line, for PlotJuggler and Foxglove (Ctrl+Shift+S)"
        )
        texts.bind(self.delete.setText, "Delete …")
        texts.bind(self.delete.setAccessibleName, "Delete the chosen recordings")
        texts.bind(self.delete.setToolTip, "Delete the chosen recordings for good, after a question (Del)")
        texts.bind(self.open.setText, "Open")
        texts.bind(self.open.setAccessibleName, "Open the recording on the Live page")
        texts.bind(self.open.setToolTip, "Look at the recording on the Live page (Enter)")
        row = QHBoxLayout(self)
        row.setContentsMargins(0, 0, 0, 0)
        row.setSpacing(Space.S)
        for button in (self.csv, self.mcap, self.keep, self.delete):
            row.addWidget(button)
        row.addStretch(1)
        row.addWidget(self.open)
        self.show_chosen((), is_idle=True)

    def show_chosen(self, chosen: Sequence[RecordingEntry], *, is_idle: bool) -> None:
        """Only what can be done is offered; nothing while something else is under way."""
        is_one = len(chosen) == 1 and chosen[0].trouble is None
        for button in (self.open, self.csv, self.mcap):
            button.setEnabled(is_idle and is_one)
        self.keep.setEnabled(is_idle and bool(chosen))
        self.delete.setEnabled(is_idle and bool(chosen) and not any(one.is_running for one in chosen))
        self._name_keep(releases=bool(chosen) and all(one.is_kept for one in chosen))

    def _name_keep(self, *, releases: bool) -> None:
        if releases == self._releases:
            return
        self._releases = releases
        bind, keep = self._texts.bind, self.keep
        if releases:
            bind(keep.setText, "Keep no longer")
            bind(keep.setAccessibleName, "Let the chosen recordings go when there are too many")
            bind(keep.setToolTip, "Let the chosen recordings go when there are too many")
        else:
            bind(keep.setText, "Keep")
            bind(keep.setAccessibleName, "Keep the chosen recordings for good")
            bind(keep.setToolTip, "Never delete the chosen recordings by itself; what is in the trash comes back")


class NoRecordings(EmptyState):
    """Before the first session."""

    def __init__(self, texts: Texts) -> None:
        super().__init__("recordings_empty", Icon.RECORDINGS)
        texts.bind(self.title.setText, "No recordings yet")
        texts.bind(
            self.text.setText,
            "Every session is recorded by itself, from the first byte that comes over a port until the port is closed. "
            "There is nothing to switch on.",
        )


def _button(name: str, picture: Icon) -> QPushButton:
    button = named(QPushButton(), name)
    button.setIcon(icon(picture))
    button.setIconSize(QSize(16, 16))
    return button

"""The Flight logs page before the first file."""

from PySide6.QtWidgets import QPushButton

from ui.core.texts import Texts
from ui.style.icons import Icon
from ui.style.theme import Space
from ui.widgets.controls import control
from ui.widgets.empty_state import EmptyState
from ui.widgets.layouts import in_row


class NoFlights(EmptyState):
    def __init__(self, texts: Texts) -> None:
        super().__init__("flights_empty", Icon.MAP)
        texts.bind(self.title.setText, "No flight logs yet")
        texts.bind(
            self.text.setText,
            "Open logs of PX4, ArduPilot, CSV files or recordings, or drop them here. The page shows which thresholds "
            "would have fired in them.",
        )
        self.files = control(QPushButton(), texts, "flights_empty_files", "Open files…", says="Open flight logs",
                             tip="Open flight logs", picture=Icon.FOLDER, role="primary")  # fmt: skip
        self.folder = control(QPushButton(), texts, "flights_empty_folder", "Open folder…",
                              says="Open a folder of flight logs", tip="Open a folder of flight logs")  # fmt: skip
        row = in_row(1, self.files, self.folder, 1, spacing=Space.S)
        self.column.insertSpacing(self.column.count() - 1, Space.S)
        self.column.insertLayout(self.column.count() - 1, row)

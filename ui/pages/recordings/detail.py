"""Details of the selected recording: facts and buttons."""

from collections.abc import Sequence
from typing import Final

from PySide6.QtWidgets import QFrame, QPushButton, QSizePolicy, QWidget

from app.recordings.entry_texts import entry_text, remarks, size_text, when_text
from app.recordings.library import RecordingEntry
from app.text.durations import stopwatch
from app.text.i18n import tr
from app.text.sentences import join_names
from protocol.translatable import marked
from ui.forms.rows_table import FactRows
from ui.style.icons import Icon
from ui.style.theme import Space, scaled
from ui.widgets.controls import control, named
from ui.widgets.labels import ElidedLabel, text_label
from ui.widgets.layouts import in_column, in_row, scroll_area

WIDTH_PX: Final = 328
_FACTS_PX: Final = 40
"""Height of the facts, which scroll, where a notice needs the room."""
_FACTS: Final = {
    "when": marked("Time"),
    "port": marked("Port"),
    "duration": marked("Duration"),
    "samples": marked("Samples"),
    "size": marked("Size"),
}


class RecordingsDetail(QFrame):
    def __init__(self) -> None:
        super().__init__()
        named(self, "recordings_detail", "card")
        self.csv = control(QPushButton(tr("CSV…")), "recordings_csv", keys="Ctrl+S", picture=Icon.TABLE)
        self.mcap = control(
            QPushButton(tr("MCAP…")),
            "recordings_mcap",
            tip=tr("For PlotJuggler and Foxglove"),
            keys="Ctrl+Shift+S",
            picture=Icon.SAVE,
        )
        self.pin = control(
            QPushButton(tr("Pin")), "recordings_keep", tip=tr("Never delete automatically"), picture=Icon.BOOKMARK
        )
        self.delete = control(QPushButton(tr("Delete…")), "recordings_delete", key="Del", picture=Icon.ERASE)
        self.open = control(QPushButton(tr("Open")), "recordings_open", key="Enter", picture=Icon.LIVE, role="primary")
        exports = in_row((self.csv, 1), (self.mcap, 1), spacing=Space.S)
        marks = in_row((self.pin, 1), (self.delete, 1), spacing=Space.S)
        self.title = named(ElidedLabel(), "recordings_detail_title", "strong")
        single_lines = {key: named(ElidedLabel(), f"recordings_{key}") for key in _FACTS}
        self._fact_rows = FactRows("recordings", _FACTS, single_lines)
        self._fact_rows.setSizePolicy(QSizePolicy.Policy.Preferred, QSizePolicy.Policy.Maximum)
        self.facts = self._fact_rows.values
        self.remarks = text_label("recordings_remarks", is_selectable=True)
        content = named(QWidget(), "recordings_facts")
        in_column(self._fact_rows, self.remarks, 1, of=content, spacing=Space.XS, margins=0)
        scroll = scroll_area(content, "recordings_facts_scroll", tr("Recordings"), is_transparent=True)
        scroll.setMinimumHeight(scaled(_FACTS_PX))
        # The buttons stay where they are when a notice below makes the page shorter.
        in_column(self.title, self.open, exports, marks, (scroll, 1), of=self, spacing=Space.S, margins=Space.M)

    def show_chosen(self, chosen: Sequence[RecordingEntry], *, is_idle: bool) -> None:
        """Shows one recording, or how many are selected and their sums. Nothing is possible while a job runs."""
        entry = chosen[0] if len(chosen) == 1 else None
        for button in (self.open, self.csv, self.mcap):
            button.setEnabled(is_idle and entry is not None and entry.trouble is None)
        self.pin.setEnabled(is_idle and bool(chosen))
        self.delete.setEnabled(is_idle and bool(chosen) and not any(entry.is_running for entry in chosen))
        self.pin.setText(tr("Unpin" if chosen and all(entry.is_pinned for entry in chosen) else "Pin"))
        readable = [entry for entry in chosen if entry.trouble is None]
        shown: dict[str, str] = {}
        if chosen:
            shown["size"] = size_text(sum(entry.size_bytes for entry in chosen))
        if readable:
            shown["duration"] = stopwatch(sum(entry.duration_s for entry in readable))
            shown["samples"] = f"{sum(entry.sample_count for entry in readable):,}"
        if entry is not None:
            shown |= {"when": when_text(entry), "port": entry.port}
            if entry.was_triggered:
                shown["samples"] = join_names((shown["samples"], tr("triggered")))
                entry = entry._replace(was_triggered=False)  # a line of its own would move the buttons
        self.title.setText(_title(chosen))
        self.remarks.setText("" if entry is None else remarks(entry) if entry.trouble is None else entry_text(entry))
        self.remarks.setVisible(bool(self.remarks.text()))
        self._fact_rows.show_facts(shown)


def _title(chosen: Sequence[RecordingEntry]) -> str:
    match chosen:
        case []:
            return ""
        case [entry]:
            return entry.module or (when_text(entry) if entry.trouble is None else entry.name)
        case _:
            return tr("{count} selected", count=len(chosen))

"""Details of the selected recording: outline, facts and buttons."""

from collections.abc import Sequence
from typing import Final

from PySide6.QtCore import QRectF, QSize
from PySide6.QtGui import QPaintEvent
from PySide6.QtWidgets import QFrame, QLabel, QPushButton, QSizePolicy, QWidget

from app.recordings.entry_texts import remarks, size_text, when_text
from app.recordings.library import RecordingEntry
from app.text.durations import stopwatch
from app.text.i18n import tr
from protocol.translatable import marked
from ui.core.texts import Texts
from ui.pages.recordings.outlines import Outline, Outlines, draw_outline
from ui.style.icons import Icon
from ui.style.painted_widget import PaintedWidget
from ui.style.theme import Space, current
from ui.widgets.controls import control, rename
from ui.widgets.labels import ElidedLabel, text_label
from ui.widgets.layouts import in_column, in_row, scroll_area
from ui.widgets.naming import named

WIDTH_PX: Final = 304
_FACTS: Final = (
    ("port", marked("Port")),
    ("duration", marked("Duration")),
    ("samples", marked("Samples")),
    ("size", marked("Size")),
    ("remarks", marked("Remarks")),
)


class OutlinePicture(PaintedWidget):
    """The tilt of one recording over its duration."""

    def __init__(self) -> None:
        super().__init__()
        self.setObjectName("recordings_outline")
        self._outline: Outline = ()
        self.setSizePolicy(QSizePolicy.Policy.Expanding, QSizePolicy.Policy.Preferred)
        self.use_card_background()

    def show_outline(self, outline: Outline) -> None:
        self._outline = outline
        highest = f" ≤ {round(max(high for _, high in outline))}°" if outline else ""
        self.announce(f"{tr('Tilt')}{highest}")

    def sizeHint(self) -> QSize:
        return QSize(200, 72)

    def minimumSizeHint(self) -> QSize:
        return QSize(120, 24)

    def paintEvent(self, _event: QPaintEvent) -> None:
        painter = self.begin_paint()
        draw_outline(painter, QRectF(self.rect()).adjusted(1, 6, -1, -2), self._outline, current())
        painter.end()


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
        rename(self.keep, self._texts, marked("Unpin") if chosen and all(one.is_pinned for one in chosen) else "Pin")


class RecordingsDetail(QFrame):
    def __init__(self, texts: Texts, outlines: Outlines) -> None:
        super().__init__()
        named(self, "recordings_detail", "card")
        self._outlines = outlines
        self.buttons = RecordingsButtons(texts)
        self.picture = OutlinePicture()
        self.title = text_label("recordings_detail_title", "strong", is_selectable=True)
        self.facts = {key: text_label(f"recordings_{key}", "", is_selectable=True) for key, _ in _FACTS}
        self.facts["port"] = named(ElidedLabel(), "recordings_port")  # a simulated one may have a long name
        rows = []
        for key, english in _FACTS:
            name = control(QLabel(), texts, f"recordings_{key}_name", english, role="muted")
            name.setFixedWidth(88)
            texts.bind(self.facts[key].setAccessibleDescription, english)
            rows.append(in_row(name, (self.facts[key], 1), spacing=Space.S))
        self.setFixedWidth(WIDTH_PX)
        content = named(QWidget(), "recordings_facts")
        in_column(self.title, self.picture, *rows, 1, of=content, spacing=Space.XS, margins=0)
        scroll = scroll_area(content, texts, "recordings_facts_scroll", "Recordings", is_transparent=True)
        in_column((scroll, 1), self.buttons, of=self, spacing=Space.XS, margins=Space.M)

    def show_chosen(self, chosen: Sequence[RecordingEntry], *, is_idle: bool) -> None:
        """Shows one recording, or how many are selected."""
        self.buttons.show_chosen(chosen, is_idle=is_idle)
        one = chosen[0] if len(chosen) == 1 else None
        self.picture.show_outline(() if one is None else self._outlines.of(one))
        if one is None:
            self.title.setText(tr("{count} selected", count=len(chosen)) if chosen else "")
            for label in self.facts.values():
                label.setText("")
            return
        is_known = one.trouble is None
        self.title.setText(" · ".join(filter(None, (when_text(one), one.module))))
        shown = {
            "port": one.port or "—",
            "duration": stopwatch(one.duration_s) if is_known else "—",
            "samples": f"{one.sample_count:,}" if is_known else "—",
            "size": size_text(one.size_bytes),
            "remarks": one.trouble or remarks(one) or "—",
        }
        for key, text in shown.items():
            self.facts[key].setText(text)

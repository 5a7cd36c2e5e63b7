"""Saves the values and pictures of the plots, and shows the outcome."""

from collections.abc import Callable, Iterable, Iterator
from functools import partial
from pathlib import Path
from typing import Final

from PySide6.QtCore import QBuffer, QByteArray, QIODevice, QRectF, Qt
from PySide6.QtGui import QColor, QImage, QPainter, QPixmap
from PySide6.QtWidgets import QSizePolicy, QToolButton, QWidget

from app.recordings.excerpt import Excerpt, csv_parts, part_count
from app.recordings.recording import write_parts
from app.text.i18n import tr
from app.text.sentences import not_written, saved_text
from ui.core.background_task import Running
from ui.files.file_dialogs import AskPath, ask_path
from ui.services.job_notice import JobNotice
from ui.style.icons import MEANING_ICONS, Icon
from ui.style.theme import IconSize, Meaning, Size, Space, current, font
from ui.widgets.controls import control, named
from ui.widgets.labels import ElidedLabel, IconLabel
from ui.widgets.layouts import in_row, retain_size
from ui.widgets.visibility_timer import VisibilityTimer

_FOOT_PX: Final = 28


def picture_with_footer(pixmap: QPixmap, foot: str) -> QImage:
    ratio = pixmap.devicePixelRatio()
    width, height = pixmap.width() / ratio, pixmap.height() / ratio
    whole = QPixmap(pixmap.width(), pixmap.height() + round(_FOOT_PX * ratio))
    whole.setDevicePixelRatio(ratio)
    whole.fill(QColor(current().window))
    painter = QPainter(whole)
    painter.drawPixmap(0, 0, pixmap)
    painter.setFont(font(Size.SMALL))
    painter.setPen(QColor(current().text))
    room = QRectF(Space.M, height, width - 2 * Space.M, _FOOT_PX)
    painter.drawText(room, Qt.AlignmentFlag.AlignLeft | Qt.AlignmentFlag.AlignVCenter, foot)
    painter.end()
    return whole.toImage()


def png_parts(image: QImage) -> Iterator[bytes]:
    """The PNG file of `image`, encoded lazily. Raises OSError."""
    data = QByteArray()
    buffer = QBuffer(data)
    buffer.open(QIODevice.OpenModeFlag.WriteOnly)
    if not image.save(buffer, "PNG"):  # type: ignore[call-overload]
        raise OSError("the picture could not be encoded as PNG")
    yield bytes(data.data())


class SaveNote(QWidget):
    """Saves values and pictures of plots. Its line, elided in the middle, shows the progress and the outcome."""

    def __init__(self) -> None:
        super().__init__()
        self.ask_path: AskPath = ask_path
        self.job = JobNotice(self)
        self._folder: Path | None = None
        self._icon = IconLabel("live_note_icon", IconSize.TEXT)
        self.label = named(ElidedLabel(Qt.TextElideMode.ElideMiddle), "live_note", "small")
        self.open = control(QToolButton(), "live_note_open", text=tr("Open"))
        self.folder = control(QToolButton(), "live_note_folder", says=tr("Show in folder"), picture=Icon.FOLDER)
        self.open.clicked.connect(lambda: self._choose("open"))
        self.folder.clicked.connect(lambda: self._choose("folder"))
        in_row(self._icon, (self.label, 1), self.open, self.folder, of=self, spacing=Space.XS, margins=0)
        self.setSizePolicy(QSizePolicy.Policy.Ignored, QSizePolicy.Policy.Preferred)
        retain_size(self)
        self.hide()  # until there is something to say
        self.job.changed.connect(self._write)
        VisibilityTimer(self, self._write)

    def save_values(self, place: Path, excerpt: Excerpt, wall_offset_s: float) -> None:
        """Asks for a path beginning with `place`, and writes the table in the background."""
        saved = partial(saved_text, rows=excerpt.row_count, is_whole=excerpt.is_whole)
        parts = csv_parts(excerpt, wall_offset_s=wall_offset_s)
        self._ask(tr("Save values…"), place, parts, part_count(excerpt), saved)

    def save_picture(self, place: Path, picture: QPixmap, foot: str) -> None:
        image = picture_with_footer(picture, foot)
        self._ask(tr("Save picture…"), place, png_parts(image), 1, lambda path: tr("Saved to {path}.", path=path))

    def _ask(self, title: str, place: Path, parts: Iterable[bytes], count: int, saved: Callable[[Path], str]) -> None:
        def save(path: Path) -> None:
            self._folder = path.parent

            def write(running: Running) -> None:
                write_parts(path, parts, count, running.set_progress_or_end)

            def end(_none: None) -> None:
                self.job.notify_saved(path, saved(path))

            self.job.begin(tr("Saving…"), write, end, partial(not_written, path))

        if not self.job.is_writing:
            self.ask_path(self, title, (self._folder or place.parent) / place.name, f"*{place.suffix}", save)

    def _write(self) -> None:
        notice = self.job.result_notice()
        self.label.setText("" if notice is None else notice.text)
        self.setVisible(notice is not None)
        for button in (self.open, self.folder):
            button.setVisible(notice is not None and notice.meaning is Meaning.GOOD)
        if notice is None or notice.meaning is Meaning.INFORMATION:
            self._icon.clear_icon()
        else:
            self._icon.show_icon(MEANING_ICONS[notice.meaning], notice.meaning)

    def _choose(self, key: str) -> None:
        notice = self.job.result_notice()
        for choice in () if notice is None else notice.choices:
            if choice.key == key:
                choice.act()

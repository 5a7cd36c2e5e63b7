"""Saves values and pictures of plots, and shows the outcome."""

from collections.abc import Callable, Iterable, Iterator
from datetime import datetime
from functools import partial
from pathlib import Path
from typing import Final, NamedTuple

from PySide6.QtCore import QBuffer, QByteArray, QIODevice, QRectF, QStandardPaths, Qt
from PySide6.QtGui import QColor, QImage, QPainter, QPixmap
from PySide6.QtWidgets import QPushButton, QSizePolicy, QToolButton, QWidget

from app import version
from app.recordings.excerpt import Excerpt, csv_parts, part_count
from app.recordings.recording import write_parts
from app.text.i18n import tr
from app.text.sentences import not_written, saved_text
from ui.core.background_task import Running
from ui.files.file_dialogs import AskPath, ask_path, default_name
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


class Origin(NamedTuple):
    """The source of the shown data. `wall_offset_s` added to its times gives seconds since 1970; `shown_at` is the end
    of the time line in sight; `module` is its name, or ""."""

    port: str
    baud_rate: int
    wall_offset_s: float
    shown_at: datetime
    module: str = ""


def footer_text(origin: Origin) -> str:
    """Time, module, port and program version."""
    port = f"{origin.port} · {origin.baud_rate} baud" if origin.port else tr("Not connected")
    stamp = origin.shown_at.isoformat(" ", "seconds")
    parts = (stamp, origin.module, port, f"DPS-S Configurator {version()}")
    return "  ·  ".join(part for part in parts if part)


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

    def __init__(self, name: str, *, is_of_module: bool = True) -> None:
        super().__init__()
        self.ask_path: AskPath = ask_path
        self.job = JobNotice(self, is_of_module=is_of_module)
        self._folder: Path | None = None
        self._icon = IconLabel(f"{name}_icon", IconSize.TEXT)
        self.label = named(ElidedLabel(Qt.TextElideMode.ElideMiddle), name, "small")
        self.open = control(QToolButton(), f"{name}_open", text=tr("Open"))
        self.folder = control(QToolButton(), f"{name}_folder", says=tr("Show in folder"), picture=Icon.FOLDER)
        self.open.clicked.connect(lambda: self._choose("open"))
        self.folder.clicked.connect(lambda: self._choose("folder"))
        in_row(self._icon, (self.label, 1), self.open, self.folder, of=self, spacing=Space.XS, margins=0)
        self.setSizePolicy(QSizePolicy.Policy.Ignored, QSizePolicy.Policy.Preferred)
        self.hide()  # until there is something to say
        self.job.changed.connect(self._write)
        VisibilityTimer(self, self._write)

    def save_values(
        self, place: Path, parts: Iterable[bytes], count: int = 1, saved: Callable[[Path], str] | None = None
    ) -> None:
        """Asks for a path beginning with `place`. `parts` is iterated in the background, `count` of them; `saved` makes
        the message."""
        self._ask(tr("Save values…"), place, "*.csv", parts, count, saved)

    def save_picture(self, place: Path, image: QImage) -> None:
        self._ask(tr("Save picture…"), place, "*.png", png_parts(image))

    def _ask(
        self,
        title: str,
        place: Path,
        kinds: str,
        parts: Iterable[bytes],
        count: int = 1,
        saved: Callable[[Path], str] | None = None,
    ) -> None:
        def save(path: Path) -> None:
            self._folder = path.parent

            def write(running: Running) -> None:
                write_parts(path, parts, count, running.set_progress_or_end)

            def end(_none: None) -> None:
                text = tr("Saved to {path}.", path=path) if saved is None else saved(path)
                self.job.notify_saved(path, text)

            self.job.begin(tr("Saving…"), write, end, partial(not_written, path))

        if not self.job.is_writing:
            self.ask_path(self, title, (self._folder or place.parent) / place.name, kinds, save)

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


class SaveBar(QWidget):
    """`take_excerpt` and `take_picture` return what is shown when saving starts, before the file dialog opens."""

    def __init__(
        self,
        *,
        take_excerpt: Callable[[], Excerpt],
        take_picture: Callable[[], QPixmap],
        find_origin: Callable[[], Origin],
    ) -> None:
        super().__init__()
        self.setObjectName("live_save")
        self._take_excerpt, self._take_picture, self._find_origin = take_excerpt, take_picture, find_origin
        self.note = SaveNote("live_note")
        retain_size(self.note)
        self.csv = control(
            QToolButton(),
            "live_save_csv",
            says=tr("Save values…"),
            keys="Ctrl+S",
            picture=Icon.TABLE,
            slot=self.save_csv,
        )
        self.png = control(
            QToolButton(),
            "live_save_png",
            says=tr("Save picture…"),
            keys="Ctrl+Shift+S",
            picture=Icon.CAMERA,
            slot=self.save_png,
        )
        self.stop = control(
            QPushButton(tr("Cancel")), "live_save_cancel", picture=Icon.CROSS, slot=self.note.job.cancel_files
        )
        self.stop.hide()
        self.note.job.changed.connect(self._refresh_buttons)
        in_row((self.note, 1), self.stop, self.csv, self.png, of=self, spacing=Space.S, margins=0)

    def _refresh_buttons(self) -> None:
        self.stop.setVisible(self.note.job.is_writing)
        for button in (self.csv, self.png):
            button.setDisabled(self.note.job.is_writing)

    def save_csv(self) -> None:
        if not self.note.job.is_writing:
            excerpt, origin = self._take_excerpt(), self._find_origin()
            saved = partial(saved_text, rows=excerpt.row_count, is_whole=excerpt.is_whole)
            parts = csv_parts(excerpt, wall_offset_s=origin.wall_offset_s)
            self.note.save_values(_place(origin, ".csv"), parts, part_count(excerpt), saved)

    def save_png(self) -> None:
        if not self.note.job.is_writing:
            origin = self._find_origin()
            image = picture_with_footer(self._take_picture(), footer_text(origin))
            self.note.save_picture(_place(origin, ".png"), image)


def _place(origin: Origin, suffix: str) -> Path:
    documents = QStandardPaths.writableLocation(QStandardPaths.StandardLocation.DocumentsLocation)
    when = datetime.now().astimezone()
    return Path(documents or Path.home()) / default_name(origin.module or origin.port, suffix, when)

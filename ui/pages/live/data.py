"""Data of the Live page: series, limits over time, markers; and how values and pictures are saved."""

from collections import deque
from collections.abc import Callable, Iterable, Iterator
from copy import deepcopy
from functools import partial
from pathlib import Path
from typing import Final

import numpy as np
from PySide6.QtCore import QBuffer, QByteArray, QIODevice, QRectF, Qt
from PySide6.QtGui import QColor, QImage, QPainter, QPixmap
from PySide6.QtWidgets import QSizePolicy, QToolButton, QWidget

from app.engine.conversation import ConversationView
from app.engine.conversation import StatusSample as Status
from app.engine.worker import Batch
from app.limits.limits import LimitsInUse
from app.recordings.excerpt import ACTIVE, TRIGGERED, Excerpt, LimitSteps, Measured, csv_parts, part_count
from app.recordings.markers import (
    Marker,
    MarkerKind,
    MarkerTracker,
    ModuleLimits,
    acting_limits,
    last_limits,
    limits_of,
)
from app.recordings.recording import write_parts
from app.samples.samples import Series
from app.text.i18n import tr
from app.text.messages import not_written, saved_text
from ui.core.background_task import Running
from ui.files.file_dialogs import AskPath, ask_path
from ui.plots.lanes import Lane, Mark, mark_of, measured_lanes
from ui.services.job_notice import JobNotice
from ui.style.icons import MEANING_ICONS, Icon
from ui.style.theme import IconSize, Meaning, Size, Space, current, font
from ui.widgets.controls import ElidedLabel, IconLabel, control, in_row, named, retain_size
from ui.widgets.visibility_timer import VisibilityTimer

# Ten hours, polled once a second.
_SLOW_SAMPLES: Final = 36_000
_MAX_MARKERS: Final = 1000
_RATE_OVER_S: Final = 2.0


class LiveData(Measured):
    """The data of the current session. Samples are added as arrays: a hundred cost about as much as one."""

    tilt: Series
    acceleration: Series
    cell: Series
    light: Series
    charging: Series
    markers: deque[Marker]

    def __init__(self) -> None:
        super().__init__()
        self.tilt = Series()
        self.acceleration = Series()
        self.cell = Series(_SLOW_SAMPLES)
        self.light = Series(_SLOW_SAMPLES)
        self.charging = Series(_SLOW_SAMPLES)
        self.acting = LimitSteps()
        """The limits that the module acts on, as far as that is known."""
        self.unproven = LimitSteps()
        """What was last known of the others: stale, or of a trigger that is not known to be on."""
        self.markers = deque(maxlen=_MAX_MARKERS)
        # One entry for each sample of tilt and acceleration.
        self._flags = Series()
        self._first_s: float | None = None
        self._tracker = MarkerTracker()

    @property
    def has_samples(self) -> bool:
        """The module has reported a status."""
        return self._first_s is not None

    def reset(self) -> None:
        """Discards everything, for another module."""
        for series in (self.tilt, self.acceleration, self.cell, self.light, self.charging, self._flags):
            series.clear()
        self.clear()
        self.acting.clear()
        self.unproven.clear()
        self.markers.clear()
        self._first_s = None
        self._tracker = MarkerTracker()

    def reports_per_s(self, now_s: float) -> float:
        """Status reports per second, streamed or polled, over the last two seconds."""
        return len(self.tilt.window(now_s - _RATE_OVER_S, now_s).time_s) / _RATE_OVER_S

    def on_batch(self, batch: Batch) -> list[Mark]:
        """Adds a batch; returns its events as marks."""
        count = len(self.markers)
        new = self._tracker.on_batch(batch)
        if batch.samples:
            self._add_samples(batch.samples)
        view = batch.conversation
        self._add_slow(view)
        acting = acting_limits(view, batch.at)
        self.put(batch.at, limits_of(view, batch.at))
        self.acting.put(batch.at, acting)
        self.unproven.put(batch.at, _without(last_limits(view), acting))
        self.markers.extend(new)
        # The first connection is the start of the time line, not an event.
        shown = new[1:] if not count and new and new[0].kind is MarkerKind.CONNECTED else new
        return [mark_of(marker) for marker in shown]

    def excerpt(self, start_s: float, end_s: float) -> Excerpt:
        """A copy of all data in a span, both ends included."""
        flags = self._flags.window(start_s, end_s).value.astype(np.uint8)
        oldest_s = self.tilt.first_s
        is_whole = self._first_s is None or start_s >= oldest_s or self._first_s >= oldest_s
        return deepcopy(self._excerpt(start_s, end_s, flags, is_whole=is_whole))

    def _add_samples(self, samples: tuple[Status, ...]) -> None:
        columns = np.array(samples, np.float64).T
        times = columns[0]
        self.tilt.append(times, columns[1])
        self.acceleration.append(times, columns[2])
        self._flags.append(times, columns[3] * TRIGGERED + columns[4] * ACTIVE)
        if self._first_s is None:
            self._first_s = float(times[0])

    def _add_slow(self, device: ConversationView) -> None:
        for series, key in ((self.cell, "cell_voltage_v"), (self.light, "light_v"), (self.charging, "charging")):
            known = device.values.get(key)
            if known is None or known.is_stale:
                continue
            last = series.last
            if last is None and device.ended is not None:
                continue  # it was read before these curves began
            if last is None or known.at > last.time_s:
                series.append(known.at, float(known.value))


def _without(known: ModuleLimits, acting: ModuleLimits) -> ModuleLimits:
    return ModuleLimits(*(old if new is None else None for old, new in zip(known, acting, strict=True)))


def live_lanes(data: LiveData, in_use: LimitsInUse) -> tuple[Lane, ...]:
    return measured_lanes(data, in_use, data.acting, data.unproven)


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

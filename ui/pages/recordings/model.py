"""Table model of the recordings, with sorting and search."""

from collections.abc import Callable
from enum import IntEnum
from typing import Final

from PySide6.QtGui import QIcon

from app.recordings.entry_texts import remarks, size_text
from app.recordings.library import RecordingEntry
from app.text.durations import stopwatch
from app.text.i18n import tr
from protocol.translatable import marked
from ui.forms.table_kit import TableColumn
from ui.style.icons import Icon, icon
from ui.style.theme import Meaning

_OUTLINE_PX: Final = 88


class Column(IntEnum):
    TILT = 0
    WHEN = 1
    MODULE = 2
    PORT = 3
    DURATION = 4
    SAMPLES = 5
    SIZE = 6
    PINNED = 7
    REMARKS = 8


def _if_known(text: Callable[[RecordingEntry], str]) -> Callable[[RecordingEntry], str]:
    return lambda entry: text(entry) if entry.trouble is None else "—"


def _port(entry: RecordingEntry) -> str:
    return entry.port.removeprefix("/dev/")


def _module(entry: RecordingEntry) -> str:
    """Its name; without one the port, which is in the list nowhere else."""
    return entry.module or f"— {_port(entry)}".rstrip()


def _remark_icon(entry: RecordingEntry) -> QIcon | None:
    if entry.trouble is not None or entry.was_cut_off:
        return icon(Icon.WARNING, Meaning.ATTENTION)
    if entry.is_running:
        return icon(Icon.RECORD)
    return icon(Icon.SIMULATOR) if entry.is_simulated else None


def _ink(entry: RecordingEntry) -> Meaning | None:
    return None if entry.trouble is None else Meaning.ATTENTION


COLUMNS: Final = (
    TableColumn[RecordingEntry](
        marked("Tilt"), lambda _entry: "", lambda entry: entry.started_at.timestamp(), fixed_px=_OUTLINE_PX
    ),
    TableColumn[RecordingEntry](
        marked("Time"),
        lambda entry: f"{entry.started_at.astimezone():%Y-%m-%d %H:%M}",
        lambda entry: entry.started_at.timestamp(),
        picture=_remark_icon,
        ink=_ink,
        widest=lambda: "0000-00-00 00:00",
    ),
    TableColumn[RecordingEntry](marked("Module"), _module, ink=_ink, widest=lambda: "M-00", stretches=True),
    TableColumn[RecordingEntry](marked("Port"), lambda entry: _port(entry) or "—", ink=_ink, is_beside=True),
    TableColumn[RecordingEntry](
        marked("Duration"),
        _if_known(lambda entry: stopwatch(entry.duration_s)),
        lambda entry: entry.duration_s,
        is_right=True,
        ink=_ink,
        widest=lambda: "00:00:00",
        is_spare=True,
    ),
    TableColumn[RecordingEntry](
        marked("Samples"),
        _if_known(lambda entry: f"{entry.sample_count:,}"),
        lambda entry: float(entry.sample_count),
        ink=_ink,
        is_beside=True,
    ),
    TableColumn[RecordingEntry](
        marked("Size"),
        lambda entry: size_text(entry.size_bytes),
        lambda entry: float(entry.size_bytes),
        ink=_ink,
        is_beside=True,
    ),
    TableColumn[RecordingEntry](
        marked("Pin"),
        lambda entry: tr("pinned") if entry.is_pinned else "",
        picture=lambda entry: icon(Icon.BOOKMARK) if entry.is_pinned else None,
        ink=_ink,
        widest=str,
    ),
    TableColumn[RecordingEntry](marked("Note"), remarks, ink=_ink, is_beside=True),
)

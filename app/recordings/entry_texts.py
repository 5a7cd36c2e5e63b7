"""Texts of a recording: start, size, remarks."""

import math
from typing import TYPE_CHECKING

from app.text.durations import stopwatch
from app.text.i18n import tr
from app.text.sentences import join_names

if TYPE_CHECKING:  # loads numpy, which would delay the window's first paint
    from app.recordings.library import RecordingEntry


def when_text(entry: "RecordingEntry") -> str:
    """Start in local time."""
    return f"{entry.started_at.astimezone():%Y-%m-%d %H:%M:%S}"


def size_text(size_bytes: float) -> str:
    """Size in powers of 1024: "12 kB", "3.4 MB"."""
    if size_bytes < 1024**2:
        return f"{math.ceil(size_bytes / 1024)} kB"
    if size_bytes < 1024**3:
        megabytes = size_bytes / 1024**2
        return f"{megabytes:.{0 if megabytes >= 100 else 1}f} MB"
    return f"{size_bytes / 1024**3:.1f} GB"


def remarks(entry: "RecordingEntry") -> str:
    if entry.trouble is not None:
        return tr("cannot be read")
    words = (
        (tr("being recorded"), entry.is_running),
        (tr("triggered"), entry.was_triggered),
        (tr("cut off"), entry.was_cut_off),
        (tr("simulated"), entry.is_simulated),
    )
    return " · ".join(word for word, holds in words if holds)


def entry_text(entry: "RecordingEntry") -> str:
    """Description of a recording, for the tooltip and screen readers."""
    if entry.trouble is not None:
        return entry.trouble.translated()
    words = [when_text(entry), entry.module, entry.port, stopwatch(entry.duration_s), size_text(entry.size_bytes)]
    words += [remarks(entry), tr("pinned") if entry.is_pinned else ""]
    return join_names(filter(None, words))

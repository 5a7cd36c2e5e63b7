"""Formats durations."""

from app.text.i18n import tr


def stopwatch(seconds: float) -> str:
    """Whole minutes and seconds, with hours if any: "1:48", "18:12:15"."""
    minutes, rest = divmod(int(seconds), 60)
    hours, minutes = divmod(minutes, 60)
    return f"{hours}:{minutes:02}:{rest:02}" if hours else f"{minutes}:{rest:02}"


def duration(seconds: float) -> str:
    """ "0.4 s", "12 s", "3 min", "2 h"."""
    if seconds < 1.95:  # else "2.0 s" beside "2 s"
        return tr("{value} s", value=f"{max(0.0, seconds):.1f}")
    if seconds < 120:
        return tr("{value} s", value=f"{seconds:.0f}")
    if seconds < 7200:
        return tr("{value:.0f} min", value=seconds / 60)
    return tr("{value:.0f} h", value=seconds / 3600)

"""Formats durations."""


def stopwatch(seconds: float) -> str:
    """Whole minutes and seconds, with hours if any: "1:48", "18:12:15"."""
    minutes, rest = divmod(int(seconds), 60)
    hours, minutes = divmod(minutes, 60)
    return f"{hours}:{minutes:02}:{rest:02}" if hours else f"{minutes}:{rest:02}"

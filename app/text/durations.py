"""Formats durations."""


def stopwatch(seconds: float) -> str:
    """ "1:48", "18:12:15": whole minutes and seconds, with hours where there are any."""
    minutes, rest = divmod(int(seconds), 60)
    hours, minutes = divmod(minutes, 60)
    return f"{hours}:{minutes:02}:{rest:02}" if hours else f"{minutes}:{rest:02}"

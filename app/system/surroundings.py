"""Replaces what the environment says and nobody can work with, so that LOCK and all else go on."""

import os
import time
from collections.abc import Iterator
from datetime import datetime
from pathlib import Path

from app.text.i18n import tr

NO_HOME = os.devnull
"""Not even root can make a folder below it: what would be kept there says so in its own words."""


def mend_surroundings() -> Iterator[str]:
    """Yields a sentence for each thing that was replaced."""
    if not _has_usable_zone():
        zone = os.environ.get("TZ", "")
        os.environ["TZ"] = "UTC"
        if hasattr(time, "tzset"):  # Windows has it from its settings
            time.tzset()
        yield tr("The time zone {zone} (TZ) cannot be used. Times are in UTC.", zone=zone)
    if not _has_home():
        os.environ["HOME"] = NO_HOME
        yield tr("This user has no home folder (HOME), so nothing can be kept there.")


def _has_usable_zone() -> bool:
    try:
        datetime.now().astimezone()
    except ValueError:  # a day or more from UTC
        return False
    return True


def _has_home() -> bool:
    """A container's user may have neither HOME nor an entry among the system's users."""
    try:
        return Path.home().is_absolute()
    except RuntimeError:
        return False

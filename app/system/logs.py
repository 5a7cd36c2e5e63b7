"""One rotating log file in the platform's folder, for the support bundle.

The log never stops the program: where the folder cannot be written, or the disk is full, there is none.
"""

import logging
from contextlib import suppress
from logging.handlers import RotatingFileHandler
from pathlib import Path

from platformdirs import user_log_path

FILE_BYTES = 1_000_000
MAX_FILES = 5  # beside the current one
_FORMAT = "%(asctime)s.%(msecs)03d %(levelname)-7s %(threadName)s %(name)s: %(message)s"


class Log:
    """The running log."""

    def __init__(self, folder: Path | None = None) -> None:
        """Start logging into `folder`, or the platform's. Never raises."""
        self.path = (folder or user_log_path("dps-s-configurator", appauthor=False)) / "dps-s.log"
        self._handler: logging.Handler = logging.NullHandler()
        with suppress(OSError):
            self.path.parent.mkdir(parents=True, exist_ok=True)
            self._handler = RotatingFileHandler(self.path, "a", FILE_BYTES, MAX_FILES, "utf-8", errors="replace")
        self._handler.setFormatter(logging.Formatter(_FORMAT, "%Y-%m-%d %H:%M:%S"))
        logging.raiseExceptions = False  # a full disk neither ends the program nor fills standard error
        root = logging.getLogger()
        root.setLevel(min(root.level or logging.INFO, logging.INFO))
        root.addHandler(self._handler)

    def stop(self) -> None:
        logging.getLogger().removeHandler(self._handler)
        with suppress(OSError):  # the last lines do not fit on a full disk
            self._handler.close()

    def text(self) -> str:
        """The current file, which may begin with earlier runs; empty where there is none. Never raises."""
        with suppress(OSError), self.path.open(encoding="utf-8", errors="replace") as file:
            return file.read(FILE_BYTES)
        return ""

"""One rotating log file in the platform's folder, and its last lines in memory, for the support bundle.

The log never stops the program: where the folder cannot be written, or the disk is full, only memory has the lines.
"""

import logging
import os
from collections import deque
from contextlib import suppress
from logging.handlers import RotatingFileHandler
from pathlib import Path

from platformdirs import user_log_path

FILE_BYTES = 1_000_000
MAX_FILES = 5  # beside the current one
MAX_LINES = 2000
_FORMAT = "%(asctime)s.%(msecs)03d %(levelname)-7s %(threadName)s %(name)s: %(message)s"
_log = logging.getLogger(__name__)


class Log(logging.Handler):
    """The running log, which holds the last lines. `trouble` is why there is no file."""

    def __init__(self, folder: Path | None = None) -> None:
        """Start logging into `folder`, or the platform's. Never raises."""
        super().__init__()
        self.path = (folder or user_log_path("dps-s-configurator", appauthor=False)) / "dps-s.log"
        self.trouble: OSError | None = None
        self._lines: deque[str] = deque(maxlen=MAX_LINES)
        self._handlers: list[logging.Handler] = [self]
        try:
            self.path.parent.mkdir(parents=True, exist_ok=True)
            self._handlers.append(RotatingFileHandler(self.path, "a", FILE_BYTES, MAX_FILES, "utf-8", errors="replace"))
        except OSError as error:
            self.trouble = error
        logging.raiseExceptions = False  # a full disk neither ends the program nor fills standard error
        root = logging.getLogger()
        root.setLevel(min(root.level or logging.INFO, logging.INFO))
        for handler in self._handlers:
            handler.setFormatter(logging.Formatter(_FORMAT, "%Y-%m-%d %H:%M:%S"))
            root.addHandler(handler)
        if self.trouble is not None:
            _log.warning("There is no log file: %s", self.trouble)

    def emit(self, record: logging.LogRecord) -> None:
        self._lines.append(self.format(record))

    def stop(self) -> None:
        for handler in self._handlers:
            logging.getLogger().removeHandler(handler)
            with suppress(OSError):  # the last lines do not fit on a full disk
                handler.close()

    def text(self, longest_bytes: int = FILE_BYTES) -> str:
        """The end of the file, which may be of earlier runs, or what is in memory. Never raises."""
        with suppress(OSError), self.path.open("rb") as file:
            size = file.seek(0, os.SEEK_END)
            file.seek(max(0, size - longest_bytes))
            text = file.read(longest_bytes).decode("utf-8", "replace").replace("\r\n", "\n")
            if not self._lines or self._lines[-1] in text:  # else it is not written any more
                return text if size <= longest_bytes else text.partition("\n")[2]
        return "".join(f"{line}\n" for line in self._lines.copy())

"""One rotating log file in the platform's folder, and its last lines in memory, for the support bundle.

The log never stops the program: where the folder cannot be written, the disk is full, or another copy of the program
writes the file, `Log.trouble` says so, and only memory has the lines.
"""

import contextlib
import logging
import os
import sys
from collections import deque
from logging.handlers import RotatingFileHandler
from pathlib import Path
from typing import IO

from platformdirs import user_log_path

from app.system.files import lock

FILE_BYTES = 1_000_000
MAX_FILES = 5  # beside the current one
MAX_LINES = 2000
_FORMAT = "%(asctime)s.%(msecs)03d %(levelname)-7s %(threadName)s %(name)s: %(message)s"
_log = logging.getLogger(__name__)


class Log(logging.Handler):
    """The running log, which holds the last lines. `trouble` is why there is no file, or it is no longer written."""

    def __init__(self) -> None:
        super().__init__()
        self.path: Path | None = None
        self.trouble: BaseException | None = None
        self._lines: deque[str] = deque(maxlen=MAX_LINES)
        self._file: _File | None = None
        self._held: IO[bytes] | None = None

    def start(self, folder: Path) -> None:
        root = logging.getLogger()
        root.setLevel(min(root.level or logging.INFO, logging.INFO))
        self.setFormatter(logging.Formatter(_FORMAT, "%Y-%m-%d %H:%M:%S"))
        root.addHandler(self)
        try:
            folder.mkdir(parents=True, exist_ok=True)
            self._held = (folder / "dps-s.lock").open("ab")
            lock(self._held)  # two copies would rotate each other's lines away
            self._file = _File(folder / "dps-s.log", self)
        except OSError as error:
            self.trouble = error
            _log.warning("There is no log file: %s", error)
            return
        self.path = folder / "dps-s.log"
        self._file.setFormatter(self.formatter)
        root.addHandler(self._file)

    def emit(self, record: logging.LogRecord) -> None:
        self._lines.append(self.format(record))

    def stop(self) -> None:
        for handler in (self, self._file):
            if handler is not None:
                logging.getLogger().removeHandler(handler)
                handler.close()
        if self._held is not None:
            self._held.close()

    def in_memory(self) -> str:
        return "".join(f"{line}\n" for line in self._lines.copy())

    def text(self, longest_bytes: int = FILE_BYTES) -> str:
        """Return the end of the file, which may be of earlier runs, or what is in memory. Never raises."""
        if self.path is not None and self.trouble is None:
            with contextlib.suppress(OSError), self.path.open("rb") as file:
                size = file.seek(0, os.SEEK_END)
                file.seek(max(0, size - longest_bytes))
                text = file.read(longest_bytes).decode("utf-8", "replace").replace("\r\n", "\n")
                return text if size <= longest_bytes else text.partition("\n")[2]
        return self.in_memory()


class _File(RotatingFileHandler):
    """The file ends at the first error, for example a full disk."""

    def __init__(self, path: Path, log: Log) -> None:
        super().__init__(path, maxBytes=FILE_BYTES, backupCount=MAX_FILES, encoding="utf-8", errors="replace")
        self._log = log

    def emit(self, record: logging.LogRecord) -> None:
        if self._log.trouble is None:
            super().emit(record)

    def handleError(self, record: logging.LogRecord) -> None:  # noqa: ARG002  its base names it
        self._log.trouble = sys.exc_info()[1]
        _log.warning("The log file is no longer written: %s", self._log.trouble)

    def close(self) -> None:
        with contextlib.suppress(OSError):  # the last lines do not fit on a full disk
            super().close()


def start_log(folder: Path | None = None) -> Log:
    """Start logging into `folder`, or the platform's. Never raises."""
    log = Log()
    log.start(folder or user_log_path("dps-s-configurator", appauthor=False))
    return log

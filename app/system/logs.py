"""One rotating log file in the platform's folder, and its last lines in memory, for the support bundle.

The log never stops the program: where the folder cannot be written, the disk is full, or another copy of the program
writes the file, `Log.trouble` says so, and only memory has the lines.
"""

import contextlib
import logging
import os
import sys
from collections import deque
from collections.abc import Callable
from dataclasses import dataclass, field
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


class Recent(logging.Handler):
    """Holds the last lines."""

    def __init__(self) -> None:
        super().__init__()
        self._lines: deque[str] = deque(maxlen=MAX_LINES)

    def emit(self, record: logging.LogRecord) -> None:
        self._lines.append(self.format(record))

    def text(self) -> str:
        return "".join(f"{line}\n" for line in self._lines.copy())


class _File(RotatingFileHandler):
    """Ends at the first error, for example a full disk, and tells it."""

    def __init__(self, path: Path, on_error: Callable[[BaseException | None], None]) -> None:
        super().__init__(path, maxBytes=FILE_BYTES, backupCount=MAX_FILES, encoding="utf-8", errors="replace")
        self._on_error = on_error
        self._is_broken = False

    def emit(self, record: logging.LogRecord) -> None:
        if not self._is_broken:
            super().emit(record)

    def handleError(self, record: logging.LogRecord) -> None:  # noqa: ARG002  its base names it
        self._is_broken = True
        self._on_error(sys.exc_info()[1])

    def close(self) -> None:
        with contextlib.suppress(OSError):  # the last lines do not fit on a full disk
            super().close()


@dataclass(slots=True)
class Log:
    """The running log. `trouble` is why there is no file, or why it is no longer written."""

    recent: Recent = field(default_factory=Recent)
    path: Path | None = None
    trouble: BaseException | None = None
    _file: _File | None = None
    _held: IO[bytes] | None = None

    def start(self, folder: Path) -> None:
        _add(self.recent)
        try:
            folder.mkdir(parents=True, exist_ok=True)
            self._held = (folder / "dps-s.lock").open("ab")
            lock(self._held)  # two copies would rotate each other's lines away
            self._file = _File(folder / "dps-s.log", self._lose_file)
        except OSError as error:
            self.trouble = error
            _log.warning("There is no log file: %s", error)
            return
        self.path = folder / "dps-s.log"
        _add(self._file)

    def stop(self) -> None:
        for handler in filter(None, (self.recent, self._file)):
            logging.getLogger().removeHandler(handler)
            handler.close()
        if self._held is not None:
            self._held.close()

    def _lose_file(self, error: BaseException | None) -> None:
        self.trouble = error
        text = "The log file is no longer written: %s"
        self.recent.handle(logging.LogRecord(__name__, logging.WARNING, __file__, 0, text, (error,), None))


def _add(handler: logging.Handler) -> None:
    handler.setFormatter(logging.Formatter(_FORMAT, "%Y-%m-%d %H:%M:%S"))
    logging.getLogger().addHandler(handler)


def start_log(folder: Path | None = None) -> Log:
    """Start logging into `folder`, or the platform's. Never raises."""
    root = logging.getLogger()
    root.setLevel(min(root.level or logging.INFO, logging.INFO))
    log = Log()
    log.start(folder or user_log_path("dps-s-configurator", appauthor=False))
    return log


def text_of(log: Log, *, longest_bytes: int = FILE_BYTES) -> str:
    """Return the end of the file, which may be of earlier runs, or what is in memory. Never raises."""
    if log.path is not None and log.trouble is None:
        with contextlib.suppress(OSError), log.path.open("rb") as file:
            size = file.seek(0, os.SEEK_END)
            file.seek(max(0, size - longest_bytes))
            text = file.read(longest_bytes).decode("utf-8", "replace").replace("\r\n", "\n")
            return text if size <= longest_bytes else text.partition("\n")[2]
    return log.recent.text()

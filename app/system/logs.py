"""Rotating log file in the platform's folder, with the last lines in memory for the support bundle.

The log never stops the program: if the folder cannot be written, the disk is full, or another instance uses the file,
this is reported once (`Log.trouble`) and logging continues in memory or in another file.
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

APP_NAME = "dps-s"
FILE_BYTES = 1_000_000
MAX_FILES = 5
"""In addition to the current one."""
MAX_LINES = 2000
MAX_COPIES = 8
"""Instances that run at the same time, each with its own file."""
_FORMAT = "%(asctime)s.%(msecs)03d %(levelname)-7s %(threadName)s %(name)s: %(message)s"
_DATE_FORMAT = "%Y-%m-%d %H:%M:%S"
_log = logging.getLogger(__name__)


class Recent(logging.Handler):
    """Holds the last lines. `text` is thread-safe."""

    def __init__(self, kept: int = MAX_LINES) -> None:
        super().__init__()
        self._lines: deque[str] = deque(maxlen=kept)

    def emit(self, record: logging.LogRecord) -> None:
        self._lines.append(self.format(record))

    def text(self) -> str:
        with contextlib.nullcontext() if self.lock is None else self.lock:
            return "".join(f"{line}\n" for line in self._lines)


class _File(RotatingFileHandler):
    """Stops at the first error, for example a full disk, and passes it to `on_error`."""

    def __init__(self, path: Path, on_error: Callable[[OSError], None]) -> None:
        super().__init__(path, maxBytes=FILE_BYTES, backupCount=MAX_FILES, encoding="utf-8", errors="replace")
        self._on_error = on_error
        self._is_broken = False

    def emit(self, record: logging.LogRecord) -> None:
        if not self._is_broken:
            super().emit(record)

    def handleError(self, record: logging.LogRecord) -> None:  # noqa: ARG002  its base names it
        error = sys.exc_info()[1]
        self._is_broken = True
        self._on_error(error if isinstance(error, OSError) else OSError(str(error)))

    def close(self) -> None:
        with contextlib.suppress(OSError):  # the last lines do not fit on a full disk
            super().close()


@dataclass(slots=True)
class Log:
    """The running log. Made by `start_log`; ended by `stop`."""

    recent: Recent
    path: Path | None = None
    trouble: OSError | None = None
    """Why there is no file, or why writing it has stopped."""
    _handlers: list[logging.Handler] = field(default_factory=list)
    _lock_file: IO[bytes] | None = None

    def stop(self) -> None:
        """Idempotent."""
        root = logging.getLogger()
        handlers, self._handlers = self._handlers, []
        for handler in handlers:
            root.removeHandler(handler)
            handler.close()
        lock_file, self._lock_file = self._lock_file, None
        if lock_file is not None:
            lock_file.close()

    def _lose_file(self, error: OSError) -> None:
        self.trouble = error
        text = "The log file is no longer written: %s"
        self.recent.handle(logging.LogRecord(__name__, logging.WARNING, __file__, 0, text, (error,), None))


def start_log(folder: Path | None = None) -> Log:
    """Start logging into `folder` or the platform's log folder. Never raises."""
    formatter = logging.Formatter(_FORMAT, _DATE_FORMAT)
    log = Log(Recent())
    log.recent.setFormatter(formatter)
    handlers: list[logging.Handler] = [log.recent]
    try:
        folder = folder or user_log_path("dps-s-configurator", appauthor=False)
        folder.mkdir(parents=True, exist_ok=True)
        path, log._lock_file = _own_file(folder)
        handler = _File(path, log._lose_file)
        handler.setFormatter(formatter)
        handlers.append(handler)
        log.path = path
    except OSError as error:
        log.trouble = error
    root = logging.getLogger()
    root.setLevel(min(root.level or logging.INFO, logging.INFO))
    for handler_ in handlers:
        root.addHandler(handler_)
    log._handlers = handlers
    if log.trouble is not None:
        _log.warning("There is no log file: %s", log.trouble)
    return log


def _own_file(folder: Path) -> tuple[Path, IO[bytes]]:
    """A file that no other instance writes: two instances would rotate each other's lines away."""
    for number in range(1, MAX_COPIES + 1):
        name = APP_NAME if number == 1 else f"{APP_NAME}-{number}"
        lock_file = (folder / f"{name}.lock").open("ab")
        try:
            lock(lock_file)
        except OSError:
            lock_file.close()
        else:
            return folder / f"{name}.log", lock_file
    raise OSError(f"{MAX_COPIES} copies of the program run already")


def text_of(log: Log, *, longest_bytes: int = FILE_BYTES) -> str:
    """The last lines of the file, including earlier runs, or those in memory. Never raises."""
    if log.path is not None and log.trouble is None:
        with contextlib.suppress(OSError), log.path.open("rb") as file:
            size = file.seek(0, os.SEEK_END)
            file.seek(max(0, size - longest_bytes))
            text = file.read(longest_bytes).decode("utf-8", "replace").replace("\r\n", "\n")
            return text if size <= longest_bytes else text.partition("\n")[2]
    return log.recent.text()

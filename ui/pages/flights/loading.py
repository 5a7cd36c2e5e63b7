"""Reads flight logs in the background with progress and cancel."""

from collections import deque
from pathlib import Path
from typing import NamedTuple

from PySide6.QtCore import QObject, Signal

from app.flight_analysis.many_logs import LogOrder, SummarisedLog, summarise_logs
from app.flight_logs.csv_columns import CsvColumns
from app.flight_logs.csv_log import read_head
from app.flight_logs.flight_log import LogFormat
from app.flight_logs.read_log import find_logs, format_of
from app.text.sentences import error_text
from app.text.user_error import UserError
from ui.core.background_task import BackgroundTask, Running


class LoadedLog(NamedTuple):
    """`head`: column names of a CSV file that could not be read; else empty."""

    log: SummarisedLog
    columns: CsvColumns | None
    head: tuple[str, ...] = ()


class LoadOrder(NamedTuple):
    """Files and folders. `columns`: of CSV files; None recognises them by name."""

    paths: tuple[Path, ...]
    columns: CsvColumns | None = None
    skipped: frozenset[str] = frozenset()
    """Names of flights that are already read."""


class LoadEnded(NamedTuple):
    """`total` is None where it was cancelled before the files were counted."""

    read: int
    total: int | None
    was_cancelled: bool = False
    why: str = ""
    """An error of the operating system."""


class _Progress:
    """Written by the reading thread, read by the window's."""

    def __init__(self) -> None:
        self.total: int | None = None
        self.done: deque[LoadedLog] = deque()


class FlightLoading(QObject):
    """Processes orders one after another; `poll` returns the logs read since."""

    ended = Signal(object)
    """`LoadEnded`."""

    def __init__(self, parent: QObject) -> None:
        super().__init__(parent)
        self._task: BackgroundTask[None] = BackgroundTask("dps-s flights", self)
        self._waiting: deque[LoadOrder] = deque()
        self._progress = _Progress()
        self._ready: list[LoadedLog] = []
        self.read = 0
        """Logs read of the current or last order."""

    @property
    def is_running(self) -> bool:
        return self._task.is_running

    @property
    def total(self) -> int | None:
        """Logs of the current order; None until they are counted."""
        return self._progress.total

    @property
    def share(self) -> float | None:
        """How much of the log that is being read is read; None if unknown."""
        return self._task.share

    def open(self, order: LoadOrder) -> None:
        self._waiting.append(order)
        if not self.is_running:
            self._begin()

    def cancel(self) -> None:
        """Returns at once; logs already read stay, logs being read are dropped."""
        if not self.is_running:
            return
        self._waiting.clear()
        self._task.cancel()
        self._end(was_cancelled=True)
        self._progress = _Progress()  # discards what the thread still reads

    def poll(self) -> list[LoadedLog]:
        """The logs read since the last call."""
        self._collect()
        ready, self._ready = self._ready, []
        return ready

    def _begin(self) -> None:
        order, progress = self._waiting.popleft(), _Progress()
        self._progress, self.read = progress, 0

        def work(running: Running) -> None:
            paths = [path for path in find_logs(order.paths) if str(path) not in order.skipped]
            progress.total = len(paths)
            for log in summarise_logs(
                paths, LogOrder(order.columns), is_cancelled=running.is_cancelled, on_progress=running.set_progress
            ):
                running.share = None
                progress.done.append(LoadedLog(log, order.columns, () if log.flight else _head_of(log.path)))

        self._task.run(work, lambda _none: self._end(), lambda error: self._end(error=error))

    def _collect(self) -> None:
        done = self._progress.done
        while done:
            self._ready.append(done.popleft())
            self.read += 1

    def _end(self, *, was_cancelled: bool = False, error: Exception | None = None) -> None:
        self._collect()
        why = "" if error is None else error_text(error)
        self.ended.emit(LoadEnded(self.read, self.total, was_cancelled, why))
        if self._waiting:
            self._begin()
        if error is not None and not isinstance(error, OSError):
            raise error


def _head_of(path: Path) -> tuple[str, ...]:
    """Column names of a CSV file; empty for other files."""
    try:
        return tuple(read_head(path)) if format_of(path) is LogFormat.CSV else ()
    except (UserError, OSError):
        return ()

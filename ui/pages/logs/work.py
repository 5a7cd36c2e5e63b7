"""What the Logs page works on: recordings and flight logs, read in the background, thresholds and proposal.

It never sends anything to a module.
"""

from collections import deque
from collections.abc import Iterable
from datetime import UTC, datetime
from pathlib import Path
from typing import NamedTuple

from PySide6.QtCore import QObject, Signal

from app.flights.judge import TriggerLimits
from app.flights.judging import FlightGroup, FlightOutcome, FlightSummary, ThresholdProposal, propose
from app.flights.read_log import distinct_names, find_logs, summarise_logs
from app.flights.table import CsvColumns
from app.recordings.library import RecordingEntry, RecordingLibrary
from app.text.messages import UserMessage, error_text
from ui.core.background_task import BackgroundTask, Running


class LogFile(NamedTuple):
    """A file that was opened, or is to be: then it has neither a flight nor a reason why not."""

    # Its path.
    name: str
    group: FlightGroup = FlightGroup.UNSORTED
    # With which a table was read; None: recognised by name.
    columns: CsvColumns | None = None
    flight: FlightSummary | None = None
    # Why it could not be read.
    why_not: UserMessage | None = None
    # Column names of a table that could not be read.
    head: tuple[str, ...] = ()
    # When the file was last changed.
    changed_at: datetime | None = None

    @property
    def is_waiting(self) -> bool:
        return self.flight is None and self.why_not is None


class LogRow(NamedTuple):
    """A line of the list: a log, a recording in the library, or both."""

    name: str
    # By which it can be told from the others.
    label: str
    # Waits as long as a recording was not read.
    log: LogFile
    entry: RecordingEntry | None
    # Of its flight with the chosen thresholds.
    outcome: FlightOutcome | None

    @property
    def why_not(self) -> UserMessage | None:
        """Why it could not be read."""
        return self.log.why_not or (None if self.entry is None else self.entry.trouble)


class Reading:
    """Files and folders to read. `names`, `total` and `done` are written by the reading thread."""

    def __init__(
        self, paths: Iterable[Path] = (), columns: CsvColumns | None = None, skipped: Iterable[str] = ()
    ) -> None:
        """`skipped`: what is already read."""
        self._paths, self._columns, self._skipped = tuple(paths), columns, frozenset(skipped)
        # None until they are counted.
        self.total: int | None = None
        self.names: tuple[str, ...] = ()
        self.done: deque[LogFile] = deque()
        # Of `done`, what was taken over.
        self.read = 0
        self.was_cancelled = False
        # An error of the operating system.
        self.why = ""

    def run(self, running: Running) -> None:
        found = list(find_logs(self._paths))
        self.names = tuple(map(str, found))
        paths = [path for path in found if str(path) not in self._skipped]
        self.total = len(paths)
        for path, flight, why_not, head in summarise_logs(paths, self._columns, is_cancelled=running.is_cancelled):
            try:
                changed_at = datetime.fromtimestamp(path.stat().st_mtime, UTC)
            except (OSError, ValueError):  # it is in an archive, or gone
                changed_at = None
            group = FlightGroup.UNSORTED
            self.done.append(LogFile(str(path), group, self._columns, flight, why_not, head, changed_at))


class LogsWork(QObject):
    """Reads orders one after another, and keeps what was read. `loading_ended` has the `Reading`."""

    changed = Signal()
    loading_ended = Signal(object)

    def __init__(self, library: RecordingLibrary, parent: QObject) -> None:
        super().__init__(parent)
        self.library = library
        self.entries: tuple[RecordingEntry, ...] = ()
        self._is_list_old = False
        self.listing: BackgroundTask[tuple[RecordingEntry, ...]] = BackgroundTask("dps-s recordings", self)
        self.logs: dict[str, LogFile] = {}
        self.limits = TriggerLimits()
        self.proposal: ThresholdProposal | None = None
        # The present one, or the last.
        self.loading = Reading()
        self._orders: deque[Reading] = deque()
        self.task: BackgroundTask[None] = BackgroundTask("dps-s logs", self)
        self.proposing: BackgroundTask[ThresholdProposal] = BackgroundTask("dps-s thresholds", self)

    def side(self, group: FlightGroup) -> list[FlightSummary]:
        """Without what could not be read."""
        return [log.flight for log in self.logs.values() if log.group is group and log.flight is not None]

    def unread(self) -> list[LogFile]:
        return [log for log in self.logs.values() if log.why_not is not None]

    def rows(self) -> list[LogRow]:
        entries = {str(entry.path): entry for entry in self.entries}
        read = (log.name for log in self.logs.values() if not log.is_waiting)
        names = list(dict.fromkeys((*entries, *read)))
        rows = []
        for name, label in zip(names, distinct_names([Path(name) for name in names]), strict=True):
            log, entry = self.logs.get(name, LogFile(name)), entries.get(name)
            outcome = None if log.flight is None else log.flight.outcome(self.limits)
            of_module = "" if entry is None else entry.module or entry.port.removeprefix("/dev/")
            rows.append(LogRow(name, of_module or label, log, entry, outcome))
        return rows

    def list_again(self) -> None:
        """The recordings."""
        self._is_list_old = self.listing.is_running  # the running one may miss what changed since it began
        if not self._is_list_old:
            self.listing.run(lambda _running: self.library.entries(), self._on_list)

    def _on_list(self, entries: tuple[RecordingEntry, ...]) -> None:
        if entries != self.entries:
            self.entries = entries
            self.changed.emit()
        if self._is_list_old:
            self.list_again()

    # Reading

    def open(self, paths: Iterable[Path], columns: CsvColumns | None = None) -> None:
        """Reads files and folders, without logs that are already there; a recording may have grown."""
        recordings = {str(entry.path) for entry in self.entries}
        read = [log.name for log in self.logs.values() if log.flight is not None and log.name not in recordings]
        self._orders.append(Reading(paths, columns, read))
        if not self.task.is_running:
            self._begin(self._orders.popleft())

    def poll(self) -> None:
        """Takes over the logs that were read since."""
        done = self.loading.done
        if not done:
            return
        while done:
            log = done.popleft()
            known = self.logs.get(log.name, log)
            self.logs[log.name] = log._replace(group=known.group)
            self.loading.read += 1
        self.changed.emit()

    def cancel(self) -> None:
        """Returns at once; logs already read stay, logs being read are dropped."""
        if self.task.is_running:
            self._orders.clear()
            self.task.cancel()
            self.loading.was_cancelled = True
            self._end()

    def _begin(self, reading: Reading) -> None:
        self.loading = reading
        self.task.run(reading.run, lambda _none: self._end(), self._end)

    def _end(self, error: Exception | None = None) -> None:
        self.poll()
        ended, self.loading = self.loading, Reading()  # what its thread still reads is discarded
        self._change()
        if error is not None:
            ended.why = error_text(error)
        self.loading_ended.emit(ended)
        if self._orders:
            self._begin(self._orders.popleft())
        if error is not None and not isinstance(error, OSError):
            raise error

    # What a person chooses

    def choose(self, limits: TriggerLimits) -> None:
        if limits != self.limits:
            self.limits = limits
            self.changed.emit()

    def move(self, names: Iterable[str], group: FlightGroup) -> None:
        """Puts logs on a side; a recording that was not read yet is read for it."""
        for name in names:
            self.logs[name] = self.logs.get(name, LogFile(name))._replace(group=group)
        self._change()
        waiting = [Path(log.name) for log in self.logs.values() if log.is_waiting]
        if waiting:
            self.open(waiting)

    def remove(self, names: Iterable[str]) -> None:
        """Removes logs from the list; the files stay."""
        for name in names:
            self.logs.pop(name, None)
        self._change()

    def _change(self) -> None:
        self.proposal = None
        sides = self.side(FlightGroup.MUST_NOT), self.side(FlightGroup.MUST)
        if any(sides):
            self.proposing.run(lambda _running: propose(*sides), self._on_proposal)
        else:
            self.proposing.cancel()
        self.changed.emit()

    def _on_proposal(self, proposal: ThresholdProposal) -> None:
        self.proposal = proposal
        self.changed.emit()

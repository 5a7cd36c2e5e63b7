"""Controller of the Flight logs page: flights, lists, thresholds and proposal. It never sends anything."""

from collections import deque
from collections.abc import Iterable, Mapping
from dataclasses import replace
from pathlib import Path
from typing import Final, NamedTuple

from PySide6.QtCore import QObject, Signal

from app.firing.judge import TriggerLimits
from app.flight_analysis.curves import steps_of
from app.flight_analysis.fire_map import FireMap, FlightGroup, FlightOutcome, fire_map, outcome_of
from app.flight_analysis.many_logs import LogOrder, SummarisedLog, summarise_logs
from app.flight_analysis.proposal import ThresholdProposal, propose, settings_of
from app.flight_analysis.summary import FlightSummary
from app.flight_logs.csv_columns import CsvColumns
from app.flight_logs.csv_log import read_head
from app.flight_logs.module_view import RuleReading
from app.flight_logs.read_log import LogFormat, find_logs, format_of
from app.text.messages import UserMessage
from app.text.sentences import error_text
from app.text.user_error import UserError
from protocol.catalogue import TENTH_G
from protocol.fields import Value
from ui.core.background_task import BackgroundTask, Running

GROUPS: Final = (FlightGroup.MUST_NOT, FlightGroup.MUST)


class UnreadLog(NamedTuple):
    """A file that could not be read. `head`: see `LoadedLog`."""

    name: str
    group: FlightGroup
    why: UserMessage
    head: tuple[str, ...] = ()


class FlightRow(NamedTuple):
    """A line of a list; `outcome` is None where the file could not be read."""

    name: str
    group: FlightGroup
    outcome: FlightOutcome | None
    longest_fall_s: float
    """Below the chosen acceleration; -1 where there is none."""
    unread: UnreadLog | None = None


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


class FlightsWork(QObject):
    flights_changed = Signal()
    """Flights were added, removed or moved."""
    thresholds_changed = Signal()
    proposal_changed = Signal()
    loading_ended = Signal(object)
    """`LoadEnded`."""

    def __init__(self, parent: QObject) -> None:
        super().__init__(parent)
        self.flights: dict[str, FlightSummary] = {}
        """By name."""
        self.limits = TriggerLimits()
        self.reading = RuleReading.DIRECT
        """Of the map; lists and proposal use both."""
        self.proposal: ThresholdProposal | None = None
        self.loading = FlightLoading(self)
        self.loading.ended.connect(self._end_loading)
        self._maps: tuple[FireMap, FireMap] | None = None
        self._maps_of: tuple[float, RuleReading] | None = None
        self._unread: dict[str, UnreadLog] = {}
        self._sides: dict[str, FlightGroup] = {}
        """The list of each flight, also of those that are still to be read."""
        self._columns: dict[str, CsvColumns | None] = {}
        self._proposing: BackgroundTask[ThresholdProposal] = BackgroundTask("dps-s thresholds", self)

    @property
    def is_empty(self) -> bool:
        return not self.flights and not self._unread

    @property
    def is_proposing(self) -> bool:
        return self._proposing.is_running

    def sorted_flights(self) -> tuple[list[FlightSummary], list[FlightSummary]]:
        """Flights that must not and that must fire; without unreadable files."""
        sides: dict[FlightGroup, list[FlightSummary]] = {group: [] for group in GROUPS}
        for name, flight in self.flights.items():
            sides[self._sides[name]].append(flight)
        return sides[FlightGroup.MUST_NOT], sides[FlightGroup.MUST]

    def unread(self) -> tuple[UnreadLog, ...]:
        return tuple(self._unread.values())

    def columns_of(self, name: str) -> CsvColumns | None:
        """The columns with which it was read."""
        return self._columns.get(name)

    def outcomes(self) -> tuple[FlightOutcome, ...]:
        return tuple(outcome_of(flight, self._sides[name], self.limits) for name, flight in self.flights.items())

    def rows(self, outcomes: Iterable[FlightOutcome]) -> dict[FlightGroup, list[FlightRow]]:
        """Rows by list, unreadable files first."""
        rows: dict[FlightGroup, list[FlightRow]] = {group: [] for group in GROUPS}
        for unread in self._unread.values():
            rows[unread.group].append(FlightRow(unread.name, unread.group, None, -1.0, unread))
        step = steps_of(self.limits.freefall_acceleration_g, TENTH_G.per_unit)
        for outcome in outcomes:
            fall_s = float(outcome.flight.direct.longest_fall_s[step])
            rows[outcome.group].append(FlightRow(outcome.flight.name, outcome.group, outcome, fall_s))
        return rows

    def maps(self) -> tuple[FireMap, FireMap]:
        """Maps of the chosen reading and of the other one, cached."""
        key = (self.limits.freefall_acceleration_g, self.reading)
        if self._maps is None or self._maps_of != key:
            other = RuleReading.DAMPED if self.reading is RuleReading.DIRECT else RuleReading.DIRECT
            flights = self.sorted_flights()
            self._maps = fire_map(*flights, self.limits, self.reading), fire_map(*flights, self.limits, other)
            self._maps_of = key
        return self._maps

    def settings(self) -> Mapping[str, Value]:
        """The chosen thresholds by key of the setting."""
        return settings_of(self.limits)

    def open(self, paths: Iterable[Path], columns: CsvColumns | None = None) -> None:
        """Reads files and folders, without flights that are already there."""
        self.loading.open(LoadOrder(tuple(paths), columns, frozenset(self.flights)))

    @property
    def kept_lists(self) -> tuple[str, ...]:
        """For the next start: the list and the path of each flight."""
        return tuple(f"{group.name} {name}" for name, group in self._sides.items())

    def restore(self, kept: Iterable[str]) -> None:
        """Reads the flights of the last start into their lists."""
        for line in kept:
            word, _, name = line.partition(" ")
            self._sides[name] = FlightGroup.MUST if word == FlightGroup.MUST.name else FlightGroup.MUST_NOT
        if self._sides:
            self.open(map(Path, self._sides))

    def poll(self) -> None:
        """Takes over the logs that were read since."""
        logs = self.loading.poll()
        if logs:
            for log in logs:
                self._on_loaded(log)
            self._maps = None
            self.flights_changed.emit()

    def choose(self, limits: TriggerLimits) -> None:
        if limits != self.limits:
            self.limits = limits
            self.thresholds_changed.emit()

    def choose_values(self, **values: float) -> None:
        """Changes some thresholds, by field of `TriggerLimits`."""
        self.choose(replace(self.limits, **values))  # type: ignore[arg-type]

    def choose_reading(self, reading: RuleReading) -> None:
        if reading is not self.reading:
            self.reading = reading
            self.thresholds_changed.emit()

    def move(self, names: Iterable[str], group: FlightGroup) -> None:
        for name in names:
            self._sides[name] = group
            if name in self._unread:
                self._unread[name] = self._unread[name]._replace(group=group)
        self._change()

    def remove(self, names: Iterable[str]) -> None:
        """Removes flights from the page; the files stay."""
        for name in names:
            self._columns.pop(name, None)
            self._sides.pop(name, None)
            self._unread.pop(name, None)
            self.flights.pop(name, None)
        self._change()

    def _on_loaded(self, loaded: LoadedLog) -> None:
        name, flight, why = str(loaded.log.path), loaded.log.flight, loaded.log.why_not
        self._unread.pop(name, None)
        group = self._sides.setdefault(name, FlightGroup.MUST_NOT)
        self._columns[name] = loaded.columns
        if flight is not None:
            self.flights[name] = flight
        elif why is not None:
            self._unread[name] = UnreadLog(name, group, why, loaded.head)

    def _end_loading(self, ended: LoadEnded) -> None:
        self.poll()
        self._change()
        self.loading_ended.emit(ended)

    def _change(self) -> None:
        self._maps = None
        self._propose()
        self.flights_changed.emit()

    def _propose(self) -> None:
        self.proposal = None
        if not self.flights:
            self._proposing.cancel()
            self.proposal_changed.emit()
            return
        flights = self.sorted_flights()
        self._proposing.run(lambda _running: propose(*flights), self._on_proposal, self._fail)
        self.proposal_changed.emit()

    def _on_proposal(self, proposal: ThresholdProposal) -> None:
        self.proposal = proposal
        self.proposal_changed.emit()

    def _fail(self, error: Exception) -> None:
        raise error

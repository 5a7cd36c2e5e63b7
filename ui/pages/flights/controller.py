"""Controller of the Flight logs page: flights, lists, thresholds and proposal. It never sends anything."""

from collections import deque
from collections.abc import Callable, Iterable, Mapping
from pathlib import Path
from typing import Final, NamedTuple

from PySide6.QtCore import QObject, Signal

from app.flights.columns import CsvColumns
from app.flights.judge import TriggerLimits
from app.flights.judging import RuleReading
from app.flights.many_logs import LogOrder, summarise_logs
from app.flights.read_log import distinct_names, find_logs
from app.flights.summary import FlightSummary
from app.flights.thresholds import (
    FireMap,
    FlightGroup,
    FlightOutcome,
    ThresholdProposal,
    fire_map,
    outcome_of,
    propose,
    settings_of,
)
from app.text.messages import UserMessage
from app.text.sentences import error_text
from protocol.fields import Value
from ui.core.background_task import BackgroundTask, Running

Settle = Callable[[], object]
GROUPS: Final = tuple(FlightGroup)


class Flight(NamedTuple):
    """A file in one of the lists."""

    name: str
    """Its path."""
    group: FlightGroup = FlightGroup.UNSORTED
    columns: CsvColumns | None = None
    """With which it was read; None: recognised by name."""
    summary: FlightSummary | None = None
    why_not: UserMessage | None = None
    """Why it could not be read."""
    head: tuple[str, ...] = ()
    """Column names of a table that could not be read."""

    @property
    def is_waiting(self) -> bool:
        return self.summary is None and self.why_not is None


class FlightRow(NamedTuple):
    """A line of a list; `outcome` is None where the file could not be read."""

    flight: Flight
    outcome: FlightOutcome | None
    longest_fall_s: float
    """Below the chosen acceleration; -1 where there is none."""
    label: str
    """The end of its path by which it can be told from the others."""

    @property
    def name(self) -> str:
        return self.flight.name


class LoadEnded(NamedTuple):
    """`total` is None where it was cancelled before the files were counted."""

    read: int
    total: int | None
    was_cancelled: bool = False
    why: str = ""
    """An error of the operating system."""


class Reading:
    """Files and folders; `total` and `done` are written by the reading thread. `skipped`: what is already read.
    `settle` is called by that thread before it reads."""

    def __init__(
        self, paths: Iterable[Path] = (), columns: CsvColumns | None = None, skipped: Iterable[str] = (),
        settle: Settle = bool,
    ) -> None:  # fmt: skip
        self._paths, self._columns, self._skipped, self._settle = tuple(paths), columns, frozenset(skipped), settle
        self.total: int | None = None
        """None until they are counted."""
        self.done: deque[Flight] = deque()
        self.read = 0
        """Of `done`, what was taken over."""

    def run(self, running: Running) -> None:
        self._settle()
        paths = [path for path in find_logs(self._paths) if str(path) not in self._skipped]
        self.total = len(paths)
        for log in summarise_logs(paths, LogOrder(self._columns), is_cancelled=running.is_cancelled):
            flight = Flight(str(log.path), FlightGroup.UNSORTED, self._columns, log.flight, log.why_not, log.head)
            self.done.append(flight)


class FlightsWork(QObject):
    """Reads orders one after another, and keeps the flights that were read."""

    flights_changed = Signal()
    """Flights were added, removed or moved."""
    thresholds_changed = Signal()
    proposal_changed = Signal()
    loading_ended = Signal(object)
    """`LoadEnded`."""

    def __init__(self, parent: QObject) -> None:
        super().__init__(parent)
        self.flights: dict[str, Flight] = {}
        """By name."""
        self._passing: set[str] = set()
        """Names of recordings that are here only to try thresholds on them."""
        self.limits = TriggerLimits()
        self.reading = RuleReading.DIRECT
        """Of the map; lists and proposal use both."""
        self.proposal: ThresholdProposal | None = None
        self.loading = Reading()
        """The present one, or the last."""
        self._waiting: deque[Reading] = deque()
        self.task: BackgroundTask[None] = BackgroundTask("dps-s flights", self)
        self._maps: tuple[FireMap, FireMap] | None = None
        self._maps_of: tuple[float, RuleReading] | None = None
        self._proposing: BackgroundTask[ThresholdProposal] = BackgroundTask("dps-s thresholds", self)

    @property
    def is_empty(self) -> bool:
        return all(flight.is_waiting for flight in self.flights.values())

    @property
    def is_proposing(self) -> bool:
        return self._proposing.is_running

    def sorted_flights(self) -> tuple[list[FlightSummary], list[FlightSummary]]:
        """Flights that must not and that must fire; without unreadable files."""
        sides: dict[FlightGroup, list[FlightSummary]] = {group: [] for group in GROUPS}
        for flight in self.flights.values():
            if flight.summary is not None:
                sides[flight.group].append(flight.summary)
        return sides[FlightGroup.MUST_NOT], sides[FlightGroup.MUST]

    def unread(self) -> list[Flight]:
        return [flight for flight in self.flights.values() if flight.why_not is not None]

    def outcome_of(self, flight: Flight) -> FlightOutcome | None:
        return None if flight.summary is None else outcome_of(flight.summary, flight.group, self.limits)

    def rows(self) -> dict[FlightGroup, list[FlightRow]]:
        rows: dict[FlightGroup, list[FlightRow]] = {group: [] for group in GROUPS}
        labels = distinct_names([Path(name) for name in self.flights])
        for flight, label in zip(self.flights.values(), labels, strict=True):
            if not flight.is_waiting:
                fall_s = -1.0 if flight.summary is None else flight.summary.longest_fall_s(self.limits)
                rows[flight.group].append(FlightRow(flight, self.outcome_of(flight), fall_s, label))
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

    def open(self, paths: Iterable[Path], columns: CsvColumns | None = None, settle: Settle = bool) -> None:
        """Reads files and folders, without flights that are already there."""
        read = (flight.name for flight in self.flights.values() if flight.summary is not None)
        self._waiting.append(Reading(paths, columns, read, settle))
        if not self.task.is_running:
            self._begin()

    def read_again(self, path: Path, settle: Settle) -> None:
        """A recording that may have grown, and grows to its present end by `settle`; it stays in its list, and is not
        there at the next start unless it was, or a person moves it."""
        known = self.flights.get(str(path))
        if known is None:
            known = Flight(str(path))
            self._passing.add(known.name)
        self.flights[known.name] = Flight(known.name, known.group)
        self.open([path], settle=settle)

    @property
    def kept_lists(self) -> tuple[str, ...]:
        """For the next start: the list and the path of each flight."""
        kept = (flight for name, flight in self.flights.items() if name not in self._passing)
        return tuple(f"{flight.group.name} {flight.name}" for flight in kept)

    def restore(self, kept: Iterable[str]) -> None:
        """Reads the flights of the last start into their lists."""
        for line in kept:
            word, _, name = line.partition(" ")
            group = FlightGroup.__members__.get(word, FlightGroup.UNSORTED)
            self.flights[name] = Flight(name, group)
        if self.flights:
            self.open(map(Path, self.flights))

    def poll(self) -> None:
        """Takes over the logs that were read since."""
        done = self.loading.done
        has_more = bool(done)
        while done:
            flight = done.popleft()
            known = self.flights.get(flight.name, flight)
            self.flights[flight.name] = flight._replace(group=known.group)
            self.loading.read += 1
        if has_more:
            self._maps = None
            self.flights_changed.emit()

    def cancel(self) -> None:
        """Returns at once; logs already read stay, logs being read are dropped."""
        if self.task.is_running:
            self._waiting.clear()
            self.task.cancel()
            self._end_reading(was_cancelled=True)
            self.loading = Reading()  # discards what the thread still reads

    def _begin(self) -> None:
        self.loading = self._waiting.popleft()
        self.task.run(self.loading.run, lambda _none: self._end_reading(), lambda error: self._end_reading(error=error))

    def _end_reading(self, *, was_cancelled: bool = False, error: Exception | None = None) -> None:
        self.poll()
        self._change()
        why = "" if error is None else error_text(error)
        self.loading_ended.emit(LoadEnded(self.loading.read, self.loading.total, was_cancelled, why))
        if self._waiting:
            self._begin()
        if error is not None and not isinstance(error, OSError):
            raise error

    def choose(self, limits: TriggerLimits) -> None:
        if limits != self.limits:
            self.limits = limits
            self.thresholds_changed.emit()

    def choose_reading(self, reading: RuleReading) -> None:
        if reading is not self.reading:
            self.reading = reading
            self.thresholds_changed.emit()

    def move(self, names: Iterable[str], group: FlightGroup) -> None:
        for name in names:
            self.flights[name] = self.flights[name]._replace(group=group)
            self._passing.discard(name)
        self._change()

    def remove(self, names: Iterable[str]) -> None:
        """Removes flights from the page; the files stay."""
        for name in names:
            self.flights.pop(name, None)
        self._change()

    def _change(self) -> None:
        self._maps = None
        self._propose()
        self.flights_changed.emit()

    def _propose(self) -> None:
        self.proposal = None
        flights = self.sorted_flights()
        if any(flights):
            self._proposing.run(lambda _running: propose(*flights), self._on_proposal)
        else:
            self._proposing.cancel()
        self.proposal_changed.emit()

    def _on_proposal(self, proposal: ThresholdProposal) -> None:
        self.proposal = proposal
        self.proposal_changed.emit()

"""Runs one cell of the table fault × procedure × phase, and checks the promises."""

import importlib
import inspect
import pkgutil
import threading
from collections import Counter
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field
from itertools import product
from typing import Any

import app.procedures
from app.engine.conversation import ConversationView, Interrupted
from app.engine.procedure import Cancelled, Job, Procedure
from app.engine.session import Session
from app.engine.transport import PortError, SerialLine
from app.engine.worker import CLOSING_LIMIT_S, MAX_STEP_S
from app.simulator.bench import SimulatedBench
from app.simulator.memory import record_frame
from protocol.catalogue import CELL_VOLT, TENTH_VOLT, Request
from protocol.events import EndReason
from protocol.fields import Value
from tests.campaigns.faults.fault_kinds import FAULTS, End, FaultKind
from tests.campaigns.faults.faulty_port import FakePort, Phase
from tests.support.line.lies import lying_bench
from tests.support.line.sim_line import INSTANT_S, FakeClock
from tests.support.line.truth import settings_held
from tests.support.thorough import some

LONGEST_S = 90.0
MAX_STEPS = 60_000
BEGINS_S = 5.0
AFTER_S = 0.4
"""Time for which the session goes on after the procedure, to receive what is late."""

TYPED = (Interrupted, Cancelled)


@dataclass(frozen=True, slots=True)
class Row:
    """A procedure of `app.procedures`, and how to judge it."""

    name: str
    make: Callable[["Cell"], Procedure[Any]]
    """Called once the conversation has begun."""
    lies: Callable[[Any, "Cell"], list[str]]
    """Returns what a result claims and the module does not hold."""
    may_repeat: frozenset[Request] = frozenset()
    """Acts that may be repeated, because a second one has no further effect."""
    options: Mapping[str, str] = field(default_factory=dict)
    """Options of the simulated module."""
    strikes_at: int | None = None
    """Index of the request to disturb, of those sent since it began; by default the first act, else the second
    query."""
    runs_for_s: float | None = None
    """Time after which a procedure without an end is cancelled."""
    variant: str = ""
    """Distinguishes the rows of one procedure."""
    outlives: bool = False
    """It is a job of the port."""
    begins: bool = True
    """In a conversation; else directly after the port was opened."""

    @property
    def title(self) -> str:
        return f"{self.name}: {self.variant}" if self.variant else self.name


@dataclass(frozen=True, slots=True)
class Result:
    """The outcome; `faults` must be empty."""

    faults: tuple[str, ...]
    has_struck: bool


def procedures() -> Iterator[tuple[str, Callable[..., Any]]]:
    """Return every public function of `app.procedures` that makes a procedure, with its dotted name."""
    for info in pkgutil.iter_modules(app.procedures.__path__):
        module = importlib.import_module(f"app.procedures.{info.name}")
        for name, one in inspect.getmembers(module, inspect.isfunction):
            returns = str(one.__annotations__.get("return", ""))
            is_procedure = "Procedure[" in returns or "Generator[" in returns
            if one.__module__ == module.__name__ and not name.startswith("_") and is_procedure:
                yield f"{info.name}.{name}", one


class Cell:
    """One run, in a conversation that has begun; `wanted_end` is set by faults that end it from outside."""

    def __init__(self, row: Row) -> None:
        self.row = row
        self.wanted_end = End.PROCEDURE
        self.clock = FakeClock()
        options = {"history": "2", "uptime": "60", **row.options}
        self.bench = lying_bench(options, self.clock)
        self.port = FakePort(self.bench, self.clock)
        self.line = SerialLine("/dev/ttyUSB0", self.port)  # type: ignore[arg-type]
        self.line._gather = lambda gather_s: None  # type: ignore[method-assign]
        self.session = Session(self.line, self.clock)
        self.clock.now_s += INSTANT_S
        end_s = self.clock.now_s + (BEGINS_S if row.begins else 0.0)
        while not self.conversation.is_going and self.clock.now_s < end_s:
            self.session.step(MAX_STEP_S)
        self.first = len(self.port.requests)
        """Index of the first request of the procedure."""
        self.job: Job[Any] = Job(row.make(self), outlives=row.outlives)
        self.hidden: frozenset[str] = frozenset()
        """Keys that the fault changes in the module without a sign."""
        self.was_over = False
        """The procedure had ended before the fault: its result describes the time before."""

    @property
    def conversation(self) -> ConversationView:
        return self.session.conversation_view(self.clock())

    @property
    def requests(self) -> list[Request]:
        """Since the procedure began."""
        return self.port.requests[self.first :]

    def go(self) -> None:
        """Run until the procedure has ended, and `AFTER_S` longer."""
        self.port.strike_if_idle()
        started_s = self.clock.now_s
        self.session.run(self.job)
        steps = 0
        while not self.job.has_ended:
            self._intervene(started_s)
            if self.wanted_end == End.CLOSED:
                self._leave()
                return
            self.session.step(MAX_STEP_S)
            steps += 1
            if steps > MAX_STEPS:
                raise AssertionError("it does not end")
        end_s = self.clock.now_s + AFTER_S
        while self.clock.now_s < end_s:
            self.port.strike_if_idle()
            self.session.step(MAX_STEP_S)

    def _leave(self) -> None:
        """Cancel as the worker does, with time to undo changes."""
        self.job.cancel()
        end_s = self.clock.now_s + CLOSING_LIMIT_S
        while not self.job.has_ended and self.clock.now_s < end_s:
            self.session.step(MAX_STEP_S)

    def _intervene(self, started_s: float) -> None:
        self.port.strike_if_idle()
        lasts_s = self.row.runs_for_s
        if lasts_s is not None and self.clock.now_s - started_s > lasts_s:
            self.job.cancel()
        if self.wanted_end == End.CANCELLED:
            self.job.cancel()


def target_index(row: Row) -> int:
    """Return the index of the request to disturb: the first act, else the second query, else the first."""
    if row.strikes_at is not None:
        return row.strikes_at
    requests = clean_requests(row)
    for index, request in enumerate(requests):
        if not request.is_repeatable:
            return index
    return min(1, len(requests) - 1)


def clean_requests(row: Row) -> list[Request]:
    """Return the requests that the procedure sends without a fault."""
    cell = Cell(row)
    cell.go()
    assert cell.job.error is None or row.runs_for_s is not None, cell.job.error
    cell.session.close(EndReason.CLOSED)
    return cell.requests


def run_cell(row: Row, fault: FaultKind, phase: Phase, index: int) -> Result:
    threads = set(threading.enumerate())
    cell = Cell(row)
    port = cell.port
    port.phase, port.index = phase, cell.first + index
    cell.hidden = fault.hides

    def strike() -> None:
        cell.was_over = cell.job.has_ended
        fault.begin(cell, port)

    port.strike = strike
    began_s = cell.clock.now_s
    error: PortError | None = None
    faults: list[str] = []
    try:
        cell.go()
    except PortError as lost:
        error = lost
    except Exception as bug:  # noqa: BLE001  any other exception is what the table is there to find
        faults.append(f"raised {type(bug).__name__}: {bug}")
    took_s = cell.clock.now_s - began_s - (3600 if fault.name.startswith("clock leaps") and port.has_struck else 0)
    if error is None:
        faults += device_lies(cell, fault.hides)
    was_raised = port.has_raised
    cell.session.close(EndReason.CLOSED if error is None else EndReason.PORT_LOST)
    faults += _judged(cell, took_s)
    faults += [f"thread left: {one.name}" for one in set(threading.enumerate()) - threads]
    if was_raised and error is None:
        faults.append("the port's error was not seen")
    if not cell.job.has_ended:
        faults.append("the procedure is still running")
    return Result(tuple(faults), port.has_struck)


def run_row(row: Row, number: int) -> dict[tuple[str, Phase], Result]:
    """Faults in phases of one procedure: a tenth of all, from another one on in each row `number`."""
    index = target_index(row)
    cells = some(product(FAULTS, Phase), one_in=10, first=number)
    return {(fault.name, phase): run_cell(row, fault, phase, index) for fault, phase in cells}


def _judged(cell: Cell, took_s: float) -> list[str]:
    faults: list[str] = []
    if took_s > LONGEST_S:
        faults.append(f"took {took_s:.0f} s")
    if not cell.port.is_closed:
        faults.append("the port is still open")
    error = cell.job.error
    if error is not None and not isinstance(error, TYPED):
        faults.append(f"ended with {type(error).__name__}: {error}")
    if cell.job.has_ended and error is None and not cell.was_over:
        faults += cell.row.lies(cell.job.outcome(), cell)
    sent = Counter(request for request in cell.port.requests if not request.is_repeatable)
    for request, count in sent.items():
        if count > 1 and request not in cell.row.may_repeat:
            faults.append(f"{request.encode().hex(' ')} was sent {count} times")
    view = cell.conversation
    if any(view.fresh(key, cell.clock.now_s) is not None for key in view.values):
        faults.append("the port is closed, and something is still shown as certain")
    return faults


def truth(bench: SimulatedBench, now_s: float) -> dict[str, Value]:
    """Return what the module holds, by the keys of the device."""
    module = bench.module
    return {
        **settings_held(module),
        "baud_rate": module.baud_rate,
        "boot_count": module.memory.boot_count,
        "active": module.state.is_active,
        "triggered": module.is_triggered,
        "tilt_deg": round(module.measure(now_s).tilt_deg),
        "acceleration_g": 1.0,
        "charging": module.world.has_external_power,
        "cell_voltage_v": CELL_VOLT.decode(module.voltage(now_s)),
        "light_v": TENTH_VOLT.decode(module.light(now_s)),
    }


def device_lies(cell: Cell, hidden: frozenset[str]) -> list[str]:
    """Return the values shown as certain that differ from the module's."""
    now_s = cell.clock.now_s
    holds = truth(cell.bench, now_s)
    view = cell.conversation
    shown = {key: view.fresh(key, now_s) for key in view.values if key not in hidden}
    return [
        f"{key} is shown as {value}, the module holds {holds[key]}"
        for key, value in shown.items()
        if value is not None and holds[key] != value
    ]


def records_held(bench: SimulatedBench) -> list[bytes]:
    return [record_frame(data) for data in bench.module.memory.records]

"""Runs the real command line in this thread, on a simulated module and a clock that only waiting advances."""

import io
import queue
import tempfile
import time
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import Future, wait
from contextlib import ExitStack, contextmanager, redirect_stderr, redirect_stdout, suppress
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Final
from unittest import mock

import app.__main__ as program
from app.engine.procedure import Job
from app.engine.transport import PortError, PortTrouble
from app.simulator.bench import SimulatedBench
from app.store.fact_store import Facts, Store
from app.terminal.connection import LOST
from tests.support.line.sim_line import FakeClock, ThreadlessWorker, WatchedLine
from tests.support.line.truth import Truth

PORT: Final = "sim://adversary"
LIMIT_S: Final = 300.0
"""The longest time on the fake clock that a command takes on the slowest line."""
IDLE_S: Final = 0.01
STEPS_AT_MOST: Final = 400_000
"""The most rounds of the worker without progress of the clock."""
CLOCKED: Final = (
    "app.terminal.connection",
    "app.terminal.streaming",
    "app.cli.act",
    "app.cli.monitor",
    "app.cli.preflight",
    "app.cli.settings.set",
)
"""Where the program's clock is read."""


class Hang(BaseException):
    """Raised when a command does not end."""


@dataclass
class Ran:
    """Output and actions of a command; `mishaps` holds the program's own errors, in order."""

    code: int = -1
    out: str = ""
    err: str = ""
    took_s: float = 0.0
    mishaps: list[BaseException] = field(default_factory=list)
    is_hung: bool = False


class Stage:
    """One module, one clock and one store, on which commands run one after the other."""

    def __init__(self, bench: SimulatedBench, clock: FakeClock, home: Path) -> None:
        self.bench, self.clock, self.home = bench, clock, home
        self.truth = Truth(bench, clock)
        self._mishaps: list[BaseException] = []
        self._worker: ThreadlessWorker | None = None
        self._ends_at_s = 0.0
        self._turns = 0
        self._accident: tuple[float, Callable[[SimulatedBench], None]] | None = None

    def happens_at(self, at_s: float, happen: Callable[[SimulatedBench], None]) -> None:
        """Call `happen` once at `at_s`."""
        self._accident = at_s, happen

    def run(self, words: list[str]) -> Ran:
        """Run `dps-s` with these words; never raises what the program should have caught."""
        ran, begun_s = Ran(mishaps=self._mishaps), self.clock()
        self._ends_at_s, self._turns = begun_s + LIMIT_S, 0
        out, err = io.StringIO(), io.StringIO()
        with self._in_place(), redirect_stdout(out), redirect_stderr(err):
            try:
                ran.code = program.main(words)
            except Hang:
                ran.is_hung = True
            except BaseException as error:  # noqa: BLE001  whatever leaves `main` is a traceback for a person
                self._mishaps.append(error)
        ran.out, ran.err, ran.took_s = out.getvalue(), err.getvalue(), self.clock() - begun_s
        self.truth.end()
        return ran

    def turn(self) -> None:
        """Run the worker's loop once, or advance the clock if there is nothing to do."""
        self._turns += 1
        if self.clock() > self._ends_at_s or self._turns > STEPS_AT_MOST:
            raise Hang
        if self._accident is not None and self.clock() >= self._accident[0]:
            happen, self._accident = self._accident[1], None
            happen(self.bench)
        if self._worker is None or not self._worker.turn():
            self.clock.now_s += IDLE_S
        self.truth.note()

    def turn_until(self, is_enough: Callable[[], bool], limit_s: float) -> bool:
        ends_at_s = self.clock() + limit_s
        while not is_enough() and self.clock() < ends_at_s:
            self.turn()
        return is_enough()

    def wait_until(self, at_s: float) -> None:
        """Advance the clock without the host."""
        while self.clock() < at_s:
            self.clock.now_s += IDLE_S
            self.bench.wire.read(self.clock())
            self.truth.note()

    def _open_line(self, port: str, baud_rate: int) -> WatchedLine:
        if port != PORT:
            raise PortError(PortTrouble.MISSING, port, "no such port")
        return WatchedLine(self.truth, self.clock, self.bench, baud_rate)

    def _explain(self, words: Sequence[str], error: Exception) -> int:
        if not isinstance(error, LOST):
            self._mishaps.append(error)
        return _explain(words, error)

    @contextmanager
    def _in_place(self) -> Iterator[None]:
        stage = self

        class Turned(ThreadlessWorker):
            def __init__(
                self, callback: Callable[[Any], None], *, make_lock: Callable[[], Job[Any]] | None = None
            ) -> None:
                super().__init__(callback, stage.clock, make_lock)
                stage._worker = self

        class Queue(TurnedQueue):
            turn = staticmethod(stage.turn)
            clock = stage.clock

        class Waited(Job[Any]):
            def wait(self, timeout_s: float) -> bool:
                return stage.turn_until(lambda: self.is_done, timeout_s)

        with (
            mock.patch.multiple("app.terminal.connection", Worker=Turned, Job=Waited, queue=_QueueModule(Queue)),
            mock.patch("app.engine.worker.open_line", self._open_line),
            mock.patch("app.engine.worker.report_uncaught_error", self._mishaps.append),
            mock.patch("app.store.fact_store.Store.write", write_at_once),
            mock.patch.object(program, "_explain", self._explain),
            mock.patch.dict("os.environ", home_variables(self.home)),
            mock.patch.object(time, "monotonic", self.clock),
            ExitStack() as clocks,
        ):
            for module in CLOCKED:
                clocks.enter_context(mock.patch(f"{module}.steady_time", self.clock))
            yield


_explain = program._explain


@contextmanager
def caught_errors() -> Iterator[list[BaseException]]:
    """The program's own errors meanwhile, which the worker tells of and goes on."""
    mishaps: list[BaseException] = []
    with mock.patch("app.engine.worker.report_uncaught_error", mishaps.append):
        yield mishaps


class TurnedQueue:
    """Stands in for `queue.SimpleQueue`; waiting runs the stage."""

    turn: Callable[[], None]
    clock: FakeClock

    def __init__(self) -> None:
        self._items: list[Any] = []

    def put(self, item: Any) -> None:
        self._items.append(item)

    def get(self, *, timeout: float) -> Any:
        ends_at_s = self.clock() + timeout
        while not self._items and self.clock() < ends_at_s:
            self.turn()
        return self.get_nowait()

    def get_nowait(self) -> Any:
        if not self._items:
            raise queue.Empty
        return self._items.pop(0)


_write = Store.write


def write_at_once(store: Store, work: Callable[[Facts], Any]) -> "Future[Any]":
    """Waits for the disk's thread, which takes no time of the fake clock."""
    future = _write(store, work)
    wait([future])
    return future


class _QueueModule:
    Empty = queue.Empty

    def __init__(self, kind: type[TurnedQueue]) -> None:
        self.SimpleQueue = kind


def home_variables(home: Path) -> dict[str, str]:
    folders = {f"XDG_{one}_HOME": str(home / one.lower()) for one in ("CONFIG", "DATA", "STATE", "CACHE")}
    overrides = {
        f"WIN_PD_OVERRIDE_{one}": str(home / one.lower()) for one in ("APPDATA", "LOCAL_APPDATA", "COMMON_APPDATA")
    }
    return {"HOME": str(home), "LC_ALL": "C.UTF-8"} | folders | overrides


@contextmanager
def temporary_homes() -> Iterator[Path]:
    """Make folders in memory where the system has such a place, because each command writes the store."""
    memory = Path("/dev/shm")
    with suppress(OSError), tempfile.TemporaryDirectory(dir=memory if memory.is_dir() else None) as folder:
        yield Path(folder)

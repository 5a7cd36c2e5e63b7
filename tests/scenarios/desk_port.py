"""One end of a desk: the simulated module, the port, and the session on it, in one thread with one clock."""

from collections.abc import Callable, Mapping
from typing import Any, Final

from app.engine.device import Device, DeviceView
from app.engine.procedure import PortLost, Procedure
from app.engine.session import Run, Session
from app.engine.transport import PortError, PortTrouble
from app.procedures.handshake import handshake
from app.procedures.stream import StreamSwitch, watch
from app.safety.acts import Act
from app.safety.journal import Entry
from app.simulator.bench import SimulatedBench
from protocol.frame import decode_request
from tests.scenarios.desk_ledger import Ledger
from tests.support.journals import FakeJournal
from tests.support.line.lies import lying_bench
from tests.support.line.sim_line import FakeClock, SimulatedLine

CLOSING_S: Final = 0.4
TURN_S: Final = 0.02


class WatchedLine(SimulatedLine):
    """A line on a bench that outlives it; it fails for good once unplugged."""

    def __init__(self, clock: FakeClock, bench: SimulatedBench, ledger: Ledger, baud_rate: int) -> None:
        super().__init__(clock, baud_rate=baud_rate, bench=bench)
        self.bench.wire.clear(clock())
        self._plug, self._ledger = bench.plug_number, ledger
        self._check()

    def write(self, data: bytes) -> None:
        super().write(data)
        for at in range(0, len(data), 6):
            self._ledger.feed(decode_request(data[at : at + 6]), self.clock())

    def _check(self) -> None:
        if not self.bench.is_plugged_in or self.bench.plug_number != self._plug:
            raise PortError(PortTrouble.LOST, "sim", "unplugged")


class LedgerJournal(FakeJournal):
    def __init__(self, ledger: Ledger) -> None:
        super().__init__()
        self._ledger = ledger

    def begin(self, act: Act, frame: bytes, detail: Mapping[str, object], /) -> Entry:
        self._ledger.intend(act)
        return super().begin(act, frame, detail)


class DeskPort:
    """Opens, loses and closes the port as the program's worker does, without its thread."""

    def __init__(self, options: Mapping[str, Any], *, is_watching: bool) -> None:
        self.clock = FakeClock()
        self.ledger = Ledger(is_background_on=is_watching)
        self.session: Session | None = None
        self.opened_at = 0.0
        self._is_watching = is_watching
        self._seeking = 0
        self._device = Device()
        self._jobs: list[tuple[Run[Any], Callable[[Run[Any]], None]]] = []
        self.replace_module(options)

    def poll(self) -> None:
        """Called whenever something may have changed, as in the window."""

    def turn(self) -> None:
        """Advance the clock by a small step, and do what is due."""
        self.step()
        self.collect()
        self.poll()

    def replace_module(self, options: Mapping[str, Any]) -> None:
        """Replace the module; no port is open."""
        self.disconnect()
        self.bench = lying_bench(options, self.clock)
        self._rate = 115200

    @property
    def is_open(self) -> bool:
        return self.session is not None

    @property
    def is_listening(self) -> bool:
        """Return whether the port has the module's rate and keeps it."""
        return self.session is not None and not self._seeking and self._rate_now == self.bench.module.baud_rate

    @property
    def _rate_now(self) -> int:
        return self._rate if self.session is None else self.session.line.baud_rate

    @property
    def view(self) -> DeviceView:
        return self._device.view(self.clock())

    def connect(self) -> None:
        if self.session is not None:
            return
        try:
            line = self.make_line(self._rate)
        except PortError:
            return
        self.session = Session(line, self.clock)
        self.opened_at = self.clock()
        self._device = self.session.device
        if self._is_watching:
            self.session.run_in_background(watch(StreamSwitch()))
        self.run(handshake(), lambda _run: None)

    def make_line(self, baud_rate: int) -> "WatchedLine":
        """Raises `PortError` if nothing is plugged in."""
        return WatchedLine(self.clock, self.bench, self.ledger, baud_rate)

    def find(self) -> None:
        """Open the port at the module's rate."""
        if self._rate_now != self.bench.module.baud_rate:
            self.disconnect()
            self._rate = self.bench.module.baud_rate
        self.connect()

    def disconnect(self) -> None:
        """Close the port as the worker does."""
        if self.session is None:
            return
        for run, _ in self._jobs:
            run.cancel()
        if self.session.background is not None:
            self.session.background.cancel()
        end_s = self.clock() + CLOSING_S
        try:
            while (self.session.background is not None or self.session.is_busy) and self.clock() < end_s:
                self.session.step()
        except PortError as error:
            self._close(error)
        else:
            self._close(PortLost())

    def _close(self, why: Exception) -> None:
        if self.session is not None:
            self._rate = self._rate_now
            self.session.close(why=why)
            self.session = None
            self.collect()
            self.ledger.lose()
            self.poll()

    # The wheel

    def wait(self, seconds: float) -> None:
        end_s = self.clock() + seconds
        while self.clock() < end_s:
            self.turn()

    def step(self) -> None:
        if self.session is None:
            self.clock.now_s += TURN_S
            return
        try:
            self.session.step()
        except PortError as error:
            self._close(error)

    def run(self, procedure: Procedure[Any], then: Callable[[Run[Any]], None], *, is_urgent: bool = False) -> Run[Any]:
        run: Run[Any] = Run(procedure)
        self._jobs.append((run, then))
        if self.session is None:
            run.throw(PortLost(), self.clock())
        else:
            self.session.run(run, is_urgent=is_urgent)
        return run

    def collect(self) -> None:
        done = [job for job in self._jobs if job[0].is_done]
        self._jobs = [job for job in self._jobs if not job[0].is_done]
        for run, then in done:
            if run.error is not None and not isinstance(run.error, PortError):
                self.ledger.take_error(run.error)
            self.ledger.end(id(run))
            then(run)

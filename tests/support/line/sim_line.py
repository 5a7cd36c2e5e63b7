"""A session on the simulated module with a fake clock that reading advances: hours pass in milliseconds."""

from collections.abc import Callable, Mapping
from math import inf
from typing import Any, Self, TypeVar

from app.engine import worker
from app.engine.conversation import ConversationView
from app.engine.procedure import EngineView, Job, Procedure, Report
from app.engine.session import Session
from app.engine.transport import PortError, PortErrorKind
from app.procedures.stream import StreamSwitch, watch
from app.safety.journal import Act
from app.safety.permit import Origin, Permit
from app.simulator.bench import SimulatedBench
from app.simulator.setup import Setup
from protocol.catalogue import Hazard, Layout, Request
from protocol.messages import Frame, decode_request
from protocol.stale_replies import FlagAnswers, LastingValues
from protocol.stream import StreamParser

Result = TypeVar("Result")
FINEST_S = 1e-4


class FakeClock:
    """A monotonic clock that stands still unless `now_s` is set."""

    def __init__(self) -> None:
        self.now_s = 1000.0

    def __call__(self) -> float:
        return self.now_s


class VirtualLine:
    """What lines in virtual time have in common: one thread, so that nobody waits in a read, and nothing to close."""

    is_closed = False

    def interrupt(self) -> None:
        """Has no effect."""

    def close(self) -> None:
        self.is_closed = True


class SimulatedLine(VirtualLine):
    """A `Line` on a simulated module, which outlives it; it fails for good once that was unplugged. `sent` holds all
    bytes written; `on_leaving` is called before each frame of the host."""

    def __init__(
        self,
        clock: FakeClock,
        bench: SimulatedBench,
        baud_rate: int = 115200,
        on_leaving: Callable[[Request], None] = lambda _request: None,
        port: str = "sim",
    ) -> None:
        self.clock, self.bench, self.port, self._on_leaving = clock, bench, port, on_leaving
        self.opened_at = clock()
        if bench.is_plugged_in:
            bench.holder = self
        self.sent = bytearray()
        # When the module told last whether it is ACTIVE, and whether it is.
        self.told_active: tuple[float, bool] | None = None
        self._parser = StreamParser()
        bench.wire.clear(clock())
        self._check()
        self.baud_rate = self.bench.wire.host_baud = baud_rate

    @property
    def requests(self) -> list[Request]:
        """The frames that the host sent."""
        return [decode_request(bytes(self.sent[at : at + 6])) for at in range(0, len(self.sent), 6)]

    def read(self, longest_s: float, gather_s: float) -> bytes:
        data = self._read(longest_s)
        for piece in self._parser.feed(data):
            if isinstance(piece, Frame) and piece.raw[:3] in (b"Au0", b"Au2"):
                self.told_active = self.clock(), bool(piece.raw[6 if len(piece.raw) == Layout.STATUS.value else 4] & 1)
        return data

    def _read(self, longest_s: float) -> bytes:
        self._check()
        wire, clock = self.bench.wire, self.clock
        end_s, looked_s = clock.now_s + longest_s, -inf
        while (due_s := wire.next_due(clock.now_s)) <= end_s:
            if looked_s == clock.now_s or due_s > clock.now_s:
                clock.now_s = max(due_s, clock.now_s + FINEST_S)
                self._check()
            if data := wire.read(clock.now_s):
                return data
            looked_s = clock.now_s
        clock.now_s = max(clock.now_s, end_s)
        return wire.read(clock.now_s)

    def write(self, data: bytes) -> None:
        self._check()
        self.sent += data
        for at in range(0, len(data), 6):
            self._on_leaving(decode_request(data[at : at + 6]))
        self.bench.wire.write(data, self.clock.now_s)

    def use_rate(self, baud_rate: int) -> None:
        self._check()
        self.baud_rate = self.bench.wire.host_baud = baud_rate
        self.bench.wire.read(self.clock.now_s)

    def _check(self) -> None:
        if self.bench.holder is not self:
            raise PortError(PortErrorKind.LOST, self.port, "unplugged")


class ThreadlessWorker(worker.Worker):
    """The worker that the window and the commands use, without its thread; `turn` is one round of its loop."""

    def __init__(self, callback: Any, clock: FakeClock, make_lock: Callable[[], Job[Any]] | None = None) -> None:
        super().__init__(callback, clock=clock, make_lock=make_lock)
        self._has_ended = False

    def start(self) -> None:
        """Has no effect: there is no thread to start."""

    def turn(self) -> bool:
        """Run one round; return whether there was anything to do."""
        if self._has_ended or (self._session is None and self._orders.empty()):
            return False
        self._turn()
        return True

    def stop(self, deadline_s: float = 2.0) -> bool:
        """Closing the port has a limit of its own."""
        if not self._has_ended:
            self._order(self._end)
            while not self._is_stopping:
                self.turn()
            self._has_ended = True
        return True


BEGINS_S = 2.0
"""A job waits at most so long for the conversation in which it is submitted."""
INSTANT_S = 1e-6
"""Time that passes after the port is opened."""


class AnyRig:
    """A session on a fake clock. `begin` waits for the conversation, as most tests want it."""

    clock: FakeClock
    session: Session
    max_step_s = 1.0  # much less than what counts as a sleep of the computer

    @property
    def conversation(self) -> ConversationView:
        """The one that goes on, or else the last one."""
        return self.session.conversation_view(self.clock())

    def begin(self, limit_s: float = 5.0) -> Self:
        self.step_until(lambda: self.conversation.is_going, limit_s=limit_s)
        return self

    def job(
        self,
        procedure: Procedure[Result],
        on_progress: Callable[[Report], None] | None = None,
        *,
        is_urgent: bool = False,
        outlives: bool = False,
        conversation: int | None = None,
        **more: Any,
    ) -> Job[Result]:
        """Submit it, in the conversation that goes on, or begins; `outlives`: as a job of the port. `more`: as of
        `Job`."""
        if not outlives and conversation is None:
            end_s = self.clock.now_s + BEGINS_S
            while not self.conversation.is_going and self.clock.now_s < end_s:
                self.step(self.max_step_s)
            conversation = self.conversation.number
        job = Job(procedure, on_progress, conversation=conversation, **more)
        self.session.run(job, is_urgent=is_urgent)
        return job

    def end(self, job: Job[Result], *, limit_s: float = 120.0) -> Result:
        """Go on to the end of `job`; raise what it raised, and fail after `limit_s` of the fake clock."""
        self.step_until(lambda: job.has_ended, limit_s=limit_s)
        return job.outcome()

    def run(self, procedure: Procedure[Result], *more: Any, limit_s: float = 120.0, **options: Any) -> Result:
        """Run `procedure` from its beginning to its end."""
        return self.end(self.job(procedure, *more, **options), limit_s=limit_s)

    def permit(self, act: Act) -> Permit:
        """As a person at the window gives it now."""
        origin = Origin.RITUAL if act is Act.DEPLOY else Origin.CONFIRMATION
        return Permit(act, origin, self.clock(), self.conversation.number)

    def step(self, longest_s: float) -> None:
        self.session.step(longest_s)

    def step_until(self, is_enough: Any, *, limit_s: float = 120.0) -> None:
        end_s = self.clock.now_s + limit_s
        while not is_enough():
            assert self.clock.now_s < end_s, "it takes too long"
            self.step(min(self.max_step_s, end_s - self.clock.now_s))

    def step_for(self, seconds: float) -> None:
        end_s = self.clock.now_s + seconds
        while self.clock.now_s < end_s:
            self.step(min(self.max_step_s, end_s - self.clock.now_s))


class Rig(AnyRig):
    """On the simulated module."""

    def __init__(
        self,
        options: Mapping[str, Any] | None = None,
        *,
        baud_rate: int = 115200,
        background: Callable[[], Procedure[None]] | None = None,
    ) -> None:
        self.clock = FakeClock()
        bench = SimulatedBench(Setup(**{"rate": 10, **(options or {})}), clock=self.clock)
        self.line = SimulatedLine(self.clock, bench, baud_rate)
        self.session = Session(self.line, self.clock, background=background)
        self.clock.now_s += INSTANT_S

    @property
    def bench(self) -> SimulatedBench:
        return self.line.bench

    @property
    def acts(self) -> list[bytes]:
        """Every frame of the host that was no question."""
        return [request.encode() for request in self.line.requests if request.hazard is not Hazard.NONE]

    def silence(self, seconds: float) -> None:
        """The module sends nothing for so long."""
        self.bench.change(mute=True)
        self.step_for(seconds)
        self.bench.change(mute=False)


def settled_rig(switch: StreamSwitch | None = None, /, **options: object) -> Rig:
    """Return a rig on a module that has run for a minute, in its first conversation. With a
    `switch` of the stream it is watched in the background."""
    background = None if switch is None else lambda: watch(switch)
    return Rig(options, background=background).begin()


def engine_view(now: float = 0.0, conversation: ConversationView | None = None, **more: Any) -> EngineView:
    """What a procedure sees of a module of which nothing is known yet."""
    known: dict[str, Any] = {"proven_rate": None, "is_rate_in_doubt": True, "overtaken_at": -inf, "sets_rate": True}
    known |= {"flags": FlagAnswers(now), "lasting": LastingValues(), "rejected_bytes": 0}
    return EngineView(now, 115200, conversation or ConversationView(), **(known | more))

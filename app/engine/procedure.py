"""Effects that a procedure may yield, and the results it is sent.

A procedure is a generator: it yields an effect, is resumed with its result, and returns its own. It holds no port,
clock or thread, so the same one runs in the window, on the command line and, in microseconds, in tests.

    effect       resumed with
    Ask          Answered | Unanswered | OutcomeUnknown
    Pause        the time (monotonic seconds)
    Await        whether the future is done; the line serves others meanwhile
    Listen       tuple[Received, ...]: the frames that came meanwhile
    UseRate      the time; the port runs at the new rate and its buffers are empty
    Inspect      EngineView: what the link and the device know, at once
    Report       the time, at once

`Cancelled` is raised at a yield to cancel it, `PortLost` when the port is lost. After `Cancelled` it may still yield to
undo what it changed, within the session's closing time.
"""

from collections.abc import Generator
from typing import TYPE_CHECKING, Any, NamedTuple, TypeVar

from app.engine.device import DeviceView, StatusSample
from app.text.messages import UserMessage, message
from app.text.user_error import ErrorCode, UserError
from protocol.catalogue import HEARTBEAT, STATUS, Command, Request
from protocol.contradictions import ToldValues
from protocol.events import Answered, Contradicted, Counters
from protocol.fields import Quantity
from protocol.flag_answers import FlagAnswers
from protocol.messages import Reading, Status
from protocol.translatable import marked

if TYPE_CHECKING:
    from concurrent.futures import Future

ASK_EVERY_S = 0.05
SLOW_S = 0.1
"""After a longer wait for a disk the module is asked."""

LOCK_GAPS_S = (0.101, 0.127, 0.149, 0.113, 0.163, 0.137, 0.179, 0.151)
MAX_LOCKS = 50
LOCKS_FOR_S = 10.0
"""From the first one, including the time without a port or in a search for the baud rate."""


class LockRepeat:
    """How often LOCK was sent and when it is sent next; shared by the procedure, the session and the display.

    The gaps differ, so that they do not fall into step with a stream on a half-duplex line.
    """

    def __init__(self) -> None:
        self.until: float | None = None
        """Not sent after this time; set when it is first sent."""
        self.sent = 0
        self.next_at = 0.0

    def is_due(self, now: float) -> bool:
        return self.is_repeating(now) and now >= self.next_at

    def is_repeating(self, now: float) -> bool:
        return self.sent < MAX_LOCKS and (self.until is None or now < self.until)

    def note_sent(self, now: float) -> None:
        if self.until is None:
            self.until = now + LOCKS_FOR_S
        self.next_at = now + LOCK_GAPS_S[self.sent % len(LOCK_GAPS_S)]
        self.sent += 1


class Ask(NamedTuple):
    """One exchange; see `Link.ask`. `repeat`: LOCK is sent whenever it is due while the answer is awaited."""

    request: Request
    waits_s: tuple[float, ...] | None = None
    attempts: int | None = None
    is_deliberate: bool = False
    repeat: LockRepeat | None = None
    is_fenced: bool = False


class Pause(NamedTuple):
    seconds: float


class Await(NamedTuple):
    """Wait for `future`, at most `limit_s`; the line is free meanwhile (slow work is a disk's)."""

    future: "Future[Any]"
    limit_s: float


class Listen(NamedTuple):
    seconds: float


class UseRate(NamedTuple):
    baud_rate: int


class Inspect:
    pass


class LinkView(NamedTuple):
    counters: Counters
    round_trip_minimum_s: float | None
    round_trip_median_s: float | None
    lag_s: float | None = None
    """How long frames from the module take to arrive; None before the first answer. See `protocol.lag`."""


class EngineView(NamedTuple):
    """What `Inspect` shows. `baud_rate` is the port's."""

    now: float
    opened_at: float
    baud_rate: int
    device: DeviceView
    link: LinkView
    proven_rate: int | None
    """The rate of the last answer since the port was opened."""
    is_rate_searched: bool
    """Another procedure changes the port's rate: the module may be at any rate."""
    overtaken_at: float | None
    """When something urgent (LOCK) last overtook the rest: confirmations before it no longer count."""
    is_settled: bool
    """False: it may be another module than expected, so only questions are sent. See `app.engine.identity`."""
    sets_rate: bool = True
    """False: the port's baud rate is set at its other end."""
    flags: FlagAnswers | None = None
    """When 16 and 17 may be set, and whether their answers count."""
    told: ToldValues | None = None
    """Since when the module tells, and whether something is told twice."""

    @property
    def is_answered_twice(self) -> bool:
        return self.told is not None and self.told.is_answered_twice(self.now)


class Report(NamedTuple):
    """Progress: `done` of `total` steps, and what is being done now (English, marked for translation)."""

    done: int
    total: int
    doing: str
    values: tuple[tuple[str, object], ...] = ()


Effect = Ask | Pause | Await | Listen | UseRate | Inspect | Report
Result = TypeVar("Result")
Procedure = Generator[Effect, Any, Result]


class Cancelled(Exception):
    """The procedure was cancelled."""


class PortLost(Exception):
    """The port went away or was closed while the procedure ran."""


class Slept(Cancelled):
    """The computer slept while the procedure ran: its findings may be out of date."""

    def __init__(self, slept_s: float) -> None:
        super().__init__(f"the computer slept for {slept_s:.0f} s")


class TwoModules(Cancelled, UserError):
    """One question was answered twice and differently: nothing that was decided or read before counts."""

    code = ErrorCode.INTERRUPTED

    def __init__(self, contradicted: Contradicted) -> None:
        UserError.__init__(self, CONTRADICTORY, **_values(contradicted))
        self.contradicted = contradicted


CONTRADICTORY = marked("{setting}: {before}, then {after}. Two modules on this line?")


def contradiction(contradicted: Contradicted) -> UserMessage:
    return message(CONTRADICTORY, **_values(contradicted))


def _values(contradicted: Contradicted) -> dict[str, object]:
    before, after = contradicted.before, contradicted.after
    return {"setting": message(before.command.title), "before": _text(before), "after": _text(after)}


def _text(reading: Reading) -> str:
    reply = reading.command.reply
    return reply.text(reading.raw) if isinstance(reply, Quantity) else str(reading.value)


# One question and its answer

HEARTBEAT_WAITS_S = (1.0,)
"""The vendor gives the module one second."""


def is_alive(waits_s: tuple[float, ...] | None = HEARTBEAT_WAITS_S) -> Procedure[bool]:
    """Whether the module answers a heartbeat."""
    return isinstance((yield Ask(HEARTBEAT.query(), waits_s)), Answered)


def ask_value(
    command: Command, waits_s: tuple[float, ...] | None = None, *, is_fenced: bool = False
) -> Procedure[Reading | None]:
    """Query a value once; None without an answer."""
    outcome = yield Ask(command.query(), waits_s, is_fenced=is_fenced)
    answer = outcome.messages[0] if isinstance(outcome, Answered) else None
    return answer if isinstance(answer, Reading) else None


def ask_report(waits_s: tuple[float, ...] | None = None, *, is_fenced: bool = False) -> Procedure[StatusSample | None]:
    """Query the status once; None without an answer. Whether it is current: `app.procedures.who_is_there`."""
    outcome = yield Ask(STATUS.query(), waits_s, is_fenced=is_fenced)
    answer = outcome.messages[0] if isinstance(outcome, Answered) else None
    return StatusSample(outcome.at, *answer) if isinstance(answer, Status) else None


def pause_asking(seconds: float) -> Procedure[None]:
    """A pause in which the module is asked for reports: one that is not asked could be exchanged unseen."""
    now = begin = yield Pause(0.0)
    while now < begin + seconds:
        yield from ask_report()
        now = yield Pause(ASK_EVERY_S)


def await_asking(future: "Future[Any]", limit_s: float) -> Procedure[bool]:
    """Whether it is done, after at most `limit_s` and a question. If it takes long the module is asked meanwhile."""
    view = begin = yield Inspect()
    while not (yield Await(future, SLOW_S)) and view.now < begin.now + limit_s:
        yield from ask_report()
        view = yield Inspect()
    return future.done()

"""Effects that a procedure may yield, and the results it is sent.

A procedure is a generator: it yields an effect, is resumed with its result, and returns its own. It holds no port,
clock or thread, so the same one runs in the window, on the command line and, in microseconds, in tests.

    effect       resumed with
    Ask          Answered | Unanswered | OutcomeUnknown
    Pause        the time (seconds of the session's clock)
    Await        whether the future is done; the line serves others meanwhile
    Listen       tuple[Received, ...]: the frames that came meanwhile
    UseRate      the time; the port runs at the new rate and its buffers are empty
    Inspect      EngineView: what is known, at once
    Report       the time, at once

`Interrupted` is raised at a yield when the conversation ends. A procedure may return after it, but not yield: nothing
that it wants to undo reaches the module that answers next. (Only a job that expects the reason goes on, and asks
questions only.) So no procedure asks whether the module is still the same one.

`Cancelled` is raised at a yield when a person cancels. After it a procedure may yield to undo what it changed.
"""

from collections.abc import Generator
from typing import TYPE_CHECKING, Any, NamedTuple, TypeVar

from app.engine.conversation import ConversationView, StatusSample
from protocol.catalogue import STATUS, Command, Request
from protocol.contradictions import ToldValues
from protocol.events import Answered, Counters
from protocol.flag_answers import FlagAnswers
from protocol.messages import Reading, Status
from protocol.translatable import marked

if TYPE_CHECKING:
    from concurrent.futures import Future

ASK_EVERY_S = 0.05

LOCK_GAPS_S = (0.101, 0.127, 0.149, 0.113, 0.163, 0.137, 0.179, 0.151)
MAX_LOCKS = 50
LOCKS_FOR_S = 10.0
"""From the first one, including the time without a port or in a search for the baud rate."""

TOO_SLOW = marked("This line is too slow for commands; use the cable.")
"""Said where `ConversationView.is_slow`: only questions and LOCK are sent."""


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
    """One exchange; see `Link.ask`, which decides how often a question is repeated and how long is waited.

    `limit_s`: give up after this time; for the acknowledgement of LOCK and the search for the baud rate only.
    `repeat`: LOCK is sent whenever it is due while the answer is awaited.
    """

    request: Request
    is_fenced: bool = False
    is_deliberate: bool = False
    limit_s: float | None = None
    repeat: LockRepeat | None = None


class Pause(NamedTuple):
    seconds: float


class Await(NamedTuple):
    """Wait for `future`, at most `limit_s`; the line is free meanwhile (slow work is a disk's)."""

    future: "Future[Any]"
    limit_s: float


class Listen(NamedTuple):
    seconds: float


class UseRate(NamedTuple):
    """Ends the conversation at the old rate; who uses the rate is not interrupted by that."""

    baud_rate: int


class Inspect:
    pass


class Report(NamedTuple):
    """Progress: `done` of `total` steps, and what is being done now (English, marked for translation)."""

    done: int
    total: int
    doing: str
    values: tuple[tuple[str, object], ...] = ()


class LinkView(NamedTuple):
    """`counters`: since the port was opened. Round trips are of the last conversation; None until one is measured."""

    counters: Counters
    round_trip_minimum_s: float | None
    round_trip_median_s: float | None


class EngineView(NamedTuple):
    """What `Inspect` shows. `baud_rate` is the port's; `conversation` the one that goes on, or else the last one."""

    now: float
    baud_rate: int
    conversation: ConversationView
    link: LinkView
    # The rate at which a conversation last began.
    proven_rate: int | None
    # The module may be at any rate: it was told to change it, or the rate is searched.
    is_rate_in_doubt: bool
    # When LOCK last overtook the rest: confirmations before it no longer count.
    overtaken_at: float | None
    # False: the port's baud rate is set at its other end.
    sets_rate: bool
    # When 16 and 17 may be set, and whether their answers count.
    flags: FlagAnswers
    # Whether something is answered twice.
    told: ToldValues


Effect = Ask | Pause | Await | Listen | UseRate | Inspect | Report
Result = TypeVar("Result")
Procedure = Generator[Effect, Any, Result]


class Cancelled(Exception):
    """A person cancelled the procedure."""


# One question and its answer


def ask_value(command: Command, *, is_fenced: bool = False) -> Procedure[Reading | None]:
    """Query a value; None if the module is there and does not answer it."""
    outcome = yield Ask(command.query(), is_fenced=is_fenced)
    answer = outcome.messages[0] if isinstance(outcome, Answered) else None
    return answer if isinstance(answer, Reading) else None


def ask_report(*, is_fenced: bool = False) -> Procedure[StatusSample | None]:
    """Query the status; None if the module is there and does not answer it. It may be a streamed one."""
    outcome = yield Ask(STATUS.query(), is_fenced=is_fenced)
    answer = outcome.messages[0] if isinstance(outcome, Answered) else None
    return StatusSample(outcome.at, *answer) if isinstance(answer, Status) else None

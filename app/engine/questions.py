"""One question and its answer."""

from app.engine.device import StatusSample
from app.engine.procedure import Ask, Procedure
from protocol.catalogue import HEARTBEAT, STATUS, Command
from protocol.events import Answered
from protocol.messages import Reading, Status

HEARTBEAT_WAITS_S = (1.0,)
"""The vendor gives the module one second."""


def is_alive(waits_s: tuple[float, ...] | None = HEARTBEAT_WAITS_S) -> Procedure[bool]:
    """Whether the module answers a heartbeat."""
    return isinstance((yield Ask(HEARTBEAT.query(), waits_s)), Answered)


def ask_value(command: Command, waits_s: tuple[float, ...] | None = None) -> Procedure[Reading | None]:
    """Query a value once; None without an answer."""
    outcome = yield Ask(command.query(), waits_s)
    answer = outcome.messages[0] if isinstance(outcome, Answered) else None
    return answer if isinstance(answer, Reading) else None


def ask_report(waits_s: tuple[float, ...] | None = None, *, is_fenced: bool = False) -> Procedure[StatusSample | None]:
    """Query the status once; None without an answer. Whether it is current: `app.procedures.ask_status`."""
    outcome = yield Ask(STATUS.query(), waits_s, is_fenced=is_fenced)
    answer = outcome.messages[0] if isinstance(outcome, Answered) else None
    return StatusSample.of(answer, outcome.at) if isinstance(answer, Status) else None

"""Reads everything that can be read; reads again what was disturbed."""

from collections.abc import Callable, Mapping
from types import MappingProxyType
from typing import TYPE_CHECKING, NamedTuple, TypeVar

from app.engine.device import READ_BACK, StatusSample
from app.engine.procedure import Ask, EngineView, Inspect, Procedure, Report, is_alive
from app.procedures.who_is_there import ACTIVE, TRIGGERED, Present
from app.text.messages import UserMessage
from protocol.catalogue import COMMANDS, HEARTBEAT, STATUS, TRIGGER_RECORDS, Command
from protocol.events import Answered, Unanswered
from protocol.fields import Value
from protocol.messages import Reading, Status
from protocol.translatable import marked

if TYPE_CHECKING:
    from app.procedures.settings_reading import SettingsReading

READABLE: tuple[Command, ...] = (
    ACTIVE,
    TRIGGERED,
    STATUS,
    *(
        command
        for command in COMMANDS
        if command.can_be_asked and command not in (ACTIVE, TRIGGERED, STATUS, HEARTBEAT, TRIGGER_RECORDS)
    ),
)
"""The state first, as it matters most: 30, 31 and the status one after the other, as they have to agree."""
PASSES = 3
"""How often is read if the module restarts or falls silent meanwhile."""


class Everything(NamedTuple):
    """The values read. `errors`: the reason for each missing one."""

    values: dict[str, Value]
    """By key ("light_threshold_v"), in the field's unit."""
    errors: dict[str, Unanswered]
    is_silent: bool
    """The module stopped answering; the rest was not asked for."""
    began_at: float
    """Monotonic seconds."""
    contradictions: Mapping[str, UserMessage] = MappingProxyType({})
    """Where 30 or 31 and the status do not agree: what both say, by the key of the status, which is unknown then."""


def read_everything() -> Procedure[Everything]:
    begin: EngineView = yield Inspect()
    values: dict[str, Value] = {}
    errors: dict[str, Unanswered] = {}
    status: StatusSample | None = None
    is_silent = False
    for done, command in enumerate(READABLE):
        yield Report(done, len(READABLE), marked("Reading: {what}"), (("what", command.title),))
        outcome = yield Ask(command.query())
        if not isinstance(outcome, Answered):
            errors[command.key] = outcome
            if not (yield from is_alive()):
                is_silent = True
                break
            continue
        message = outcome.messages[0]
        if isinstance(message, Reading):
            values[command.key] = message.value
        elif isinstance(message, Status):
            status = StatusSample(outcome.at, *message)
    present = Present(values.pop(ACTIVE.key, None), values.pop(TRIGGERED.key, None), status)
    contradictions = {} if is_silent else present.contradictions
    return Everything(values, errors, is_silent, begin.now, contradictions)


Readings = TypeVar("Readings", Everything, "SettingsReading")


def undisturbed(read: Callable[[], Procedure[Readings]]) -> Procedure[Readings | None]:
    """Read again after a restart or a silence: what was read before may be lost, or another module's. None where that
    goes on and the readings differ."""
    former: Mapping[str, Value] | None = None
    for _ in range(PASSES):
        before = (yield Inspect()).device.breaks
        reading = yield from read()
        lasting = {key: value for key, value in reading.values.items() if key in READ_BACK}
        is_broken = (yield Inspect()).device.breaks != before
        is_same = former is None or all(former.get(key, value) == value for key, value in lasting.items())
        if not is_broken or (is_same and (reading.is_silent or former is not None)):
            return reading
        if reading.is_silent:
            break
        former = lasting
    return None

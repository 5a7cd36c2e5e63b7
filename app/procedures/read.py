"""Reads everything that can be read."""

from dataclasses import dataclass, field

from app.engine.procedure import Ask, Procedure, Report, is_alive
from protocol.catalogue import BY_NAME, COMMANDS, HEARTBEAT, STATUS, TRIGGER_RECORDS, Command
from protocol.events import Answered, Unanswered
from protocol.fields import Value
from protocol.messages import Reading, Status
from protocol.translatable import marked

READABLE: tuple[Command, ...] = (
    STATUS,
    *(
        command
        for command in COMMANDS
        if command.can_be_asked
        and command not in (STATUS, HEARTBEAT, TRIGGER_RECORDS, BY_NAME["active"], BY_NAME["triggered"])
    ),
)
"""Status first, as it matters most. 30 and 31 add nothing to the status."""


@dataclass(slots=True)
class Everything:
    """The values read. `errors`: the reason for each missing one."""

    status: Status | None = None
    values: dict[str, Value] = field(default_factory=dict)
    """By key ("light_threshold_v"), in the field's unit."""
    errors: dict[str, Unanswered] = field(default_factory=dict)
    is_line_dead: bool = False
    """The module stopped answering; the rest was not asked for."""


def read_everything() -> Procedure[Everything]:
    everything = Everything()
    for done, command in enumerate(READABLE):
        yield Report(done, len(READABLE), marked("Reading: {what}"), (("what", command.title),))
        outcome = yield Ask(command.query())
        if not isinstance(outcome, Answered):
            everything.errors[command.key] = outcome
            if not (yield from is_alive()):
                everything.is_line_dead = True
                break
            continue
        message = outcome.messages[0]
        if isinstance(message, Status):
            everything.status = message
        elif isinstance(message, Reading):
            everything.values[command.key] = message.value
    return everything

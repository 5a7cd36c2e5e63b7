"""Asks who is there, directly before a frame that changes something, and wherever the state is judged.

    30 behind a fence  ->  31  ->  the status  ->  the boot count

30 and 31 tell the same as the status, so a module that contradicts itself, or a second one on the line, shows here.
While the module streams, the answer to the query of the status looks like a streamed report, which a line may delay by
seconds. As the module answers in order, a status after the answer to 31 was sent after that question.
`DeviceView.proven` tells whether that is recent enough. The boot count comes last, because it tells of a restart, or of
another module, up to that moment.
"""

from collections.abc import Mapping
from typing import NamedTuple

from app.engine.device import StatusSample
from app.engine.procedure import Ask, EngineView, Inspect, Procedure, ask_report, ask_value, is_alive
from app.text.messages import UserMessage, joined, message
from protocol.catalogue import BOOT_COUNT, BY_NAME
from protocol.fields import Value
from protocol.translatable import marked

ACTIVE, TRIGGERED = BY_NAME["active"], BY_NAME["triggered"]
TRIES = 3
"""The first answer of a slow module may be too old, and the state may change between two questions."""
_WORDS: Mapping[tuple[str, Value | None], str] = {
    (ACTIVE.key, True): marked("ACTIVE"),
    (ACTIVE.key, False): marked("LOCKED"),
    (TRIGGERED.key, True): marked("TRIGGERED"),
    (TRIGGERED.key, False): marked("not triggered"),
}
NO_REPLY = marked("no reply")
ANSWERED_TWICE = message(marked("Questions are answered twice. Two modules on this line?"))


class Present(NamedTuple):
    """Who is there. None: not answered."""

    active: Value | None = None
    triggered: Value | None = None
    status: StatusSample | None = None
    is_proven: bool = False
    """The module sent the status within the last second."""

    @property
    def contradictions(self) -> Mapping[str, UserMessage]:
        """Where 30 or 31 and the status differ, or one of them was not answered: what both say, by the status's key."""
        found: dict[str, UserMessage] = {}
        for command, answer in ((ACTIVE, self.active), (TRIGGERED, self.triggered)):
            reported = None if self.status is None else getattr(self.status, command.key)
            if answer is None or reported is None or answer != reported:
                found[command.key] = message(
                    marked("{code}: {answer}, status: {reported}."),
                    code=f"{command.code:02X}",
                    answer=_said(command.key, answer),
                    reported=_said(command.key, reported),
                )
        return found

    @property
    def contradiction(self) -> UserMessage | None:
        found = self.contradictions
        return joined([*found.values()], " ") if found else None


def _said(key: str, value: Value | None) -> UserMessage:
    return message(_WORDS.get((key, value), NO_REPLY))


def who_is_there() -> Procedure[Present]:
    """See the module's docstring. Asked again where the status is too old, or where the answers contradict each other;
    not where one of them does not come, as each is repeated already."""
    for _ in range(TRIES):
        active = yield from ask_value(ACTIVE, is_fenced=True)
        if active is None and not (yield from is_alive()):
            return Present()
        triggered = yield from ask_value(TRIGGERED)
        status = yield from ask_report()
        yield Ask(BOOT_COUNT.query())
        after: EngineView = yield Inspect()
        present = Present(
            None if active is None else active.value,
            None if triggered is None else triggered.value,
            status,
            is_proven=after.device.proven("active", after.now) is not None,
        )
        has_all = active is not None and triggered is not None and status is not None
        if present.contradiction is None and present.is_proven:
            return present
        if not has_all and (present.is_proven or not (yield from is_alive())):
            return present
    return present

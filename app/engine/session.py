"""One open port: its link, the conversation on it, and the jobs that run in it. Everything but the thread."""

from collections.abc import Callable
from typing import Any

from app.engine.conversation import ConversationView
from app.engine.job import Job
from app.engine.procedure import LinkView, Procedure
from app.engine.transport import Line
from app.system.clock import Clock
from protocol.events import EndReason, Event

BATCH_S = 0.008
"""How long to gather a stream while no answer is awaited, if at least a frame arrives in this time."""
MAX_STEP_S = 0.02


class Session:
    def __init__(
        self,
        line: Line,
        clock: Clock,
        *,
        background: Callable[[], Procedure[None]] | None = None,
        conversations: int = 0,
    ) -> None:
        """`background` makes the procedure that keeps the values fresh, anew in each conversation. `conversations`:
        how many there were before at this port."""
        self.line = line
        self.clock = clock
        self.batch_s = BATCH_S

    def run(self, job: Job[Any], *, is_urgent: bool = False) -> None:
        raise NotImplementedError

    def treat_as_another(self) -> None:
        """A person said that another module is connected now."""
        raise NotImplementedError

    @property
    def is_busy(self) -> bool:
        raise NotImplementedError

    def conversation_view(self) -> ConversationView:
        raise NotImplementedError

    def link_view(self) -> LinkView:
        raise NotImplementedError

    def step(self, longest_s: float = MAX_STEP_S) -> None:
        raise NotImplementedError

    def take_events(self) -> list[Event]:
        raise NotImplementedError

    def close(self, reason: EndReason) -> None:
        raise NotImplementedError

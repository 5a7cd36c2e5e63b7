"""A session on the independent module, or on several that share a line, with a fake clock that reading advances."""

from collections.abc import Callable
from typing import Any, TypeVar

from app.engine.conversation import ConversationView
from app.engine.procedure import Job, Procedure
from app.engine.session import Session
from app.safety.acts import Act
from app.safety.permit import Origin, Permit
from tests.module.module import Module
from tests.module.options import Options
from tests.support.line.sim_line import FakeClock

Result = TypeVar("Result")
FINEST_S = 1e-4
BYTE_S = 10 / 115200


class ModuleLine:
    """A `Line`; every module hears everything, and all of them speak."""

    def __init__(self, clock: FakeClock, *modules: Module) -> None:
        self.clock, self.modules = clock, modules
        self.baud_rate = 115200
        self.sets_rate = True
        self.is_closed = False

    def read(self, longest_s: float, gather_s: float) -> bytes:
        end_s = self.clock.now_s + longest_s
        while True:
            if data := b"".join(module.speak(self.clock.now_s) for module in self.modules):
                self.clock.now_s += len(data) * BYTE_S
                return data
            if self.clock.now_s >= end_s:
                return b""
            due_s = min(module.next_at() for module in self.modules)
            self.clock.now_s = min(end_s, max(self.clock.now_s + FINEST_S, due_s))

    def write(self, data: bytes) -> None:
        self.clock.now_s += len(data) * BYTE_S
        for module in self.modules:
            module.hear(data, self.clock.now_s)

    def use_rate(self, baud_rate: int) -> None:
        self.baud_rate = baud_rate

    def close(self) -> None:
        self.is_closed = True


class ModuleRig:
    """A session, its line and its clock. `reopen` is the next command on the same line; `begin` waits for the
    conversation."""

    def __init__(self, options: Options | None = None, *others: Options) -> None:
        self.clock = FakeClock()
        self.modules = [
            Module(each, name=f"{number}", seed=number + 1, now=self.clock.now_s)
            for number, each in enumerate((options or Options(), *others))
        ]
        self.module = self.modules[0]
        self.reopen()

    def reopen(self) -> None:
        self.line = ModuleLine(self.clock, *self.modules)
        self.session = Session(self.line, self.clock)
        self.clock.now_s += 1e-6

    @property
    def conversation(self) -> ConversationView:
        """The one that goes on, or else the last one."""
        return self.session.conversation_view(self.clock())

    def begin(self, limit_s: float = 5.0) -> "ModuleRig":
        self.step_until(lambda: self.conversation.is_going, limit_s=limit_s)
        return self

    def job(self, procedure: Procedure[Result], *, is_urgent: bool = False, **more: Any) -> Job[Result]:
        """Submit it; `more`: as of `Job`."""
        job = Job(procedure, **more)
        self.session.run(job, is_urgent=is_urgent)
        return job

    def run(self, procedure: Procedure[Result], *, limit_s: float = 120.0, **more: Any) -> Result:
        return self.end(self.job(procedure, **more), limit_s=limit_s)

    def end(self, job: Job[Result], *, limit_s: float = 120.0) -> Result:
        self.step_until(lambda: job.has_ended, limit_s=limit_s)
        return job.outcome()

    def step_until(self, is_enough: Callable[[], bool], *, limit_s: float = 120.0) -> None:
        end_s = self.clock.now_s + limit_s
        while not is_enough():
            assert self.clock.now_s < end_s, "it takes too long"
            self.session.step(min(1.0, end_s - self.clock.now_s))

    def step_for(self, seconds: float) -> None:
        end_s = self.clock.now_s + seconds
        while self.clock.now_s < end_s:
            self.session.step(min(1.0, end_s - self.clock.now_s))

    def permit(self, act: Act) -> Permit:
        return Permit(act, Origin.COMMAND_LINE, self.clock(), self.conversation.number)

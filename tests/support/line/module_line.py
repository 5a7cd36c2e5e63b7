"""A session on the independent module, or on several that share a line, with a fake clock that reading advances."""

from app.engine.session import Session
from tests.module.module import Module
from tests.module.options import Options
from tests.support.line.sim_line import FINEST_S, INSTANT_S, AnyRig, FakeClock

BYTE_S = 10 / 115200


class ModuleLine:
    """A `Line`; every module at its rate hears everything, and all of them speak."""

    def __init__(self, clock: FakeClock, *modules: Module) -> None:
        self.clock, self.modules = clock, modules
        self.baud_rate = 115200
        self.sets_rate = True
        self.is_closed = False

    def read(self, longest_s: float, gather_s: float) -> bytes:
        end_s = self.clock.now_s + longest_s
        while True:
            said = [(module.speak(self.clock.now_s), module.rate) for module in self.modules]
            if data := b"".join(part for part, rate in said if rate == self.baud_rate):
                self.clock.now_s += len(data) * BYTE_S
                return data
            if self.clock.now_s >= end_s:
                return b""
            due_s = min(module.next_at() for module in self.modules)
            self.clock.now_s = min(end_s, max(self.clock.now_s + FINEST_S, due_s))

    def write(self, data: bytes) -> None:
        self.clock.now_s += len(data) * BYTE_S
        for module in self.modules:
            if module.rate == self.baud_rate:
                module.hear(data, self.clock.now_s)

    def use_rate(self, baud_rate: int) -> None:
        self.baud_rate = baud_rate

    def close(self) -> None:
        self.is_closed = True


class ModuleRig(AnyRig):
    """`reopen` is the next command on the same line."""

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
        self.clock.now_s += INSTANT_S

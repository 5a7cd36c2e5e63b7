"""What goes wrong in a soak, one thing after the other, in an order that a seed decides."""

import random
import threading
import time
from collections import Counter
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path
from typing import Final

from tests.bench.module import StreamingModule

_FAULTS: Final = (
    ("delay_ms", "250"), ("delay_ms", "400"), ("delay_ms", "1100"), ("double", "0.2"), ("double", "1"), ("drop", "0.1"),
    ("drop", "0.3"), ("echo", "yes"), ("jitter_ms", "300"), ("lag_ms", "250"), ("lag_ms", "350"), ("lose", "0.01"),
    ("mute", "yes"), ("split_ms", "8"), ("direction", "to-module"),
)  # fmt: skip
_CALM_S: Final = (0.5, 2.5)
"""Between two troubles."""
_AWAY_S: Final = (0.05, 2.0)
_TROUBLES: Final = 7
"""Between two storms."""
_STORM: Final = 60
"""Times that a loose plug slips out and in, one after the other."""
_SLIP_S: Final = (0.02, 0.25)
_HOLDS_S: Final = (0.0, 0.15)
_BACK_LIMIT_S: Final = 10.0
_OPENING: Final = ("MainThread", "dps-s worker")
"""The threads that open a port, one after the other."""


def kept_waiting_s() -> float:
    """For how long the threads that open a port have been ready to run while the machine ran something else; 0 where
    only Linux would tell."""
    waited_ns = 0
    for thread in threading.enumerate():
        if thread.name in _OPENING:
            with suppress(OSError):
                path = Path(f"/proc/self/task/{thread.native_id}/schedstat")
                waited_ns += int(path.read_text(encoding="ascii").split()[1])
    return waited_ns / 1e9


class Chaos(threading.Thread):
    """Troubles the module until `end`, which leaves it healed, plugged in and quiet. `returns`: how often the program
    has opened the port again by itself."""

    def __init__(self, module: StreamingModule, seed: int, returns: Callable[[], int]) -> None:
        super().__init__(name="chaos")
        self.done: Counter[str] = Counter()
        """How often each thing was done to it."""
        self.slowest_return_s = 0.0
        """From the plug to the open port that is recognised."""
        self.slowest_own_s = 0.0
        """The same, without the time for which the machine kept the program waiting."""
        self.error: BaseException | None = None
        self._module = module
        self._returns = returns
        self._source = random.Random(seed)
        self._is_over = threading.Event()

    def run(self) -> None:
        try:
            while not self._is_over.is_set():
                self._storm()
                for _ in range(_TROUBLES):
                    if self._is_over.wait(self._source.uniform(*_CALM_S)):
                        break
                    self._trouble()
            for line in ("fault none", "plug", "restart"):  # a restart ends the stream
                self._tell(line)
        except Exception as error:  # noqa: BLE001  told by the soak
            self.error = error

    def end(self, limit_s: float) -> bool:
        """Whether it ended within the limit."""
        self._is_over.set()
        self.join(limit_s)
        return not self.is_alive()

    def _tell(self, line: str) -> None:
        answer = self._module.tell(line)
        if answer.startswith("refused"):
            raise RuntimeError(f"{line}: {answer}")

    def _storm(self) -> None:
        self._tell("fault none")
        self._tell("plug")
        for _ in range(_STORM):
            if self._is_over.wait(self._source.uniform(*_HOLDS_S)):
                return
            before, away_s = self._returns(), self._source.uniform(*_SLIP_S)
            plugged_at, waited_s = time.monotonic() + away_s, kept_waiting_s()
            self._tell(f"unplug {away_s:.3f}")
            self.done["unplug"] += 1
            while self._returns() == before:
                if time.monotonic() - plugged_at > _BACK_LIMIT_S:
                    raise RuntimeError(f"it did not come back within {_BACK_LIMIT_S:.0f} s")
                if self._is_over.wait(0.01):
                    return
            return_s = time.monotonic() - plugged_at
            self.slowest_return_s = max(self.slowest_return_s, return_s)
            self.slowest_own_s = max(self.slowest_own_s, return_s - (kept_waiting_s() - waited_s))

    def _trouble(self) -> None:
        kind = self._source.choices(("fault", "heal", "unplug", "restart"), weights=(5, 3, 3, 1))[0]
        if kind == "fault":
            name, value = self._source.choice(_FAULTS)
            kind = f"fault {name}"
            self._tell(f"fault {name} {value}")
        elif kind == "heal":
            self._tell("fault none")
        elif kind == "unplug":
            self._tell(f"unplug {self._source.uniform(*_AWAY_S):.2f}")
        else:
            self._tell("restart")
        self.done[kind] += 1

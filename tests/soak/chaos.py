"""What goes wrong in a soak, one thing after the other, in an order that a seed decides."""

import random
import threading
from collections import Counter
from typing import Final

from tests.bench.module import StreamingModule

_FAULTS: Final = (
    ("corrupt", "0.01"),
    ("lose", "0.01"),
    ("drop", "0.1"),
    ("garbage", "0.1"),
    ("double", "0.1"),
    ("jitter_ms", "30"),
    ("split_ms", "2"),
    ("mute", "yes"),
    ("echo", "yes"),
)
_LEAST_S: Final = 0.5
_MOST_S: Final = 2.5
_AWAY_S: Final = (0.05, 2.0)


class Chaos(threading.Thread):
    """Troubles the module until `end`, which leaves it healed, plugged in and quiet."""

    def __init__(self, module: StreamingModule, seed: int) -> None:
        super().__init__(name="chaos")
        self.done: Counter[str] = Counter()
        """How often each thing was done to it."""
        self.error: BaseException | None = None
        self._module = module
        self._source = random.Random(seed)
        self._is_over = threading.Event()

    def run(self) -> None:
        try:
            while not self._is_over.wait(self._source.uniform(_LEAST_S, _MOST_S)):
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

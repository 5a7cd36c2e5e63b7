"""What happens to the module and its line while somebody sits at the window, and what must be true of what is shown."""

import math
import random
from collections.abc import Callable, Iterator, Mapping
from dataclasses import replace
from typing import Final

from app.safety.acts import Act
from app.safety.journal import Outcome
from app.simulator.setup import parse_options
from tests.adversary.campaign import latency_s
from tests.adversary.faults import DIALECTS, LIES, LINE
from tests.adversary.window import SURE, Session
from tests.gestures.gesture_bench import GestureBench
from tests.support.line.lies import lies_of, lying
from tests.support.line.odd_module import end_faults, forget_settings
from tests.support.line.truth import Moment

SEEN_WITHIN_S: Final = 0.5
"""Within this time a restart on a good line is known."""
TOLD_AFTER_S: Final = 1.0
"""A frame may be known to be whole only by what follows it."""
CALM_S: Final = 4.0
"""Nothing late arrives after this time without a fault."""
ONLINE_WITHIN_S: Final = 8.0
OF_LINE: Final = tuple(one.options for one in LINE.values() if one.options and not one.forges)
_OF_MODULE: Final = tuple(lie.options for lie in LIES.values() if lie.options and not lie.forges)
_LIES_OF_LINE: Final = ("min_gap_ms", "half_duplex")
BASIS: Final = {"uptime": "60", "noise": "0"}
CONFIRMED_WITHIN_S: Final = 3.0
_HOLDS: Final[Mapping[Act, Callable[[Moment], bool]]] = {
    Act.ACTIVATE: lambda moment: moment.is_active,
    Act.LOCK: lambda moment: not moment.is_active,
    Act.SHUTDOWN: lambda moment: not moment.is_on,
    Act.DEPLOY: lambda moment: moment.is_triggered,
}
"""What must have been so where an act is said to be confirmed."""


class Accidents:
    """`look` returns what is shown as certain and is not so."""

    def __init__(self, bench: GestureBench, dice: random.Random) -> None:
        self.bench, self._dice = bench, dice
        self._session = Session(bench, 0.0)
        self._judged = set[int]()
        self._note_latency()
        self._is_honest, self._calm_since = True, -math.inf
        """Since when the line has had no fault; infinite while it has one."""

    @property
    def is_reachable(self) -> bool:
        port = self.bench.assembly.ports.current
        return port.is_open and self.bench.bench.plug_number == self.bench.line.plug and self.bench.bench.is_plugged_in

    @property
    def is_in_order(self) -> bool:
        module, port = self.bench.bench.module, self.bench.assembly.ports.current
        return self.is_reachable and module.is_on and not module.is_triggered and port.module.is_read

    def happen(self) -> str:
        """Let something happen; return its name."""
        what = self._dice.choice((self.disturb, self.disturb, self.heal, self.restart, self.slip, self.exchange))
        what()
        return what.__name__

    def disturb(self) -> None:
        self._end_faults()
        options = self._dice.choice(OF_LINE)
        lies = {name: text for name, text in options.items() if name in _LIES_OF_LINE}
        module = lying(self.bench.bench)
        module.lies = replace(module.lies, **{name: getattr(lies_of(lies), name) for name in lies})
        self.bench.bench.change(**parse_options(dict(options.items() - lies.items())))
        self._calm_since = math.inf
        self._note_latency()

    def slow_down(self) -> None:
        """So that an act leaves seconds after its button. Slower, it would not leave at all: the boot count is asked
        after the status, which may then be a second old."""
        self.bench.bench.change(delay_ms=220.0)
        self._calm_since = math.inf
        self._note_latency()

    def _note_latency(self) -> None:
        self._session.latency_s = max(self._session.latency_s, latency_s(self.bench.bench) + TOLD_AFTER_S)

    def _end_faults(self) -> None:
        module = lying(self.bench.bench)
        module.lies = replace(module.lies, min_gap_ms=0.0, half_duplex=False)
        end_faults(self.bench.bench)

    def heal(self) -> None:
        self._end_faults()
        self._calm_since = min(self._calm_since, self.bench.clock())

    def restart(self) -> None:
        self.bench.bench.restart()
        if self._dice.random() < 0.5:
            forget_settings(self.bench.bench.module.memory)

    def slip(self) -> None:
        """The plug slips out and in again; the port is opened again."""
        self.bench.bench.unplug()
        self.bench.wait(self._dice.choice((0.02, 0.3)))
        self.bench.bench.plug()
        self.bench.connect()

    def exchange(self) -> None:
        """Another module hangs at the port, perhaps one that lies."""
        lies = self._dice.choice(_OF_MODULE) if self._dice.random() < 0.5 else {}
        self._is_honest, self._calm_since = not lies, -math.inf
        options = {
            **BASIS,
            "seed": str(self._dice.randrange(1000)),
            **self._dice.choice(list(DIALECTS.values())),
            **lies,
        }
        self.bench.disconnect()
        self.bench.exchange(options)
        self._session.latency_s = 0.0
        self._note_latency()
        self.bench.connect()

    def put_in_order(self, wait: Callable[[float], None]) -> None:
        """No fault, connected, switched on, locked and read."""
        bench = self.bench
        self.heal()
        if not bench.bench.module.is_on:
            bench.bench.press_switch()
        bench.bench.module.activate(is_active=False)  # locked once, it is triggered no more
        if not self.is_reachable:
            bench.bench.plug()
            bench.disconnect()
            bench.connect(bench.bench.module.baud_rate)
        ends_at_s = bench.clock() + ONLINE_WITHIN_S
        while bench.clock() < ends_at_s and not bench.assembly.ports.module.is_read:
            wait(0.4)

    def look(self) -> Iterator[str]:
        self._session.look()
        found, self._session.findings = self._session.findings, []
        yield from (f"{one.breach.value}: {one.text}" for one in found)
        yield from self._kept_over_a_restart()
        yield from self._false_outcomes()

    def _kept_over_a_restart(self) -> Iterator[str]:
        """On a good line the two heartbeats of a restart make every value from before it stale."""
        bench, at, now = self.bench, self.bench.truth.restarted_at(), self.bench.clock()
        is_seen = self.is_reachable and at > bench.truth.opened_at and now - at > SEEN_WITHIN_S
        if self._is_honest and is_seen and self._calm_since + CALM_S < at:
            for row in self._session.rows():
                if row.state in SURE and row.module_value is not None and row.module_value.at < at:
                    yield f"{row.command.key} is kept over a restart"

    def _false_outcomes(self) -> Iterator[str]:
        """What the log says was confirmed was so when the module last reported it."""
        journal, truth = self.bench.journal, self.bench.truth
        moments = list(truth.since(self.bench.clock() - CONFIRMED_WITHIN_S - self._session.latency_s))
        for number, outcome in journal.outcomes.items():
            holds = _HOLDS.get(journal.intents[number][0])
            is_news = number not in self._judged and outcome is Outcome.CONFIRMED and holds is not None
            self._judged.add(number)
            if is_news and holds is not None and not any(map(holds, moments)):
                yield f"{journal.intents[number][0].value} is said to be confirmed"

"""What happens to the module and its line while somebody sits at the window, and what must be true of what is shown."""

import math
import random
from collections.abc import Callable, Iterator, Mapping
from dataclasses import replace
from typing import Final

from app.preflight.verdict import REREAD_EVERY_S
from app.safety.acts import Act
from app.safety.journal import Outcome
from app.settings.form import FormRow, RowState
from app.simulator.setup import parse_options
from protocol.catalogue import BY_CODE, SERIAL_OUTPUT
from protocol.fields import Value
from tests.campaigns.gestures.gesture_bench import GestureBench
from tests.support.line.lies import lies_of, lying
from tests.support.line.odd_module import end_faults, forget_settings, odd
from tests.support.line.troubles import DIALECTS, LIES, LINE
from tests.support.line.truth import Moment, flag_in, settings_keys
from ui.session.check import Standing

SEEN_WITHIN_S: Final = 0.5
"""Within this time a restart on a good line is known."""
TOLD_AFTER_S: Final = 1.0
"""A frame may be known to be whole only by what follows it."""
CALM_S: Final = 4.0
"""Nothing late arrives after this time without a fault."""
ONLINE_WITHIN_S: Final = 8.0
OF_LINE: Final = tuple(LINE.values())
_OF_MODULE: Final = tuple(LIES.values())
_LIES_OF_LINE: Final = ("min_gap_ms", "half_duplex")
BASIS: Final = {"uptime": "60", "noise": "0"}
CONFIRMED_WITHIN_S: Final = 3.0
STEP_S: Final = 0.06
"""The greatest age of an answer that the program accepts on a perfect line."""
SURE: Final = (RowState.READ, RowState.ACKNOWLEDGED, RowState.VERIFIED)
LOOKS_IN_A_ROW: Final = 40
"""Count of answers that reading everything again may take; it takes longer on a slow line."""
VOID_WITHIN_S: Final = REREAD_EVERY_S + 2.0
"""Time within which a change must end a verdict."""
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
        self._latency_s = 0.0
        """Delay that the line adds to a reply."""
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
        faults = odd(self.bench.bench.module)
        added_ms = faults.delay_ms + faults.jitter_ms + faults.lag_ms + faults.split_ms
        added_ms += lying(self.bench.bench).lies.latest_ms
        self._latency_s = max(self._latency_s, STEP_S + added_ms / 1000 + TOLD_AFTER_S)

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
        self._latency_s = 0.0
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
        self.bench.truth.end()
        yield from self._wrong_values()
        yield from self._wrong_verdict()
        yield from self._kept_over_a_restart()
        yield from self._false_outcomes()

    def _rows(self) -> tuple[FormRow, ...]:
        return self.bench.settings.work.form.rows(self.bench.device, self.bench.clock())

    def _wrong_values(self) -> Iterator[str]:
        """What is shown as certain was so when it was last reported; what is verified was set and read twice since."""
        view, truth = self.bench.device, self.bench.truth
        is_linked = self.bench.assembly.ports.current.is_open and view.is_going
        for row in self._rows():
            if row.state not in SURE or row.module_value is None:
                continue
            command, value = row.command, row.module_value.value
            if not is_linked:
                yield f"{command.key} is shown as certain without a link"
            elif command is not SERIAL_OUTPUT:  # a stream proves it, too
                yield from self._wrong_value(command.key, value)
            if row.state is RowState.VERIFIED:
                set_at = truth.sent_since(command.set(value), truth.opened_at)
                if not set_at or len(truth.sent_since(command.query(), set_at[-1])) < 2:
                    yield f"{command.key} = {value} is called verified and was not set and read twice on this line"
        for key in ("active", "triggered", "boot_count"):
            known = view.fresh(key, self.bench.clock())
            if known is not None:
                yield from self._wrong_value(key, known)

    def _wrong_value(self, key: str, value: Value) -> Iterator[str]:
        truth = self.bench.truth
        last = truth.last_heard(key)
        if last is None:
            yield f"{key} is shown as {value}, and the module never said it"
            return
        was_so = any(truth.value(key, moment) == value for moment in truth.since(last.at - self._latency_s))
        if not was_so and not self._says(key, last.raw, value):
            yield f"{key} is shown as {value}, and it is {truth.value(key, truth.now)}"

    def _says(self, key: str, raw: bytes, value: Value) -> bool:
        """Whether a line that turns bits brought a reply with this value, which nobody can notice."""
        if not odd(self.bench.bench.module).corrupt:
            return False
        if key in ("active", "triggered"):
            return flag_in(key, raw) is value
        command = next(one for one in BY_CODE.values() if one.key == key)
        return command.reply is not None and command.reply.decode(raw[4]) == value

    def _wrong_verdict(self) -> Iterator[str]:
        """A verdict that stands rests on what is still so, or was a short while ago."""
        work, truth = self.bench.preflight.work, self.bench.truth
        if work.standing not in (Standing.GO, Standing.READY) or work.assessment is None:
            return
        values = work.assessment.case.evidence.values
        said = {key: values.get(key) for key in (*settings_keys(), "boot_count")}
        said |= {"active": work.standing is Standing.GO, "triggered": False}
        for key, value in said.items():
            changed_at = truth.changed_at(key)
            limit_s = VOID_WITHIN_S + LOOKS_IN_A_ROW * self._latency_s
            is_news = changed_at is not None and self.bench.clock() - changed_at <= limit_s
            if truth.value(key, truth.now) != value and not is_news:
                yield f"{work.standing.value} stands: {key} = {value}, and it is {truth.value(key, truth.now)}"

    def _kept_over_a_restart(self) -> Iterator[str]:
        """On a good line the two heartbeats of a restart make every value from before it stale."""
        bench, at, now = self.bench, self.bench.truth.restarted_at(), self.bench.clock()
        is_seen = self.is_reachable and at > bench.truth.opened_at and now - at > SEEN_WITHIN_S
        if self._is_honest and is_seen and self._calm_since + CALM_S < at:
            for row in self._rows():
                if row.state in SURE and row.module_value is not None and row.module_value.at < at:
                    yield f"{row.command.key} is kept over a restart"

    def _false_outcomes(self) -> Iterator[str]:
        """What the log says was confirmed was so when the module last reported it."""
        journal, truth = self.bench.journal, self.bench.truth
        moments = list(truth.since(self.bench.clock() - CONFIRMED_WITHIN_S - self._latency_s))
        for number, outcome in journal.outcomes.items():
            holds = _HOLDS.get(journal.intents[number][0])
            is_news = number not in self._judged and outcome is Outcome.CONFIRMED and holds is not None
            self._judged.add(number)
            if is_news and holds is not None and not any(map(holds, moments)):
                yield f"{journal.intents[number][0].value} is said to be confirmed"

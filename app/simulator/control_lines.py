"""Text commands that control the running simulated module, typed or piped into `dps-s simulate`."""

import math
import os
import stat
import sys
from collections.abc import Callable
from dataclasses import dataclass
from typing import TextIO

from app.simulator.bench import SimulatedBench
from app.simulator.options import BY_NAME, OptionTarget, as_text, find_option, parse_value
from app.simulator.quirks import Group
from app.text.i18n import tr
from app.text.user_error import UserError
from protocol.translatable import marked

READ_CHUNK = 4096
MAX_LINE_LENGTH = 1000


@dataclass(frozen=True, slots=True)
class Verb:
    """A control line. `text` is in English."""

    usage: str
    text: str
    obey: Callable[[SimulatedBench, list[str]], None]


def execute(bench: SimulatedBench, line: str) -> str:
    """Carry out a line; returns the answer. Raises `UserError`."""
    words = line.split()
    if not words:
        return ""
    name, words = words[0].lower(), words[1:]
    if name == "help":
        return help_text()
    if name == "state":
        return _state(bench)
    verb = VERBS.get(name)
    if verb is None:
        raise UserError(help_text())
    try:
        verb.obey(bench, words)
    except (IndexError, KeyError, ValueError):
        raise UserError(verb.usage) from None
    return _state(bench)


def help_text() -> str:
    """All control lines, one per line."""
    width = max(len(verb.usage) for verb in VERBS.values())
    lines = [f"{verb.usage:<{width}}  {tr(verb.text)}" for verb in VERBS.values()]
    return "\n".join((*lines, f"{'state':<{width}}  {tr('State')}"))


def _state(bench: SimulatedBench) -> str:
    state = bench.state()
    names = ("is_on", "is_plugged_in", "is_active", "is_triggered", "is_streaming", "tilt_deg", "is_falling",
             "bay_is_open", "cell_v", "has_external_power", "boot_count", "record_count", "baud_rate")  # fmt: skip
    return "  ".join(f"{name}={as_text(getattr(state, name))}" for name in names)


def _number(words: list[str], least: float = -math.inf, most: float = math.inf) -> float:
    value = float(words[0])
    if not (math.isfinite(value) and least <= value <= most):
        raise ValueError
    return value


def _is_on(words: list[str], on: str = "on", off: str = "off") -> bool:
    return {on: True, off: False}[words[0]]


def _active(bench: SimulatedBench, words: list[str]) -> None:
    with bench.changed:
        bench.module.advance(bench.clock())
        bench.module.activate(is_active=_is_on(words))


def _pwm(bench: SimulatedBench, _words: list[str]) -> None:
    if not bench.pulse_pwm():
        raise UserError(marked("not triggered"))


def _change(bench: SimulatedBench, words: list[str]) -> None:
    if words[0] == "none":
        bench.end_faults()
        return
    option = find_option(words[0])
    if option.target is OptionTarget.SETUP and option.name != "rate":
        raise KeyError(option.name)
    bench.change(**{option.name: parse_value(option, words[1] if len(words) > 1 else "")})


VERBS: dict[str, Verb] = {
    "tilt": Verb("tilt DEG", BY_NAME["tilt"].text, lambda b, w: b.set_tilt(_number(w))),
    "drop": Verb("drop [METRES]", marked("Fall"), lambda b, w: b.drop(_number(w or ["20"], 0.1, 10_000))),
    "bay": Verb(
        "bay open|closed", BY_NAME["bay_open"].text, lambda b, w: b.set_bay(is_open=_is_on(w, "open", "closed"))
    ),
    "cell": Verb("cell VOLT", BY_NAME["cell"].text, lambda b, w: b.set_cell(_number(w))),
    "charger": Verb("charger on|off", BY_NAME["charger"].text, lambda b, w: b.set_charger(is_plugged_in=_is_on(w))),
    "lifelike": Verb("lifelike on|off", BY_NAME["lifelike"].text, lambda b, w: b.set_lifelike(is_lifelike=_is_on(w))),
    "noise": Verb("noise N", BY_NAME["noise"].text, lambda b, w: b.set_noise(_number(w))),
    "restart": Verb("restart", marked("Restart"), lambda b, _w: b.restart()),
    "off": Verb("off", marked("Power off"), lambda b, _w: b.power_off()),
    "press": Verb("press", marked("Press switch"), lambda b, _w: b.press_switch()),
    "pwm": Verb("pwm", marked("PWM trigger"), _pwm),
    "active": Verb("active on|off", BY_NAME["active"].text, _active),
    "unplug": Verb("unplug [SECONDS]", marked("Unplug"), lambda b, w: b.unplug(for_s=_number(w) if w else None)),
    "plug": Verb("plug", marked("Plug in"), lambda b, _w: b.plug()),
    "fault": Verb("fault NAME VALUE|none", Group.FAULTS.value, _change),
    "set": Verb("set NAME VALUE", Group.QUIRKS.value, _change),
}


class ControlLines:
    """Reads control lines from a terminal or a pipe without blocking."""

    def __init__(self, bench: SimulatedBench, source: TextIO | int, *, answer: Callable[[str], None]) -> None:
        self._bench = bench
        self._answer = answer
        self._file: int | None = None
        self._pending = b""
        try:
            file = source if isinstance(source, int) else source.fileno()
            if sys.platform != "win32" and not stat.S_ISREG(os.fstat(file).st_mode):
                self._file = file
        except (OSError, ValueError):
            pass  # closed, or no real file

    def files(self) -> list[int]:
        return [] if self._file is None else [self._file]

    def read(self, ready: list[int]) -> None:
        """Read and carry out lines if the file is among those that are ready."""
        file = self._file
        if file is None or file not in ready:
            return
        try:
            # The system stops background jobs that read their terminal, so reading ends then.
            is_in_background = os.isatty(file) and os.tcgetpgrp(file) != os.getpgrp()
            data = b"" if is_in_background else os.read(file, READ_CHUNK)
        except OSError:
            data = b""
        if not data:
            self._file = None
        *lines, self._pending = (self._pending + data).split(b"\n")
        self._pending = self._pending[-MAX_LINE_LENGTH:]
        if not data and self._pending:
            lines, self._pending = [self._pending], b""
        for line in lines:
            self._execute(line.decode("utf-8", "replace"))

    def _execute(self, line: str) -> None:
        try:
            answer = execute(self._bench, line)
        except UserError as error:
            answer = error.sentence
        if answer:
            self._answer(answer)

"""What the simulated module held when, and which frames went over the line: what every judge compares with."""

import math
from collections.abc import Callable, Iterator
from typing import Final, NamedTuple

from app.simulator.bench import SimulatedBench
from app.simulator.module import SimulatedModule
from protocol.catalogue import BY_CODE, BY_NAME, STATUS_CODE, Layout, Request
from protocol.fields import Value
from protocol.frame import Direction, Frame, decode_request
from protocol.stream import StreamParser
from tests.support.line.lies import CHANGEABLE_CODES
from tests.support.line.odd_module import read_raw

SETTING_CODES: Final = (0x15, 0x20, 0x21, 0x22)
"""Codes that can be set and read."""
KEYS: Final = {BY_CODE[code].key: code for code in sorted(CHANGEABLE_CODES - {0x10})}


class Moment(NamedTuple):
    """A state of the module from `at` until the next one."""

    at: float
    raws: tuple[int, ...]
    """Values in the order of `_CODES`."""
    is_active: bool
    is_triggered: bool
    is_on: bool
    boots: int
    baud_rate: int
    tilt_deg: float
    records: tuple[bytes, ...]


class Heard(NamedTuple):
    at: float
    raw: bytes


_CODES: Final = tuple(KEYS.values())


def settings_held(module: SimulatedModule) -> dict[str, Value]:
    """Every setting but the baud rate, by its key and in its field's unit."""
    commands = [BY_CODE[code] for code in KEYS.values()]
    return {one.key: one.reply.decode(read_raw(module, one.code)) for one in commands if one.reply is not None}


def flag_in(key: str, raw: bytes) -> bool:
    """Return "active" or "triggered" in a status report, or in the answer to the question for it alone."""
    return bool(raw[(5 if key == "triggered" else 6) if len(raw) == Layout.STATUS.value else 4] & 1)


class Truth:
    """The states of the module; `note` is called at every step of the clock. Times are the module's."""

    def __init__(self, bench: SimulatedBench, clock: Callable[[], float]) -> None:
        self._bench, self._clock, self._parser = bench, clock, StreamParser()
        self.moments: list[Moment] = []
        self.heard: dict[int, list[Heard]] = {}
        """Valid frames of the module that arrived at the host, by code."""
        self.sent: list[Request] = []
        self.sent_at: list[float] = []
        self.opened_at = self.ends_at = clock()
        self.note()

    def note(self) -> None:
        module = self._bench.module
        moment = Moment(
            self._clock(),
            tuple(read_raw(module, code) for code in _CODES),
            module.state.is_active,
            module.is_triggered,
            module.is_on,
            module.memory.boot_count,
            module.baud_rate,
            round(abs(module.world.tilt_deg - module.memory.zero_tilt_deg), 1),
            tuple(module.memory.records),
        )
        if not self.moments or moment[1:] != self.moments[-1][1:]:
            self.moments.append(moment)

    def take_arrived(self, data: bytes) -> None:
        for piece in self._parser.feed(data):
            if isinstance(piece, Frame) and piece.direction is Direction.MODULE_TO_HOST:
                self.heard.setdefault(piece.raw[2], []).append(Heard(self._clock(), piece.raw))

    def take_sent(self, data: bytes) -> None:
        for at in range(0, len(data), 6):
            self.sent.append(decode_request(data[at : at + 6]))
            self.sent_at.append(self._clock())

    def begin(self) -> None:
        """Note that a port is opened: what an earlier one heard is known to nobody any more."""
        self.heard.clear()
        self.opened_at = self._clock()
        self.note()

    def end(self) -> None:
        """Note that the command has ended."""
        self.note()
        self.ends_at = self._clock()

    # States

    @property
    def now(self) -> Moment:
        return self.moments[-1]

    def value(self, key: str, moment: Moment) -> Value:
        """Return a value in the field's unit."""
        if key == "boot_count":
            return moment.boots
        if key == "baud_rate":
            return moment.baud_rate
        if key == "active":
            return moment.is_active
        if key == "triggered":
            return moment.is_triggered
        command = BY_CODE[KEYS[key]]
        assert command.reply is not None
        return command.reply.decode(moment.raws[_CODES.index(command.code)])

    def since(self, at: float) -> Iterator[Moment]:
        """Return every state from a time until the end."""
        for moment, after in zip(self.moments, [*self.moments[1:], None], strict=True):
            if after is None or after.at >= at:
                yield moment

    def changed_at(self, key: str) -> float | None:
        """Return since when the current value holds, or None if from the start."""
        value = self.value(key, self.now)
        changed_at = None
        for before, after in zip(self.moments, self.moments[1:], strict=False):
            if self.value(key, before) != value == self.value(key, after):
                changed_at = after.at
        return changed_at

    def restarted_at(self) -> float:
        """Return when it last started; minus infinity if it has run all the time."""
        pairs = zip(self.moments, self.moments[1:], strict=False)
        return max((after.at for before, after in pairs if before.boots != after.boots), default=-math.inf)

    # Frames

    def sent_since(self, request: Request, at: float) -> list[float]:
        """Return when this frame was sent since then."""
        return [when for one, when in zip(self.sent, self.sent_at, strict=True) if one == request and when >= at]

    def last_heard(self, key: str) -> Heard | None:
        """Return the last answer for this key that arrived."""
        if key in ("active", "triggered"):
            answers = [*self.heard.get(STATUS_CODE, []), *self.heard.get(BY_NAME[key].code, [])]
            return max(answers, default=None)
        if key in ("tilt_deg", "acceleration_g"):
            code = STATUS_CODE
        elif key == "cell_voltage_v":
            both = [*self.heard.get(0x34, []), *(one for one in self.heard.get(0x35, []) if len(one.raw) == 6)]
            return max(both, default=None)
        else:
            code = {"boot_count": 0x23, "light_v": 0x14, "charging": 0x33}.get(key) or KEYS[key]
        codes = BY_CODE[code].reply_codes if code in KEYS.values() else (code,)
        return max((self.heard[code][-1] for code in codes if code in self.heard), default=None)


def settings_keys() -> list[str]:
    return [BY_CODE[code].key for code in SETTING_CODES]

"""What a person really did, what really went onto the wire and what the module really holds, kept by a witness.

Knows nothing of permits, rituals and procedures: it judges them.
"""

from collections import Counter
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from math import inf
from typing import Final

from app.engine.procedure import Cancelled, PortLost
from app.safety.acts import REQUESTS, Act
from protocol.catalogue import BAUD_RATE, SERIAL_OUTPUT, Hazard, Request

CONFIRMED_FOR_S: Final = 5.0
HELD_FOR_S: Final = 1.0
"""How long a gesture stays valid while it waits; repeats the promise of `app.safety.permit`."""
_MAX_LOCKS: Final = 50
_LOCKS_FOR_S: Final = 10.0
"""The most repetitions of one LOCK, and their time."""
_HOLD_S: Final = 2.0
_ARMED_FOR_S: Final = 10.0
_SLACK_S: Final = 1e-3
_ACTS: Final[Mapping[Request, Act]] = {request: act for act, request in REQUESTS.items()}
_LOCK: Final = REQUESTS[Act.LOCK]


@dataclass
class Hands:
    """Progress of the ritual: chosen, armed, then held by one new press for two seconds."""

    is_chosen: bool = False
    is_rehearsal: bool = False
    armed_at: float | None = None
    held_since: float | None = None

    def choose(self, *, is_rehearsal: bool) -> None:
        if not self.is_chosen:
            self.is_chosen, self.is_rehearsal = True, is_rehearsal

    def arm(self, now: float) -> None:
        if self.is_chosen and self.armed_at is None:
            self.armed_at = now

    def press(self, now: float, kind: str) -> None:
        if kind == "repeat" or self.armed_at is None:
            return
        if self.held_since is not None:
            self.leave()  # two presses at once are no single one
        elif kind == "single":
            self.held_since = now

    def release(self) -> None:
        if self.held_since is not None:
            self.leave()

    def leave(self) -> None:
        """Cancel the ritual; it starts again with choosing."""
        self.is_chosen, self.is_rehearsal, self.armed_at, self.held_since = False, False, None, None

    def take_full(self, now: float) -> bool:
        """Return whether it has just been completed, and is not a rehearsal."""
        if self.armed_at is None:
            return False
        if now - self.armed_at >= _ARMED_FOR_S:
            self.leave()
            return False
        if self.held_since is None or now - self.held_since < _HOLD_S:
            return False
        is_earnest = not self.is_rehearsal
        self.leave()
        return is_earnest


@dataclass(frozen=True)
class Gesture:
    """One complete gesture for one frame of `act`, valid until `ends_at`."""

    act: Act
    at: float
    ends_at: float


@dataclass
class Ledger:
    """Records gestures and frames; `complaints` describes each violation."""

    complaints: list[str] = field(default_factory=list)
    wire: list[tuple[float, Request]] = field(default_factory=list)
    """All frames of the host, with their times."""
    is_background_on: bool = False
    """A procedure that switches the serial output by itself is running."""
    _gestures: list[Gesture] = field(default_factory=list)
    _intents: Counter[Act] = field(default_factory=Counter)
    _leaves: dict[int, Counter[Request]] = field(default_factory=dict)
    _locks: int = 0
    _locked_at: float = -inf

    def gesture(self, act: Act, now: float) -> None:
        self._gestures.append(Gesture(act, now, now + (HELD_FOR_S if act is Act.DEPLOY else CONFIRMED_FOR_S)))

    def lock(self, now: float) -> None:
        """Note a LOCK: it cancels earlier requests, and may be repeated within limits."""
        self._locks, self._locked_at = _MAX_LOCKS, now
        self._gestures.clear()

    def intend(self, act: Act) -> None:
        self._intents[act] += 1

    def allow(self, job: int, requests: Iterable[Request]) -> None:
        """Note a click on Write: each of these is set once until `job` ends."""
        self._leaves[job] = Counter(requests)

    def end(self, job: int) -> None:
        self._leaves.pop(job, None)

    def lose(self) -> None:
        """Note that the port is gone: earlier requests must not be sent on another port."""
        self._gestures.clear()
        self._leaves.clear()
        self._locks = 0

    def feed(self, request: Request, now: float) -> None:
        """Note a frame that the host sent."""
        self.wire.append((now, request))
        if request.hazard is Hazard.NONE:
            return
        if request.hazard is Hazard.DANGEROUS:
            self._take_dangerous(request, now)
        elif request == _LOCK:
            self._locks -= 1
            if self._locks < 0 or now > self._locked_at + _LOCKS_FOR_S + _SLACK_S:
                self._complain(now, request, "LOCK that nobody pressed, or too often, or too late")
        elif not self._is_allowed(request):
            self._complain(now, request, "nobody asked for this set, or it was sent twice")

    def _take_dangerous(self, request: Request, now: float) -> None:
        act = Act.CHANGE_BAUD if request.command is BAUD_RATE else _ACTS[request]
        found = next(
            (one for one in self._gestures if one.act is act and one.at <= now <= one.ends_at + _SLACK_S), None
        )
        if found is None:
            had = [f"{one.act.value} {now - one.at:.2f} s ago" for one in self._gestures]
            self._complain(now, request, f"dangerous, without a gesture of its own; there are {had}")
        else:
            self._gestures.remove(found)
        self._intents[act] -= 1
        if self._intents[act] < 0:
            self._complain(now, request, "dangerous, without an intent in the log")

    def _is_allowed(self, request: Request) -> bool:
        for leave in self._leaves.values():
            if leave[request] > 0:
                leave[request] -= 1
                return True
        return request.command is SERIAL_OUTPUT and self.is_background_on

    def take_error(self, error: BaseException) -> None:
        """Complain about the error that ended a procedure, unless it was cancelled or lost the port."""
        if not isinstance(error, Cancelled | PortLost):
            self.complaints.append(f"a procedure ended with {error!r}")

    def _complain(self, now: float, request: Request, why: str) -> None:
        self.complaints.append(f"at {now:.3f}: {request.command.name} {request.encode().hex(' ')}: {why}")

    def sent_since(self, request: Request, at: float) -> int:
        """Return how often a frame was sent at `at` or later."""
        return sum(when >= at and one == request for when, one in self.wire)

    def last_set(self, code: int) -> tuple[float, Request] | None:
        """Return the last set of this command."""
        found = (entry for entry in reversed(self.wire) if entry[1].command.code == code and entry[1].is_set)
        return next(found, None)


@dataclass
class Truth:
    """When the module changed behind the program's back, and until when the program cannot be blamed for it.

    A restart that the line lets through must be known within `SEEN_WITHIN_S`; one that the line hid stays unknown until
    the value has been read again.
    """

    SEEN_WITHIN_S = 0.5
    LONGEST_DELAY_S = 4.0

    calm_since: float = -inf
    """Since when the line has had no fault; infinite while it has one."""
    changed: dict[str, tuple[float, float]] = field(default_factory=dict)
    """By key: when it changed, and up to which time readings may be older than that."""

    def change(self, keys: Iterable[str], now: float, *, is_audible: bool) -> None:
        is_told = is_audible and self.is_calm(now)
        self.changed |= dict.fromkeys(keys, (now, -inf if is_told else now + self.LONGEST_DELAY_S))

    def disturb(self, now: float) -> None:
        """Note that a fault begins."""
        self.calm_since = inf
        self.miss(now)

    def miss(self, now: float) -> None:
        """Note that the program may miss the current change."""
        for key, (at, _) in self.changed.items():
            if now - at <= self.SEEN_WITHIN_S:
                self.changed[key] = (at, at + self.LONGEST_DELAY_S)

    def calm(self, now: float) -> None:
        self.calm_since = min(self.calm_since, now)

    def is_calm(self, now: float) -> bool:
        """Return whether the line has been free of faults for so long that nothing late can arrive."""
        return now - self.calm_since > self.LONGEST_DELAY_S

    def changed_at(self, key: str) -> float:
        return self.changed.get(key, (-inf, -inf))[0]

    def is_excused(self, key: str, known_at: float, now: float) -> bool:
        """Return whether the value of `key` read at `known_at` may be outdated through no fault of the program."""
        at, until = self.changed.get(key, (-inf, -inf))
        return now - at <= self.SEEN_WITHIN_S or known_at <= until

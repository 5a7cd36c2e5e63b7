"""The link in conversations with honest modules and with whatever else may come, before a referee.

One input is one conversation: some requests (LOCK also in the middle of another one), answered or not, late, doubled,
in pieces, through restarts, streams, echoes and noise, on a clock that is looked at in time or somewhat late.
"""

import random
import sys
from dataclasses import dataclass, field
from enum import Enum
from typing import Final, Protocol

from protocol.catalogue import COMMANDS, HEARTBEAT, LOCK, STATUS, Request
from protocol.events import Answered, Event, OutcomeUnknown, Sent, Unanswered
from protocol.link import Link
from protocol.messages import Acknowledgement, EmptySlot, Message, Reading, Status, TriggerRecord
from tests.scenarios.fuzz import hostile_bytes
from tests.support.line.honest_module import Habits, HonestModule
from tests.support.line.reference_link import End, Referee, Told

BEGAN_S: Final = 100.0
LATENESS_S: Final = ((0.0,), (0.0,), (0.0, 0.001, 0.02), (0.0, 0.08))
WAITS_S: Final = ((1.0,), (0.2,), (0.1, 0.1), (0.15, 0.3, 1.0), (1.0, 1.0, 1.0))
IMPATIENT_S: Final = ((0.1,), (0.1, 0.1), (0.1, 0.1, 0.1))
PAUSES_S: Final = (0.0, 0.0, 0.0, 0.001, 0.01, 0.1, 0.4, 3.5, 11.0)
AT_ONCE_S: Final = (0.0, 0.0, 0.001, 0.03)
SLOW_S: Final = (0.003, 0.05, 0.2, 0.45, 1.2, 2.4)
"""Not longer than a late reply is waited for."""
LONGEST_STEPS: Final = 2000
RECORDS_CODE: Final = 0x35


def _requests() -> tuple[Request, ...]:
    made = []
    for command in COMMANDS:
        if command.query_data is not None:
            made.append(command.query())
        if command.write is not None:
            allowed = sorted(command.write.allowed)
            some = {allowed[0], allowed[-1], allowed[len(allowed) // 2]}
            made += [Request(command, 2, data) for data in sorted(some)]
    return tuple(made)


REQUESTS: Final = _requests()


class Kind(Enum):
    """Kinds of the other end."""

    DISTINCT = "honest, nothing asked twice"
    """Codes differ, so no reply is ambiguous: the whole conversation is predictable without extra queries."""
    HONEST = "honest"
    SHORT_35 = "honest, voltages with code 35"
    """E3, with replies in time or not at all, because a late one is decided only by what follows."""
    ADVERSE = "adverse"


TURNS: Final = (Kind.HONEST, Kind.ADVERSE, Kind.HONEST, Kind.DISTINCT, Kind.HONEST, Kind.SHORT_35)


class Party(Protocol):
    """The other end of the line."""

    def next_due_s(self) -> float: ...
    def write(self, raw: bytes, number: int | None, now_s: float) -> None: ...
    def read(self, now_s: float, referee: Referee) -> bytes: ...


class Adversary:
    """Not a module: its frames are right, wrong, early, cut and repeated at random."""

    def __init__(self, source: random.Random) -> None:
        self._source = source
        self._honest = HonestModule(source, Habits(voltage_as_35=source.random() < 0.5))
        self._due_s = BEGAN_S
        self._left = b""
        self._heard: list[bytes] = []

    def next_due_s(self) -> float:
        return self._due_s

    def write(self, raw: bytes, _number: int | None, _now_s: float) -> None:
        self._heard.append(raw)

    def read(self, now_s: float, referee: Referee) -> bytes:
        if now_s < self._due_s:
            return b""
        self._due_s = now_s + self._source.choice((0.001, 0.01, 0.1, 0.3, 1.0))
        data, self._left = self._left + self._piece(), b""
        if self._source.random() < 0.3:
            place = self._source.randrange(len(data) + 1)
            data, self._left = data[:place], data[place:]
        referee.heard(data)
        return data

    def _piece(self) -> bytes:
        kind = self._source.randrange(4)
        if kind == 0:
            return hostile_bytes(self._source)
        if kind == 1 and self._heard:
            return self._heard[-1]
        is_stray = kind == 2 or not self._heard
        asked = self._source.choice(REQUESTS).encode() if is_stray else self._heard[-1][-6:]
        return b"".join(self._honest.answers(asked))


@dataclass(slots=True)
class Conversation:
    """One conversation; after `run` the referee holds the faults."""

    source: random.Random
    kind: Kind
    referee: Referee = field(init=False)
    steps: int = 0
    _now_s: float = BEGAN_S
    _link: Link = field(init=False)
    _party: Party = field(init=False)
    _number: int = 0
    _to_ask: list[Request] = field(init=False)
    _lateness_s: tuple[float, ...] = field(init=False)
    _waits_s: tuple[tuple[float, ...], ...] = field(init=False)
    _pauses_s: tuple[float, ...] = field(init=False)
    _abandons: float = 0.0
    _restarts: float = 0.0

    def __post_init__(self) -> None:
        choose = self.source.choice
        self.referee = Referee(is_certain=self.kind is not Kind.ADVERSE)
        self._link = Link(self._now_s)
        self._lateness_s = choose(LATENESS_S)
        self._waits_s = choose((WAITS_S, IMPATIENT_S))
        self._pauses_s = choose((PAUSES_S, AT_ONCE_S))
        count = self.source.randint(1, 10)
        self._to_ask = [choose(REQUESTS) for _ in range(count)]
        if self.kind is Kind.DISTINCT:
            by_code = {_family(one): one for one in self._to_ask if one != HEARTBEAT.query()}
            self._to_ask = list(by_code.values())
        elif choose((True, False)):  # a few, again and again: what can be mistaken for each other
            few = [choose(REQUESTS), choose(REQUESTS), choose((STATUS.query(), HEARTBEAT.query(), LOCK))]
            code = choose(few).command
            few += [request for request in REQUESTS if request.command.reply_codes & code.reply_codes]
            self._to_ask = [choose(few) for _ in range(count)]
        if self.kind in (Kind.HONEST, Kind.ADVERSE):
            self._abandons = choose((0.0, 0.0, 0.05, 0.3))
            self._restarts = choose((0.0, 0.0, 0.05))
        self._party = Adversary(self.source) if self.kind is Kind.ADVERSE else self._module()

    def _module(self) -> HonestModule:
        choose = self.source.choice
        is_short_35 = self.kind is Kind.SHORT_35
        slowest = choose((1, 1, 2, 4, 6))
        # A copy follows at once, also as the reader sees it: it is in one piece, and nobody reads late.
        doubled = 0.0 if is_short_35 or self._lateness_s[-1] > 0 else choose((0.0, 0.3, 1.0))
        habits = Habits(
            delays_s=(0.003, 0.05) if is_short_35 else SLOW_S[:slowest],
            dropped=choose((0.0, 0.0, 0.2, 0.7)),
            doubled=doubled,
            cut=0.0 if is_short_35 or doubled else choose((0.0, 0.3)),
            noise=choose((0.0, 0.0, 0.4)),
            echo=choose((False, False, True)),
            streams_every_s=choose((None, None, 0.1, 0.7)),
            voltage_as_35=is_short_35,
            freefall_as_16=choose((False, True)),
            acknowledges_by_one=choose((False, True)),
            gap_s=choose((0.0, 0.0, 0.005, 0.03)),
        )
        module = HonestModule(self.source, habits)
        module.stream(BEGAN_S + self.source.random(), BEGAN_S + 8.0)
        return module

    def run(self) -> None:
        """Run until every request has ended."""
        ask_at_s = BEGAN_S
        while self._to_ask or self.referee.asked is not None:
            is_free = self.referee.asked is None and self._link.is_idle
            dues = [self._link.next_deadline(), self._party.next_due_s()]
            if is_free:
                dues.append(ask_at_s)
            self._now_s = max(self._now_s, min(dues)) + self.source.choice(self._lateness_s)
            was_waiting = self.referee.asked
            self._hear()
            self._look()
            if was_waiting is not None and self.referee.asked is None:
                ask_at_s = self._now_s + self.source.choice(self._pauses_s)
            self._act(ask_at_s)
            self.steps += 1
            if self.steps > LONGEST_STEPS:
                self.referee.faults.append("the conversation does not end")
            if self.referee.faults:
                return

    def _act(self, ask_at_s: float) -> None:
        """Do a random action of the caller, or a random event of the module."""
        chance = self.source.random
        if self._restarts and chance() < self._restarts and isinstance(self._party, HonestModule):
            self._party.restart(self._now_s)
        if not self._link.is_idle and self._abandons and chance() < self._abandons:
            self.referee.abandon()
            self._settle(self._link.abandon(self._now_s))
            if chance() < 0.5:
                self._ask(LOCK)
        elif self._to_ask and self.referee.asked is None and self._link.is_idle and self._now_s >= ask_at_s:
            self._ask(self._to_ask.pop())

    def _ask(self, request: Request) -> None:
        waits_s = self.source.choice(self._waits_s)
        raw = request.encode()
        self._number += 1
        self.referee.ask(raw, self._now_s, waits_s)
        self._settle(self._link.ask(request, self._now_s, waits_s=waits_s, is_deliberate=True))

    def _hear(self) -> None:
        data = self._party.read(self._now_s, self.referee)
        if data:
            self._settle(self._link.receive(data, self._now_s))

    def _look(self) -> None:
        self._settle(self._link.tick(self._now_s))
        self.referee.looked(self._now_s, late_s=self._lateness_s[-1])

    def _settle(self, events: list[Event]) -> None:
        written = self._link.take_outgoing()
        if written != b"".join([event.raw for event in events if isinstance(event, Sent)]):
            self.referee.faults.append("what is said to be sent is not what went out")
        told = [one for event in events if (one := _told(event)) is not None]
        if written:
            self.referee.wrote(written, self._now_s)
        self.referee.settled(told, self._now_s)
        if written:
            asked = self.referee.asked
            number = self._number if asked is not None and asked.is_written else None
            self._party.write(written, number, self._now_s)


def _family(request: Request) -> int:
    return {0x17: 0x16, 0x34: RECORDS_CODE}.get(request.command.code, request.command.code)


def _told(event: Event) -> Told | None:
    match event:
        case Answered():
            values = tuple(_values(message) for message in event.messages)
            return Told(event.request.encode(), End.ANSWERED, values, event.attempts, event.round_trip_s)
        case Unanswered():
            return Told(event.request.encode(), End.UNANSWERED, attempts=event.attempts)
        case OutcomeUnknown():
            return Told(event.request.encode(), End.UNKNOWN)
        case _:
            return None


def _values(message: Message) -> tuple[int, ...]:
    """Return a request's bytes."""
    match message:
        case Reading(raw=raw) | Acknowledgement(raw=raw):
            return (raw,)
        case Status():
            return (message.tilt_deg, round(message.acceleration_g * 10), int(message.triggered), int(message.active))
        case TriggerRecord(raw=frame) | EmptySlot(raw=frame):
            return tuple(frame[4:-1])
        case _:
            return ()


@dataclass(slots=True)
class LinkStatistics:
    """Counts of a run."""

    inputs: int = 0
    steps: int = 0
    ends: dict[End, int] = field(default_factory=lambda: dict.fromkeys(End, 0))
    faults: int = 0


def kind_of(seed: int) -> Kind:
    """Return the kind of the n-th conversation; half of them are with honest modules."""
    return TURNS[seed % len(TURNS)]


def converse(seed: int, kind: Kind) -> Conversation:
    """Run one conversation to its end."""
    conversation = Conversation(random.Random(seed), kind)
    conversation.run()
    return conversation


def fuzz_link(count: int, seed: int) -> LinkStatistics:
    """Run `count` conversations of the kinds in `TURNS`; print faults and how to repeat them to standard error."""
    figures = LinkStatistics()
    for number in range(count):
        one = converse(seed + number, kind_of(seed + number))
        figures.inputs += 1
        figures.steps += one.steps
        for end, ended in one.referee.ends.items():
            figures.ends[end] += ended
        for fault in one.referee.faults[:1]:
            figures.faults += 1
            print(f"converse({seed + number}, {one.kind}): {fault}", file=sys.stderr)
    return figures

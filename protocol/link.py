"""Conversation with one module, sans I/O: bytes and `now` in, bytes and events out.

Rules:

- One request is in flight. Replies are matched by request, never by position.
- Only questions are repeated. A set or an act is sent once; unanswered, it is `OutcomeUnknown`.
- The one exception is LOCK (`lock_again`): locking twice has the effect of locking once and cannot make a module fire,
  while a lost LOCK leaves a module active beside a person who believes otherwise. So it is repeated, whatever is in
  flight, until the module reports that it is locked.
- A module answers in the order in which it was asked: once a later request is answered, no earlier reply can come.
  Where an earlier reply could be mistaken for the present one (the acknowledgement of a set for its read-back, a
  trigger record for a cell voltage, 16 for 17), the link first sends a *fence*: a heartbeat, or another harmless
  question where a heartbeat may come unasked. Everything before the fence's answer is late. See `StaleReplies`.
- A frame that began before a request was sent is not its answer.
- Some modules need a pause before they listen again, so a request may wait (`protocol.request_gap`); LOCK never does.
- A status carries the earliest time at which it can have been sent, as a line may delay everything (`protocol.lag`).
- Two heartbeats that nobody asked for are a restart; where nothing answers for a moment, but to 35, it is `FellSilent`.
- 16 and 17 are set only when no answer to an earlier set can be taken for theirs (`protocol.flag_answers`).
- Two different answers to one question end whatever was asked: `Contradicted` (`protocol.contradictions`).
- After ten seconds without a valid frame a heartbeat is sent; if it is not answered, the module is offline.

The owner writes the bytes of `take_outgoing` after each call, and calls `tick` no later than `next_deadline`.
All changes of the exchange's state go through the table of `link_states`.
"""

from math import inf

from protocol.catalogue import HEARTBEAT, LOCK, STATUS, Hazard, Layout, Request
from protocol.contradictions import ToldValues
from protocol.events import (
    Answered,
    Contradicted,
    Counters,
    Event,
    FellSilent,
    OutcomeUnknown,
    Received,
    Rejected,
    Restarted,
    Role,
    Sent,
    Unanswered,
    WentOffline,
    WentOnline,
)
from protocol.flag_answers import FLAG_CODES, FlagAnswers
from protocol.frame import Direction, Frame, Noise
from protocol.lag import Lag
from protocol.link_states import EXCHANGE, Exchange, Flight, Presence, Step
from protocol.messages import Heartbeat, Message, Reading, Status, answers, decode
from protocol.request_gap import Gap
from protocol.round_trips import RoundTrips, Timing
from protocol.stale_replies import StaleReplies
from protocol.stream import Piece, StreamParser


class LinkMisused(RuntimeError):
    """A bug in the caller: a second request while one is in flight, or a dangerous one without an explicit act."""


_HEARTBEAT = HEARTBEAT.query()


class Link:
    """The conversation through one opened port; see the module's docstring."""

    def __init__(self, now: float, *, timing: Timing | None = None, before: "Link | None" = None) -> None:
        """`before`: the link on the same port that this one replaces; its measurements are kept."""
        self.timing = timing or Timing()
        self.counters: Counters = Counters() if before is None else before.counters
        self.round_trips: RoundTrips = RoundTrips() if before is None else before.round_trips
        self.gap: Gap = Gap() if before is None else before.gap
        self.lag: Lag = Lag(now) if before is None else before.lag
        self.flags: FlagAnswers = FlagAnswers(now, self.timing) if before is None else before.flags
        self.told = ToldValues(self.timing)
        self.exchange = Exchange.IDLE
        self.presence = Presence.UNKNOWN
        self._parser = StreamParser()
        self._outgoing = bytearray()
        self._flight: Flight | None = None
        self._behind_fence: Flight | None = None
        self._stale = StaleReplies(self.timing)
        self._unasked_heartbeat_at: float | None = None
        self.unanswered_since: float | None = None if before is None else before.unanswered_since
        self.has_timed_out: bool = before is not None and before.has_timed_out  # since the last frame
        self._last_byte_at = self._proven_at = -inf
        self._probe_at = now + self.timing.heartbeat_every_s

    @property
    def is_idle(self) -> bool:
        return self.exchange is Exchange.IDLE

    @property
    def has_left(self) -> bool:
        """Whether the request in flight was sent; it may still wait for a fence or for a quiet line."""
        return self._behind_fence is None and self._flight is not None and self._flight.attempt > 0

    def ask(
        self,
        request: Request,
        now: float,
        *,
        waits_s: tuple[float, ...] | None = None,
        attempts: int | None = None,
        is_deliberate: bool = False,
        is_fenced: bool = False,
    ) -> list[Event]:
        """Send `request`, unless it sets 16 or 17 too early (`FlagAnswers.free_at`).

        Exactly one of `Answered`, `Unanswered` and `OutcomeUnknown` follows later.

        `waits_s`: how long each attempt waits for the answer, by default as measured; `attempts`: only the first ones
        of these. A request that must not be repeated has one attempt. A dangerous request needs `is_deliberate`. With
        `is_fenced` another question is answered first, so that the answer cannot be older than this call. Raises
        `LinkMisused` while another request is in flight.
        """
        if not self.is_idle:
            raise LinkMisused(f"{request.command.name} asked while the link is {self.exchange.name}")
        if request.hazard is Hazard.DANGEROUS and not is_deliberate:
            raise LinkMisused(f"{request.command.name} is dangerous and was not asked for by an explicit act")
        if now < self.flags.free_at(request):
            return [Unanswered(request, 0, 0.0, now)]
        if request.command.layout is Layout.RECORD or not request.is_repeatable:
            waits = (waits_s or (self.timing.answer_s,))[:1]
        else:
            waits = (waits_s or self.round_trips.waits_s(self.timing))[:attempts]
        flight = Flight(request, waits)
        self._stale.drop_expired(now)
        # LOCK must not wait, and the state is read afterwards.
        if is_fenced or (request != LOCK and self._stale.could_answer(request, now)):
            self._behind_fence = flight
            self._move(Step.ASK_BEHIND_FENCE)
            fence = self._stale.fence(now, is_proof=is_fenced)
            return self._hold(Flight(fence, self.round_trips.waits_s(self.timing)), now, now)
        self._move(Step.ASK)
        return self._hold(flight, now, now)

    def abandon(self, now: float) -> list[Event]:
        """Stop waiting for the request in flight, if any; a reply to it is late from now on.

        A set or an act that was sent is `OutcomeUnknown`: it may have been carried out.
        """
        events: list[Event] = []
        if (flight := self._flight) is not None and flight.attempt:
            self._stale.expect_late(flight.request, now, count=flight.attempt)
            if not flight.request.is_repeatable:
                events.append(OutcomeUnknown(flight.request, now - flight.sent_at, now))
        self._behind_fence = None
        self._finish(Step.ABANDON)
        return events

    def lock_again(self, now: float, attempt: int) -> list[Event]:
        """Send LOCK beside the request in flight; see the module's docstring. Its acknowledgement proves nothing: the
        owner asks for the state afterwards."""
        raw = LOCK.encode()
        self._outgoing += raw
        self.counters.sent += 1
        self.counters.retries += 1
        self._stale.expect_late(LOCK, now, count=1)
        return [Sent(raw, LOCK, attempt, now)]

    def begin_again(self) -> None:
        """A person said that another module answers from now on: nothing that was told before counts."""
        self.told.forget()
        self.flags.begin_again()

    def take_outgoing(self) -> bytes:
        """Return the bytes to write, each once."""
        outgoing = bytes(self._outgoing)
        self._outgoing.clear()
        return outgoing

    def receive(self, data: bytes, now: float) -> list[Event]:
        """Take in `data`, just read from the port."""
        if not data:
            return []
        self._last_byte_at = now
        self.counters.bytes_received += len(data)
        events: list[Event] = []
        for piece in self._parser.feed(data):
            self._digest(piece, now, events)
        if self._flight is not None and self._flight.held_until is not None:
            events += self._release(self._flight, now)
        return events

    def tick(self, now: float) -> list[Event]:
        """Do what is due; idempotent for the same `now`."""
        events: list[Event] = []
        if self._parser.pending and now >= self._last_byte_at + self.timing.quiet_s:
            for piece in self._parser.flush():
                self._digest(piece, now, events)
        suspicion = self._unasked_heartbeat_at
        if suspicion is not None and now >= suspicion + self.timing.restart_s:
            self._restart(events, now, is_certain=False)
        if self._flight is not None and now >= self._flight.deadline:
            self._run_out(self._flight, now, events)
        if self.is_idle and now >= self._probe_at:
            self._move(Step.PROBE)
            events += self._send(Flight(_HEARTBEAT, (self.timing.answer_s,)), now)
        return events

    def next_deadline(self) -> float:
        """When to call `tick` if nothing arrives before."""
        deadlines = [self._probe_at if self._flight is None else self._flight.deadline]
        if self._parser.pending:
            deadlines.append(self._last_byte_at + self.timing.quiet_s)
        if self._unasked_heartbeat_at is not None:
            deadlines.append(self._unasked_heartbeat_at + self.timing.restart_s)
        return min(deadlines)

    # Sending

    def _move(self, step: Step) -> None:
        self.exchange = EXCHANGE[self.exchange, step]

    def _hold(self, flight: Flight, until: float, now: float) -> list[Event]:
        """Send it at `until`, or as soon afterwards as the line is ready."""
        return self._release(flight._replace(held_until=until), now)

    def _release(self, flight: Flight, now: float) -> list[Event]:
        until = now if flight.held_until is None else flight.held_until
        due = self.gap.due(flight.request, until, is_repeated=flight.attempt > 0, now=now)
        if now < due:
            self._flight = flight._replace(deadline=due)
            return []
        if self.exchange is Exchange.DRAINING:
            self._move(Step.QUIET)
        return self._send(flight, now)

    def _send(self, flight: Flight, now: float) -> list[Event]:
        if not flight.attempt:
            flight = flight._replace(received_before=self._parser.end)
        deadline = now + flight.waits_s[flight.attempt]
        self._flight = flight._replace(attempt=flight.attempt + 1, sent_at=now, deadline=deadline, held_until=None)
        self.unanswered_since = self.unanswered_since or now
        self.gap.sent(is_repeated=flight.attempt > 0, now=now)
        self.lag.ask(flight.request, now)
        self.flags.on_sent(flight.request, now)
        self.told.on_sent(flight.request, now)
        self.counters.retries += flight.attempt > 0
        self.counters.sent += 1
        self._parser.asked = flight.request
        raw = flight.request.encode()
        self._outgoing += raw
        return [Sent(raw, flight.request, flight.attempt + 1, now)]

    # Receiving

    def _digest(self, piece: Piece, now: float, events: list[Event]) -> None:
        if isinstance(piece, Noise):
            self.counters.rejected_bytes[piece.reason] += len(piece.raw)
            events.append(Rejected(piece, now))
            return
        self.counters.frames += 1
        if piece.direction is Direction.HOST_TO_MODULE:
            self._note(events, piece, None, Role.ECHO, now)
            return
        self._prove(now, events)
        if answers(piece.raw, _HEARTBEAT):
            self._stale.on_heartbeat(now)
        flight = self._flight
        if flight is not None and self._is_answer(flight, piece, now):
            if piece.raw[2] in FLAG_CODES:
                self.flags.on_answer(flight.request, piece.raw, now)
            self._on_answer(flight, piece, now, events)
        else:
            if piece.raw[2] in FLAG_CODES:
                self.flags.on_other(piece.raw, now)
            self._on_other(piece, now, events)

    def _note(self, events: list[Event], frame: Frame, message: Message | None, role: Role, now: float) -> None:
        self.counters.by_role[role] += 1
        sent_after = self.lag.sent_after
        if role in (Role.STREAMED, Role.UNSOLICITED):
            self.lag.on_unsolicited(now)
        if role is Role.STREAMED:
            self.gap.on_streamed(now)
        elif role is not Role.ECHO:
            self.gap.on_reply(now)
        if isinstance(message, Status) and role is Role.ANSWER:
            sent_after = self.lag.answer_sent_after(STATUS.query(), now)
        events.append(Received(frame, message, role, now, sent_after))

    def _prove(self, now: float, events: list[Event]) -> None:
        self._note_silence(now, events)
        self._proven_at, self.unanswered_since, self.has_timed_out = now, None, False
        self.lag.heard_at = now
        self._probe_at = now + self.timing.heartbeat_every_s
        if self.presence is not Presence.ONLINE:
            self.presence = Presence.ONLINE
            events.append(WentOnline(now))

    def _is_answer(self, flight: Flight, frame: Frame, now: float) -> bool:
        if not flight.attempt or frame.offset < flight.received_before or not answers(frame.raw, flight.request):
            return False
        return self.exchange is not Exchange.FENCING or self._stale.opens(flight.request, frame.raw, now)

    def _on_answer(self, flight: Flight, frame: Frame, now: float, events: list[Event]) -> None:
        message = decode(frame.raw, flight.request)
        self._note(events, frame, message, Role.ANSWER, now)
        if self._contradicts(message, now, events, is_answer=True):
            return
        may_be_copy = self._stale.copied(frame.raw, now) is not None
        self._stale.expect_copy(frame.raw, flight.request, now)
        if flight.request.command.layout is Layout.RECORD:
            self.lag.answer(flight.request, now)
            self._collect(flight, message, now)
            return
        is_timed = flight.attempt == 1 and not self.lag.may_be_streamed(flight.request, now)
        round_trip_s = now - flight.sent_at if is_timed else None
        if round_trip_s is not None:
            self.round_trips.add(round_trip_s)
        if may_be_copy:
            self.lag.answer_or_copy(flight.request)
        else:  # a copy of the answer to the same question before says nothing about later requests
            self._stale.on_answered(flight.request, now)
            self.gap.answered()
            self.lag.answer(flight.request, now)
        # If a copy was taken for the answer, the status that still follows is the answer and not streamed.
        owed = flight.attempt - 1 + (may_be_copy and flight.request.command is STATUS)
        if owed:
            self._stale.expect_late(flight.request, now, count=owed)
        elif may_be_copy or not flight.request.is_repeatable:
            self._stale.remember(flight.request)
        fenced, self._behind_fence = self._behind_fence, None
        probing = self.exchange is Exchange.PROBING
        self._finish(Step.ANSWER)
        if fenced is not None:
            events += self._hold(fenced, now, now)
        elif not probing:
            events.append(Answered(flight.request, (message,), flight.attempt, round_trip_s, now))

    def _finish(self, step: Step) -> None:
        self._move(step)
        self._flight = None
        self._parser.asked = None

    def _collect(self, flight: Flight, message: Message, now: float) -> None:
        ends = flight.collects_until or now + self.timing.records_longest_s
        deadline = min(ends, now + self.timing.records_quiet_s)
        self._flight = flight._replace(messages=(*flight.messages, message), deadline=deadline, collects_until=ends)

    def _on_other(self, frame: Frame, now: float, events: list[Event]) -> None:
        """Take a frame that does not answer the request in flight."""
        self._stale.drop_expired(now)
        earlier = self._stale
        copied = earlier.copied(frame.raw, now)
        if copied is not None:  # before "late": a copy must not stand for a reply that is still to come
            message = decode(frame.raw, copied.request)
            if not earlier.is_owed(frame.raw):
                self.told.note_unasked(message, now)
            role = Role.LATE if copied.is_late else Role.DUPLICATE
            if isinstance(message, Status):
                earlier.expect_no_copy(frame.raw)  # the next ones may be streamed
            self._note(events, frame, message, role, now)
            return
        late = earlier.pop_late(frame.raw)
        if late is not None:
            self.lag.answer(late, now)
            earlier.expect_copy(frame.raw, late, now, is_late=True)
            message = decode(frame.raw, late)
            self._note(events, frame, message, Role.LATE, now)
            self._contradicts(message, now, events, is_answer=False)
            return
        message = decode(frame.raw)
        role = Role.STREAMED if isinstance(message, Status) else Role.UNSOLICITED
        self._note(events, frame, message, role, now)
        self.told.note_unasked(message, now)
        self._contradicts(message, now, events, is_answer=False)
        if isinstance(message, Heartbeat):
            earlier.expect_copy(frame.raw, None, now)
            if self._unasked_heartbeat_at is None:
                self._unasked_heartbeat_at = now
            else:
                self._restart(events, now, is_certain=True)

    def _contradicts(self, message: Message, now: float, events: list[Event], *, is_answer: bool) -> bool:
        """Whether it says otherwise than what was told before; nothing that waits is sent then."""
        before = self.told.contradicted(message, now, is_answer=is_answer)
        if before is None or not isinstance(message, Reading):
            return False
        events += self.abandon(now)
        self.begin_again()
        events.append(Contradicted(before, message, now))
        return True

    def _restart(self, events: list[Event], now: float, *, is_certain: bool) -> None:
        # Earlier requests are not forgotten: the heartbeats may be late replies, followed by others.
        self._unasked_heartbeat_at = None
        self.counters.restarts += 1
        self.begin_again()
        events.append(Restarted(is_certain, now))

    # Time

    def _run_out(self, flight: Flight, now: float, events: list[Event]) -> None:
        if flight.held_until is not None:
            events += self._release(flight, now)
            return
        if flight.messages:
            self._stale.remember(flight.request)
            self._finish(Step.ANSWER)
            events.append(Answered(flight.request, flight.messages, flight.attempt, None, now))
            return
        self.counters.time_outs += 1
        self.has_timed_out |= flight.request.command.layout is not Layout.RECORD
        self._note_silence(now, events)
        if flight.attempt < len(flight.waits_s):
            self._move(Step.TIME_OUT)
            is_draining = self.exchange is Exchange.DRAINING
            events += self._hold(flight, now + is_draining * self.timing.drain_s, now)
            return
        self._give_up(flight, now, events)

    def _note_silence(self, now: float, events: list[Event]) -> None:
        lasted_s = now - (self.unanswered_since or now)
        if self.has_timed_out and lasted_s >= self.timing.silent_gap_s:
            self.told.forget()
            events.append(FellSilent(now, lasted_s))

    def _give_up(self, flight: Flight, now: float, events: list[Event]) -> None:
        fenced, self._behind_fence = self._behind_fence, None
        probing = self.exchange is Exchange.PROBING
        self._finish(Step.GIVE_UP)
        self._stale.expect_late(flight.request, now, count=flight.attempt)
        self._probe_at = now + self.timing.probe_after_s
        if flight.request == _HEARTBEAT:
            self._probe_at = now + self.timing.offline_probe_s
            is_proven_otherwise = self._proven_at >= flight.sent_at
            if self.presence is not Presence.OFFLINE and not is_proven_otherwise:
                self.presence = Presence.OFFLINE
                self.begin_again()
                events.append(WentOffline(now))
        if probing:
            return
        waited_s = flight.waits_s[-1]
        if fenced is not None:
            events.append(Unanswered(fenced.request, 0, waited_s, now))
        elif flight.request.is_repeatable:
            events.append(Unanswered(flight.request, flight.attempt, waited_s, now))
        else:
            events.append(OutcomeUnknown(flight.request, waited_s, now))

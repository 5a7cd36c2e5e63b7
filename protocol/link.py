"""One line, one conversation after another, sans I/O: bytes and `now` in, bytes and events out.

    beginning  --boot count answered behind a fence-->                      Began
    begun      --restart, silence, contradiction, or its owner's reason-->  Ended, and it begins again

In a conversation all frames come from one module. The link asks for the boot count when nobody asks anything, so that a
module cannot be exchanged unseen: no other part of the program watches for a silence.

Rules:

- One request of the owner, or of the link itself, is in flight. Replies are matched by request, never by position.
- Only questions are repeated. A set, an act or the query of the trigger records is sent once. The one exception is LOCK
  (`lock_again`): locking twice has the effect of locking once and cannot make a module fire, while a lost LOCK leaves a
  module active beside a person who believes otherwise. So it is repeated, whatever is in flight.
- A module answers in the order in which it was asked. So where an answer fails to come, the boot count is asked behind
  it (a *probe*): once that is answered the other answer is lost. Where an earlier reply could be mistaken for the
  present one (the acknowledgement of a set for its read-back, a trigger record for a cell voltage, 16 for 17), another
  question is answered first (a *fence*). See `StaleReplies`.
- A frame that began before a request was sent is not its answer.
- Without a valid frame for `silence_s`, although something was asked, the conversation ends. The first frame after such
  a time may be another module's, so it ends it, too; but the reply to what was sent once, before, is its module's.
- Where the owner does not call `tick` for `silence_s`, this program stood still and nobody knows what happened
  meanwhile: that ends the conversation, too, and nothing that changes the module is sent before.
- An unasked heartbeat is a restart if it cannot be a late answer, or if two come; else the boot count is asked at once.
- A boot count or a setting that reads otherwise, though nobody set it, ends the conversation (`contradictions`).
- Some modules need a pause before they listen again, so a request may wait (`request_gap`); LOCK never does.
- 16 and 17 are set only when no answer to an earlier set can be taken for theirs (`flag_answers`).

The owner writes the bytes of `take_outgoing` after each call, and calls `tick` after each `receive` and no later than
`next_deadline`. Counters, learnt pauses, replies that may still come, and 16 and 17 outlive a conversation.
"""

import logging
from collections.abc import Callable
from math import inf

from protocol import timing
from protocol.catalogue import BOOT_COUNT, BOOTS, HEARTBEAT, LOCK, STATUS, Hazard, Layout, Request
from protocol.events import (
    Answered,
    Began,
    Contradiction,
    Counters,
    Ended,
    EndReason,
    Event,
    Received,
    Rejected,
    Role,
    Sent,
    Unanswered,
)
from protocol.messages import (
    Direction,
    EmptySlot,
    Frame,
    Heartbeat,
    Message,
    Noise,
    Reading,
    Status,
    TriggerRecord,
    answers,
    decode,
)
from protocol.stale_replies import FENCES, FLAG_CODES, FlagAnswers, LastingValues, StaleReplies
from protocol.stream import Piece, StreamParser
from protocol.timing import Gap, RoundTrips

_log = logging.getLogger(__name__)
_HEARTBEAT = HEARTBEAT.query()
_BOOTS = BOOT_COUNT.query()
MOST_PROBES = 2 * timing.TRIES  # so often the boot count is asked, until the module counts as silent
MAX_STARTS = 3  # a module starts no more often between two of its answers; 256 starts are counted


class LinkMisused(RuntimeError):
    """A bug in the caller: a second request while one is in flight, or a dangerous one without an explicit act."""


class _Flight:
    """The request in flight. Times are the link's `now`."""

    def __init__(
        self, request: Request, now: float, *, is_own: bool, limit_s: float, behind: "_Flight | None" = None
    ) -> None:
        self.request = request
        self.is_own = is_own  # the link's own question, not its owner's
        self.behind = behind  # what waits for the answer, where this is a fence
        self.limit_s = limit_s
        self.wanted_at = now  # since when its next frame waits for a quiet line
        self.attempts = self.probes = 0
        self.first_at = self.sent_at = 0.0  # when it was first and last sent
        self.probed_at = -inf
        # Bytes received when it was first sent: a frame that began among them is not its answer.
        self.received_before = 0
        self.records: list[Message] = []
        self.record_at = 0.0
        self.is_past = False  # a probe was answered since the last record: no more can come
        # A set, an act or the query of the trigger records: never repeated.
        self.is_once = request.command.layout is Layout.RECORD or not request.is_repeatable

    def unanswered(self, now: float) -> list[Event]:
        """What its owner is told if it is not answered."""
        if self.is_own:
            return []
        if self.behind is not None:
            return self.behind.unanswered(now)
        return [Unanswered(self.request, self.attempts, now - self.first_at if self.attempts else 0.0, now)]


_Step = Callable[[_Flight, float], None]


class Link:
    """See the module's docstring."""

    def __init__(self, now: float, shortest_silence_s: float = timing.SHORTEST_SILENCE_S) -> None:
        """`shortest_silence_s`: longer where somebody else watches for shorter ones."""
        self._shortest_silence_s = shortest_silence_s
        # What is the line's, so that it outlives a conversation, and a change of the port's rate.
        self.counters = Counters()
        self.gap = Gap()
        self.flags = FlagAnswers(now)
        self._stale = StaleReplies()
        self._events: list[Event] = []
        self._outgoing = bytearray()
        self._flight: _Flight | None = None
        self.reset(now)

    def reset(self, now: float) -> None:
        """The port runs at another rate now: what was received at the old one is no part of a frame."""
        self.lasting = LastingValues()
        self._parser = StreamParser()
        self._outgoing.clear()  # what was to leave at the old one
        self._last_byte_at = -inf
        self._turned_at = now  # when its owner called `tick` last
        self._valid_at = now  # when the last valid frame came, or the conversation began
        self._boots_sent_at = self._heartbeat_sent_at = now
        self._restarted_at = -inf
        self._await_module(now)

    def _await_module(self, now: float) -> None:
        self.is_begun = False
        self.round_trips = RoundTrips(self._shortest_silence_s)  # of this conversation
        self._begin_at = now  # when the link asks for the next one
        self._boots_are_due = False  # an unasked heartbeat came
        self._unasked_at = -inf  # when the last one came that may be a late answer
        # Since the last answer that its owner was told; see `Answered`.
        self._rejected = self._strays = 0

    # The owner's side

    @property
    def is_idle(self) -> bool:
        return self._flight is None

    @property
    def is_own(self) -> bool:
        return self._flight is not None and self._flight.is_own

    @property
    def lag_s(self) -> float | None:
        """How long answers take in this conversation; None until one is measured."""
        return self.round_trips.usual_s

    @property
    def allows_commands(self) -> bool:
        """Whether sets and acts may be sent: a report may be too old on a slow line."""
        return self.lag_s is not None and self.lag_s <= timing.SLOW_S

    def has_stood_still(self, now: float) -> bool:
        """Whether this program did since the last `tick`, so that another module may answer now."""
        return now - self._turned_at > self.round_trips.silence_s

    def ask(
        self,
        request: Request,
        now: float,
        *,
        is_fenced: bool = False,
        is_deliberate: bool = False,
        limit_s: float = inf,
    ) -> list[Event]:
        """Send `request`, unless it sets 16 or 17 too early (`FlagAnswers.free_at`), or the module may have restarted.

        `Answered` or `Unanswered` follows. A dangerous request needs `is_deliberate`. With
        `is_fenced` another question is answered first, so that the answer cannot be older than this call. After
        `limit_s` it is given up. Raises `LinkMisused` while another request is in flight.
        """
        if self._flight is not None:
            raise LinkMisused(f"{request.command.name} asked while a request is in flight")
        # The last look before the wire: no mistake further up may fire a parachute.
        if request.hazard is Hazard.DANGEROUS and not is_deliberate:
            raise LinkMisused(f"{request.command.name} is dangerous and was not asked for by an explicit act")
        is_change = not request.is_repeatable and request != LOCK
        # Not sent rather than sent later: what its owner has just found out would be old by then.
        if now < self.flags.free_at(request) or (is_change and (self._boots_are_due or self.has_stood_still(now))):
            return [Unanswered(request, 0, 0.0, now)]
        self._take_off(request, now, is_own=False, is_fenced=is_fenced, limit_s=limit_s)
        return self._take_events()

    def abandon(self, now: float) -> list[Event]:
        """Stop waiting for the request in flight, if any; a reply to it is late from now on."""
        flight = self._drop_flight()
        return [] if flight is None else flight.unanswered(now)

    def lock_again(self, now: float, attempt: int) -> list[Event]:
        """Send LOCK beside the request in flight; see the module's docstring. Its acknowledgement proves nothing: the
        owner asks for the state afterwards."""
        self._stale.expect_late(LOCK, now, count=1)
        self._put(LOCK, attempt, now)
        return self._take_events()

    def end(self, reason: EndReason, now: float) -> list[Event]:
        """End the conversation for a reason that the owner knows. What is in flight is not waited for any more."""
        self._end(reason, now)
        return self._take_events()

    def take_outgoing(self) -> bytes:
        outgoing = bytes(self._outgoing)
        self._outgoing.clear()
        return outgoing

    def receive(self, data: bytes, now: float) -> list[Event]:
        if data:
            self._last_byte_at = now
        self.counters.bytes_received += len(data)
        for piece in self._parser.feed(data):
            self._digest(piece, now)
        return self._take_events()

    def tick(self, now: float) -> list[Event]:
        if self._parser.pending and now >= self._last_byte_at + timing.QUIET_S:
            for piece in self._parser.flush():
                self._digest(piece, now)
        flight = self._flight
        if self.is_begun and (self.has_stood_still(now) or (flight is not None and now >= self._silent_at(flight))):
            self._end_silent(now)
        self._turned_at = now
        self._advance(now)
        if self._flight is None and now >= self._own_due_at():
            is_heartbeat_due = now >= self._heartbeat_sent_at + timing.HEARTBEAT_EVERY_S
            request = _HEARTBEAT if self.is_begun and is_heartbeat_due and not self._boots_are_due else _BOOTS
            # A late answer to an earlier question must not begin a conversation.
            self._take_off(request, now, is_own=True, is_fenced=not self.is_begun)
        return self._take_events()

    def next_deadline(self, now: float) -> float:
        """When to call `tick` if nothing arrives before."""
        flight = self._flight
        dues = [self._own_due_at() if flight is None else self._next_step(flight, now)[0]]
        if self._parser.pending:
            dues.append(self._last_byte_at + timing.QUIET_S)
        if flight is not None and self.is_begun:
            dues.append(self._silent_at(flight))
        return min(dues)

    def _take_events(self) -> list[Event]:
        events, self._events = self._events, []
        return events

    def _own_due_at(self) -> float:
        if not self.is_begun:
            return self._begin_at
        if self._boots_are_due:
            return -inf  # it may have restarted
        return min(
            self._valid_at + self.round_trips.asks_after_s,
            self._boots_sent_at + timing.BOOT_COUNT_EVERY_S,
            self._heartbeat_sent_at + timing.HEARTBEAT_EVERY_S,
        )

    # Sending

    def _take_off(self, request: Request, now: float, *, is_own: bool, is_fenced: bool, limit_s: float = inf) -> None:
        stale = self._stale
        stale.drop_expired(now)
        needs_fence = is_fenced or stale.could_answer(request, now) or stale.owes(request)
        is_own_fence = request in FENCES and not stale.could_be_late(request, now)
        self._flight = flight = _Flight(request, now, is_own=is_own, limit_s=limit_s)
        if needs_fence and not is_own_fence and request != LOCK:  # LOCK must not wait, and the state is read afterwards
            self._flight = _Flight(stale.fence(now), now, is_own=is_own, limit_s=limit_s, behind=flight)
        self._advance(now)

    def _advance(self, now: float) -> None:
        if self._flight is not None:
            at, step = self._next_step(self._flight, now)
            if now >= at:
                step(self._flight, now)

    def _next_step(self, flight: _Flight, now: float) -> tuple[float, _Step]:
        """Whether the request in flight is sent, the boot count is asked behind it, or it is given up, and when."""
        trips, request = self.round_trips, flight.request
        if not flight.attempts:
            return self.gap.due(request, flight.wanted_at), self._transmit
        send: _Step = self._probe
        end: _Step = self._give_up
        ends_at = flight.first_at + flight.limit_s
        if flight.records:
            ends_at, end = flight.first_at + timing.RECORDS_LONGEST_S, self._finish_records
            at = max(flight.record_at + trips.asks_after_s, flight.probed_at + trips.repeat_s)
            if flight.is_past:
                ends_at = min(ends_at, flight.record_at + timing.RECORDS_QUIET_S)
                # On a slow line `asks_after_s` is nothing, and the line would be flooded.
                at = flight.probed_at + max(trips.asks_after_s, trips.repeat_s)
        elif flight.is_once:
            # Something else came in this time, or it would be silent.
            ends_at = min(ends_at, flight.first_at + timing.ANSWER_S)
            at = flight.probed_at + trips.repeat_s if flight.probes else flight.first_at + trips.asks_after_s
        else:
            at, send = self._next_question(flight)
            if flight.is_own and not self.is_begun:
                # Asked again, so that no late answer begins a conversation.
                ends_at, send = flight.first_at + timing.ANSWER_S, self._transmit
        at = self.gap.due(_BOOTS, at)
        return (ends_at, end) if now >= ends_at or ends_at <= at else (at, send)

    def _next_question(self, flight: _Flight) -> tuple[float, _Step]:
        """When a question is sent again, or the boot count behind it."""
        trips, is_boots = self.round_trips, flight.request == _BOOTS
        is_quick = self.is_begun and trips.silence_s < timing.LONGEST_SILENCE_S
        can_send = flight.attempts < (MOST_PROBES if is_boots else timing.TRIES)
        can_probe = not is_boots and flight.probes < MOST_PROBES
        spoken_at = max(flight.sent_at, flight.probed_at)
        if can_send:
            repeat_s = trips.first_repeat_s if flight.attempts == 1 else trips.repeat_s
            if is_quick and flight.sent_at - self._valid_at >= trips.asks_after_s:
                repeat_s = min(repeat_s, trips.probe_s)  # what is asked late in a silence is lost as often as the rest
            at = flight.sent_at + repeat_s
        elif can_probe:
            at = spoken_at + (trips.probe_s if is_quick else trips.repeat_s)
        else:
            return spoken_at + trips.silence_s / 2, self._fall_silent  # for the answers on a slow line
        if is_quick or not self.is_begun:
            return at, self._transmit if can_send else self._probe
        # On a slow line few repetitions fit into a silence. Where no answer can have come yet only one; then many, of
        # which some may be lost.
        look_at = often_at = self._valid_at + max(
            timing.ASKS_AFTER * timing.LONGEST_SILENCE_S, 1.5 * (self.lag_s or 0.0)
        )
        if is_boots:
            return min(at, max(often_at, flight.sent_at + trips.probe_s)), self._transmit
        if self.lag_s is not None:
            look_at = self._valid_at + trips.asks_after_s
        if flight.probed_at >= look_at:
            look_at = max(often_at, flight.probed_at + trips.probe_s)
        is_look = can_probe and (look_at <= at or not can_send)
        return min(at, look_at), self._probe if is_look else self._transmit

    def _fall_silent(self, flight: _Flight, now: float) -> None:
        # Nobody answers, also if something streams: it does not hear us.
        if self.is_begun:
            self._end_silent(now)
        else:
            self._give_up(flight, now)

    def _transmit(self, flight: _Flight, now: float) -> None:
        request = flight.request
        if not flight.attempts:
            flight.first_at = now
            flight.received_before = self._parser.end
        flight.attempts += 1
        flight.sent_at = now
        self._parser.asked = request
        self.gap.on_spoken(now)
        self.flags.on_sent(request, now)
        self.lasting.on_sent(request, now)
        self._put(request, flight.attempts, now)

    def _probe(self, flight: _Flight, now: float) -> None:
        flight.probes += 1
        flight.probed_at = now
        self.gap.on_spoken(now)
        self._stale.expect_late(_BOOTS, now, count=1)
        self._put(_BOOTS, 1, now)

    def _put(self, request: Request, attempt: int, now: float) -> None:
        self.counters.sent += 1
        if request == _BOOTS:
            self._boots_sent_at = now
            self._boots_are_due = False
        elif request == _HEARTBEAT:
            self._heartbeat_sent_at = now
        raw = request.encode()
        self._outgoing += raw
        self._events.append(Sent(raw, request, attempt, now))

    # Receiving

    def _digest(self, piece: Piece, now: float) -> None:
        if isinstance(piece, Noise):
            self.counters.rejected_bytes[piece.reason] += len(piece.raw)
            self._rejected += len(piece.raw)
            self._events.append(Rejected(piece, now))
            return
        self.counters.frames += 1
        if piece.direction is Direction.HOST_TO_MODULE:
            self._note(piece, None, Role.ECHO, now)
            return
        flight = self._flight
        is_answer = (
            flight is not None
            and flight.attempts > 0
            and piece.offset >= flight.received_before
            and answers(piece.raw, flight.request)
            # A fence is opened by its own answer only.
            and (flight.behind is None or self._stale.opens(flight.request, piece.raw, now))
        )
        # Only the reply to what was sent once, before the silence, proves that it is still the same module.
        is_proof = is_answer and flight is not None and flight.is_once
        if self.is_begun and now - self._valid_at >= self.round_trips.silence_s and not is_proof:
            self._end_silent(now)
            is_answer = False
        self._valid_at = now
        if flight is not None and is_answer:
            if piece.raw[2] in FLAG_CODES:
                self.flags.on_answer(flight.request, piece.raw, now)
            self._on_answer(flight, piece, now)
        else:
            self._on_other(piece, now)

    def _note(self, frame: Frame, message: Message | None, role: Role, now: float) -> None:
        self.counters.by_role[role] += 1
        if role not in (Role.STREAMED, Role.ECHO):
            self.gap.on_spoken(now)
        is_late_record = role is Role.LATE and isinstance(message, TriggerRecord | EmptySlot)
        if is_late_record or role in (Role.DUPLICATE, Role.UNSOLICITED):
            self._strays += 1
        self._events.append(Received(frame, message, role, now))

    def _on_answer(self, flight: _Flight, frame: Frame, now: float) -> None:
        request = flight.request
        message = decode(frame.raw, request)
        if self._contradicts(frame, message, Role.ANSWER, now):
            return
        is_copy = self._stale.copied(frame.raw, now) is not None  # perhaps, of the answer to the same question before
        # A status may be a streamed one, and of repeated questions nobody knows which was answered.
        is_timed = flight.attempts == 1 and request.command is not STATUS and not self._stale.owes(request)
        self._stale.expect_copy(frame.raw, request, now)
        self._note(frame, message, Role.ANSWER, now)
        if request == _BOOTS and flight.first_at >= self._unasked_at:
            self._unasked_at = -inf  # the count is the same, so that heartbeat was no restart's
        if request.command.layout is Layout.RECORD:
            flight.records.append(message)
            flight.record_at = now
            flight.is_past = False
            return
        round_trip_s = now - flight.sent_at if is_timed else None
        if round_trip_s is not None:
            self.round_trips.add(round_trip_s)
        elif flight.attempts > 1:
            self.round_trips.note_repeated()
        if not is_copy:
            self._stale.on_answered(request, flight.first_at, now)
            self.gap.on_answered(flight.attempts)
        # If a copy was taken for a status, the one that still follows is the answer and not streamed.
        owed = flight.attempts if is_copy and request.command is STATUS else flight.attempts - 1
        if owed or is_copy or flight.is_once:
            self._stale.expect_late(request, flight.sent_at, count=owed)
        self._land(flight, (message,), round_trip_s, now)

    def _land(self, flight: _Flight, messages: tuple[Message, ...], round_trip_s: float | None, now: float) -> None:
        # It was answered: send what waited for that, tell the owner, or begin a conversation.
        self._drop_flight(is_answered=True)
        if flight.behind is not None:
            self._open(flight.behind, now)
        elif not flight.is_own:
            request, attempts, rejected, strays = flight.request, flight.attempts, self._rejected, self._strays
            self._rejected = self._strays = 0
            self._events.append(Answered(request, messages, attempts, round_trip_s, now, rejected, strays))
        elif not self.is_begun and isinstance(messages[0], Reading):
            self.is_begun = True
            self.flags.begin_again()
            self.lasting.contradicted(messages[0], now, is_answer=True)  # the first that is told
            self._rejected = self._strays = 0
            _log.debug("began: boot count %d", messages[0].raw)
            self._events.append(Began(messages[0].raw, now))

    def _open(self, waiting: _Flight, now: float) -> None:
        # No earlier reply can follow: send what waited for that.
        waiting.wanted_at = now
        self._flight = waiting
        self._advance(now)

    def _finish_records(self, flight: _Flight, now: float) -> None:
        self._stale.expect_late(flight.request, flight.sent_at, count=0)
        self._land(flight, tuple(flight.records), None, now)

    def _on_other(self, frame: Frame, now: float) -> None:
        stale, raw = self._stale, frame.raw
        stale.drop_expired(now)
        copied = stale.copied(raw, now)
        # A copy does not stand for a reply that is still to come.
        late = stale.pop_late(raw) if copied is None else None
        if raw[2] in FLAG_CODES:
            self.flags.on_other(now, is_late=late is not None)
        asked = late.request if late is not None else copied.request if copied is not None else None
        message, role = decode(raw, asked), Role.UNSOLICITED
        if copied is not None:
            role = Role.LATE if copied.is_late else Role.DUPLICATE
        elif late is not None:
            role = Role.LATE
            stale.expect_copy(raw, asked, now, is_late=True)
        if copied is None and self._contradicts(frame, message, role, now):
            return
        if late is None and not (copied is not None and stale.is_owed(raw)):
            self.lasting.note_unasked(message, now)
        if isinstance(message, Heartbeat):
            if role is Role.UNSOLICITED:
                stale.expect_copy(raw, None, now)
                self._on_unasked_heartbeat(now)
            else:
                self._ask_at_once(now)
        elif isinstance(message, Status) and copied is None and late is None:
            role = Role.STREAMED
        self._note(frame, message, role, now)
        if late is not None and asked == _BOOTS:
            self._on_probe_answered(late.at, now)

    def _on_unasked_heartbeat(self, now: float) -> None:
        if now - self._restarted_at < timing.RESTART_S:
            return  # the second one of a restart
        is_second = now - self._unasked_at < timing.RESTART_S
        self._unasked_at = now
        if not self.is_begun:
            self._restarted_at = now
        elif is_second or now - self._heartbeat_sent_at > timing.LATE_S:
            self._restarted_at = now
            self._end(EndReason.RESTARTED, now)
        else:
            self._ask_at_once(now)

    def _ask_at_once(self, now: float) -> None:
        # A heartbeat may be a late answer, or a restart's: its boot count tells. Nothing that changes the module leaves
        # before that.
        if not self.is_begun:
            return
        self._boots_are_due = True
        flight = self._flight
        if flight is None or flight.request == _BOOTS:
            return
        if flight.attempts:
            self._probe(flight, now)
        elif flight.is_once:
            self._give_up(flight, now)

    def _on_probe_answered(self, sent_at: float, now: float) -> None:
        # The boot count that was asked at `sent_at` was told: no reply to an earlier frame can follow.
        flight = self._flight
        if flight is None or not flight.attempts or sent_at < flight.sent_at or flight.request == LOCK:
            return
        if flight.records:
            flight.is_past = True
        elif flight.behind is not None:
            self._drop_flight()
            self._open(flight.behind, now)  # the boot count is fence enough
        elif flight.is_once or flight.attempts >= timing.TRIES:
            self._give_up(flight, now)

    def _contradicts(self, frame: Frame, message: Message, role: Role, now: float) -> bool:
        """Whether it says otherwise than what was told before, so that the conversation is over."""
        if not self.is_begun:
            return False
        is_answer = role is Role.ANSWER
        contradiction = self.lasting.contradicted(message, now, is_answer=is_answer)
        if contradiction is None:
            return False
        # A boot count that grew a little is a restart whose heartbeats were lost; not where one question was answered
        # twice, so that it came unasked.
        before, after = contradiction
        has_grown = after.command is BOOT_COUNT and (after.raw - before.raw) % BOOTS <= MAX_STARTS
        is_restart = has_grown and (is_answer or role is Role.LATE)
        self._end(EndReason.RESTARTED if is_restart else EndReason.CONTRADICTED, now, contradiction)
        self._note(frame, message, Role.UNSOLICITED, now)  # nobody's value
        return True

    # Ends

    def _silent_at(self, flight: _Flight) -> float:
        if not flight.attempts:
            return inf
        silent_at = self._valid_at + self.round_trips.silence_s
        if flight.is_once:
            # The vendor gives the module a second for its own answer, counted from the request.
            return max(silent_at, flight.first_at + timing.ANSWER_S)
        return max(silent_at, flight.first_at + self.round_trips.silence_s / 2)

    def _end_silent(self, now: float) -> None:
        has_slept = now - self._turned_at > timing.SLEPT_S
        self._end(EndReason.SLEPT if has_slept else EndReason.SILENT, now)

    def _drop_flight(self, *, is_answered: bool = False) -> _Flight | None:
        flight = self._flight
        self._flight = None
        self._parser.asked = None
        if flight is not None and flight.attempts and not is_answered:
            self._stale.expect_late(flight.request, flight.sent_at, count=flight.attempts)
        return flight

    def _give_up(self, flight: _Flight, now: float) -> None:
        # The module is there and does not answer this, or it must not be sent any more.
        self._drop_flight()
        if flight.attempts:
            self.counters.time_outs += 1
            _log.debug("%s: no answer to %d attempts", flight.request.command.name, flight.attempts)
        if flight.is_own:
            self._begin_at = now
        self._events += flight.unanswered(now)

    def _end(self, reason: EndReason, now: float, contradiction: Contradiction | None = None) -> None:
        flight = self._drop_flight()
        outcome = [] if flight is None else flight.unanswered(now)
        self._begin_at = now
        if self.is_begun:
            _log.debug("ended: %s", reason.name)
            self._await_module(now)
            self.lasting.forget()
            if reason is EndReason.RESTARTED:
                self.counters.restarts += 1
            self._events.append(Ended(reason, now, contradiction))
        self._events += outcome

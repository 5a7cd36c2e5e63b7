"""One open port: its link, the conversation on it, and the jobs that run in it. Everything but the thread.

A byte goes through `Line.read`, `Link.receive` (stream, frame, message), `Conversation.apply` and `events`. `step` is
called in a loop by the worker's thread, or by a test with a fake line and a fake clock.

With a conversation everything ends that was known and that was being done in it (`app.engine.procedure`). The next one
begins by itself, with nothing known.

Two jobs may run: one in the foreground (what somebody asked for) and one in the background (which keeps the values
fresh, and is made again in each conversation). The background has the line only while the foreground does not need it.
"""

import logging
from collections.abc import Callable
from math import inf
from typing import Any

from app.engine.conversation import Conversation, ConversationView, Interrupted, StatusSample
from app.engine.procedure import Ask, Cancelled, EngineView, Job, Procedure, UseRate
from app.engine.target import is_shared, is_socket
from app.engine.transport import Line
from app.system.clock import Clock
from protocol.catalogue import ACTIVATION, BAUD_RATE, LOCK, Hazard
from protocol.events import Answered, Began, Counters, Ended, EndReason, Event, Rejected, Sent, Unanswered
from protocol.link import Link
from protocol.timing import LONGEST_SILENCE_S, SHORTEST_SILENCE_S

_log = logging.getLogger(__name__)
# An order ends it earlier; see `SerialLine.interrupt`.
MAX_STEP_S = 0.05
# How long to gather a stream while no answer is awaited.
BATCH_S = 0.008
# Of the last rejected bytes, by which it is told what else is on the line.
MAX_NOISE_BYTES = 512


class Session:
    """For one thread. `step` raises `PortError` when the port is lost; the owner then calls `close`."""

    def __init__(
        self,
        line: Line,
        clock: Clock,
        *,
        background: Callable[[], Procedure[None]] | None = None,
        last: ConversationView | None = None,
    ) -> None:
        """`background` makes the procedure that keeps the values fresh, again in each conversation. `last`: the last
        conversation, if there was one before."""
        self.line = line
        self.clock = clock
        self._last = last or ConversationView()
        self.conversations = self._last.number
        self._is_shared = is_shared(line.port)
        # The one that goes on, or else the last one of this port.
        self.conversation: Conversation | None = None
        # What was interrupted has activated a module, or was to lock one. The owner resets it.
        self.owes_lock = False
        # Who shares it watches for shorter silences, and answers one reader after the other.
        self._link = Link(clock(), LONGEST_SILENCE_S if self._is_shared else SHORTEST_SILENCE_S)
        self._make_background = background
        # The first one runs, the others wait for it.
        self._jobs: list[Job[Any]] = []
        self._background: Job[None] | None = None
        # The job whose request is in flight, and whether that was sent.
        self._asking: Job[Any] | None = None
        self._has_left = False
        self._overtaken_at = -inf
        # The rate at which a conversation last began. Since then the module was told to change it, or it is searched.
        self._proven_rate: int | None = None
        self._is_rate_in_doubt = True
        # What happened, and the status reports, until the owner takes them.
        self.events: list[Event] = []
        self.samples: list[StatusSample] = []
        self.noise = b""

    # What others want

    def run(self, job: Job[Any], *, is_urgent: bool = False) -> None:
        """Queue a job. An urgent one (LOCK) interrupts all others, which continue after it: a question is asked again
        later, the outcome of a set or an act in flight is unknown then, and what is dangerous and was confirmed before
        is not sent any more. A second urgent one replaces the first."""
        now = job.submitted_at = self.clock()
        if not is_urgent:
            self._jobs.append(job)
            return
        _log.debug("an urgent job overtakes %d", len(self._jobs))
        job.is_urgent = True
        for other in self._jobs:
            if other.is_urgent:
                other.cancel()
        self._overtaken_at = now
        self._free_line(now)  # LOCK waits for no answer
        self._jobs.insert(0, job)
        job.start(now, self._view)

    def treat_as_another(self) -> None:
        self._end_conversation(EndReason.ANOTHER, self.clock())

    def cancel_all(self) -> None:
        """The port is about to be closed: everything but LOCK may undo what it changed, and ends."""
        for job in self._all():
            if not job.is_urgent:
                job.cancel()

    @property
    def is_busy(self) -> bool:
        return bool(self._jobs) or self._background is not None

    # What is known

    @property
    def is_going(self) -> bool:
        return self.conversation is not None and self.conversation.ended is None

    def conversation_view(self, now: float) -> ConversationView:
        if self.conversation is None:
            return self._last
        view = self.conversation.view(now, self._link.lag_s if self.is_going else None)
        return view._replace(is_shared=self._is_shared)

    @property
    def counters(self) -> Counters:
        return self._link.counters.copy()

    # The loop

    def step(self, longest_s: float = MAX_STEP_S) -> None:
        """Wait at most `longest_s` for bytes, and do what is due."""
        now = self.clock()
        if self._background is not None and not self._background.is_started:
            # Not at once when the conversation begins: LOCK goes first, where the owner owes it.
            self._background.start(now, self._view)
        self._serve(now)
        wait_s = max(0.0, min(longest_s, self._next_due(now) - now))
        # An answer that somebody waits for is not kept back for the bytes behind it.
        data = self.line.read(wait_s, BATCH_S if self._link.is_idle else 0.0)
        if not data and self.clock() - now > wait_s:
            data = self.line.read(0.0, 0.0)  # in time, though this thread was kept waiting after the driver had nothing
        now = self.clock()
        self._digest(self._link.receive(data, now), now)
        self._serve(now)  # before the link asks for itself: nothing comes between a check and its frame
        self._digest(self._link.tick(now), now)
        self._serve(now)

    def close(self, reason: EndReason) -> None:
        """End the conversation and all jobs, and close the port. Never raises."""
        now = self.clock()
        # LOCK that did not come to its end is owed.
        self.owes_lock |= any(job.is_urgent and not job.has_ended for job in self._jobs)
        self._end_conversation(reason, now)
        for job in self._all():
            job.stop(Interrupted(reason), now)
        self._jobs.clear()
        self._background = None
        self.line.close()

    def _all(self) -> list[Job[Any]]:
        return [*self._jobs, self._background] if self._background is not None else list(self._jobs)

    @property
    def _asked(self) -> Ask | None:
        """What the job in flight asked, until it is told of the outcome."""
        return None if self._asking is None else self._asking.pending_ask

    def _next_due(self, now: float) -> float:
        dues = [self._link.next_deadline(now), *(job.pauses_until for job in self._all())]
        repeat = None if self._asked is None else self._asked.repeat
        if repeat is not None and repeat.is_repeating(now):
            dues.append(repeat.next_at)
        return min(dues)

    def _serve(self, now: float) -> None:
        # Else what the port holds is read first; then the conversation ends.
        is_more = not self._link.has_stood_still(now)
        while is_more:
            for job in self._all():
                if job.pop_cancel():
                    if self._asking is job:
                        self._free_line(now)
                    job.throw(Cancelled(), now)
                job.tick(now)
            self._start_next(now)
            # LOCK that is due does not wait for the answer to the question in flight.
            repeat = None if self._asked is None else self._asked.repeat
            if repeat is not None and repeat.is_due(now):
                self._digest(self._link.lock_again(now, repeat.sent + 1), now)
            is_more = self._serve_next(now)

    def _start_next(self, now: float) -> None:
        """Drop what has ended, and start the next job, unless it was decided in another conversation."""
        if self._background is not None and self._background.has_ended:
            self._background = None
        while self._jobs:
            job = self._jobs[0]
            if job.has_ended:
                self._jobs.remove(job)
            elif job.is_started:
                break
            elif job.conversation is None or (self.is_going and job.conversation == self.conversations):
                job.start(now, self._view)
            else:
                # Why the conversation is over in which it was decided.
                ended = None if self.conversation is None else self.conversation.ended
                job.stop(Interrupted(EndReason.CLOSED if ended is None else ended.reason), now)

    def _serve_next(self, now: float) -> bool:
        """Do what the next job wants of the line. Whether it went on."""
        job = self._jobs[0] if self._jobs else None
        if job is None or not job.is_started or job.frees_line:
            job = self._background  # also while the foreground waits for a disk or a person
        if job is None or self._asking is not None:
            return False
        if isinstance(job.effect, UseRate):
            # LOCK goes back to the proven rate; all others look for the module.
            self._is_rate_in_doubt |= not job.is_urgent
            _log.debug("%d baud", job.effect.baud_rate)
            self.line.use_rate(job.effect.baud_rate)
            self._end_conversation(EndReason.RATE_CHANGED, now)
            self._link.reset(now)
            job.resume(now, now)
            return True
        ask = job.pending_ask
        if ask is None:
            return False
        if job.conversation is None and self._link.is_own:
            self._link.abandon(now)  # it does not wait until a module answers the link
        if not self._link.is_idle:
            return False
        return self._send(job, ask)

    def _send(self, job: Job[Any], ask: Ask) -> bool:
        """Send the request of `job`, if it may be sent. Whether the job went on without that."""
        now, request = self.clock(), ask.request
        # What was confirmed before LOCK was pressed is void.
        is_void = job.submitted_at <= self._overtaken_at and request.hazard is Hazard.DANGEROUS
        asks_only = self._is_shared or job.asks_only or not self._link.allows_commands
        if not request.is_repeatable and request != LOCK and (asks_only or is_void):
            _log.debug("%s is not sent any more", request.command.name)
            job.resume(Unanswered(request, 0, 0.0, now), now)
            return True
        self._asking = job
        self._has_left = False
        self._digest(
            self._link.ask(request, now, is_fenced=ask.is_fenced, is_deliberate=ask.is_deliberate, limit_s=ask.limit_s),
            now,
        )
        return self._asking is None

    def _free_line(self, now: float) -> None:
        # Nothing that is in flight is waited for any more. Who asked a question asks it again when it is his turn; of a
        # set or an act he is told what became of it.
        if self._asked is not None and self._asked.request.is_repeatable:
            self._asking = None
        self._digest(self._link.abandon(now), now)

    def _view(self, now: float) -> EngineView:
        return EngineView(
            now,
            self.line.baud_rate,
            self.conversation_view(now),
            proven_rate=self._proven_rate,
            is_rate_in_doubt=self._is_rate_in_doubt,
            overtaken_at=self._overtaken_at,
            sets_rate=not is_socket(self.line.port),
            flags=self._link.flags,
            lasting=self._link.lasting,
            rejected_bytes=self._link.counters.rejected,
        )

    # What the link tells

    def _digest(self, events: list[Event], now: float) -> None:
        for event in events:
            self.events.append(event)
            if self.conversation is not None and self.conversation.ended is None:
                sample = self.conversation.apply(event)
                if sample is not None:
                    self.samples.append(sample)
            match event:
                case Began():
                    self.conversations += 1
                    _log.debug("conversation %d begins, boot count %d", self.conversations, event.boot_count)
                    rate = self.line.baud_rate
                    self._proven_rate, self._is_rate_in_doubt = rate, False
                    flags = self._link.flags
                    self.conversation = Conversation(self.conversations, event.boot_count, now, rate, flags)
                    if self._make_background is not None:
                        self._background = Job(self._make_background(), conversation=self.conversations)
                case Ended():
                    self._on_ended(event, now)
                case Sent():
                    request, job, ask = event.request, self._asking, self._asked
                    if job is not None and ask is not None and ask.request == request:
                        self._has_left = True
                        job.has_activated |= request == ACTIVATION.set(True)
                    if request == LOCK and ask is not None and ask.repeat is not None:
                        ask.repeat.note_sent(event.at)
                    if request.command is BAUD_RATE:
                        self._is_rate_in_doubt = True
                case Answered() | Unanswered():
                    job, self._asking = self._asking, None
                    if job is not None:
                        job.resume(event, now)
                case Rejected():
                    self.noise = (self.noise + event.noise.raw)[-MAX_NOISE_BYTES:]
        outgoing = self._link.take_outgoing()
        if outgoing:
            self.line.write(outgoing)

    def _end_conversation(self, reason: EndReason, now: float) -> None:
        self._digest(self._link.end(reason, now), now)

    def _on_ended(self, ended: Ended, now: float) -> None:
        _log.debug("conversation %d ends: %s", self.conversations, ended.reason.name)
        asking, had_left = self._asking, self._has_left
        if asking is not None and asking.conversation is not None:
            self._asking = None
        for job in self._all():
            if job.conversation is None or job.has_ended:
                continue
            self.owes_lock |= job.has_activated
            is_unsent = job.pending_ask is not None and not (job is asking and had_left)
            job.interrupt(Interrupted(ended.reason, ended.contradiction, is_unsent=is_unsent), now)

"""Writes settings, verifies each, logs all and reads everything again at the end.

    read all settings -> for each: intent, who is there, the set, once, two readings -> wait `SETTLE_S`
    -> read all settings again -> `WriteReport`

All values are checked before the first is sent, and nothing is sent if one of them takes protection away and nobody
accepted that. Who is there is asked before the first set and after each pause; nothing is written to a module that is
or may be active, unless a person has unlocked it. Only reading back proves a value, twice, because the 8-bit sum misses
about 6 % of two-bit errors. The last reading decides: it shows what the module changed late or unasked. What cannot be
read back (E8) is never verified, only acknowledged; of the two triggers even that is known only some seconds later
(E4, `protocol.stale_replies`). The free-fall trigger comes before the attitude trigger, which need not wait then.

An interruption ends it. What was set and not yet read back is unknown then; what was verified was verified then.
"""

import logging
from collections.abc import Callable, Iterable, Mapping, Sequence
from concurrent.futures import Future
from dataclasses import dataclass, field, replace
from enum import Enum
from math import inf
from typing import Any, NamedTuple

from app.engine.conversation import Interrupted
from app.engine.procedure import Ask, Await, Cancelled, EngineView, Inspect, Pause, Procedure, Report, ask_report
from app.procedures.act import Armed, checked_inputs, inputs_of
from app.procedures.read import SettingsReading, read_settings, read_twice, who_is_there
from app.safety.acts import Act
from app.safety.consequences import Consequence, risks
from app.safety.interlocks import ASKS_NOTHING, Interlock, Refusal, refusals
from app.safety.journal import DURABLE_LIMIT_S, Entry, Journal, Outcome
from app.text.messages import UserMessage, joined, message
from protocol.catalogue import ATTITUDE_TRIGGER, BAUD_RATE, READABLE_SETTINGS, Command, Request
from protocol.events import Answered, Contradiction, Unanswered
from protocol.events import Outcome as Reply
from protocol.fields import Value
from protocol.messages import Acknowledgement, Reading
from protocol.stale_replies import TRIGGER_FLAGS
from protocol.translatable import marked

_log = logging.getLogger(__name__)

# From the last write to the last reading. Modules are known to clamp, revert or restart some time after the
# acknowledgement; the background reading of a connected window finds later changes.
SETTLE_S = 1.0
# Who is there is asked again before a set that comes later than this after the last time.
PRESENT_FOR_S = 1.0
FLAGS_STEP_S = 0.25
# Late answers make it wait longer until the triggers are known.
FLAGS_LIMIT_S = 10.0
WAITING = marked("Waiting some seconds: an answer may come twice")


class SetReply(Enum):
    """The module's answer to the set (E2)."""

    ECHO = "echo"  # the value that was sent
    ONE = "one"  # 01, "understood"
    OTHER = "other"  # another value
    NOTHING = "nothing"
    NOT_SENT = "not sent"
    UNNEEDED = "unneeded"  # it already has the value, so nothing was sent


class WriteFault(Enum):
    """Why a setting is not as it was to be; the value is its English, translatable text."""

    REFUSED = marked("refused; the old value stands")
    CLAMPED = marked("the module holds another value")
    NOT_RETAINED = marked("acknowledged, but not kept")
    LOST = marked("no reply, not set")
    NO_REPLY = marked("no reply; may have been carried out")
    REPEATED = marked("this line repeats answers: not known")
    NO_READ_BACK = marked("could not be read back")
    CHANGED = marked("changed: by itself, or another module?")
    NO_LAST_READING = marked("not read again")
    INTERRUPTED = marked("interrupted; may have been carried out")
    VERIFIED_THEN = marked("verified then, before the interruption")
    ACKNOWLEDGED_THEN = marked("acknowledged then, before the interruption")
    NOT_ALLOWED = marked("not sent: a condition is not met")
    NOT_SENT = marked("not sent")
    # Of the baud rate; see `app.procedures.baud`.
    AT_RESTART = marked("acknowledged, still at the old rate: restart the module")
    UNCHANGED = marked("still at the old rate")
    MODULE_LOST = marked("no answer at any rate")


class SettingChange(NamedTuple):
    """A setting and its target value, in the field's unit."""

    command: Command
    value: Value

    @property
    def risks(self) -> tuple[Consequence, ...]:
        """What a person has to accept before it is written."""
        return risks(self.command, self.value)


def risk_message(changes: Iterable[SettingChange]) -> UserMessage | None:
    """What these changes take away, by setting; None if nothing."""
    parts = [
        message(
            marked("{value}: {why}"),
            value=message(change.command.title),
            why=joined([risk.message for risk in change.risks], between=" "),
        )
        for change in changes
        if change.risks
    ]
    return joined(parts, between=" ") if parts else None


class Written(NamedTuple):
    """The result of a write. Values are in the field's unit."""

    command: Command
    target: Value
    heard: SetReply = SetReply.NOT_SENT
    read_back: Value | None = None
    # True only if two answers had the target value, and the last reading, too; None if it cannot be read.
    verified: bool | None = None
    fault: WriteFault | None = None

    @property
    def is_acknowledged(self) -> bool:
        return self.heard in (SetReply.ECHO, SetReply.ONE)

    @property
    def is_sent(self) -> bool:
        return self.heard not in (SetReply.NOT_SENT, SetReply.UNNEEDED)

    @property
    def is_fine(self) -> bool:
        """Whether it is verified, or only acknowledged where it cannot be read back."""
        return self.fault is None


def not_sent(change: SettingChange, fault: WriteFault = WriteFault.NOT_SENT) -> Written:
    verified = False if change.command.reads_back or change.command is BAUD_RATE else None
    return Written(change.command, change.value, verified=verified, fault=fault)


@dataclass(frozen=True, slots=True, kw_only=True)
class WriteReport:
    """`results` in the order in which they were to be written."""

    results: tuple[Written, ...]
    # Why some were not sent.
    refusals: tuple[Refusal, ...] = ()
    # A setting that changed without being written, which ended the conversation.
    changed: Contradiction | None = None
    # Settings that were not written and could not be read afterwards.
    unread: tuple[Command, ...] = ()
    # When the last reading began, in seconds of the session's clock; None without one.
    read_at: float | None = None
    # The settings by key as they were read before the first write.
    before: Mapping[str, Value] = field(default_factory=dict)
    # Why it ended early. Nothing is known of the module that answers now.
    interrupted: Interrupted | None = None
    is_cancelled: bool = False

    @property
    def is_fine(self) -> bool:
        is_whole = self.interrupted is None and not self.is_cancelled
        return is_whole and not self.unread and all(written.is_fine for written in self.results)

    @property
    def is_refused(self) -> bool:
        """Nothing was sent, because a condition is not met."""
        return bool(self.refusals) and not any(written.is_sent for written in self.results)


def why_not_verified(written: Written, report: WriteReport) -> UserMessage | None:
    """What to say of a setting; None where it is as written."""
    fault, interrupted = written.fault, report.interrupted
    if fault is WriteFault.NOT_ALLOWED and report.refusals:
        why = joined([refusal.message for refusal in report.refusals], between=" ")
        return message(marked("not sent: {why}"), why=why)
    if fault is WriteFault.NOT_SENT and interrupted is not None:
        return message(marked("not sent: {why}"), why=interrupted.message)
    if fault is WriteFault.INTERRUPTED and interrupted is not None:
        return message(marked("unknown: {why}"), why=interrupted.message)
    return None if fault is None else message(fault.value)


@dataclass(frozen=True, slots=True, kw_only=True)
class WriteContext:
    """What a write needs besides the values."""

    journal: Journal
    armed: Armed | None = None
    # A person allowed it although the module is, or may be, active.
    is_unlocked: bool = False
    # The changes whose risk a person was shown and accepted.
    accepted_risks: frozenset[SettingChange] = frozenset()
    # Stores the old settings; called in the session's thread, so it must not wait for a disk. The future is done when
    # they are stored; None if they were stored before in this conversation.
    keep_as_found: Callable[[Mapping[str, Value], int | None], "Future[Any] | None"] | None = None
    # Called with each result in the session's thread. The report decides: a result may be taken back later.
    on_written: Callable[[Written], None] | None = None


def write_all(changes: Sequence[SettingChange], context: WriteContext) -> Procedure[WriteReport]:
    """Write these settings. Raises `ValueRefused` or `LookupError` before anything is sent; an interruption and a
    cancellation are in the report. Not for the baud rate (ValueError): changing that is a job of its own."""
    writing = _Writing(changes, context)
    return (yield from writing.run(_write_and_read_again(writing)))


def set_each(changes: Sequence[SettingChange], context: WriteContext) -> Procedure[WriteReport]:
    """As `write_all`, within a procedure that reads the settings itself. What was acknowledged of the triggers counts
    once `await_flags_known` has returned. Raises `Interrupted` and `Cancelled`."""
    writing = _Writing(changes, context)
    report = yield from writing.run(_set_all(writing))
    if report.interrupted is not None:
        raise report.interrupted
    if report.is_cancelled:
        raise Cancelled
    return report


def await_flags_free(request: Request, progress: Report | None = None) -> Procedure[None]:
    """Before a set of 16 or 17: wait until no answer to an earlier one can be taken for its own (E4)."""
    view: EngineView = yield Inspect()
    while view.flags.free_at(request) > view.now:
        if progress is not None:
            yield progress._replace(doing=WAITING)
        yield Pause(view.flags.free_at(request) - view.now)
        view = yield Inspect()


def await_flags_known(progress: Report | None = None) -> Procedure[None]:
    """After a set of 16 or 17: wait until no copy of its answer can come any more, or one has come (E4)."""
    view: EngineView = yield Inspect()
    ends_at = view.now + FLAGS_LIMIT_S
    while not (view.flags.has_repeated or view.flags.are_known(view.now)):
        if view.now >= ends_at:
            return
        if progress is not None:
            yield progress._replace(doing=WAITING)
        yield Pause(FLAGS_STEP_S)
        view = yield Inspect()


def reply_of(outcome: Reply) -> SetReply:
    """What the module answered to a set."""
    if isinstance(outcome, Unanswered) and not outcome.attempts:
        return SetReply.NOT_SENT
    answer = outcome.messages[0] if isinstance(outcome, Answered) else None
    if not isinstance(answer, Acknowledgement):
        return SetReply.NOTHING
    if answer.is_echo:
        return SetReply.ECHO
    return SetReply.ONE if answer.is_accepted else SetReply.OTHER


# One after the other


class _Writing:
    """How far it is."""

    def __init__(self, changes: Sequence[SettingChange], context: WriteContext) -> None:
        """Raises `ValueRefused`, `LookupError` or ValueError where a value cannot be sent."""
        for change in changes:
            if change.command is BAUD_RATE:
                raise ValueError("changing the baud rate is a job of its own")
            change.command.set(change.value)
        self.context = context
        self.changes = sorted(changes, key=lambda change: change.command is ATTITUDE_TRIGGER)
        self.refused = _unaccepted(changes, context)
        self.results = {change.command: not_sent(change) for change in self.changes}
        self.entries: dict[Command, Entry] = {}
        self.before: Mapping[str, Value] = {}
        self.progress: Report | None = None
        # When it was last asked who is there.
        self.present_at = -inf
        # The set that was handed to the link, until its outcome is known.
        self.setting: Command | None = None
        self.report = WriteReport(results=())

    def run(self, steps: Procedure[None]) -> Procedure[WriteReport]:
        try:
            if not self.refused:
                yield from steps
        except Interrupted as error:
            self.report = replace(self.report, interrupted=error)
            self._note_broken_off(error)
        except Cancelled:
            self.report = replace(self.report, is_cancelled=True)
            self._note_broken_off(None)
        finally:
            for command, entry in self.entries.items():
                written = self.results[command]
                self.context.journal.settle(entry, _outcome(written), _logged(written))
        for command, written in self.results.items():
            if self.refused and not written.is_sent:
                self.results[command] = written._replace(fault=WriteFault.NOT_ALLOWED)
        results = tuple(self.results.values())
        return replace(self.report, results=results, refusals=self.refused, before=self.before)

    def note(self, written: Written) -> None:
        _log.debug("%s: %s, %s", written.command.name, written.heard.name, written.fault)
        self.results[written.command] = written
        if self.context.on_written is not None:
            self.context.on_written(written)

    def note_last(self, last: SettingsReading, view: EngineView) -> None:
        """The last reading decides what is verified."""
        for command, written in self.results.items():
            if written.is_sent and command.reads_back:
                self.results[command] = _after_last_reading(written, last.values.get(command.key))
            elif written.is_fine and command in TRIGGER_FLAGS:
                self.results[command] = _after_copies(written, view)
        # Whatever else reads otherwise now has ended the conversation.
        sent = [command for command, written in self.results.items() if written.is_sent]
        unread = tuple(command for command in last.unread if command not in sent and command.key in self.before)
        self.report = replace(self.report, unread=unread, read_at=last.began_at)

    def _note_broken_off(self, interrupted: Interrupted | None) -> None:
        """What was found so far was so then. What was set and not yet read back is unknown."""
        if self.setting is not None and interrupted is not None and interrupted.is_unsent:
            unsent = next(change for change in self.changes if change.command is self.setting)
            self.results[self.setting] = not_sent(unsent)
        for command, written in self.results.items():
            if written.is_sent and written.is_fine:
                self.results[command] = _until_then(written)
        contradiction = None if interrupted is None else interrupted.contradiction
        if contradiction is None or contradiction.after.command not in READABLE_SETTINGS:
            return
        command, now = contradiction.after.command, contradiction.after.value
        known = self.results.get(command)
        if known is not None and known.is_sent:
            self.results[command] = known._replace(read_back=now, verified=False, fault=WriteFault.CHANGED)
        else:
            self.report = replace(self.report, changed=contradiction)


def _write_and_read_again(writing: _Writing) -> Procedure[None]:
    context = writing.context
    writing.before = (yield from read_settings()).values
    view: EngineView = yield Inspect()
    if context.keep_as_found is not None:
        stored = context.keep_as_found(view.conversation.settings(view.now), view.conversation.boot_count)
        if stored is not None:
            yield Await(stored, DURABLE_LIMIT_S)
    yield from _set_all(writing)
    if not any(written.is_sent for written in writing.results.values()):
        return
    yield Pause(SETTLE_S)
    yield from await_flags_known(writing.progress)
    last = yield from read_settings()
    view = yield Inspect()
    writing.note_last(last, view)


def _set_all(writing: _Writing) -> Procedure[None]:
    for done, change in enumerate(writing.changes):
        title = change.command.title
        writing.progress = Report(done, len(writing.changes), marked("Writing: {what}"), (("what", title),))
        yield writing.progress
        yield from _set_one(writing, change)
        if writing.refused:
            writing.note(writing.results[change.command]._replace(fault=WriteFault.NOT_ALLOWED))
            return


def _set_one(writing: _Writing, change: SettingChange) -> Procedure[None]:
    command, context = change.command, writing.context
    request = command.set(change.value)
    view: EngineView = yield Inspect()
    writing.refused = refusals(Act.WRITE, inputs_of(view, None, context.armed), only=ASKS_NOTHING)
    if writing.refused:
        return
    yield from await_flags_free(request, writing.progress)
    entry = context.journal.begin(Act.WRITE, request.encode(), {command.key: change.value})
    writing.entries[command] = entry
    # Unlike an act, a set is sent also where the disk takes longer.
    yield Await(entry, DURABLE_LIMIT_S)
    yield from _check(writing)
    if writing.refused:
        return
    waiting = writing.results[command]
    writing.results[command] = waiting._replace(heard=SetReply.NOTHING, fault=WriteFault.INTERRUPTED)
    writing.setting = command
    heard = reply_of((yield Ask(request)))
    writing.setting = None
    if heard is SetReply.NOT_SENT:
        writing.note(waiting)
        return
    writing.results[command] = waiting._replace(heard=heard, fault=WriteFault.INTERRUPTED)
    if not command.reads_back:
        # Else the next set would wait for the answer to a question, and not come directly after its check.
        yield from ask_report(is_fenced=True)
        writing.note(waiting._replace(heard=heard, fault=_UNREADABLE_FAULTS.get(heard)))
        return
    reading = yield from read_twice(command)
    fault = _fault(heard, request, reading, writing.before.get(command.key))
    read_back = None if reading is None else reading.value
    writing.note(waiting._replace(heard=heard, read_back=read_back, verified=fault is None, fault=fault))


def _check(writing: _Writing) -> Procedure[None]:
    """Ask who is there and whether writing is allowed, unless that was done a moment ago."""
    view: EngineView = yield Inspect()
    if view.now - writing.present_at <= PRESENT_FOR_S:
        return
    present = yield from who_is_there()
    view = yield Inspect()
    inputs = replace(
        checked_inputs(present, view, armed=writing.context.armed),
        contradiction=present.contradiction,  # a line that repeats answers is no reason
        is_unlocked=writing.context.is_unlocked,
    )
    writing.refused = refusals(Act.WRITE, inputs)
    writing.present_at = view.now
    _log.debug("before writing: %s", [refusal.condition.name for refusal in writing.refused] or "allowed")


def _unaccepted(changes: Sequence[SettingChange], context: WriteContext) -> tuple[Refusal, ...]:
    risk = risk_message(change for change in changes if change not in context.accepted_risks)
    if risk is None:
        return ()
    return (Refusal(Interlock.RISK_ACCEPTED, message(marked("Not accepted: {what}"), what=risk)),)


# What became of one


_UNREADABLE_FAULTS = {SetReply.NOTHING: WriteFault.NO_REPLY, SetReply.OTHER: WriteFault.REFUSED}
_REFUSED = (WriteFault.REFUSED, WriteFault.CLAMPED, WriteFault.NOT_RETAINED, WriteFault.LOST)
_FINE_THEN = (None, WriteFault.VERIFIED_THEN, WriteFault.ACKNOWLEDGED_THEN)


def _fault(heard: SetReply, request: Request, reading: Reading | None, old: Value | None) -> WriteFault | None:
    if reading is None:
        return WriteFault.NO_READ_BACK
    if reading.raw == request.data:
        return None
    if old is not None and reading.value != old:
        return WriteFault.CLAMPED
    faults = {SetReply.NOTHING: WriteFault.LOST, SetReply.OTHER: WriteFault.REFUSED}
    return faults.get(heard, WriteFault.NOT_RETAINED)


def _after_last_reading(written: Written, last: Value | None) -> Written:
    if written.fault is not None:
        return written if last is None else written._replace(read_back=last)
    if last is None:
        return written._replace(read_back=None, verified=False, fault=WriteFault.NO_LAST_READING)
    if last != written.read_back:
        return written._replace(read_back=last, verified=False, fault=WriteFault.CHANGED)
    return written


def _after_copies(written: Written, view: EngineView) -> Written:
    """The acknowledgement of a trigger counts only if no copy of it came (E4)."""
    if view.conversation.fresh(written.command.key, view.now) == written.target:
        return written
    has_repeated = view.flags.has_repeated
    fault = WriteFault.REPEATED if has_repeated else WriteFault.NO_LAST_READING
    return written._replace(heard=SetReply.NOTHING, fault=fault)


def _until_then(written: Written) -> Written:
    if written.verified:
        return written._replace(verified=False, fault=WriteFault.VERIFIED_THEN)
    if written.command in TRIGGER_FLAGS:
        return written._replace(heard=SetReply.NOTHING, fault=WriteFault.INTERRUPTED)
    return written._replace(fault=WriteFault.ACKNOWLEDGED_THEN)


def _outcome(written: Written) -> Outcome:
    if not written.is_sent:
        return Outcome.NOT_SENT
    if written.fault in _FINE_THEN:
        return Outcome.CONFIRMED
    return Outcome.REFUSED if written.fault in _REFUSED else Outcome.UNKNOWN


def _logged(written: Written) -> dict[str, object]:
    return {
        "acknowledged": written.is_acknowledged,
        "read_back": written.read_back,
        "verified": written.verified,
        "fault": None if written.fault is None else written.fault.name,
    }

"""Writes settings, verifies each, logs all and reads everything again at the end; and changes the baud rate.

    read all settings -> for each: intent, who is there, the set, once, two readings -> wait `SETTLE_S`
    -> read all settings again -> `WriteReport`

All values are checked before the first is sent, and nothing is sent if one of them takes protection away and nobody
accepted that. Who is there is asked before the first set and after each pause; nothing is written to a module that is
or may be active, unless a person has unlocked it. Only reading back proves a value, and the last reading decides: it
shows what the module changed late or unasked. What cannot be read back (E8) is never verified, only acknowledged; of
the two triggers even that is known only some seconds later (E4, `protocol.stale_replies`).

An interruption ends it. What was set and not yet read back is unknown then; what was verified was verified then.
"""

import logging
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from enum import Enum
from math import inf
from typing import NamedTuple

from app.engine.conversation import Interrupted
from app.engine.procedure import (
    Ask,
    Cancelled,
    EngineView,
    Inspect,
    Pause,
    Procedure,
    Report,
    ask_report,
    is_accepted,
    wait_for,
)
from app.procedures.act import Armed, begin_act, inputs_of
from app.procedures.find import find_rate
from app.procedures.read import read_settings, read_twice, who_is_there
from app.safety.consequences import consequences
from app.safety.journal import DURABLE_LIMIT_S, NOTE, Act, Entry, Journal, Outcome
from app.safety.permit import ASKS_NOTHING, Interlock, Permit, Refusal, refusals
from app.text.messages import UserMessage, joined, message
from protocol.catalogue import ATTITUDE_TRIGGER, BAUD_RATE, Command
from protocol.events import Answered
from protocol.fields import Value
from protocol.stale_replies import TRIGGER_FLAGS
from protocol.translatable import marked

_log = logging.getLogger(__name__)
# From the last write to the last reading. Modules are known to clamp, revert or restart some time after the
# acknowledgement; the background reading of a connected window finds later changes.
SETTLE_S = 1.0
# Who is there is asked again before a set that comes later than this after the last time.
PRESENT_FOR_S = 1.0
FLAGS_STEP_S = 0.25
WAITING = marked("Waiting some seconds: an answer may come twice")


class WriteFault(Enum):
    """Why a setting is not as it was to be; the value is its English, translatable text."""

    REFUSED = marked("refused; the old value stands")
    NOT_SET = marked("not set")
    NO_REPLY = marked("no reply; may have been carried out")
    REPEATED = marked("this line repeats answers: not known")
    NO_READ_BACK = marked("could not be read back")
    CHANGED = marked("changed: by itself, or another module?")
    INTERRUPTED = marked("interrupted; may have been carried out")
    VERIFIED_THEN = marked("verified then, before the interruption")
    NOT_ALLOWED = marked("not sent: a condition is not met")
    NOT_SENT = marked("not sent")
    # Of the baud rate
    AT_RESTART = marked("acknowledged, still at the old rate: restart the module")
    MODULE_LOST = marked("no answer at any rate: switch the module off and on, then find its rate")


class SettingChange(NamedTuple):
    """A setting and its target value, in the field's unit."""

    command: Command
    value: Value

    @property
    def risks(self) -> tuple[UserMessage, ...]:
        """What a person has to accept before it is written. The baud rate takes no protection away, and is never
        written without a permit."""
        found = () if self.command is BAUD_RATE else consequences(self.command, self.value)
        return tuple(consequence.message for consequence in found if consequence.is_risk)


def risk_message(changes: Iterable[SettingChange]) -> UserMessage | None:
    """Say what these changes take away, by setting; None if nothing."""
    text = marked("{value}: {why}")
    risky = [change for change in changes if change.risks]
    parts = [message(text, value=message(one.command.title), why=joined(one.risks, between=" ")) for one in risky]
    return joined(parts, between=" ") if parts else None


@dataclass(slots=True)
class Written:
    """The fate of one setting. Values are in the field's unit."""

    command: Command
    target: Value
    # Where it was not sent and nothing is wrong, the module already had the value.
    is_sent: bool = False
    # The module said the value that was sent, or 01, "understood" (E2).
    is_acknowledged: bool = False
    read_back: Value | None = None
    # None: it is verified, or only acknowledged where it cannot be read back.
    fault: WriteFault | None = WriteFault.NOT_SENT

    @property
    def verified(self) -> bool | None:
        """Whether two answers had the target value, and the last reading, too; None if it cannot be read."""
        is_readable = self.command.reads_back or self.command is BAUD_RATE
        return self.fault is None if is_readable else None

    @property
    def outcome(self) -> Outcome:
        """The outcome as the log has it."""
        if not self.is_sent:
            return Outcome.NOT_SENT
        if self.fault in (None, WriteFault.VERIFIED_THEN):
            return Outcome.CONFIRMED
        return Outcome.REFUSED if self.fault in (WriteFault.REFUSED, WriteFault.NOT_SET) else Outcome.UNKNOWN


@dataclass(slots=True)
class WriteReport:
    """The fate of each setting, in the order in which they were to be written; filled in as it goes on, so that an
    interrupted one is as good as it got."""

    results: Sequence[Written]
    # Why some were not sent.
    refusals: tuple[Refusal, ...] = ()
    # The settings by key as they were read before the first write.
    before: Mapping[str, Value] = field(default_factory=dict)
    # Why it ended early. Nothing is known of the module that answers now.
    interrupted: Interrupted | None = None
    is_cancelled: bool = False

    @property
    def is_fine(self) -> bool:
        return self.interrupted is None and all(written.fault is None for written in self.results)

    @property
    def is_refused(self) -> bool:
        """Nothing was sent, because a condition is not met."""
        return bool(self.refusals) and not any(written.is_sent for written in self.results)


def why_not_verified(written: Written, report: WriteReport) -> UserMessage | None:
    """Say why a setting is not verified; None where it is as written."""
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
    """Everything that a write needs besides the values."""

    journal: Journal
    armed: Armed | None = None
    # A person allowed it although the module is, or may be, active.
    is_unlocked: bool = False
    # The changes whose risk a person was shown and accepted.
    accepted_risks: frozenset[SettingChange] = frozenset()
    # Stores the old settings and the boot count; called in the session's thread, so it must not wait for a disk.
    keep_as_found: Callable[[Mapping[str, Value], int | None], object] | None = None
    # Who writes, and why, as a person said it.
    note: str = ""


def write_all(changes: Sequence[SettingChange], context: WriteContext) -> Procedure[WriteReport]:
    """Write these settings. Raises `ValueRefused` or `LookupError` before anything is sent; an interruption and a
    cancellation are in the report. Not for the baud rate (ValueError): changing that is a job of its own."""
    return (yield from _Writing(changes, context).run(reads=True))


def set_each(changes: Sequence[SettingChange], context: WriteContext) -> Procedure[WriteReport]:
    """Write as `write_all` does, within a procedure that reads the settings itself, and calls `await_flags_known` after
    the triggers. Raises `Interrupted` and `Cancelled`."""
    return (yield from _Writing(changes, context).run(reads=False))


def await_flags_known(progress: Report) -> Procedure[None]:
    """Wait after a set of 16 or 17, until no copy of its answer can come any more, or one has come (E4). A late answer
    makes it wait again, of which there is one for each set."""
    view: EngineView = yield Inspect()
    while not (view.flags.has_repeated or view.flags.are_known(view.now)):
        yield progress._replace(doing=WAITING)
        yield Pause(FLAGS_STEP_S)
        view = yield Inspect()


class _Writing:
    def __init__(self, changes: Sequence[SettingChange], context: WriteContext) -> None:
        """Raises `ValueRefused`, `LookupError` or ValueError where a value cannot be sent."""
        for change in changes:
            if change.command is BAUD_RATE:
                raise ValueError("changing the baud rate is a job of its own")
            change.command.set(change.value)
        self.context = context
        # 17 before 16, so that neither has to wait for the other's answer (E4).
        ordered = sorted(changes, key=lambda change: change.command is ATTITUDE_TRIGGER)
        self.report = WriteReport([Written(*change) for change in ordered])
        self.entries: list[tuple[Written, Entry]] = []
        self.progress = Report(0, len(changes), WAITING)
        # When it was last asked who is there.
        self.present_at = -inf
        risk = risk_message(change for change in changes if change not in context.accepted_risks)
        if risk is not None:
            why = message(marked("Not accepted: {what}"), what=risk)
            self.report.refusals = (Refusal(Interlock.RISK_ACCEPTED, why),)

    def run(self, *, reads: bool) -> Procedure[WriteReport]:
        report, results = self.report, self.report.results
        try:
            if reads and not report.refusals:
                report.before = (yield from read_settings()).values
                if self.context.keep_as_found is not None:
                    view: EngineView = yield Inspect()
                    self.context.keep_as_found(view.conversation.settings(view.now), view.conversation.boot_count)
            for done, written in enumerate(results):
                if report.refusals:
                    break
                what = (("what", written.command.title),)
                self.progress = Report(done, len(results), marked("Writing: {what}"), what)
                yield self.progress
                yield from self._set_one(written)
                _log.debug("%s: %s, %s", written.command.name, written.is_acknowledged, written.fault)
            if reads and any(written.is_sent for written in results):
                yield from self._read_again()
        except (Interrupted, Cancelled) as error:
            report.interrupted = error if isinstance(error, Interrupted) else None
            report.is_cancelled = isinstance(error, Cancelled)
            self._note_broken_off()
            if not reads:
                raise
        finally:
            for written in results:
                if report.refusals and not written.is_sent:
                    written.fault = WriteFault.NOT_ALLOWED
            for written, entry in self.entries:
                fault = None if written.fault is None else written.fault.name
                found = {"acknowledged": written.is_acknowledged, "read_back": written.read_back, "fault": fault}
                self.context.journal.settle(entry, written.outcome, found)
        return report

    def _read_again(self) -> Procedure[None]:
        # The last reading decides. Whatever else reads otherwise by then ends the conversation.
        yield Pause(SETTLE_S)
        yield from await_flags_known(self.progress)
        last = yield from read_settings()
        view: EngineView = yield Inspect()
        for written in [written for written in self.report.results if written.is_sent]:
            if written.command.reads_back:
                value = last.values.get(written.command.key)
                if written.fault is None and value != written.read_back:
                    written.fault = WriteFault.NO_READ_BACK if value is None else WriteFault.CHANGED
                written.read_back = value
            # The acknowledgement of a trigger counts only if no copy of it came (E4).
            is_known = view.conversation.fresh(written.command.key, view.now) == written.target
            if written.fault is None and written.command in TRIGGER_FLAGS and not is_known:
                written.is_acknowledged = False
                written.fault = WriteFault.REPEATED if view.flags.has_repeated else WriteFault.NO_READ_BACK

    def _set_one(self, written: Written) -> Procedure[None]:
        command, context, report = written.command, self.context, self.report
        request = command.set(written.target)
        view: EngineView = yield Inspect()
        report.refusals = refusals(Act.WRITE, inputs_of(view, armed=context.armed), only=ASKS_NOTHING)
        if report.refusals:
            return
        while view.flags.free_at(request) > view.now:  # until no answer to an earlier one can be taken for its own (E4)
            yield self.progress._replace(doing=WAITING)
            yield Pause(view.flags.free_at(request) - view.now)
            view = yield Inspect()
        detail = {command.key: written.target} | ({NOTE: context.note} if context.note else {})
        entry = context.journal.begin(Act.WRITE, request.encode(), detail)
        self.entries.append((written, entry))
        yield from wait_for(entry, DURABLE_LIMIT_S)  # unlike an act, a set is sent also where the disk takes longer
        for _try in range(2):
            view = yield Inspect()
            if view.now - self.present_at > PRESENT_FOR_S:
                present = yield from who_is_there()
                view = yield Inspect()
                self.present_at = view.now
                inputs = inputs_of(view, armed=context.armed, present=present)
                report.refusals = refusals(Act.WRITE, replace(inputs, is_unlocked=context.is_unlocked))
                if report.refusals:
                    return
            # If it ends before the outcome is known it may have been carried out.
            written.is_sent, written.fault = True, WriteFault.INTERRUPTED
            try:
                reply = yield Ask(request)
            except Interrupted as error:
                if error.is_unsent:
                    written.is_sent, written.fault = False, WriteFault.NOT_SENT
                raise
            if reply.attempts:
                break
            # A heartbeat came in between, as of a module that was plugged in a moment ago: who is there is asked again.
            written.is_sent, written.fault = False, WriteFault.NOT_SENT
            self.present_at = -inf
        else:
            return
        written.is_acknowledged = is_accepted(reply)
        if not command.reads_back:
            # Else the next set would wait for the answer to a question, and not come directly after its check.
            yield from ask_report(is_fenced=True)
            missing = WriteFault.REFUSED if isinstance(reply, Answered) else WriteFault.NO_REPLY
            written.fault = None if written.is_acknowledged else missing
            return
        written.read_back = yield from read_twice(command)
        if written.read_back is None:
            written.fault = WriteFault.NO_READ_BACK
        else:
            written.fault = None if written.read_back == written.target else WriteFault.NOT_SET

    def _note_broken_off(self) -> None:
        interrupted = self.report.interrupted
        contradiction = None if interrupted is None else interrupted.contradiction
        for written in [written for written in self.report.results if written.is_sent]:
            if contradiction is not None and written.command is contradiction.after.command:
                written.read_back, written.fault = contradiction.after.value, WriteFault.CHANGED
            elif written.fault is None:
                # What was found so far was so then.
                written.fault = WriteFault.VERIFIED_THEN if written.verified else WriteFault.INTERRUPTED
                written.is_acknowledged &= written.command not in TRIGGER_FLAGS


# The baud rate


def change_baud(
    new_rate: int, journal: Journal, *, permit: Permit | None = None, armed: Armed | None = None
) -> Procedure[WriteReport]:
    """Change the module's baud rate, as an act, and find the module again whatever it did (E9): at the new rate, the
    old one or any other, at which the port stays.

    A job of the port, as the conversation at the old rate ends with it. The table specifies neither the rate of the
    acknowledgement nor the time of the change, so only a conversation proves a rate: what is read back is the rate at
    which the module answers, None if it does not (the port is at the old rate). Raises `ValueRefused` for a rate
    without a code, before anything is sent. An interruption is in the report.
    """
    request = BAUD_RATE.set(new_rate)
    view: EngineView = yield Inspect()
    old_rate = view.baud_rate
    written = Written(BAUD_RATE, new_rate)
    report = WriteReport([written])
    rates = {"old": old_rate, "new": new_rate}
    entry: Entry | None = None
    try:
        begun = yield from begin_act(Act.CHANGE_BAUD, request, journal, permit=permit, armed=armed, detail=rates)
        if isinstance(begun, tuple):
            report.refusals, written.fault = begun, WriteFault.NOT_ALLOWED
            return report
        entry = begun
        # If it ends before the outcome is known it may have been carried out.
        written.is_sent, written.fault = True, WriteFault.INTERRUPTED
        reply = yield Ask(request, is_deliberate=True)
        written.is_acknowledged = is_accepted(reply)
        if not reply.attempts:
            written.is_sent, written.fault = False, WriteFault.NOT_SENT
        else:
            found = written.read_back = (yield from find_rate(new_rate, old_rate)).baud_rate
            if found is None:
                written.fault = WriteFault.MODULE_LOST
            elif found == new_rate:
                written.fault = None
            elif found == old_rate and written.is_acknowledged:
                written.fault = WriteFault.AT_RESTART
            else:
                written.fault = WriteFault.NOT_SET  # also where the set was corrupted on the line
    except Interrupted as error:
        report.interrupted = error
    finally:
        if entry is not None:
            fault = None if written.fault is None else written.fault.name
            _log.debug("from %d to %d baud: %s, %s", old_rate, new_rate, fault, written.read_back)
            journal.settle(entry, written.outcome, {"fault": fault, "found": written.read_back})
    return report

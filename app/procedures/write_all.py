"""Writes several settings, verifies each, logs all and reads everything again at the end.

    read all settings -> who is there -> write and read back, one by one -> wait `SETTLE_S`
    -> read all settings again -> `WriteReport`

All values are checked before the first is sent, and nothing is sent if one of them takes protection away and nobody
accepted that, wherever the write began. Each write checks again whether writing is allowed (not while the
module is active). The free-fall trigger comes before the attitude trigger, which need not wait then (E4), and the baud
rate last, as it may break the connection. The last reading decides: it shows what the module changed late or unasked.
"""

from collections.abc import Callable, Iterable, Mapping, Sequence
from concurrent.futures import Future
from dataclasses import dataclass, field, replace
from typing import Any, NamedTuple

from app.engine.procedure import EngineView, Inspect, Procedure, Report, TwoModules, await_asking, pause_asking
from app.engine.setting_changes import READABLE_SETTINGS, ChangedSetting, changed_settings
from app.engine.snapshots import Snapshot, snapshot_of
from app.procedures.act import Armed
from app.procedures.baud import BaudChanged, BaudEnd, change_baud
from app.procedures.settings_reading import SettingsReading, is_refuted, look, read_one_module, read_settings
from app.procedures.write import SetReply, WriteFault, Written, await_flags_free, await_flags_known, write_verified
from app.safety.acts import Act
from app.safety.consequences import Consequence, risks
from app.safety.interlocks import Interlock, Refusal, interlock_inputs, refusals
from app.safety.journal import Entry, Journal, Outcome
from app.safety.permit import Permit
from app.text.messages import UserMessage, joined, message
from protocol.catalogue import ATTITUDE_TRIGGER, BAUD_RATE, Command
from protocol.fields import Value
from protocol.flag_answers import TRIGGER_FLAGS
from protocol.translatable import marked

SETTLE_S = 1.0
"""From the last write to the last reading. Modules are known to clamp, revert or restart some time after the
acknowledgement; the background reading of a connected window finds later changes."""
LAST_READINGS = 2
"""The last reading is repeated if the line disturbed it."""
DISK_LIMIT_S = 1.5
"""How long a write waits until the old settings and the intent are stored."""


_LAST = (ATTITUDE_TRIGGER, BAUD_RATE)


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
            marked("{value}: {why}"), value=message(change.command.title),
            why=joined([risk.message for risk in change.risks], between=" "),
        )
        for change in changes
        if change.risks
    ]  # fmt: skip
    return joined(parts, between=" ") if parts else None


@dataclass(frozen=True, slots=True, kw_only=True)
class WriteReport:
    """`results` in the order of the changes, the baud rate last."""

    results: tuple[Written, ...]
    refusals: tuple[Refusal, ...] = ()
    """Why some were not sent."""
    changed: tuple[ChangedSetting, ...] = ()
    """Settings that changed without being written."""
    unread: tuple[Command, ...] = ()
    """Settings that were not written and could not be read afterwards."""
    read_at: float | None = None
    """When the last reading began, in monotonic seconds."""
    before: Mapping[str, Value] = field(default_factory=dict)
    """The settings by key as they were read before the first write."""

    @property
    def is_fine(self) -> bool:
        return all(written.is_fine for written in self.results) and not self.changed and not self.unread

    @property
    def is_refused(self) -> bool:
        """Nothing was sent."""
        return bool(self.refusals) and all(written.heard is SetReply.NOT_SENT for written in self.results)


def why_not_verified(written: Written, refusals: Sequence[Refusal]) -> UserMessage | None:
    """What to say of a setting; None where it is as written."""
    fault = written.fault
    if fault is WriteFault.NO_REPLY and written.waited_s is not None:
        return message(marked("no reply within {seconds:.1f} s; may have been carried out"), seconds=written.waited_s)
    if fault in (WriteFault.NOT_ALLOWED, WriteFault.CONTRADICTED):
        text = marked("not sent: {why}") if fault is WriteFault.NOT_ALLOWED else marked("unknown: {why}")
        return message(text, why=joined([refusal.message for refusal in refusals], between=" "))
    return None if fault is None else message(fault.value)


@dataclass(frozen=True, slots=True, kw_only=True)
class WriteContext:
    """What `write_all` needs besides the values."""

    journal: Journal
    permit: Permit | None = None
    """For the baud rate."""
    armed: Armed | None = None
    is_unlocked: bool = False
    """The user allowed it although the module is, or may be, active."""
    accepted_risks: frozenset[SettingChange] = frozenset()
    """The changes whose risk a person was shown and accepted."""
    store_snapshot: Callable[[Snapshot], Future[Any] | None] | None = None
    """Stores the old settings; called in the session's thread, so it must not wait for a disk. The future is done when
    they are stored; None if they were stored before in this session."""
    on_written: Callable[[Written], None] | None = None
    """Called with each result in the session's thread, even if the port is lost later."""
    begin: EngineView | None = None
    """Of the module that it was decided for; by default the one that answers first."""
    on_begun: Callable[[Command], None] | None = None
    """Called in the session's thread before the set of this setting may be sent."""


def write_all(changes: Sequence[SettingChange], context: WriteContext) -> Procedure[WriteReport]:
    """Raises `ValueRefused` or `LookupError` before anything is sent."""
    for change in changes:
        change.command.set(change.value)
    ordered = sorted(changes, key=lambda change: _LAST.index(change.command) if change.command in _LAST else -1)
    if refused := _unaccepted(changes, context):
        return WriteReport(results=_all_refused(ordered), refusals=refused)
    before = yield from read_one_module()
    read: EngineView = yield Inspect()
    if isinstance(before, Refusal):
        return WriteReport(results=_all_refused(ordered), refusals=(before,))
    progress = _WriteProgress(replace(context, begin=read))
    try:
        if context.store_snapshot is not None:
            yield from _store_snapshot(context.store_snapshot)
        for done, change in enumerate(ordered):
            progress.now = Report(done, len(ordered), marked("Writing: {what}"), (("what", change.command.title),))
            yield progress.now
            yield from _write_one(progress, change)
            if context.on_written is not None:
                context.on_written(progress.results[-1])
            view: EngineView = yield Inspect()
            progress.note(view, change.command)
        is_sent = any(written.heard is not SetReply.NOT_SENT for written in progress.results)
        if is_sent:
            report = yield from _last_reading(progress, before)
        else:
            report = WriteReport(results=tuple(progress.results), refusals=progress.refused)
    except TwoModules as error:
        report = _of_two_modules(ordered, progress, error)
    except BaseException:
        settle_writes(context.journal, progress.entries, unconfirmed(progress.results))
        raise
    settle_writes(context.journal, progress.entries, report.results)
    return replace(report, before=before.values)


@dataclass(slots=True)
class _WriteProgress:
    context: WriteContext
    results: list[Written] = field(default_factory=list)
    restarts: list[int] = field(default_factory=list)
    """The device's restarts after each write."""
    entries: dict[Command, Entry] = field(default_factory=dict)
    """Journal entries without an outcome."""
    refused: tuple[Refusal, ...] = ()
    fault: WriteFault | None = None
    """Why nothing more is sent."""
    now: Report | None = None
    """What is being done."""
    are_flags_settled: bool = False

    def note(self, view: EngineView, command: Command) -> None:
        """What is known of the module now: after a break what was before it, but for what was set since."""
        self.restarts.append(view.device.restarts)
        begin = self.context.begin or view
        if view.device.breaks == begin.device.breaks:
            begin = view
        elif self.results[-1].heard is not SetReply.NOT_SENT:
            values = {key: known for key, known in begin.device.values.items() if key != command.key}
            begin = begin._replace(device=begin.device._replace(values=values))
        self.context = replace(self.context, begin=begin)


def _write_one(progress: _WriteProgress, change: SettingChange) -> Procedure[None]:
    context = progress.context
    if progress.fault is not None:
        progress.results.append(not_sent(change, progress.fault))
    elif change.command is BAUD_RATE:
        yield from _settle_flags(progress)
        if context.on_begun is not None:
            context.on_begun(BAUD_RATE)
        baud = yield from change_baud(
            int(change.value), context.journal, permit=context.permit, armed=context.armed, begin=context.begin
        )
        progress.refused = baud.refusals
        progress.results.append(_written(change, baud))
    else:
        written, progress.refused = yield from write_logged(change, context, progress.entries, progress.now)
        progress.results.append(written)
        progress.fault = written.fault if written.heard is SetReply.NOT_SENT else None


def write_logged(
    change: SettingChange, context: WriteContext, entries: dict[Command, Entry], progress: Report | None = None
) -> Procedure[tuple[Written, tuple[Refusal, ...]]]:
    """Write one setting, if that is allowed; the caller settles the intent in `entries`, also where this raises.
    `progress`: what is shown while it waits."""
    command, value = change.command, change.value
    yield from await_flags_free(command.set(value), progress)
    refused = _unaccepted([change], context) or (yield from _refusals(context))
    if not refused:
        frame = command.set(value).encode()
        entry = entries[command] = context.journal.begin(Act.WRITE, frame, {command.key: value})
        if not entry.done():
            # Unlike an act a set is sent even if the disk takes too long, after checking again whether it is allowed.
            yield from _wait_for_disk(entry)
            refused = yield from _refusals(context)
    if refused:
        return not_sent(change, WriteFault.NOT_ALLOWED), refused
    if context.on_begun is not None:
        context.on_begun(command)
    return (yield from write_verified(command, value)), ()


def settle_writes(journal: Journal, entries: Mapping[Command, Entry], results: Iterable[Written]) -> None:
    """Log the outcomes; a write without a result is unknown."""
    by_command = {written.command: written for written in results}
    for command, entry in entries.items():
        written = by_command.get(command)
        journal.settle(entry, _outcome(written), {} if written is None else _result(written))


def _of_two_modules(ordered: Sequence[SettingChange], progress: _WriteProgress, error: TwoModules) -> WriteReport:
    """What was sent may be in either: nothing is known of it, and nothing more was sent."""
    results = [
        _doubtful(written, WriteFault.CONTRADICTED) if written.is_fine else written for written in progress.results
    ]
    for change in ordered[len(results) :]:
        if change.command in progress.entries or (change.command is BAUD_RATE and len(results) == len(ordered) - 1):
            written = not_sent(change, WriteFault.CONTRADICTED)
            results.append(written._replace(heard=SetReply.NOTHING))
        else:
            results.append(not_sent(change, WriteFault.NOT_ALLOWED))
    before, after = error.contradicted.before, error.contradicted.after
    is_ours = before.command in progress.entries or before.command not in READABLE_SETTINGS
    changed = () if is_ours else (ChangedSetting(before.command, before.value, after.value),)
    refused = Refusal(Interlock.AGREES, error.message)
    return WriteReport(results=tuple(results), refusals=(refused,), changed=changed)


def _last_reading(progress: _WriteProgress, before: SettingsReading) -> Procedure[WriteReport]:
    """Read everything once more after a pause: only values that are still there, without a restart, are verified, and
    none that another module may have."""
    yield from pause_asking(SETTLE_S)
    yield from _settle_flags(progress)
    for _ in range(LAST_READINGS):
        last = yield from read_settings()
        is_spoiled = last.boot_count is None or not last.faults.keys() <= before.faults.keys()
        if last.is_silent or not is_spoiled:
            break
    sent = {written.command.key for written in progress.results if written.heard is not SetReply.NOT_SENT}
    view: EngineView = yield Inspect()
    if is_refuted(progress.context.begin or view, view) or not view.is_settled:
        last = last._replace(values={})
        results = [
            _unconfirmed(written) if written.command.reads_back and written.command.key in sent else written
            for written in progress.results
        ]
    elif last.boot_count is None:
        results = [_unconfirmed(written) if written.verified else written for written in progress.results]
    else:
        results = [_read_again(written, last.values) for written in progress.results]
    results = _invalidated(results, progress.restarts, now=view.device.restarts)
    stood = {key: value for key, value in before.values.items() if key not in sent}
    return WriteReport(
        results=tuple(results),
        refusals=progress.refused,
        changed=changed_settings(stood, last.values),
        unread=tuple(
            command for command in READABLE_SETTINGS if command.key in stood and command.key not in last.values
        ),
        read_at=last.began_at,
    )


def _read_again(written: Written, values: Mapping[str, Value]) -> Written:
    """The result of one write after the last reading."""
    if not written.command.reads_back or written.heard is SetReply.NOT_SENT:
        return written
    value = values.get(written.command.key)
    if written.fault is not None:
        return written._replace(read_back=value) if value is not None else written
    if value is None:
        return _unconfirmed(written)
    if value != written.target:
        return written._replace(read_back=value, verified=False, fault=WriteFault.REVERTED)
    return written


def _settle_flags(progress: _WriteProgress) -> Procedure[None]:
    """Wait until it is known what became of the triggers: after a change of the baud rate it can no longer be known."""
    if progress.are_flags_settled:
        return
    yield from await_flags_known(progress.now)
    view: EngineView = yield Inspect()
    progress.results = [_with_flag(written, view) for written in progress.results]
    progress.are_flags_settled = True


def _with_flag(written: Written, view: EngineView) -> Written:
    """The acknowledgement of a trigger counts only if no copy of it came (E4)."""
    if written.command not in TRIGGER_FLAGS or not written.is_fine:
        return written
    if view.device.fresh(written.command.key, view.now) == written.target:
        return written
    has_repeated = view.flags is not None and view.flags.has_repeated
    return _doubtful(written, WriteFault.REPEATED if has_repeated else WriteFault.NO_LAST_READING)


def unconfirmed(results: Iterable[Written]) -> list[Written]:
    """The results without a last reading: nothing is verified, and no trigger acknowledged."""
    return [
        _doubtful(written, WriteFault.NO_LAST_READING)
        if written.is_fine and (written.verified or written.command in TRIGGER_FLAGS)
        else written
        for written in results
    ]


def _unconfirmed(written: Written) -> Written:
    return _doubtful(written, WriteFault.NO_LAST_READING)


def _doubtful(written: Written, fault: WriteFault) -> Written:
    """What was said of it no longer stands."""
    if written.command in TRIGGER_FLAGS:
        return written._replace(heard=SetReply.NOTHING, fault=fault)
    return written._replace(read_back=None, verified=False if written.verified else written.verified, fault=fault)


def _store_snapshot(store: Callable[[Snapshot], Future[Any] | None]) -> Procedure[None]:
    view: EngineView = yield Inspect()
    snapshot = snapshot_of(view.device, view.now)
    # Not of another module than the one that it was decided for; to that nothing is written either.
    stored = store(snapshot) if snapshot.settings and view.is_settled else None
    if stored is not None and not stored.done():
        yield from _wait_for_disk(stored)


def _wait_for_disk(future: Future[Any]) -> Procedure[None]:
    yield from await_asking(future, DISK_LIMIT_S)


def _unaccepted(changes: Sequence[SettingChange], context: WriteContext) -> tuple[Refusal, ...]:
    risk = risk_message(change for change in changes if change not in context.accepted_risks)
    if risk is None:
        return ()
    return (Refusal(Interlock.RISK_ACCEPTED, message(marked("Not accepted: {what}"), what=risk)),)


def _refusals(context: WriteContext) -> Procedure[tuple[Refusal, ...]]:
    """The conditions that are not met by who is there now."""
    begin = context.begin or (yield Inspect())
    seen = yield from look(begin)
    view: EngineView = yield Inspect()
    inputs = replace(
        interlock_inputs(view.device, view.now, must_be_proven=True),
        is_identity_settled=view.is_settled and seen.is_same,
        contradiction=seen.present.contradiction,
        armed=context.armed.act if context.armed is not None else None,
        is_unlocked=context.is_unlocked,
    )
    return refusals(Act.WRITE, inputs)


def _outcome(written: Written | None) -> Outcome:
    if written is None:
        return Outcome.UNKNOWN
    if written.heard is SetReply.NOT_SENT:
        return Outcome.NOT_SENT
    if written.is_fine:
        return Outcome.CONFIRMED
    is_read = written.read_back is not None and written.fault is not WriteFault.RESTARTED
    return Outcome.REFUSED if is_read or written.fault is WriteFault.REFUSED else Outcome.UNKNOWN


def _result(written: Written) -> dict[str, object]:
    return {
        "acknowledged": written.is_acknowledged,
        "read_back": written.read_back,
        "verified": written.verified,
        "fault": written.fault.name if written.fault is not None else None,
    }


def _all_refused(changes: Iterable[SettingChange]) -> tuple[Written, ...]:
    return tuple(not_sent(change, WriteFault.NOT_ALLOWED) for change in changes)


def not_sent(change: SettingChange, fault: WriteFault) -> Written:
    verified = False if change.command.reads_back or change.command is BAUD_RATE else None
    return Written(command=change.command, target=change.value, heard=SetReply.NOT_SENT, verified=verified, fault=fault)


_BAUD_FAULTS = {
    BaudEnd.AT_RESTART: WriteFault.AT_RESTART,
    BaudEnd.UNCHANGED: WriteFault.UNCHANGED,
    BaudEnd.ELSEWHERE: WriteFault.CLAMPED,
    BaudEnd.LOST: WriteFault.MODULE_LOST,
}


def _written(change: SettingChange, baud: BaudChanged) -> Written:
    fault = _BAUD_FAULTS.get(baud.end)
    if baud.end is BaudEnd.NOT_SENT:
        fault = WriteFault.NOT_ALLOWED if baud.refusals else WriteFault.NOT_SENT
    return Written(
        command=change.command,
        target=change.value,
        heard=baud.heard,
        read_back=baud.found_rate,
        verified=baud.end is BaudEnd.CHANGED,
        fault=fault,
    )


def _invalidated(results: Sequence[Written], restarts: Sequence[int], *, now: int) -> list[Written]:
    """Mark writes before a restart as doubtful, as it is unknown what survives one (E15)."""
    return [
        written._replace(fault=WriteFault.RESTARTED, verified=False if written.verified else None)
        if written.heard is not SetReply.NOT_SENT and _may_be_lost(written) and count != now
        else written
        for written, count in zip(results, restarts, strict=True)
    ]


def _may_be_lost(written: Written) -> bool:
    """Whether a restart may explain the result."""
    return written.fault in (None, WriteFault.REVERTED, WriteFault.NO_LAST_READING)

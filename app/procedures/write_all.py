"""Write several settings, each verified; what stood before is kept, what was done is logged.

All values are checked before the first is sent. Each write asks anew whether writing is allowed (not while the module
is active). The baud rate comes last: it may take the line with it.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

from app.acts import Act
from app.device import How
from app.journal import Journal, Outcome, begin_if_possible
from app.permit import Permit
from app.procedure import Ask, Look, Procedure, Report, Sight
from app.procedures.act import Armed
from app.procedures.baud import BaudChanged, BaudEnd, change_baud
from app.procedures.write import Heard, WriteFault, Written, write_verified
from app.safety import Refusal, refusals, situation
from app.snapshots import Snapshot, snapshot_of
from protocol.catalogue import BAUD_RATE, SETTINGS, STATUS, Command
from protocol.fields import Value
from protocol.text import marked


@dataclass(frozen=True, slots=True)
class Change:
    """A setting and the value wanted, in its field's unit."""

    command: Command
    value: Value


@dataclass(frozen=True, slots=True, kw_only=True)
class WriteReport:
    """`results` in the order of the changes, the baud rate last."""

    results: tuple[Written, ...]
    refusals: tuple[Refusal, ...] = ()
    """Why some were not sent."""
    baud: BaudChanged | None = None

    @property
    def is_fine(self) -> bool:
        return all(written.is_fine for written in self.results)


@dataclass(frozen=True, slots=True, kw_only=True)
class Leave:
    """What writing needs besides the values."""

    journal: Journal
    permit: Permit | None = None
    """For the baud rate."""
    armed: Armed | None = None
    is_unlocked: bool = False
    """Somebody allowed this although the module is, or may be, active."""
    keep_snapshot: Callable[[Snapshot], None] | None = None
    """Takes the settings as they were; None where that was done before in this session."""
    on_written: Callable[[Written], None] | None = None
    """Hears of every result as it comes, in the session's thread: also where the line breaks off in the middle."""


def write_all(changes: Sequence[Change], leave: Leave) -> Procedure[WriteReport]:
    """Raises `ValueRefused` or `LookupError` before anything is sent."""
    for change in changes:
        change.command.set(change.value)
    ordered = sorted(changes, key=lambda change: change.command is BAUD_RATE)
    if leave.keep_snapshot is not None:
        yield from _keep_snapshot(leave.keep_snapshot)
    results: list[Written] = []
    restarts: list[int] = []
    refused: tuple[Refusal, ...] = ()
    baud: BaudChanged | None = None
    fault: WriteFault | None = None
    for done, change in enumerate(ordered):
        yield Report(done, len(ordered), marked("Writing: {what}"), (("what", change.command.title),))
        if fault is None:
            refused = yield from _refusals(leave)
            fault = WriteFault.NOT_ALLOWED if refused else None
        if fault is not None:
            results.append(_not_sent(change, fault))
        elif change.command is BAUD_RATE:
            baud = yield from change_baud(int(change.value), leave.journal, permit=leave.permit, armed=leave.armed)
            refused = baud.refusals
            results.append(_written(change, baud))
        else:
            written = yield from _write_logged(change, leave.journal)
            results.append(written)
            fault = WriteFault.NOT_SENT if written.heard is Heard.NOT_SENT else None
        if leave.on_written is not None:
            leave.on_written(results[-1])
        sight: Sight = yield Look()
        restarts.append(sight.device.restarts)
    return WriteReport(results=tuple(_doubted(results, restarts)), refusals=refused, baud=baud)


def _keep_snapshot(keep: Callable[[Snapshot], None]) -> Procedure[None]:
    for command in SETTINGS:
        sight: Sight = yield Look()
        if command.reads_back and sight.device.fresh(command.key, sight.now) is None:
            yield Ask(command.query())
    sight = yield Look()
    snapshot = snapshot_of(sight.device, sight.now)
    if snapshot.settings:
        keep(snapshot)


def _refusals(leave: Leave) -> Procedure[tuple[Refusal, ...]]:
    """The module is asked where it has not just said, being asked, that it is locked: a report that came unasked says
    what was so when it left, and nobody knows how long ago that is."""
    for has_been_asked in (False, True):
        sight: Sight = yield Look()
        armed = leave.armed.act if leave.armed is not None else None
        found = refusals(Act.WRITE, situation(sight.device, sight.now, armed=armed, is_unlocked=leave.is_unlocked))
        active = sight.device.known("active", sight.now)
        is_answer = has_been_asked or (active is not None and active.how is How.READ)
        if not found and (leave.is_unlocked or is_answer):
            break
        yield Ask(STATUS.query())
    return found


def _write_logged(change: Change, journal: Journal) -> Procedure[Written]:
    frame = change.command.set(change.value).encode()
    entry = begin_if_possible(journal, Act.WRITE, frame, {change.command.key: change.value})
    written: Written | None = None
    try:
        written = yield from write_verified(change.command, change.value)
    finally:
        if entry is not None:
            journal.settle(entry, _outcome(written), {} if written is None else _result(written))
    return written


def _outcome(written: Written | None) -> Outcome:
    if written is None:
        return Outcome.UNKNOWN
    if written.heard is Heard.NOT_SENT:
        return Outcome.NOT_SENT
    if written.is_fine:
        return Outcome.CONFIRMED
    return Outcome.REFUSED if written.stands is not None else Outcome.UNKNOWN


def _result(written: Written) -> dict[str, object]:
    return {
        "acknowledged": written.is_acknowledged,
        "read_back": written.stands,
        "verified": written.verified,
        "fault": written.fault.name if written.fault is not None else None,
    }


def _not_sent(change: Change, fault: WriteFault) -> Written:
    verified = False if change.command.reads_back or change.command is BAUD_RATE else None
    return Written(command=change.command, wanted=change.value, heard=Heard.NOT_SENT, verified=verified, fault=fault)


_BAUD_FAULTS = {
    BaudEnd.AT_RESTART: WriteFault.AT_RESTART,
    BaudEnd.UNCHANGED: WriteFault.UNCHANGED,
    BaudEnd.ELSEWHERE: WriteFault.CLAMPED,
    BaudEnd.LOST: WriteFault.MODULE_LOST,
}


def _written(change: Change, baud: BaudChanged) -> Written:
    fault = _BAUD_FAULTS.get(baud.end)
    if baud.end is BaudEnd.NOT_SENT:
        fault = WriteFault.NOT_ALLOWED if baud.refusals else WriteFault.NOT_SENT
    return Written(
        command=change.command,
        wanted=change.value,
        heard=baud.heard,
        stands=baud.found_rate,
        verified=baud.end is BaudEnd.CHANGED,
        fault=fault,
    )


def _doubted(results: Sequence[Written], restarts: Sequence[int]) -> list[Written]:
    """What was written before a restart is claimed no longer: nobody knows what survived it (E15)."""
    last = restarts[-1] if restarts else 0
    return [
        replace(written, fault=WriteFault.RESTARTED, stands=None, verified=False if written.verified else None)
        if written.fault is None and count != last
        else written
        for written, count in zip(results, restarts, strict=True)
    ]

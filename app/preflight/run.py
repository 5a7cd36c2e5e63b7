"""Pre-flight check as a procedure: collects evidence with queries only, judges nothing.

    20 heartbeats -> settings between two boot counts, who is there -> trigger records
                  -> the two trigger flags, only when asked -> cell, charge, light -> two seconds of status
                  -> settings between two boot counts, who is there, once more

The flags come after the records, as not every module answers that question, and they are known only while the module
keeps answering; they take some seconds, because on some lines an answer comes twice (`protocol.flag_answers`). A check
in which it did not answer for a moment is void: it may have been exchanged.
What decides is asked until two answers in a row agree, or several times, because the 8-bit checksum lets some damaged
frames pass. What may change while a trigger is enabled or during measuring is read before and after: see
`app.preflight.reread`. Nothing that is sent activates, locks, fires, zeroes, shuts down or changes the rate.
"""

from app.engine.device import How
from app.engine.identity import Trust, same_module
from app.engine.procedure import (
    HEARTBEAT_WAITS_S,
    Ask,
    Cancelled,
    EngineView,
    Inspect,
    Pause,
    PortLost,
    Procedure,
    Report,
    TwoModules,
    ask_report,
    ask_value,
    is_alive,
)
from app.preflight.evidence import HEARTBEATS, STILL_S, Disturbance, Evidence, FlagState, TriggerFlag
from app.preflight.reread import StateReading, read_state
from app.procedures.history import read_history
from app.procedures.settings_reading import is_refuted, read_settings
from app.procedures.write import SetReply, Written, await_flags_known, read_back
from app.procedures.write_all import SettingChange, WriteContext, settle_writes, write_logged
from app.safety.journal import Entry, Journal, NoJournal
from app.text.messages import message
from protocol.catalogue import BOOT_COUNT, BY_NAME, HEARTBEAT, Command
from protocol.events import Answered, Role
from protocol.flag_answers import TRIGGER_FLAGS
from protocol.translatable import marked

TRIAL_EVERY_S = 0.05
TRIAL_WAITS_S = (0.25,)
VALUE_ROUNDS = 3
"""Of asking for cell voltage, charging and light."""
GIVE_UP_AFTER = 4
"""After this many unanswered questions in a row the module is taken as silent."""
SLOWEST_STREAM = 4
"""Reports at most, in the two seconds, of a stream that sent no more than one in the second before."""
STEPS = 7
TRIGGERS = (BY_NAME["attitude_trigger"], BY_NAME["freefall_trigger"])
SLOW = tuple(BY_NAME[name] for name in ("cell_voltage", "charging", "light"))


class _Silent(Exception):
    """The module stopped answering."""


def run_preflight(
    evidence: Evidence, *, is_enabling: bool = False, journal: Journal | None = None
) -> Procedure[Evidence]:
    """Fill `evidence`; with `is_enabling` enable both automatic triggers, if the module is locked. Raises `Cancelled`,
    `PortLost` or `Slept`; `evidence` is void then."""
    evidence.is_enabling = is_enabling
    try:
        yield from _collect(evidence, journal or NoJournal())
    except _Silent:
        evidence.disturbance = Disturbance.SILENT
        yield from _count_rejected(evidence)
    except TwoModules as error:
        evidence.note_error(error)
    except (Cancelled, PortLost) as error:
        evidence.note_error(error)
        raise
    return evidence


def _collect(evidence: Evidence, journal: Journal) -> Procedure[None]:
    start = begin = yield Inspect()
    evidence.began_at, evidence.opened_at, evidence.baud_rate = begin.now, begin.opened_at, begin.baud_rate
    yield Report(0, STEPS, marked("Link"))
    yield from read_back(BOOT_COUNT)
    # A restart before the check that is only seen now does not count as one during the check.
    begin = yield Inspect()
    evidence.restarts, evidence.rejected_before = begin.device.restarts, begin.link.counters.rejected
    yield from _heartbeats(evidence)
    begin = yield Inspect()
    evidence.breaks = begin.device.breaks
    evidence.breaks_noticed = begin.device.breaks
    yield from _step(evidence, 1, marked("Settings"))
    evidence.first = yield from _read_state(evidence)
    yield from _step(evidence, 2, marked("Trigger records"))
    begin = yield Inspect()
    history = yield from read_history()
    end: EngineView = yield Inspect()
    evidence.streamed = _streamed(end) - _streamed(begin)
    if history.is_line_dead:
        raise _Silent
    evidence.history = history
    yield from _step(evidence, 3, marked("Triggers"))
    is_changed = False
    if evidence.is_enabling:  # the records end in a silence, in which it may have been exchanged
        again = yield from read_settings()
        view: EngineView = yield Inspect()
        is_changed = same_module(evidence.first.settings.evidence, again.evidence) is Trust.REFUTED
        is_changed, start = is_changed or is_refuted(start, view), view
    evidence.flags = {command.key: TriggerFlag() for command in TRIGGERS}
    for command in TRIGGER_FLAGS:
        if evidence.is_enabling and (is_changed or (yield Inspect()).device.breaks != evidence.breaks):
            evidence.flags[command.key] = TriggerFlag(FlagState.NOT_SENT, message(Disturbance.BROKEN.value))
        elif evidence.is_enabling:
            evidence.flags[command.key] = yield from _enable(
                command, WriteContext(journal=journal, begin=start), Report(3, STEPS, "")
            )
    yield from _step(evidence, 4, marked("Cell voltage"))
    for _ in range(VALUE_ROUNDS):
        for command in SLOW:
            yield from _read_slow(evidence, command)
    yield from _step(evidence, 5, marked("Tilt and acceleration"))
    yield from _watch(evidence)
    yield from await_flags_known(Report(5, STEPS, ""))
    yield from _step(evidence, 6, marked("Settings"))
    evidence.last = yield from _read_state(evidence)
    yield from _finish(evidence)


def _read_state(evidence: Evidence) -> Procedure[StateReading]:
    """Raises `_Silent` if the module does not answer."""
    state = yield from read_state()
    for key, value in state.settings.values.items():
        evidence.values[key] = value
        evidence.faults.pop(key, None)
    for key, fault in state.settings.faults.items():
        evidence.values.pop(key, None)
        evidence.faults[key] = message(fault.value)
    if state.settings.boot_count is not None:
        evidence.values[BOOT_COUNT.key] = state.settings.boot_count
    yield from _drop_doubtful(evidence)
    evidence.status = state.status or evidence.status
    if state.settings.is_restarted:
        evidence.disturbance = Disturbance.RESTARTED
    if state.settings.is_silent:
        raise _Silent
    return state


def _drop_doubtful(evidence: Evidence) -> Procedure[None]:
    """After a break drop what was read before: it may be another module's, and the check may end at any moment."""
    view: EngineView = yield Inspect()
    if view.device.breaks == evidence.breaks_noticed:
        return
    evidence.breaks_noticed = view.device.breaks
    fresh = {key: view.device.fresh(key, view.now) for key in evidence.values}
    evidence.keep_only({key: value for key, value in fresh.items() if value is not None})


def _step(evidence: Evidence, done: int, doing: str) -> Procedure[None]:
    """Report progress; counts invalid bytes so that an aborted check has them, too."""
    yield from _count_rejected(evidence)
    yield Report(done, STEPS, doing)


def _count_rejected(evidence: Evidence) -> Procedure[None]:
    view: EngineView = yield Inspect()
    evidence.rejected_bytes = view.link.counters.rejected - evidence.rejected_before


def _finish(evidence: Evidence) -> Procedure[None]:
    end: EngineView = yield Inspect()
    if end.told is not None and evidence.began_at is not None:
        evidence.is_answered_twice |= end.told.twice_at >= evidence.began_at
    for command in TRIGGERS:
        evidence.flags[command.key] = _final_state(command, evidence.flags[command.key], end)
    if evidence.status is not None:
        evidence.status_age_s = max(0.0, end.now - evidence.status.at)
    yield from _count_rejected(evidence)
    evidence.ended_at = end.now
    if end.device.restarts != evidence.restarts:
        evidence.disturbance = Disturbance.RESTARTED
    elif end.device.breaks != evidence.breaks:
        evidence.disturbance = Disturbance.BROKEN


def _heartbeats(evidence: Evidence) -> Procedure[None]:
    silent_in_a_row = 0
    for _ in range(HEARTBEATS):
        evidence.heartbeats_sent += 1
        outcome = yield Ask(HEARTBEAT.query(), HEARTBEAT_WAITS_S)
        if isinstance(outcome, Answered) and outcome.round_trip_s is not None:
            evidence.round_trips_s.append(outcome.round_trip_s)
            silent_in_a_row = 0
        else:
            silent_in_a_row += 1
            if silent_in_a_row >= 2 * GIVE_UP_AFTER:
                raise _Silent


def _read_slow(evidence: Evidence, command: Command) -> Procedure[None]:
    before: EngineView = yield Inspect()
    reading = yield from ask_value(command)
    yield from _drop_doubtful(evidence)
    if reading is not None:
        evidence.series.setdefault(command.key, []).append(reading.value)
        return
    evidence.faults[command.key] = message(marked("no reply"))
    yield from _require_answers(before)


def _require_answers(before: EngineView) -> Procedure[None]:
    """Raise `_Silent` if the module stopped answering altogether."""
    frames = before.link.counters.frames
    for _ in range(GIVE_UP_AFTER):
        view: EngineView = yield Inspect()
        if view.link.counters.frames > frames:
            return
        yield from is_alive()
    view = yield Inspect()
    if view.link.counters.frames == frames:
        raise _Silent


def _watch(evidence: Evidence) -> Procedure[None]:
    begin: EngineView = yield Inspect()
    ends_at = begin.now + STILL_S
    now = begin.now
    while now < ends_at:
        report = yield from ask_report(TRIAL_WAITS_S)
        yield from _drop_doubtful(evidence)
        if report is not None:
            evidence.status = report
            evidence.trials.append(report)
        now = yield Pause(TRIAL_EVERY_S)
    end: EngineView = yield Inspect()
    # The slowest streams send one report a second; one may also be the second answer to the last question before.
    has_stream = evidence.streamed > 1
    evidence.is_answered_twice |= not has_stream and _streamed(end) - _streamed(begin) > SLOWEST_STREAM


def _streamed(view: EngineView) -> int:
    return view.link.counters.by_role[Role.STREAMED]


def _enable(command: Command, context: WriteContext, progress: Report | None = None) -> Procedure[TriggerFlag]:
    """Enable a trigger with one frame, if writing is allowed: never on an active module."""
    entries: dict[Command, Entry] = {}
    results: list[Written] = []
    try:
        written, refused = yield from write_logged(SettingChange(command, True), context, entries, progress)
        results.append(written)
    finally:
        settle_writes(context.journal, entries, results)
    if written.heard is SetReply.NOT_SENT:
        return TriggerFlag(FlagState.NOT_SENT, refused[0].message if refused else message(marked("no reply")))
    if written.is_acknowledged:
        return TriggerFlag(FlagState.ENABLED)
    return TriggerFlag(FlagState.REFUSED if written.heard is SetReply.OTHER else FlagState.UNANSWERED)


def _final_state(command: Command, flag: TriggerFlag, view: EngineView) -> TriggerFlag:
    """State of the trigger at the end: what the module acknowledged in this conversation."""
    has_repeated = view.flags is not None and view.flags.has_repeated
    if has_repeated and flag.state in (FlagState.ENABLED, FlagState.UNANSWERED):
        return TriggerFlag(FlagState.UNANSWERED, message(marked("this line repeats answers: not known")))
    known = view.device.known(command.key, view.now)
    if known is None or known.is_stale or known.how is not How.ACKNOWLEDGED:
        return TriggerFlag() if flag.state is FlagState.ENABLED else flag
    if flag.state in (FlagState.REFUSED, FlagState.UNANSWERED):
        return flag
    return TriggerFlag(FlagState.ENABLED if known.value is True else FlagState.DISABLED)

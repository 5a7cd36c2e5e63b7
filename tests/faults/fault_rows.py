"""The procedures of the table: how to make each, and how to find a false claim in its result."""

from collections.abc import Mapping
from types import MappingProxyType

from app.procedures.handshake import handshake
from app.procedures.light import measure_light
from app.procedures.read import Seen, SettingsReading, is_another, look, read_one_module, read_settings
from app.procedures.read import who_is_there
from app.procedures.write import SettingChange, WriteContext, write_all, write_logged

from app.engine.procedure import Ask, EngineView, Inspect, Procedure
from app.engine.setting_changes import READABLE_SETTINGS
from app.procedures.act import Performed, begin_act, perform
from app.procedures.baud import BaudChanged, BaudEnd, change_baud
from app.procedures.find import WAITS_S, answers_here, find_rate, look_for, proofs
from app.procedures.history import History, read_history
from app.procedures.lock import Locked, lock
from app.procedures.read import Everything, read_everything, undisturbed
from app.procedures.stream import StreamSwitch, watch
from app.procedures.write import (
    ReadBack,
    SetReply,
    Written,
    await_flags_free,
    await_flags_known,
    read_back,
    restarted_since,
    write_verified,
)
from app.safety.acts import REQUESTS, Act
from app.safety.interlocks import Refusal
from app.safety.journal import Entry, Outcome
from app.safety.permit import Origin, Permit
from protocol.catalogue import BAUD_RATE, BY_NAME, LOCK, SERIAL_OUTPUT, STATUS
from tests.faults.fault_table import Cell, Row, records_held, truth
from tests.support.journals import FakeJournal
from tests.support.line.sim_line import INSTANT_S, FakeClock

THRESHOLD = BY_NAME["attitude_threshold"]
WANTED_DEG = 75
WANTED_RATE = 57600
TRIGGER = BY_NAME["freefall_trigger"]
DISABLED = SettingChange(TRIGGER, False)
BOOTS = 37
"""Boot count of the simulated module before a restart."""
ACTIVE = MappingProxyType({"active": "yes"})


def _no_everything_lie(everything: Everything, cell: Cell) -> list[str]:
    has_restarted = cell.session.device.view(cell.clock.now_s).restarts
    own = {key: value for key, value in everything.values.items() if not (key == "boot_count" and has_restarted)}
    return _value_lies(own, cell)


def _value_lies(values: Mapping[str, object], cell: Cell) -> list[str]:
    holds = truth(cell.bench, cell.clock.now_s)
    return [
        f"read {key} {value}, the module holds {holds[key]}" for key, value in values.items() if holds[key] != value
    ]


def _no_history_lie(history: History, cell: Cell) -> list[str]:
    held = records_held(cell.bench)
    faults = [f"{record.raw.hex()} is no record of it" for record in history.records if record.raw not in held]
    if history.is_confirmed and [record.raw for record in history.records] != held:
        faults.append("confirmed, and not what it holds")
    return faults


def _no_locked_lie(locked: Locked, cell: Cell) -> list[str]:
    if locked.is_locked is None or locked.is_locked is not cell.bench.module.state.is_active:
        return []
    return [f"is_locked is {locked.is_locked}, and the module says otherwise"]


def _no_back_lie(back: ReadBack, cell: Cell) -> list[str]:
    holds = cell.bench.module.memory.attitude_threshold
    return [] if back.raw in (None, holds) else [f"read {back.raw}, the module holds {holds}"]


def _no_reading_lie(reading: SettingsReading, cell: Cell) -> list[str]:
    return _value_lies(reading.values, cell) if reading.is_complete else []


def _is_another() -> Procedure[bool]:
    """Struck after the first reading."""
    yield from read_settings()
    begin: EngineView = yield Inspect()
    yield from who_is_there()
    return (yield from is_another(begin))


def _look() -> Procedure[Seen]:
    begin: EngineView = yield Inspect()
    return (yield from look(begin))


def _trigger() -> Procedure[object]:
    """Disable a trigger; what is known of it once its answer counts."""
    request = BY_NAME["freefall_trigger"].set(False)
    yield from await_flags_free(request)
    yield Ask(request)
    yield from await_flags_known()
    view: EngineView = yield Inspect()
    return view.device.fresh("freefall_trigger", view.now)


def _no_trigger_lie(known: object, cell: Cell) -> list[str]:
    is_enabled = cell.bench.module.state.freefall_is_enabled
    return [] if known in (None, is_enabled) else [f"known as {known}, and the module says {is_enabled}"]


def _permit(act: Act) -> Permit:
    """A permit granted when the clock of the cell starts."""
    return Permit(act, Origin.RITUAL if act is Act.DEPLOY else Origin.COMMAND_LINE, FakeClock().now_s + INSTANT_S)


def _holds(act: Act, cell: Cell) -> bool:
    """Return whether the module is in the state that the act requests."""
    module = cell.bench.module
    match act:
        case Act.LOCK:
            return not module.state.is_active
        case Act.ACTIVATE:
            return module.state.is_active
        case Act.SHUTDOWN:
            return not module.is_on
        case Act.DEPLOY:
            return len(module.memory.records) > 2  # two from earlier days
        case Act.FORBID_DEPLOY:
            return module.state.is_forbidden
        case _:
            return module.memory.zero_tilt_deg != 0.0


def _no_performed_lie(done: Performed, cell: Cell) -> list[str]:
    holds = _holds(done.act, cell)
    # Nothing reports these two: "confirmed" says that it acknowledged, and a restart may come right behind it.
    is_acknowledgement = done.act in (Act.FORBID_DEPLOY, Act.ZERO)
    has_restarted = cell.bench.module.memory.boot_count != BOOTS
    was_sent = REQUESTS[done.act] in cell.port.requests
    if done.outcome is Outcome.CONFIRMED and not holds and not (is_acknowledgement and has_restarted):
        return ["confirmed, and the module says otherwise"]
    if done.outcome is Outcome.REFUSED and holds:
        return ["refused, and the module did it"]
    if done.outcome is Outcome.NOT_SENT and was_sent:
        return ["not sent, and it was"]
    return []


def _act(act: Act, **options: str) -> Row:
    return Row(
        "act.perform",
        lambda: perform(act, FakeJournal(), permit=_permit(act)),
        _no_performed_lie,
        options=MappingProxyType(options),
        variant=act.value,
    )


def _begin_act() -> Procedure[Entry | tuple[Refusal, ...]]:
    act, permit = Act.SHUTDOWN, _permit(Act.SHUTDOWN)
    return (yield from begin_act(act, REQUESTS[act], FakeJournal(), permit=permit, armed=None))


def _no_baud_lie(changed: BaudChanged, cell: Cell) -> list[str]:
    was_sent = BAUD_RATE.set(WANTED_RATE) in cell.port.requests
    if changed.end is BaudEnd.NOT_SENT:
        return ["not sent, and it was"] if was_sent else []
    return rate_lies(changed.found_rate, cell)


def rate_lies(found_rate: int | None, cell: Cell) -> list[str]:
    holds = cell.bench.module.baud_rate
    has_lied = found_rate not in (None, holds) and "baud_rate" not in cell.hidden
    return [f"found at {found_rate}, the module is at {holds}"] if has_lied else []


def written_lies(written: Written, cell: Cell) -> list[str]:
    key, holds = written.command.key, truth(cell.bench, cell.clock.now_s)[written.command.key]
    faults = []
    if written.verified and holds != written.target:
        faults.append(f"{key} verified, and the module holds {holds}")
    if written.read_back is not None and holds != written.read_back:
        faults.append(f"{key} stands {written.read_back}, and the module holds {holds}")
    return faults


def _no_logged_lie(done: tuple[Written, tuple[Refusal, ...]], cell: Cell) -> list[str]:
    was_sent = TRIGGER.set(False) in cell.port.requests
    return ["not sent, and it was"] if was_sent and done[0].heard is SetReply.NOT_SENT else []


def _changes() -> list[SettingChange]:
    wanted = {"attitude_threshold": 75, "freefall_time": 1.2, "light_threshold": 2.0}
    return [SettingChange(BY_NAME[name], value) for name, value in wanted.items()]


def _restarted() -> Procedure[bool]:
    before: EngineView = yield Inspect()
    yield Ask(STATUS.query())
    return (yield from restarted_since(before))


def _no_restart_lie(has_restarted: bool, cell: Cell) -> list[str]:
    return ["a restart, and there was none"] if has_restarted and cell.bench.module.memory.boot_count == BOOTS else []


ROWS: tuple[Row, ...] = (
    Row("handshake.handshake", handshake, lambda _result, _cell: []),
    Row("who_is_there.who_is_there", who_is_there, lambda _result, _cell: []),
    Row("settings_reading.look", _look, lambda _result, _cell: []),
    Row("write.await_flags_free", _trigger, _no_trigger_lie),
    Row("write.await_flags_known", _trigger, _no_trigger_lie),
    Row(
        "find.answers_here",
        lambda: answers_here(WAITS_S, proofs()),
        lambda is_here, cell: rate_lies(cell.session.line.baud_rate if is_here else None, cell),
    ),
    Row("find.find_rate", lambda: find_rate(115200), lambda found, cell: rate_lies(found.baud_rate, cell)),
    Row("read.read_everything", read_everything, _no_everything_lie),
    Row(
        "read.undisturbed",
        lambda: undisturbed(read_everything),
        lambda everything, cell: [] if everything is None else _no_everything_lie(everything, cell),
    ),
    Row("history.read_history", read_history, _no_history_lie),
    Row(
        "lock.lock",
        lock,
        _no_locked_lie,
        options=ACTIVE,
        may_repeat=frozenset({LOCK}),
    ),
    Row(
        "stream.watch",
        lambda: watch(StreamSwitch()),
        lambda _result, _cell: ["it has no end of its own"],
        may_repeat=frozenset({SERIAL_OUTPUT.set(False), SERIAL_OUTPUT.set(True)}),
        runs_for_s=3.0,
    ),
    Row("settings_reading.read_settings", read_settings, _no_reading_lie),
    Row(
        "settings_reading.read_one_module",
        read_one_module,
        lambda reading, cell: [] if isinstance(reading, Refusal) else _no_reading_lie(reading, cell),
    ),
    Row(
        "settings_reading.is_another",
        _is_another,
        lambda is_other, _cell: ["it is the same one"] if is_other else [],
        strikes_at=2 * (len(READABLE_SETTINGS) + 2),
    ),
    Row("write.read_back", lambda: read_back(THRESHOLD), _no_back_lie),
    Row("write.write_verified", lambda: write_verified(THRESHOLD, WANTED_DEG), written_lies),
    _act(Act.ACTIVATE),
    _act(Act.DEPLOY, active="yes"),
    _act(Act.FORBID_DEPLOY, active="yes"),
    _act(Act.SHUTDOWN),
    _act(Act.ZERO, tilt="4"),
    Row(
        "act.begin_act",
        _begin_act,
        lambda _entry, cell: ["sent"] if REQUESTS[Act.SHUTDOWN] in cell.port.requests else [],
    ),
    Row(
        "baud.change_baud",
        lambda: change_baud(WANTED_RATE, FakeJournal(), permit=_permit(Act.CHANGE_BAUD)),
        _no_baud_lie,
    ),
    Row(
        "find.look_for",
        lambda: look_for(WANTED_RATE, 115200),
        rate_lies,
        strikes_at=3,  # the first three heartbeats go out at a rate at which there is no module
    ),
    Row(
        "write_all.write_all",
        lambda: write_all(_changes(), WriteContext(journal=FakeJournal())),
        lambda report, cell: [lie for written in report.results for lie in written_lies(written, cell)],
    ),
    Row(
        "write_all.write_logged",
        lambda: write_logged(DISABLED, WriteContext(journal=FakeJournal(), accepted_risks=frozenset((DISABLED,))), {}),
        _no_logged_lie,
    ),
    Row(
        "light_calibration.measure_light",
        lambda: measure_light(samples=12),
        lambda band, _cell: [f"read {raw}, the module holds 3" for raw in band.raws if raw != 3],
    ),
    Row("write.restarted_since", _restarted, _no_restart_lie),
)
ROW_BY_TITLE: Mapping[str, Row] = MappingProxyType({row.title: row for row in ROWS})

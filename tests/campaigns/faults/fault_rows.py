"""The procedures of the table: how to make each, and how to find a false claim in its result."""

from collections.abc import Mapping
from types import MappingProxyType
from typing import Any

from app.engine.procedure import Ask, EngineView, Inspect, Pause, Procedure
from app.procedures.act import Performed, begin_act, perform
from app.procedures.baud import BaudChanged, change_baud
from app.procedures.find import await_module, find_rate, look_for
from app.procedures.history import History, read_history
from app.procedures.light import measure_light
from app.procedures.lock import Locked, lock
from app.procedures.read import Everything, SettingsReading, read_everything, read_settings, read_twice, who_is_there
from app.procedures.stream import StreamSwitch, watch
from app.procedures.write import (
    SettingChange,
    WriteContext,
    WriteReport,
    Written,
    await_flags_known,
    set_each,
    write_all,
)
from app.safety.acts import REQUESTS, Act
from app.safety.journal import Outcome
from app.safety.permit import Origin, Permit
from protocol.catalogue import BAUD_RATE, BY_NAME, LOCK, SERIAL_OUTPUT
from protocol.messages import Reading
from tests.campaigns.faults.fault_table import Cell, Row, records_held, truth
from tests.support.journals import FakeJournal

THRESHOLD = BY_NAME["attitude_threshold"]
WANTED_RATE = 57600
TRIGGER = BY_NAME["freefall_trigger"]
DISABLED = SettingChange(TRIGGER, False)
BOOTS = 37
"""Boot count of the simulated module before a restart."""
ACTIVE = MappingProxyType({"active": "yes"})


def _no_everything_lie(everything: Everything, cell: Cell) -> list[str]:
    # Returned means that the conversation was unbroken until then: it may have restarted since.
    has_restarted = cell.bench.module.memory.boot_count != BOOTS
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


def _no_back_lie(back: Reading | None, cell: Cell) -> list[str]:
    holds = cell.bench.module.memory.attitude_threshold
    return [] if back is None or back.raw == holds else [f"read {back.raw}, the module holds {holds}"]


def _no_reading_lie(reading: SettingsReading, cell: Cell) -> list[str]:
    return _value_lies(reading.values, cell)


def _trigger() -> Procedure[object]:
    """Disable a trigger; what is known of it once its answer counts."""
    request = BY_NAME["freefall_trigger"].set(False)
    view: EngineView = yield Inspect()
    yield Pause(max(0.0, view.flags.free_at(request) - view.now))
    yield Ask(request)
    yield from await_flags_known()
    view = yield Inspect()
    return view.conversation.fresh("freefall_trigger", view.now)


def _no_trigger_lie(known: object, cell: Cell) -> list[str]:
    is_enabled = cell.bench.module.state.freefall_is_enabled
    return [] if known in (None, is_enabled) else [f"known as {known}, and the module says {is_enabled}"]


def _permit(act: Act, cell: Cell) -> Permit:
    origin = Origin.RITUAL if act is Act.DEPLOY else Origin.COMMAND_LINE
    return Permit(act, origin, cell.clock(), cell.conversation.number)


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
    was_sent = REQUESTS[done.act] in cell.requests
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
        lambda cell: perform(act, FakeJournal(), permit=_permit(act, cell)),
        _no_performed_lie,
        options=MappingProxyType(options),
        variant=act.value,
    )


def _begin_act(cell: Cell) -> Procedure[Any]:
    act = Act.SHUTDOWN
    return begin_act(act, REQUESTS[act], FakeJournal(), permit=_permit(act, cell), armed=None)


def _no_baud_lie(changed: BaudChanged, cell: Cell) -> list[str]:
    was_sent = BAUD_RATE.set(WANTED_RATE) in cell.port.requests
    if not changed.written.is_sent:
        return ["not sent, and it was"] if was_sent else []
    found = changed.written.read_back
    return rate_lies(None if found is None else int(found), cell)


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


def _no_report_lie(report: WriteReport, cell: Cell) -> list[str]:
    unsent = [written for written in report.results if not written.is_sent]
    found = [
        f"{one.command.key} not sent, and it was" for one in unsent if one.command.set(one.target) in cell.requests
    ]
    return found + [lie for written in report.results for lie in written_lies(written, cell)]


def _changes() -> list[SettingChange]:
    wanted = {"attitude_threshold": 75, "freefall_time": 1.2, "light_threshold": 2.0}
    return [SettingChange(BY_NAME[name], value) for name, value in wanted.items()]


ROWS: tuple[Row, ...] = (
    Row("find.await_module", lambda _cell: await_module(), lambda _result, _cell: [], strikes_at=0, outlives=True,
        begins=False),
    Row("read.who_is_there", lambda _cell: who_is_there(), lambda _result, _cell: []),
    Row("write.await_flags_known", lambda _cell: _trigger(), _no_trigger_lie),
    Row(
        "find.find_rate",
        lambda _cell: find_rate(115200),
        lambda found, cell: rate_lies(found.baud_rate, cell),
        outlives=True,
    ),
    Row("read.read_everything", lambda _cell: read_everything(), _no_everything_lie),
    Row("history.read_history", lambda _cell: read_history(), _no_history_lie),
    Row(
        "lock.lock",
        lambda _cell: lock(),
        _no_locked_lie,
        options=ACTIVE,
        may_repeat=frozenset({LOCK}),
        outlives=True,
    ),
    Row(
        "stream.watch",
        lambda _cell: watch(StreamSwitch()),
        lambda _result, _cell: ["it has no end of its own"],
        may_repeat=frozenset({SERIAL_OUTPUT.set(False), SERIAL_OUTPUT.set(True)}),
        runs_for_s=3.0,
    ),
    Row("read.read_settings", lambda _cell: read_settings(), _no_reading_lie),
    Row("read.read_twice", lambda _cell: read_twice(THRESHOLD), _no_back_lie),
    _act(Act.ACTIVATE),
    _act(Act.DEPLOY, active="yes"),
    _act(Act.FORBID_DEPLOY, active="yes"),
    _act(Act.SHUTDOWN),
    _act(Act.ZERO, tilt="4"),
    Row(
        "act.begin_act",
        _begin_act,
        lambda _entry, cell: ["sent"] if REQUESTS[Act.SHUTDOWN] in cell.requests else [],
    ),
    Row(
        "baud.change_baud",
        lambda cell: change_baud(WANTED_RATE, FakeJournal(), permit=_permit(Act.CHANGE_BAUD, cell)),
        _no_baud_lie,
        outlives=True,
    ),
    Row("find.look_for", lambda _cell: look_for(WANTED_RATE, 115200), rate_lies, strikes_at=14, outlives=True),
    Row(
        "write.write_all", lambda _cell: write_all(_changes(), WriteContext(journal=FakeJournal())), _no_report_lie
    ),
    Row(
        "write.set_each",
        lambda _cell: set_each([DISABLED], WriteContext(journal=FakeJournal(), accepted_risks=frozenset((DISABLED,)))),
        _no_report_lie,
    ),
    Row(
        "light.measure_light",
        lambda _cell: measure_light(samples=12),
        lambda band, _cell: [f"read {raw}, the module holds 3" for raw in band.raws if raw != 3],
    ),
)  # fmt: skip
ROW_BY_TITLE: Mapping[str, Row] = MappingProxyType({row.title: row for row in ROWS})

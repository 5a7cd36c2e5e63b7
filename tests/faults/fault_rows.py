"""The procedures of the table that only ask or write: how to make each, and find a false claim in its result."""

from collections.abc import Mapping
from types import MappingProxyType

from app.engine.procedure import EngineView, Inspect, Procedure
from app.engine.setting_changes import READABLE_SETTINGS
from app.procedures.ask_status import ask_status
from app.procedures.find import WAITS_S, answers_here, find_rate, proofs
from app.procedures.handshake import handshake
from app.procedures.history import History, read_history
from app.procedures.lock import Locked, lock
from app.procedures.read import Everything, read_everything, undisturbed
from app.procedures.settings_reading import SettingsReading, is_another, read_settings
from app.procedures.stream import StreamSwitch, watch
from app.procedures.write import ReadBack, read_back, write_verified
from protocol.catalogue import BY_NAME, LOCK, SERIAL_OUTPUT
from tests.faults.fault_rows_acts import ACT_ROWS, rate_lies, written_lies
from tests.faults.fault_table import Cell, Row, records_held, truth

THRESHOLD = BY_NAME["attitude_threshold"]
WANTED_DEG = 75


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
    yield from ask_status()
    return (yield from is_another(begin))


ROWS: tuple[Row, ...] = (
    Row("handshake.handshake", handshake, lambda _result, _cell: []),
    Row("ask_status.ask_status", ask_status, lambda _result, _cell: []),
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
        options=MappingProxyType({"active": "yes"}),
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
        "settings_reading.is_another",
        _is_another,
        lambda is_other, _cell: ["it is the same one"] if is_other else [],
        strikes_at=2 * (len(READABLE_SETTINGS) + 2),
    ),
    Row("write.read_back", lambda: read_back(THRESHOLD), _no_back_lie),
    Row("write.write_verified", lambda: write_verified(THRESHOLD, WANTED_DEG), written_lies),
    *ACT_ROWS,
)
ROW_BY_TITLE: Mapping[str, Row] = MappingProxyType({row.title: row for row in ROWS})

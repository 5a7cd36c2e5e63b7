"""The procedures of build/faults: how to make each, describe its result, and find a false claim in it."""

from collections.abc import Mapping
from types import MappingProxyType
from typing import Any

from app.procedures.ask_status import ask_status
from app.procedures.find import WAITS_S, Found, answers_here, find_rate, proofs
from app.procedures.handshake import handshake
from app.procedures.history import History, read_history
from app.procedures.lock import Locked, lock
from app.procedures.read import Everything, read_everything
from app.procedures.settings_reading import SettingsReading, read_settings
from app.procedures.stream import StreamSwitch, watch
from app.procedures.write import ReadBack, Written, read_back, write_verified
from protocol.catalogue import BY_NAME, LOCK, SERIAL_OUTPUT
from tests.faults.fault_rows_acts import ACT_ROWS
from tests.faults.fault_table import Cell, Row, records_held, truth

THRESHOLD = BY_NAME["attitude_threshold"]
WANTED_DEG = 75


def _says_found(found: Found) -> str:
    return "not found" if found.baud_rate is None else f"{found.baud_rate}"


def _says_everything(everything: Everything) -> str:
    if everything.is_line_dead:
        return "part, then silent"
    return f"all but {len(everything.errors)}" if everything.errors else "all"


def _says_history(history: History) -> str:
    if history.is_confirmed:
        return "confirmed"
    return "silent" if history.is_line_dead else "not confirmed"


def _says_back(back: ReadBack) -> str:
    return "read" if back.raw is not None else ("unsteady" if back.is_unsteady else "not read")


def _says_reading(reading: SettingsReading) -> str:
    if reading.is_silent:
        return "part, then silent"
    if reading.is_restarted:
        return "restarted"
    return "complete" if reading.is_complete else f"all but {len(reading.faults)}"


def _says_written(written: Written) -> str:
    if written.fault is None:
        return "verified" if written.verified else "acknowledged"
    return written.fault.name.lower().replace("_", " ")


def _nothing(_result: Any, _cell: Cell) -> list[str]:
    return []


def _no_found_lie(found: Found, cell: Cell) -> list[str]:
    holds = cell.bench.module.baud_rate
    has_lied = found.baud_rate not in (None, holds) and "baud_rate" not in cell.hidden
    return [f"found {found.baud_rate}, the module is at {holds}"] if has_lied else []


def _no_here_lie(is_here: bool, cell: Cell) -> list[str]:
    return _no_found_lie(Found(cell.session.line.baud_rate if is_here else None, ()), cell)


def _no_everything_lie(everything: Everything, cell: Cell) -> list[str]:
    holds = truth(cell.bench, cell.clock.now_s)
    return [
        f"read {key} {value}, the module holds {holds[key]}"
        for key, value in everything.values.items()
        if holds[key] != value and not (key == "boot_count" and cell.session.device.view(cell.clock.now_s).restarts)
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
    if not reading.is_complete:
        return []
    holds = truth(cell.bench, cell.clock.now_s)
    return [
        f"read {key} {value}, the module holds {holds[key]}"
        for key, value in reading.values.items()
        if holds[key] != value
    ]


def _no_written_lie(written: Written, cell: Cell) -> list[str]:
    holds = truth(cell.bench, cell.clock.now_s)[written.command.key]
    faults = []
    if written.verified and holds != written.wanted:
        faults.append(f"verified, and the module holds {holds}")
    if written.stands is not None and holds != written.stands:
        faults.append(f"stands {written.stands}, and the module holds {holds}")
    return faults


ROWS: tuple[Row, ...] = (
    Row(
        "handshake.handshake",
        handshake,
        lambda done: "answered" if done.silence is None else done.silence.value,
        _nothing,
    ),
    Row("ask_status.ask_status", ask_status, lambda is_known: "known" if is_known else "unknown", _nothing),
    Row(
        "find.answers_here",
        lambda: answers_here(WAITS_S, proofs()),
        lambda is_here: "answers here" if is_here else "not here",
        _no_here_lie,
    ),
    Row("find.find_rate", lambda: find_rate(115200), _says_found, _no_found_lie),
    Row("read.read_everything", read_everything, _says_everything, _no_everything_lie),
    Row("history.read_history", read_history, _says_history, _no_history_lie),
    Row(
        "lock.lock",
        lock,
        lambda locked: {True: "locked", False: "not locked", None: "not known"}[locked.is_locked],
        _no_locked_lie,
        options=MappingProxyType({"active": "yes"}),
        may_repeat=frozenset({LOCK}),
    ),
    Row(
        "stream.watch",
        lambda: watch(StreamSwitch()),
        str,
        lambda _result, _cell: ["it has no end of its own"],
        may_repeat=frozenset({SERIAL_OUTPUT.set(False), SERIAL_OUTPUT.set(True)}),
        runs_for_s=3.0,
        says_cancelled=lambda cell: (
            "stream left on" if cell.bench.module.state.serial_output_is_on else "stream off again"
        ),
    ),
    Row("settings_reading.read_settings", read_settings, _says_reading, _no_reading_lie),
    Row("write.read_back", lambda: read_back(THRESHOLD), _says_back, _no_back_lie),
    Row(
        "write.write_verified",
        lambda: write_verified(THRESHOLD, WANTED_DEG),
        _says_written,
        _no_written_lie,
    ),
    *ACT_ROWS,
)
ROW_BY_TITLE: Mapping[str, Row] = MappingProxyType({row.title: row for row in ROWS})

"""Fault × procedure × phase: every cell ends in time, typed, without a lie, and leaves nothing behind."""

from collections.abc import Callable
from pathlib import Path

import pytest

from app.engine.procedure import Ask, Inspect, Pause, Procedure
from app.engine.transport import PortError, PortTrouble
from protocol.catalogue import BY_NAME, HEARTBEAT
from tests.campaigns.faults.fault_kinds import BY_NAME_OF_FAULT, FAULTS
from tests.campaigns.faults.fault_rows import ROW_BY_TITLE, ROWS
from tests.campaigns.faults.fault_table import Cell, Row, device_lies, procedures, run_cell, run_row, target_index
from tests.campaigns.faults.faulty_port import Phase

PAGE = Path(__file__).parents[3] / "docs" / "internals" / "line-faults.md"
FEWEST_FAULTS = 20


def test_every_procedure_has_a_row_and_every_row_a_procedure() -> None:
    found = {name for name, _ in procedures()}
    assert found == {row.name for row in ROWS}, "add the procedure to tests/campaigns/faults/fault_rows.py"
    assert len(ROW_BY_TITLE) == len(ROWS)


def test_there_are_enough_faults_and_each_has_its_own_name() -> None:
    assert len(FAULTS) >= FEWEST_FAULTS
    assert len(BY_NAME_OF_FAULT) == len(FAULTS)


@pytest.mark.parametrize(("number", "row"), list(enumerate(ROWS)), ids=[row.title for row in ROWS])
@pytest.mark.promise("i", "k")
def test_all_faults_in_all_phases(number: int, row: Row) -> None:
    cells = run_row(row, number)
    broken = {key: cell.faults for key, cell in cells.items() if cell.faults}
    assert broken == {}
    missed = [key for key, cell in cells.items() if not cell.has_struck]
    assert missed == [], "the fault never happened"


def test_the_page_says_what_the_program_does_under_each_fault() -> None:
    table = "\n".join(f"| {fault.name} | {fault.behaviour} |" for fault in FAULTS)
    assert f"| Fault | What the program does |\n| --- | --- |\n{table}\n" in PAGE.read_text(encoding="utf-8")


# The table is shown to notice what it looks for


def broken() -> Procedure[object]:
    yield Inspect()
    raise KeyError("bug")


def slow() -> Procedure[object]:
    yield Pause(200)
    return None


def twice() -> Procedure[object]:
    for _ in range(2):
        yield Ask(BY_NAME["attitude_threshold"].set(70))
    return None


@pytest.mark.parametrize(
    ("procedure", "said"),
    [(broken, "ended with KeyError"), (slow, "took"), (twice, "sent 2 times")],
)
def test_a_faulty_procedure_is_noticed(procedure: Callable[[], Procedure[object]], said: str) -> None:
    row = Row("test", lambda _cell: procedure(), lambda _result, _cell: [])
    assert any(said in fault for fault in run_cell(row, BY_NAME_OF_FAULT["half a frame"], Phase.BEFORE, 0).faults)


def test_a_value_that_the_module_does_not_hold_is_noticed() -> None:
    def read() -> Procedure[object]:
        yield Ask(BY_NAME["attitude_threshold"].query())
        cell.bench.module.memory.attitude_threshold = 11
        return None

    cell = Cell(Row("test", lambda _cell: read(), lambda _result, _cell: []))
    cell.go()
    assert device_lies(cell, frozenset()) == ["attitude_threshold_deg is shown as 60, the module holds 11"]


def test_a_port_that_is_lost_says_how() -> None:
    def ask() -> Procedure[object]:
        yield Ask(HEARTBEAT.query())
        return None

    for name, trouble in (("unplugged", PortTrouble.LOST), ("a write that blocks", PortTrouble.STUCK)):
        cell = Cell(Row("test", lambda _cell: ask(), lambda _result, _cell: []))
        cell.port.index, cell.port.phase = cell.first, Phase.BEFORE
        fault = BY_NAME_OF_FAULT[name]
        cell.port.strike = lambda fault=fault, cell=cell: fault.begin(cell, cell.port)  # type: ignore[misc]
        with pytest.raises(PortError) as lost:
            cell.go()
        assert lost.value.trouble is trouble


def test_the_struck_request_is_the_act_where_there_is_one() -> None:
    titles = ("lock.lock", "write.write_all", "read.read_everything", "find.look_for")
    assert [target_index(ROW_BY_TITLE[title]) for title in titles] == [0, 9, 1, 14]

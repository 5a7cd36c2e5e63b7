"""Every sub-command in this process, on the simulated module: what it prints and how it ends."""

import json

import pytest

import app.__main__ as program
from app.engine.procedure import Inspect, Procedure
from app.procedures.history import History
from app.simulator import bench as benches
from protocol.catalogue import STATUS
from tests.support.cli_line import Printed, bench_of, falls_after, is_one_sentence, run_here

pytest_plugins = ["tests.support.cli_fixtures"]
pytestmark = pytest.mark.usefixtures("speaks_english")


@pytest.mark.parametrize(("is_unplugged", "error", "said"), [(False, "no reply", ""), (True, "port lost", "unplugged")])
def test_what_ends_in_the_middle_keeps_what_was_read(
    port: str, hasty: None, is_unplugged: bool, error: str, said: str, capsys: pytest.CaptureFixture[str]
) -> None:
    bench = bench_of(port)
    with falls_after(bench, 4, bench.unplug if is_unplugged else lambda: bench.change(mute=True)):
        assert program.main(["read", "--port", port, "--json"]) == 4
    printed = Printed(capsys)
    shown = json.loads(printed.out)
    assert (shown["status"]["tilt_deg"], shown["status"]["acceleration_g"]) == (0, 1.0)
    assert (shown["boot_count"], shown["errors"]["boot_count"]) == (None, error)
    assert said in printed.err
    assert is_one_sentence(printed.err)


def test_a_restart_in_the_middle_reads_again(port: str, capsys: pytest.CaptureFixture[str], wire: list[bytes]) -> None:
    bench = bench_of(port)
    with falls_after(bench, 6, bench.restart):
        assert program.main(["read", "--port", port, "--json"]) == 0
    shown = json.loads(Printed(capsys).out)
    assert shown["boot_count"] == 38
    assert shown["errors"] == {}
    assert wire.count(STATUS.query().encode()) >= 2


def test_records_of_a_port_that_was_lost_are_kept(port: str, hasty: None, capsys: pytest.CaptureFixture[str]) -> None:
    bench = benches.module(port.removeprefix("sim://"))
    # The second reading of the records is the third frame: heartbeat, records, records.
    with falls_after(bench, 3, bench.unplug):
        assert program.main(["history", "--port", f"{port}?empty_slots=ones", "--json"]) == 4
    printed = Printed(capsys)
    assert json.loads(printed.out) == {"records": [], "empty_slots": 9, "answered": True, "complete": False}
    assert "unplugged" in printed.err


def test_records_that_never_agree_are_said_to_be_uncertain(
    port: str, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    def read_history() -> Procedure[History]:
        yield Inspect()
        return History((), 1, is_answered=True)

    monkeypatch.setattr("app.cli.history.read_history", read_history)
    printed = run_here(capsys, ["history", "--port", port, "--json"], 4)
    assert json.loads(printed.out) == {"records": [], "empty_slots": 1, "answered": True, "complete": False}
    assert "may be missing" in printed.err

"""Another module, that runs already, is plugged in behind the port in the middle of a command."""

import json
from threading import Timer

import pytest

from app.simulator import bench as benches
from tests.support.cli_line import bench_of, falls_after, run_here

pytest_plugins = ["tests.support.cli_fixtures"]
pytestmark = pytest.mark.usefixtures("speaks_english")
GAP_S = 0.5
"""While the cable is in nobody's hands; a query is repeated for a second."""


def exchange(bench: benches.SimulatedBench, **memory: int) -> None:
    bench.change(mute=True)
    for name, value in {"boot_count": 90, "attitude_threshold": 85, **memory}.items():
        setattr(bench.module.memory, name, value)
    Timer(GAP_S, bench.change, kwargs={"mute": False}).start()


@pytest.mark.parametrize("frame", [5, 8, 10])
def test_values_of_two_modules_are_not_read_as_those_of_one(
    port: str, frame: int, capsys: pytest.CaptureFixture[str]
) -> None:
    bench = bench_of(port)
    with falls_after(bench, frame, lambda: exchange(bench, light_threshold=70)):
        shown = json.loads(run_here(capsys, ["read", "--port", port, "--json"]).out)
    settings = shown["settings"]
    assert (shown["boot_count"], settings["attitude_threshold_deg"], settings["light_threshold_v"]) == (90, 85, 7.0)


def test_a_reading_that_ends_in_silence_is_not_whole(
    port: str, hasty: None, capsys: pytest.CaptureFixture[str]
) -> None:
    """Everything was read, after a silence in between, and is read once more."""
    bench = bench_of(port)
    with (
        falls_after(bench, 14, lambda: bench.change(mute=True)),
        falls_after(bench, 5, lambda: exchange(bench, boot_count=37, attitude_threshold=60)),
    ):
        printed = run_here(capsys, ["read", "--port", port, "--json"], 4)
    assert "stopped answering" in printed.err
    assert json.loads(printed.out)["settings"]["attitude_threshold_deg"] == 60


@pytest.mark.parametrize("frame", [6, 7])
def test_of_a_module_that_was_activated_nobody_says_that_it_is_locked(
    port: str, frame: int, capsys: pytest.CaptureFixture[str]
) -> None:
    """What answers then is another one, which is locked."""
    bench = bench_of(port)

    def leave_active() -> None:
        assert bench.module.state.is_active
        bench.module.activate(is_active=False)
        exchange(bench)

    with falls_after(bench, frame, leave_active):
        printed = run_here(capsys, ["activate", "--yes", "--port", port], 1)
    assert printed.err == "Sent, not confirmed: treat the module as ACTIVE.\n"


@pytest.mark.parametrize("frame", [4, 8, 12])
def test_nothing_is_written_to_another_module_than_was_read(
    port: str, frame: int, capsys: pytest.CaptureFixture[str]
) -> None:
    bench = bench_of(port)
    with falls_after(bench, frame, lambda: exchange(bench)):
        printed = run_here(capsys, ["set", "attitude_threshold_deg=75", "--port", port], 1)
    assert "not sent: The module restarted. Read again." in printed.out
    assert bench.module.memory.attitude_threshold == 85


def test_a_check_that_met_two_modules_tells_nothing_of_the_named_one(
    port: str, capsys: pytest.CaptureFixture[str]
) -> None:
    bench = bench_of(port)
    words = ["preflight", "--port", port, "--who", "R. Tanaka", "--module", "M-07", "--json"]
    with falls_after(bench, 8, lambda: exchange(bench)):
        met = json.loads(run_here(capsys, words, 1).out)
    assert met["read"]["boot_count"] == 90
    bench.module.memory.boot_count, bench.module.memory.attitude_threshold = 37, 60
    checks = {one["id"]: one for one in json.loads(run_here(capsys, words, 1).out)["checks"]}
    assert checks["undisturbed"]["result"] == "pass"
    assert checks["boot_count"]["result"] == "warn", checks["boot_count"]


def test_records_of_one_module_are_not_kept_under_the_name_of_the_next(
    port: str, capsys: pytest.CaptureFixture[str]
) -> None:
    bench, words = bench_of(port), ["history", "--port", port, "--module", "M-07"]
    with falls_after(bench, 15, lambda: exchange(bench)):
        printed = run_here(capsys, words, 4)
    assert printed.err.startswith("The module restarted. Read again.\n")
    bench.module.memory.boot_count, bench.module.memory.attitude_threshold = 37, 60
    run_here(capsys, words)

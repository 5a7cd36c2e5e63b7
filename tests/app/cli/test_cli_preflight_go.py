"""`dps-s preflight`: READY and GO only in the connection in which the triggers were enabled."""

import json

import pytest

import app.__main__ as program
from tests.support.cli_line import Printed, bench_of, run_here

pytest_plugins = ["tests.support.cli_fixtures"]
pytestmark = pytest.mark.usefixtures("speaks_english", "hasty", "brief")


def _enabled(port: str, capsys: pytest.CaptureFixture[str], *words: str) -> None:
    assert run_here(capsys, ["preflight", "--enable-triggers", "--port", port, *words]).out.startswith("READY")


def _checked(port: str, capsys: pytest.CaptureFixture[str], *words: str) -> tuple[str, set[str]]:
    """The verdict of "check only", and the checks that stand against it."""
    program.main(["preflight", "--port", port, "--json", *words])
    shown = json.loads(Printed(capsys).out)
    return shown["verdict"], {one["id"] for one in shown["checks"] if one["result"] in ("fail", "unknown")}


@pytest.mark.parametrize("is_active", [False, True])
@pytest.mark.parametrize(("before", "after"), [("", ""), ("", "M-08"), ("M-07", ""), ("M-07", "M-07")])
def test_another_connection_is_never_ready_or_go(
    port: str, capsys: pytest.CaptureFixture[str], before: str, after: str, is_active: bool
) -> None:
    """Another module behind the same port: the same boot count and settings, its triggers never enabled."""
    _enabled(port, capsys, *(("--module", before) if before else ()))
    bench_of(port).module.activate(is_active=is_active)
    verdict, against = _checked(port, capsys, *(("--module", after) if after else ()))
    assert (verdict, against) == ("NO-GO", {"attitude_trigger", "freefall_trigger"})


def test_a_restart_that_the_boot_count_does_not_count(port: str, capsys: pytest.CaptureFixture[str]) -> None:
    _enabled(port, capsys)
    bench_of(port).module.memory.boot_count -= 1
    bench_of(port).restart()
    assert _checked(port, capsys)[0] == "NO-GO"

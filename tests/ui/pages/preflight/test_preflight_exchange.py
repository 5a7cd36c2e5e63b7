"""A module exchanged behind the same port, or restarted unseen by its boot count, has no READY and no GO."""

from pathlib import Path

import pytest
from PySide6.QtWidgets import QApplication
from pytestqt.qtbot import QtBot

from app.simulator import bench as benches
from tests.support.window.preflight_window import OnBench, name_module, on_bench
from ui.pages.preflight.controller import Standing


def exchange(bench: OnBench, *, is_active: bool) -> None:
    """For a new module with the same boot count and settings, whose triggers were never enabled."""
    connector = bench.assembly.connector
    connector.current.disconnect_port()
    bench.until(lambda: not connector.current.is_open)
    benches.remove_bench(bench.name)
    bench.bench = benches.module(bench.name)
    bench.bench.module.activate(is_active=is_active)
    bench.connect()
    bench.until(lambda: bench.preflight.work.can_check and bench.preflight.work.reported_active is is_active)


@pytest.mark.parametrize("is_active", [False, True])
@pytest.mark.parametrize(("before", "after"), [("", ""), ("", "M-08"), ("M-07", ""), ("M-07", "M-07")])
def test_a_twin_behind_the_same_port_is_never_ready_or_go(
    qtbot: QtBot, qapp: QApplication, tmp_path: Path, quick: None, before: str, after: str, is_active: bool
) -> None:
    with on_bench(qtbot, qapp, tmp_path, "twin") as bench:
        if before:
            name_module(bench, before)
        assert bench.check() is Standing.READY
        exchange(bench, is_active=is_active)
        name_module(bench, after)
        assert bench.check(is_enabling=False) in (Standing.NO_GO, Standing.VOID)
        assessment = bench.preflight.work.assessment
        assert assessment is not None
        assert {"attitude_trigger", "freefall_trigger"} <= set(assessment.open_checks)


def test_a_restart_that_is_not_counted_ends_ready_until_they_are_enabled_again(
    qtbot: QtBot, qapp: QApplication, tmp_path: Path, quick: None
) -> None:
    with on_bench(qtbot, qapp, tmp_path, "brown") as bench:
        assert bench.check() is Standing.READY
        bench.bench.module.memory.boot_count -= 1
        bench.restart()
        bench.wait_standing(Standing.VOID)
        assert bench.check(is_enabling=False) is Standing.NO_GO
        assert bench.check() is Standing.READY

"""Survives a power cycle: claimed only where a restart was seen, proven and everything was read again."""

from collections.abc import Callable
from typing import Any

import pytest

from app.engine.procedure import Report
from app.procedures.power_cycle import (
    Ending,
    PowerCycleResult,
    Retention,
    SettingRetention,
    _ending,
    survives_power_cycle,
)
from protocol.catalogue import BY_NAME
from protocol.fields import Value
from tests.support.line.sim_line import Rig

WANTED: dict[str, Value] = {"freefall_time_s": 1.6, "attitude_threshold_deg": 60, "attitude_trigger": True}


def survive(rig: Rig, meanwhile: Callable[[], None], **more: Any) -> PowerCycleResult:
    run = rig.started(survives_power_cycle(WANTED, **more))
    rig.step_for(3.0)
    assert not run.is_done
    meanwhile()
    return rig.end(run, limit_s=400)


@pytest.mark.parametrize("boots", [37, 255])
def test_a_restart_with_everything_kept(boots: int) -> None:
    rig = Rig({"boots": boots})
    survival = survive(rig, rig.bench.restart)
    assert (survival.ending, survival.boots_after) == (Ending.RESTARTED, (boots + 1) % 256)
    assert survival.is_fine
    assert survival.stamps == {
        "freefall_time_s": SettingRetention(1.6, Retention.RETAINED, 1.6),
        "attitude_threshold_deg": SettingRetention(60, Retention.RETAINED, 60),
        "attitude_trigger": SettingRetention(True, Retention.UNREADABLE),
    }


def test_a_value_that_is_gone_is_lost() -> None:
    rig = Rig()

    def forgets() -> None:
        rig.bench.module.memory.freefall_time = 100
        rig.bench.restart()

    survival = survive(rig, forgets)
    assert survival.stamps["freefall_time_s"] == SettingRetention(1.6, Retention.LOST, 1.0)
    assert not survival.is_fine


def test_a_value_that_is_not_answered_afterwards_is_neither_kept_nor_lost() -> None:
    rig = Rig()

    def falls_silent() -> None:
        rig.bench.change(mute_codes=frozenset((BY_NAME["freefall_time"].code,)))
        rig.bench.restart()

    survival = survive(rig, falls_silent)
    assert survival.stamps["freefall_time_s"] == SettingRetention(1.6, Retention.NOT_READ)
    assert survival.stamps["attitude_threshold_deg"].result is Retention.RETAINED
    assert not survival.is_fine


def test_off_for_a_while_and_heartbeats_that_nobody_heard() -> None:
    rig = Rig()

    def goes_away() -> None:
        rig.bench.power_off()
        rig.step_for(20.0)
        rig.bench.change(mute=True)
        rig.bench.press_switch()
        rig.step_for(3.0)
        rig.bench.end_faults()

    survival = survive(rig, goes_away)
    assert survival.ending is Ending.RESTARTED
    assert survival.is_fine


def test_several_restarts_are_said() -> None:
    rig = Rig()

    def twice() -> None:
        rig.bench.power_off()
        rig.bench.press_switch()
        rig.bench.restart()

    assert survive(rig, twice).ending is Ending.SEVERAL


def test_nobody_switches_it_off() -> None:
    rig = Rig()
    survival = survive(rig, lambda: None, longest_wait_s=30.0)
    assert (survival.ending, survival.stamps, survival.is_fine) == (Ending.NOT_SEEN, {}, False)


def test_a_boot_count_that_cannot_be_read_proves_nothing() -> None:
    rig = Rig({"mute_codes": frozenset((0x23,))})
    survival = survive(rig, rig.bench.restart, longest_wait_s=20.0)
    assert survival.ending is Ending.NOT_SEEN


def test_a_line_that_damages_frames_never_makes_a_restart_of_it() -> None:
    for seed in range(20):
        rig = Rig({"corrupt": 0.05, "seed": seed})
        survival = rig.run(survives_power_cycle(WANTED, longest_wait_s=20.0))
        assert survival.ending in (Ending.NOT_SEEN, Ending.UNPROVEN)
        assert not survival.is_fine


def test_what_to_do_is_said() -> None:
    reports: list[Report] = []
    rig = Rig()
    rig.run(survives_power_cycle(WANTED, longest_wait_s=2.0), reports.append)
    assert {report.doing for report in reports} == {"Switch the module off and on"}


@pytest.mark.parametrize("phase_ms", range(0, 1100, 10))
def test_what_was_read_back_is_not_in_doubt_because_of_the_same_restart(phase_ms: int) -> None:
    """The boot count can be read between the two heartbeats of one restart."""
    rig = Rig()

    def restarts() -> None:
        rig.step_for(phase_ms / 1000)
        rig.bench.restart()

    assert survive(rig, restarts).ending is Ending.RESTARTED
    rig.step_for(0.5)
    known = rig.session.device.view(rig.clock()).known("freefall_time_s", rig.clock())
    assert known is not None
    assert not known.is_stale


@pytest.mark.parametrize(
    ("before", "after", "ending"),
    [
        (7, 7, Ending.UNPROVEN),
        (7, 8, Ending.RESTARTED),
        (255, 0, Ending.RESTARTED),
        (7, 9, Ending.SEVERAL),
        (None, 8, Ending.UNPROVEN),
        (7, None, Ending.UNPROVEN),
    ],
)
def test_a_restart_is_proven_by_the_boot_count(before: int | None, after: int | None, ending: Ending) -> None:
    assert _ending(before, after) is ending


@pytest.mark.parametrize("ending", Ending)
@pytest.mark.parametrize("fate", Retention)
def test_everything_is_kept_only_after_a_restart_that_was_seen(ending: Ending, fate: Retention) -> None:
    stamps = {"a": SettingRetention(1, Retention.RETAINED, 1), "b": SettingRetention(2, fate)}
    result = PowerCycleResult(ending=ending, stamps=stamps, boots_before=7)
    is_seen = ending in (Ending.RESTARTED, Ending.SEVERAL)
    assert result.is_fine is (is_seen and fate in (Retention.RETAINED, Retention.UNREADABLE))

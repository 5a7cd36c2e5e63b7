"""Near misses and margins of measurements made by hand, and what is not judged."""

import math
from collections import deque
from typing import NamedTuple

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from app.firing.judge import Firing, SensorSample, TriggerLimits
from app.firing.what_if import MAX_FIRINGS, WhatIfFinding, judge_excerpt
from app.recordings.markers import Marker, MarkerKind
from app.simulator.memory import Memory, limits, record_frame
from app.simulator.module import SimulatedModule
from app.simulator.physics import GRAVITY_M_S2, Physics
from app.simulator.setup import Setup
from protocol.catalogue import SERIAL_OUTPUT
from protocol.messages import Source, TriggerRecord, decode_record
from tests.support.records.excerpts import excerpt

STEP_S = 0.02


def at_rest(count: int, since_s: float = 0.0) -> list[SensorSample]:
    return [SensorSample(since_s + n * STEP_S, 0.0, 1.0) for n in range(count)]


def tilted(*tilts: float) -> list[SensorSample]:
    return [SensorSample(n * STEP_S, tilt, 1.0) for n, tilt in enumerate(tilts)]


def weighed(*weights: float) -> list[SensorSample]:
    return [SensorSample(n * STEP_S, 0.0, weight) for n, weight in enumerate(weights)]


def found_in(
    samples: list[SensorSample], limits: TriggerLimits | None = None, *, active: list[bool] | None = None,
    counts_locked: bool = True, markers: tuple[Marker, ...] = (), is_whole: bool = True,
) -> WhatIfFinding:  # fmt: skip
    whole = excerpt(samples, active=active, markers=markers, is_whole=is_whole)
    return judge_excerpt(whole, limits or TriggerLimits(), counts_locked=counts_locked)


# Tilt


def test_the_nearest_approach_and_its_margin() -> None:
    found = found_in(tilted(0, 52, 57, 51, 0, 55, 40))
    assert [(one.at_s, one.tilt_deg, one.margin_deg) for one in found.near_tilts] == [
        (pytest.approx(0.04), 57, 3), (pytest.approx(0.10), 55, 5),
    ]  # fmt: skip
    assert found.nearest_tilt == found.near_tilts[0]
    assert not found.firings


def test_below_the_reset_angle_it_is_no_near_miss_but_still_the_nearest() -> None:
    found = found_in(tilted(0, 12, 30, 7))
    assert not found.near_tilts
    assert found.nearest_tilt is not None
    assert (found.nearest_tilt.tilt_deg, found.nearest_tilt.margin_deg) == (30, 30)


def test_the_way_to_a_firing_is_no_near_miss() -> None:
    found = found_in(tilted(0, 58, 59, 60, 58, 55, 50, 20))
    assert [one.sample.tilt_deg for one in found.firings] == [60]
    assert not found.near_tilts
    assert found.nearest_tilt is not None
    assert found.nearest_tilt.tilt_deg == 50


@pytest.mark.parametrize(("tilt", "is_close"), [(59, True), (58, False)])
def test_what_is_nearer_than_a_step_of_the_reports(tilt: float, is_close: bool) -> None:
    assert found_in(tilted(0, tilt, 0)).near_tilts[0].may_have_fired is is_close


# Falls


def test_a_short_fall_and_what_was_missing() -> None:
    found = found_in([*weighed(*([1.0] * 5 + [0.1] * 51 + [1.0] * 5))])
    (fall,) = found.near_falls
    assert (fall.since_s, fall.lasted_s) == (pytest.approx(0.10), pytest.approx(1.0))
    assert (fall.margin_s, fall.lowest_g) == (pytest.approx(0.6), 0.1)
    assert fall.longest_s == pytest.approx(1.04)
    assert not fall.may_have_fired
    assert found.lowest is not None
    assert found.lowest.acceleration_g == 0.1


def test_a_fall_whose_end_was_not_seen_may_have_fired() -> None:
    samples = [*weighed(*([1.0] * 5 + [0.1] * 50)), *at_rest(5, since_s=4.0)]
    (fall,) = found_in(samples).near_falls
    assert fall.lasted_s == pytest.approx(0.98)
    assert fall.may_have_fired


def test_a_fall_that_is_not_over_may_still_fire() -> None:
    (fall,) = found_in(weighed(*([1.0] * 5 + [0.1] * 50))).near_falls
    assert math.isinf(fall.longest_s)
    assert fall.may_have_fired


def test_a_fall_as_long_as_the_reports_can_tell() -> None:
    (fall,) = found_in(weighed(*([1.0] * 5 + [0.1] * 80 + [1.0] * 5))).near_falls
    assert fall.lasted_s == pytest.approx(1.58)
    assert fall.may_have_fired  # up to two reports longer


@pytest.mark.parametrize("threshold_g", [0.1 * n for n in range(1, 20)])
def test_the_threshold_itself_is_no_fall_although_values_are_kept_as_short_floats(threshold_g: float) -> None:
    limits = TriggerLimits(freefall_acceleration_g=round(threshold_g, 1), freefall_time_s=0.1)
    at, below = round(threshold_g, 1), round(threshold_g - 0.1, 1)
    assert not found_in(weighed(*[at] * 50), limits).firings
    assert len(found_in(weighed(*[below] * 50), limits).firings) == 1


# What is not judged


def test_pauses_are_not_judged() -> None:
    found = found_in([*at_rest(51), *at_rest(51, since_s=5.0), *at_rest(51, since_s=9.0)])
    assert found.judged_s == pytest.approx(3.0)
    pauses = found.pauses
    assert (pauses.count, pauses.total_s) == (2, pytest.approx(7.0))
    assert (pauses.longest_s, pauses.longest_at_s) == (pytest.approx(4.0), pytest.approx(1.0))


def test_reports_too_far_apart_tell_nothing() -> None:
    found = found_in([SensorSample(float(n), 0.0, 1.0) for n in range(20)])
    assert not found.is_judged
    assert found.report_count == 20


def test_of_a_trigger_that_is_off_nothing_is_said() -> None:
    limits = TriggerLimits(attitude_is_enabled=False, freefall_is_enabled=False)
    found = found_in([SensorSample(0.0, 90.0, 0.0), SensorSample(0.1, 90.0, 0.0)], limits)
    assert (found.firing_count, found.nearest_tilt, found.lowest, found.longest_fall) == (0, None, None, None)


def test_while_it_is_locked() -> None:
    samples, active = tilted(*[0.0] * 10, *[70.0] * 10, *[0.0] * 10), [True] * 5 + [False] * 20 + [True] * 5
    as_it_was = found_in(samples, active=active, counts_locked=False)
    as_if_active = found_in(samples, active=active, counts_locked=True)
    assert (as_it_was.firing_count, as_if_active.firing_count) == (0, 1)
    assert as_it_was.locked_s == as_if_active.locked_s == pytest.approx(0.40)
    assert (as_it_was.judged_s, as_if_active.judged_s) == (pytest.approx(0.18), pytest.approx(0.58))
    assert as_it_was.report_count == 10


def test_activated_while_tilted_it_fires_at_once() -> None:
    found = found_in(tilted(*[70.0] * 20), active=[False] * 10 + [True] * 10, counts_locked=False)
    assert [one.sample.at_s for one in found.firings] == [pytest.approx(0.20)]


@pytest.mark.parametrize("kind", [MarkerKind.RESTARTED, MarkerKind.CONNECTED])
def test_after_a_restart_it_has_forgotten_everything(kind: MarkerKind) -> None:
    samples = tilted(*[70.0] * 20)
    found = found_in(samples, markers=(Marker(0.21, kind), Marker(0.3, MarkerKind.OFFLINE)))
    assert [one.sample.at_s for one in found.firings] == [0.0, pytest.approx(0.22)]


def test_what_is_only_summed_up_is_told() -> None:
    assert not found_in(at_rest(5), is_whole=False).is_whole


def test_many_firings_are_counted_and_the_first_ones_kept() -> None:
    found = found_in(tilted(*[0.0, 90.0] * (MAX_FIRINGS + 10)))
    assert (found.firing_count, len(found.firings)) == (MAX_FIRINGS + 10, MAX_FIRINGS)


# What would have fired by the streamed reports is what the simulated module did, whatever is done to it.


GRID_S = 0.05
"""Everything that is done begins and ends on it; the free-fall times lie between, further from it than a report lasts:
whether a fall was long enough must not hang on which of the sensor's samples is reported."""
RATE_HZ = 200.0


class Action(NamedTuple):
    """Something that is done to the module, and how long nothing is done after it."""

    what: str
    value: float
    steps: int


deeds = st.lists(
    st.builds(
        Action, st.sampled_from(("tilt", "tilt", "drop", "drop", "lock", "unlock")), st.integers(0, 40).map(float),
        st.integers(1, 30),
    ), min_size=1, max_size=14,
)  # fmt: skip
memories = st.builds(
    Memory,
    attitude_threshold=st.integers(0, 100),
    freefall_acceleration=st.integers(0, 9),
    freefall_time=st.sampled_from((32, 52, 78, 108, 162)),
    records=st.builds(lambda: deque(maxlen=100)),
)


class Session(NamedTuple):
    """What a host has of it."""

    samples: list[SensorSample]
    active: list[bool]
    records: list[TriggerRecord]
    limits: TriggerLimits
    booted_s: float


def session(memory: Memory, done: list[Action], *, attitude: bool, freefall: bool) -> Session:
    """Streamed reports of a module with these settings, and the records that it wrote."""
    module = SimulatedModule(Physics(drain_v_per_h=0.0), Setup(rate=RATE_HZ), memory=memory)
    module.power_on(0.0)
    module.state.attitude_is_enabled, module.state.freefall_is_enabled = attitude, freefall
    module.collect(1.0)
    module.receive(SERIAL_OUTPUT.set(True).encode(), 1.0)
    module.activate(is_active=True)
    samples: list[SensorSample] = []
    active: list[bool] = []

    def pass_time(until_s: float) -> None:
        for sent in module.collect(until_s):
            assert sent.data[2] == 0x32
            samples.append(SensorSample(sent.at_s, sent.data[3], sent.data[4] / 10))
            active.append(sent.data[6] == 1)

    step = 20
    for deed in done:
        now_s = 1.0 + step * GRID_S
        pass_time(now_s)
        match deed.what:
            case "tilt":
                module.world.tilt_deg = 5 * deed.value - 100
            case "drop":
                module.world.drop(GRAVITY_M_S2 * (deed.value * GRID_S) ** 2 / 2, now_s)
            case word:
                module.activate(is_active=word == "unlock")
        step += deed.steps
    pass_time(1.0 + step * GRID_S)
    found = [decode_record(record_frame(raw)) for raw in memory.records]
    return Session(
        samples, active, [one for one in found if isinstance(one, TriggerRecord)], limits(memory, module.state), 0.0
    )


def words(firing: Firing) -> tuple[str, ...]:
    return tuple(one.name.lower() for one in Source if one in firing.sources and one.name)


@settings(max_examples=60)
@given(memories, deeds, st.booleans(), st.booleans())
def test_the_module_wrote_a_record_of_each(memory: Memory, done: list[Action], attitude: bool, freefall: bool) -> None:
    made = session(memory, done, attitude=attitude, freefall=freefall)
    found = judge_excerpt(excerpt(made.samples, active=made.active), made.limits, counts_locked=False)
    assert [words(one) for one in found.firings] == [record.sources for record in made.records]
    for firing, record in zip(found.firings, made.records, strict=True):
        assert -0.05 <= firing.sample.at_s - record.uptime_s < 1.05


def test_these_sessions_have_something_in_them() -> None:
    done = [
        Action("tilt", 40, 10),
        Action("tilt", 20, 10),
        Action("drop", 30, 40),
        Action("drop", 6, 20),
        Action("tilt", 31, 4),
    ]
    made = session(Memory(freefall_time=78), done, attitude=True, freefall=True)
    found = judge_excerpt(excerpt(made.samples, active=made.active), made.limits, counts_locked=False)
    assert [words(one) for one in found.firings] == [("attitude",), ("freefall",)]
    assert [one.tilt_deg for one in found.near_tilts] == [55]
    assert [one.lasted_s for one in found.near_falls] == [pytest.approx(0.3, abs=0.011)]
    assert found.lowest is not None
    assert found.lowest.acceleration_g == 0.0

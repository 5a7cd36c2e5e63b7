"""Whole arrays of measurements made by hand; and what would have fired by the streamed reports is what the simulated
module did, whatever is done to it."""

from collections import deque
from typing import NamedTuple

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from app.firing.judge import SensorSample, TriggerLimits
from app.firing.samples import MAX_FIRINGS, Firings, judge_samples
from app.simulator.answers import SimulatedModule
from app.simulator.memory import Memory, limits, record_frame
from app.simulator.physics import GRAVITY_M_S2, Physics
from app.simulator.setup import Setup
from protocol.catalogue import SERIAL_OUTPUT
from protocol.messages import Source, TriggerRecord, decode_record
from tests.support.flights.samples_made import samples_of

STEP_S = 0.02


def tilted(*tilts: float) -> list[SensorSample]:
    return [SensorSample(n * STEP_S, tilt, 1.0) for n, tilt in enumerate(tilts)]


def weighed(*weights: float) -> list[SensorSample]:
    return [SensorSample(n * STEP_S, 0.0, weight) for n, weight in enumerate(weights)]


def found_in(
    samples: list[SensorSample], limits: TriggerLimits | None = None, *, active: list[bool] | None = None,
    resets_s: tuple[float, ...] = (),
) -> Firings:  # fmt: skip
    return judge_samples(*samples_of(samples, active), limits or TriggerLimits(), resets_s)


def test_a_short_fall() -> None:
    assert found_in(weighed(*([1.0] * 5 + [0.1] * 51 + [1.0] * 5))) == ((), pytest.approx(1.0))


@pytest.mark.parametrize("threshold_g", [0.1 * n for n in range(1, 16)])
def test_the_threshold_itself_is_no_fall(threshold_g: float) -> None:
    limits = TriggerLimits(freefall_acceleration_g=round(threshold_g, 1), freefall_time_s=0.1)
    at, below = round(threshold_g, 1), round(threshold_g - 0.1, 1)
    assert not found_in(weighed(*[at] * 50), limits).firings
    assert len(found_in(weighed(*[below] * 50), limits).firings) == 1


def test_of_a_trigger_that_is_off_nothing_is_said() -> None:
    limits = TriggerLimits(attitude_is_enabled=False, freefall_is_enabled=False)
    assert found_in([SensorSample(0.0, 90.0, 0.0), SensorSample(0.1, 90.0, 0.0)], limits) == ((), 0.0)


def test_after_a_restart_it_has_forgotten_everything() -> None:
    found = found_in(tilted(*[70.0] * 20), resets_s=(0.21,))
    assert [at_s for at_s, _ in found.firings] == [0.0, pytest.approx(0.22)]


def test_of_many_firings_the_first_ones_are_kept() -> None:
    found = found_in(tilted(*[0.0, 90.0] * (MAX_FIRINGS + 10)))
    assert len(found.firings) == MAX_FIRINGS
    assert found.firings[0] == (STEP_S, Source.ATTITUDE)


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


def words(sources: Source) -> tuple[str, ...]:
    return tuple(one.name.lower() for one in Source if one in sources and one.name)


@settings(max_examples=60)
@given(memories, deeds, st.booleans(), st.booleans())
def test_the_module_wrote_a_record_of_each(memory: Memory, done: list[Action], attitude: bool, freefall: bool) -> None:
    made = session(memory, done, attitude=attitude, freefall=freefall)
    found = judge_samples(*samples_of(made.samples, made.active), made.limits)
    assert [words(sources) for _, sources in found.firings] == [record.sources for record in made.records]
    for (at_s, _), record in zip(found.firings, made.records, strict=True):
        assert -0.05 <= at_s - record.uptime_s < 1.05


def test_these_sessions_have_something_in_them() -> None:
    done = [
        Action("tilt", 40, 10),
        Action("tilt", 20, 10),
        Action("drop", 30, 40),
        Action("drop", 6, 20),
        Action("tilt", 31, 4),
    ]
    made = session(Memory(freefall_time=78), done, attitude=True, freefall=True)
    found = judge_samples(*samples_of(made.samples, made.active), made.limits)
    assert [words(sources) for _, sources in found.firings] == [("attitude",), ("freefall",)]
    assert found.longest_miss_s == pytest.approx(0.3, abs=0.011)

"""What would have fired by the streamed reports is what the simulated module did, whatever is done to it."""

from collections import deque
from typing import NamedTuple

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from app.firing.judge import Firing, SensorSample, TriggerLimits
from app.firing.what_if import judge_excerpt
from app.simulator.memory import Memory, limits, record_frame
from app.simulator.module import SimulatedModule
from app.simulator.physics import GRAVITY_M_S2, Physics
from protocol.catalogue import SERIAL_OUTPUT
from protocol.messages import Source, TriggerRecord, decode_record
from tests.support.records.excerpts import excerpt

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
    module = SimulatedModule(Physics(drain_v_per_h=0.0), memory=memory, rate_hz=RATE_HZ)
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

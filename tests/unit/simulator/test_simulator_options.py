"""The option table, and what the module does by itself or is made to do."""

from dataclasses import fields

import pytest

from app.simulator.bench import SimulatedBench
from app.simulator.module import SimulatedModule
from app.simulator.setup import Setup, as_text, parse_options
from app.text.messages import UserError
from tests.support.line.sim_line import FakeClock


@pytest.fixture
def clock() -> FakeClock:
    return FakeClock()


@pytest.fixture
def bench(clock: FakeClock) -> SimulatedBench:
    return SimulatedBench(clock=clock)


def test_defaults_read_back_as_themselves() -> None:
    for option in fields(Setup):
        assert parse_options({option.name: as_text(option.default)}) == {option.name: option.default}


@pytest.mark.parametrize(
    ("name", "text", "said"),
    [
        ("rate", "0", "1…1440"),
        ("rate", "fast", "1…1440"),
        ("drop", "nan", "0…1"),
        ("drop", "2", "0…1"),
        ("boots", "1.5", "0…255"),
        ("baud", "1234", "115200"),
        ("active", "maybe", "yes|no"),
    ],
)
def test_a_wrong_value_is_refused_with_what_is_possible(name: str, text: str, said: str) -> None:
    with pytest.raises(UserError, match=name) as refused:
        parse_options({name: text})
    assert said in str(refused.value)


def after(bench: SimulatedBench, seconds: float) -> SimulatedModule:
    """The module so long after its beginning."""
    bench.module.advance(1000.0 + seconds)
    return bench.module


@pytest.mark.parametrize("is_active", [True, False])
def test_its_pwm_input_triggers_it_once_at_the_given_time_if_it_is_active(clock: FakeClock, is_active: bool) -> None:
    bench = SimulatedBench(Setup(pwm_after=20.0, active=is_active), clock=clock)
    assert not after(bench, 19.9).is_triggered
    assert after(bench, 20.1).is_triggered is is_active
    assert len(after(bench, 200.0).memory.records) == is_active


def test_it_falls_at_the_given_time_and_fires(clock: FakeClock) -> None:
    bench = SimulatedBench(Setup(fall_after=20.0, active=True), clock=clock)
    assert after(bench, 21.0).measure(1021.0).acceleration_g < 0.1
    assert not bench.module.is_triggered
    assert after(bench, 22.0).is_triggered


def test_it_restarts_at_the_given_time(clock: FakeClock) -> None:
    bench = SimulatedBench(Setup(restart_after=20.0, active=True, boots=37), clock=clock)
    assert after(bench, 19.9).state.is_active
    assert bench.wire.read(1019.9) == b""
    assert len(bench.wire.read(1021.0)) == 12, "two heartbeats"
    assert after(bench, 100.0).memory.boot_count == 38
    assert not bench.module.state.is_active

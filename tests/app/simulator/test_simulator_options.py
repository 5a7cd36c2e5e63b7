"""The option table, and what the module does by itself or is made to do."""

import pytest

from app.simulator.bench import SimulatedBench
from app.simulator.options import (
    OPTIONS,
    OptionTarget,
    default_text,
    find_option,
    parse_options,
    parse_value,
    setup_from,
)
from app.simulator.quirks import Acknowledge, Delivery, Quirks
from app.simulator.wire import Faults
from app.text.user_error import UserError
from tests.support.line.sim_line import FakeClock


@pytest.fixture
def clock() -> FakeClock:
    return FakeClock()


@pytest.fixture
def bench(clock: FakeClock) -> SimulatedBench:
    return SimulatedBench(clock=clock)


def test_every_field_of_quirks_and_faults_has_an_option() -> None:
    fields = set(Quirks.__slots__) | set(Faults.__slots__)
    assert {option.name for option in OPTIONS if option.target is not OptionTarget.SETUP} == fields


def test_defaults_read_back_as_themselves() -> None:
    for option in OPTIONS:
        assert parse_value(option, default_text(option)) == option.default, option.name
        assert option.text


def test_options_as_typed() -> None:
    setup = setup_from(parse_options({"rate": "200", "drop": "0.1", "records": "pieces", "mute-codes": "14,33"}))
    assert setup.rate == 200
    assert setup.faults.drop == 0.1
    assert setup.quirks.records is Delivery.PIECES
    assert setup.quirks.mute_codes == {0x14, 0x33}


@pytest.mark.parametrize(
    ("name", "text", "said"),
    [
        ("rate", "0", "1…1440"),
        ("rate", "fast", "1…1440"),
        ("drop", "nan", "0…1"),
        ("drop", "2", "0…1"),
        ("boots", "1.5", "0…255"),
        ("ack", "two", "echo|one"),
        ("baud", "1234", "115200"),
        ("active", "maybe", "yes|no"),
        ("mute_codes", "99", "01|10"),
        ("mute_codes", "xy", "CODE,…"),
    ],
)
def test_a_wrong_value_is_refused_with_what_is_possible(name: str, text: str, said: str) -> None:
    with pytest.raises(UserError, match=name) as refused:
        parse_options({name: text})
    assert said in str(refused.value)


def test_an_unknown_option_is_refused_by_name() -> None:
    with pytest.raises(UserError, match="speed"):
        find_option("speed")


def test_a_setup_reaches_the_bench(clock: FakeClock) -> None:
    texts = {"active": "", "boots": "0", "history": "4", "tilt": "5", "bay_open": "yes", "cell": "3.6", "charger": "on"}
    bench = SimulatedBench(setup_from(parse_options(texts | {"baud": "9600"})), clock=clock)
    state = bench.state()
    assert state.is_active
    assert state.boot_count == 0
    assert state.record_count == 4
    assert state.tilt_deg == 5
    assert state.bay_is_open
    assert state.cell_v == 3.6
    assert state.has_external_power
    assert state.baud_rate == 9600
    assert bench.wire.read(clock()) == b"", "its heartbeats are long gone"


def test_a_module_that_is_just_switched_on_shows_its_heartbeats(clock: FakeClock) -> None:
    bench = SimulatedBench(setup_from({"uptime": 0.0}), clock=clock)
    assert len(bench.wire.read(clock() + 0.1)) == 12


def test_its_pwm_input_triggers_it_at_the_given_time_if_it_is_active(clock: FakeClock) -> None:
    for is_active in (True, False):
        bench = SimulatedBench(setup_from({"pwm_after": 20.0, "active": is_active}), clock=clock)
        clock.now_s += 19.9
        assert not bench.state().is_triggered
        clock.now_s += 0.2
        assert bench.state().is_triggered is is_active
        bench.restart()
        clock.now_s += 100
        assert bench.state().record_count == is_active, "once"


def test_a_silent_restart_each_time_that_it_has_run_so_long(clock: FakeClock) -> None:
    bench = SimulatedBench(setup_from({"restart_at_s": 70.0, "active": True}), clock=clock)
    clock.now_s += 9.99
    assert bench.state().is_active
    clock.now_s += 0.02
    assert not bench.state().is_active
    assert (bench.state().boot_count, bench.wire.read(clock())) == (38, b"")
    clock.now_s += 71.0
    assert bench.state().boot_count == 39
    bench.change(restart_at_s=0.0)
    clock.now_s += 500.0
    bench.change(restart_at_s=100.0)
    clock.now_s += 1.0
    assert bench.state().boot_count == 40, "once for a time that has passed already"
    assert bench.wire.next_due(clock()) is not None, "the line wakes for it"


def test_a_restart_that_loses_the_settings(clock: FakeClock) -> None:
    bench = SimulatedBench(setup_from({"forgets": True}), clock=clock)
    bench.module.memory.attitude_threshold = 70
    bench.restart()
    assert bench.module.memory.attitude_threshold == 60


def test_a_module_that_does_nothing_by_itself_is_never_due(clock: FakeClock) -> None:
    assert SimulatedBench(clock=clock).module.next_due(clock()) is None


def test_power_faults_and_the_plug(bench: SimulatedBench, clock: FakeClock) -> None:
    bench.power_off()
    assert not bench.state().is_on
    bench.press_switch()
    assert bench.state().is_on
    bench.change(drop=0.2, ack=Acknowledge.ONE, rate=100.0)
    state = bench.state()
    assert (state.values["drop"], state.values["ack"], state.rate_hz) == (0.2, "one", 100)
    bench.end_faults()
    assert bench.state().values["drop"] == 0
    bench.unplug(for_s=2)
    assert not bench.state().is_plugged_in
    clock.now_s += 2.1
    assert bench.state().is_plugged_in
    bench.unplug()
    clock.now_s += 100
    assert not bench.state().is_plugged_in
    bench.plug()
    assert bench.state().is_plugged_in


def test_the_pwm_input_fires_only_an_active_module(bench: SimulatedBench) -> None:
    assert not bench.pulse_pwm()
    bench.module.activate(is_active=True)
    assert bench.pulse_pwm()
    assert bench.state().is_triggered
    assert bench.state().record_count == 1

"""The option table and the control lines: what one types."""

import os
from collections.abc import Iterator

import pytest

from app.simulator.bench import SimulatedBench
from app.simulator.control_lines import VERBS, ControlLines, execute, help_text
from app.simulator.options import (
    OPTIONS,
    OptionTarget,
    default_text,
    find_option,
    parse_options,
    parse_value,
    setup_from,
)
from app.simulator.quirks import Delivery, Quirks
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
        ("mute_codes", "xy", "CODE[/N]"),
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


def test_control_lines_move_the_module(bench: SimulatedBench, clock: FakeClock) -> None:
    for line in ("tilt 30", "bay open", "cell 3.6", "charger on", "active on", "noise 0", "lifelike off", ""):
        execute(bench, line)
    state = bench.state()
    assert (state.tilt_deg, state.bay_is_open, state.cell_v, state.has_external_power) == (30, True, 3.6, True)
    assert state.is_active
    execute(bench, "drop 20")
    clock.now_s += 1.0
    assert bench.state().is_falling
    clock.now_s += 1.0
    assert bench.state().is_triggered
    execute(bench, "restart")
    assert not bench.state().is_triggered
    assert bench.state().boot_count == 38


def test_control_lines_switch_power_faults_and_quirks(bench: SimulatedBench, clock: FakeClock) -> None:
    execute(bench, "off")
    assert not bench.state().is_on
    execute(bench, "press")
    assert bench.state().is_on
    execute(bench, "fault drop 0.2")
    execute(bench, "set ack one")
    execute(bench, "set rate 100")
    assert bench.state().values["drop"] == 0.2
    assert bench.state().values["ack"] == "one"
    assert bench.state().rate_hz == 100
    execute(bench, "fault none")
    assert bench.state().values["drop"] == 0
    execute(bench, "unplug 2")
    assert not bench.state().is_plugged_in
    clock.now_s += 2.1
    assert bench.state().is_plugged_in
    execute(bench, "unplug")
    clock.now_s += 100
    assert not bench.state().is_plugged_in
    execute(bench, "plug")
    assert bench.state().is_plugged_in


def test_pwm_fires_only_an_active_module(bench: SimulatedBench) -> None:
    with pytest.raises(UserError, match="not triggered"):
        execute(bench, "pwm")
    execute(bench, "active on")
    execute(bench, "pwm")
    assert bench.state().is_triggered
    assert bench.state().record_count == 1


@pytest.mark.parametrize(
    "line", ["fly", "tilt", "tilt high", "tilt nan", "bay ajar", "drop -1", "fault speed 1", "set boots 3", "charger"]
)
def test_a_line_that_means_nothing_is_refused_and_changes_nothing(bench: SimulatedBench, line: str) -> None:
    before = bench.state()
    with pytest.raises(UserError):
        execute(bench, line)
    assert bench.state() == before


def test_help_names_every_line(bench: SimulatedBench) -> None:
    assert execute(bench, "help") == help_text()
    assert all(verb.usage in help_text() for verb in VERBS.values())
    assert "is_on=yes" in execute(bench, "state")


@pytest.fixture
def pipe() -> Iterator[tuple[int, int]]:
    reading, writing = os.pipe()
    yield reading, writing
    for file in (reading, writing):
        try:
            os.close(file)
        except OSError:
            continue


def test_lines_from_a_pipe_in_pieces_and_the_last_one_without_an_end(
    bench: SimulatedBench, pipe: tuple[int, int]
) -> None:
    reading, writing = pipe
    answers: list[str] = []
    control = ControlLines(bench, reading, answer=answers.append)
    os.write(writing, b"tilt 1")
    control.read([reading])
    assert answers == []
    os.write(writing, b"2\nfly\ncell 3.5")
    control.read([reading])
    os.close(writing)
    control.read([reading])
    assert bench.state().tilt_deg == 12
    assert bench.state().cell_v == 3.5
    assert len(answers) == 3
    assert control.files() == [], "the end of the input is not looked at again"


def test_a_file_is_no_place_for_control_lines(bench: SimulatedBench, tmp_path: os.PathLike[str]) -> None:
    with open(os.path.join(tmp_path, "empty"), "w+", encoding="utf-8") as file:  # noqa: PTH118, PTH123
        assert ControlLines(bench, file, answer=print).files() == []

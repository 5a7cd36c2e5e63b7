"""The option table, and what the module does by itself or is made to do."""

from dataclasses import fields

import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.stateful import RuleBasedStateMachine, initialize, invariant, rule

from app.simulator.bench import SimulatedBench
from app.simulator.module import SimulatedModule
from app.simulator.setup import Setup, as_text, parse_options
from app.text.user_error import UserError
from protocol.catalogue import BY_NAME, COMMANDS, HEARTBEAT, STATUS, TRIGGER_RECORDS
from protocol.messages import Status, decode
from tests.support.line.sim_line import FakeClock
from tests.support.line.simulated import receive, running, tick


@pytest.fixture
def clock() -> FakeClock:
    return FakeClock()


@pytest.fixture
def bench(clock: FakeClock) -> SimulatedBench:
    return SimulatedBench(clock=clock)


def test_defaults_read_back_as_themselves() -> None:
    for option in fields(Setup):
        assert parse_options({option.name: as_text(option.default)}) == {option.name: option.default}


def test_options_as_typed() -> None:
    setup = Setup(**parse_options({"rate": "200", "drop": "0.1", "pwm-after": "20", "mute": ""}))
    assert setup.rate == 200
    assert setup.drop == 0.1
    assert setup.pwm_after == 20
    assert setup.mute


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


def test_a_setup_reaches_the_bench(clock: FakeClock) -> None:
    texts = {"active": "", "boots": "0", "history": "4", "tilt": "5", "bay_open": "yes", "cell": "3.6", "charger": "on"}
    bench = SimulatedBench(Setup(**parse_options(texts | {"baud": "9600"})), clock=clock)
    assert bench.module.state.is_active
    assert bench.module.memory.boot_count == 0
    assert len(bench.module.memory.records) == 4
    assert bench.world.tilt_deg == 5
    assert bench.world.bay_is_open
    assert bench.world.cell_v == 3.6
    assert bench.world.has_external_power
    assert bench.module.baud_rate == 9600
    assert bench.wire.read(clock()) == b"", "its heartbeats are long gone"


def test_a_module_that_is_just_switched_on_shows_its_heartbeats(clock: FakeClock) -> None:
    bench = SimulatedBench(Setup(uptime=0.0), clock=clock)
    assert len(bench.wire.read(clock() + 0.1)) == 12


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


def test_power_faults_and_the_plug(bench: SimulatedBench, clock: FakeClock) -> None:
    bench.power_off()
    assert not bench.module.is_on
    bench.press_switch()
    assert bench.module.is_on
    bench.change(drop=0.2, rate=100.0)
    assert (bench.module.setup.drop, bench.module.setup.rate) == (0.2, 100)
    bench.unplug()
    clock.now_s += 100
    assert not bench.is_plugged_in
    bench.plug()
    assert bench.is_plugged_in


def test_the_pwm_input_fires_only_an_active_module(bench: SimulatedBench) -> None:
    assert not bench.pulse_pwm()
    bench.module.activate(is_active=True)
    assert bench.pulse_pwm()
    assert bench.module.is_triggered
    assert len(bench.module.memory.records) == 1


# The simulated module under any bytes and any order of commands (Hypothesis)


BYTE = st.integers(0, 255)
FRAMES = [command.query().encode() for command in COMMANDS if command.query_data is not None]
FRAMES += [
    command.set(command.write.decode(value)).encode()
    for command in COMMANDS
    if command.write is not None
    for value in sorted(command.write.allowed)[:3]
]


@given(st.lists(st.one_of(st.binary(max_size=40), st.sampled_from(FRAMES)), max_size=30))
def test_any_bytes_never_raise_and_a_module_that_is_on_answers_the_next_request(pieces: list[bytes]) -> None:
    module = running()
    for number, piece in enumerate(pieces):
        receive(module, piece, number * 0.01)
    module.press_switch(10.0)
    tick(module, 11.0)
    answer = receive(module, HEARTBEAT.query().encode(), 12.0)
    assert answer.endswith(bytes.fromhex("41 75 01 a5 5a 00"))


class ModuleMachine(RuleBasedStateMachine):
    """A model of a few plain variables, and whatever a host and a person may do in any order."""

    @initialize()
    def begin(self) -> None:
        self.module = running()
        self.now_s = 0.0
        self.settings = {"attitude_threshold": 60, "freefall_acceleration": 5, "freefall_time": 160,
                         "light_threshold": 0x12}  # fmt: skip
        self.boots = 1
        self.is_on = True
        self.is_active = False
        self.is_streaming = False

    def say(self, raw: bytes) -> bytes:
        self.now_s += 0.2
        tick(self.module, self.now_s)
        return receive(self.module, raw, self.now_s)

    @rule(name=st.sampled_from(["attitude_threshold", "freefall_acceleration", "freefall_time", "light_threshold"]),
          value=BYTE)  # fmt: skip
    def set_a_threshold(self, name: str, value: int) -> None:
        command = BY_NAME[name]
        assert command.write is not None
        answer = self.say(command.set(command.write.decode(value)).encode())
        assert answer.endswith(bytes((command.code, 1, value, (command.code + 1 + value) & 0xFF))) is self.is_on
        if self.is_on:
            self.settings[name] = value

    @rule(is_active=st.booleans())
    def activate(self, is_active: bool) -> None:
        self.say(BY_NAME["activation"].set(is_active).encode())
        if self.is_on:
            self.is_active = is_active

    @rule(is_on=st.booleans())
    def serial_output(self, is_on: bool) -> None:
        self.say(BY_NAME["serial_output"].set(is_on).encode())
        if self.is_on:
            self.is_streaming = is_on

    @rule()
    def shut_down(self) -> None:
        self.say(BY_NAME["shutdown"].set(True).encode())
        if self.is_on:
            self.forget()
            self.is_on = False

    @rule()
    def press_switch(self) -> None:
        if not self.is_on:
            self.boots += 1
        self.module.press_switch(self.now_s)
        self.is_on = True

    @rule()
    def restart(self) -> None:
        self.module.restart(self.now_s)
        self.forget()
        self.boots += 1
        self.is_on = True

    @rule(tilt_deg=st.integers(-180, 180))
    def tilt(self, tilt_deg: int) -> None:
        self.module.world.tilt_deg = tilt_deg

    @rule(height_m=st.integers(1, 60))
    def drop(self, height_m: int) -> None:
        self.module.world.drop(height_m, self.now_s)

    @rule(seconds=st.floats(0, 12))
    def wait(self, seconds: float) -> None:
        self.now_s += seconds

    @rule(noise=st.binary(max_size=12))
    def hear_noise(self, noise: bytes) -> None:
        self.say(noise.replace(b"a", b""))

    def forget(self) -> None:
        self.is_active = self.is_streaming = False

    @invariant()
    def it_is_as_the_model_says(self) -> None:
        module = self.module
        assert module.is_on is self.is_on
        assert module.memory.boot_count == self.boots & 0xFF
        for name, value in self.settings.items():
            assert getattr(module.memory, name) == value
        assert module.is_streaming is self.is_streaming
        if self.is_on:
            assert module.state.is_active is self.is_active
            assert self.is_active or not module.is_triggered
        assert len(module.memory.records) <= 9

    @invariant()
    def its_status_says_so(self) -> None:
        if self.is_on and not self.is_streaming:
            answer = self.say(STATUS.query().encode())
            status = decode(answer[-8:])
            assert isinstance(status, Status)
            assert status.active is self.is_active
            assert status.triggered is self.module.is_triggered
            assert len(self.say(TRIGGER_RECORDS.query().encode())) == 16 * 9


TestModule = ModuleMachine.TestCase

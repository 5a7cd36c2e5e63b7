"""The simulated module under any bytes and any order of commands (Hypothesis)."""

from hypothesis import given
from hypothesis import strategies as st
from hypothesis.stateful import RuleBasedStateMachine, initialize, invariant, rule

from app.simulator.module import SimulatedModule
from app.simulator.physics import Physics
from app.simulator.quirks import EmptySlots, Quirks
from protocol.catalogue import BY_NAME, COMMANDS, HEARTBEAT, STATUS, TRIGGER_RECORDS
from protocol.frame import Frame
from protocol.messages import decode_status
from protocol.stream import StreamParser
from tests.support.line.simulated import booted, receive, tick

BYTE = st.integers(0, 255)
FRAMES = [command.query().encode() for command in COMMANDS if command.query_data is not None]
FRAMES += [
    command.set(command.write.decode(value)).encode()
    for command in COMMANDS
    if command.write is not None
    for value in sorted(command.write.allowed)[:3]
]


def running() -> SimulatedModule:
    return booted(SimulatedModule(Physics(), Quirks(empty_slots=EmptySlots.NONE)))


@given(st.lists(st.one_of(st.binary(max_size=40), st.sampled_from(FRAMES)), max_size=30))
def test_any_bytes_never_raise_and_a_module_that_is_on_answers_the_next_request(pieces: list[bytes]) -> None:
    module = running()
    for number, piece in enumerate(pieces):
        receive(module, piece, number * 0.01)
    module.press_switch(10.0)
    tick(module, 11.0)
    answer = receive(module, HEARTBEAT.query().encode(), 12.0)
    assert answer.endswith(bytes.fromhex("41 75 01 a5 5a 00"))


@given(st.binary(max_size=200), st.lists(st.integers(1, 7), max_size=60))
def test_how_requests_are_cut_makes_no_difference(noise: bytes, cuts: list[int]) -> None:
    data = noise.replace(b"B", b"") + b"".join(BY_NAME[name].query().encode() for name in ("boot_count", "active"))
    whole = receive(running(), data, 0.0)
    module = running()
    pieces = b""
    for cut in cuts:
        pieces += receive(module, data[:cut], 0.0)
        data = data[cut:]
    assert pieces + receive(module, data, 0.0) == whole


@given(st.binary(max_size=20), st.integers(1, 5))
def test_only_frames_come_out(noise: bytes, times: int) -> None:
    module = running()
    asked = [BY_NAME[name].query() for name in ("heartbeat", "boot_count", "light", "attitude_threshold", "status")]
    data = b"".join(request.encode() for request in asked)
    out = receive(module, (noise.replace(b"B", b"") + data) * times, 0.0) + tick(module, 1.0)
    frames = StreamParser().feed(out)
    assert [frame.code for frame in frames if isinstance(frame, Frame)] == [one.command.code for one in asked] * times
    assert len(frames) == len(asked) * times, "nothing else came"


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
            status = decode_status(answer[-8:])
            assert status.active is self.is_active
            assert status.triggered is self.module.is_triggered
            assert len(self.say(TRIGGER_RECORDS.query().encode())) == 16 * len(self.module.memory.records)


TestModule = ModuleMachine.TestCase

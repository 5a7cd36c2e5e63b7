"""Finding the baud rate, and waiting for a module: nothing but the link's own questions."""

from collections import Counter

import pytest

from app.diagnosis.silence import Silence, what_came
from app.procedures.find import find_rate
from protocol.catalogue import BAUD_RATES, Hazard
from protocol.events import Counters, Role
from protocol.messages import Reason
from tests.support.line.sim_line import Rig


@pytest.mark.parametrize("lag_ms", [0.0, 400.0, 700.0])
@pytest.mark.parametrize("rate", [115200, 9600])
@pytest.mark.promise("k")
def test_a_module_that_takes_its_time_is_found(rate: int, lag_ms: float) -> None:
    rig = Rig({"baud": rate, "lag_ms": lag_ms})
    assert rig.run(find_rate(), outlives=True).baud_rate == rate
    rig = Rig({"baud": rate, "lag_ms": lag_ms})
    assert rig.run(find_rate(57600, 38400), outlives=True).baud_rate == rate


def test_after_a_change_the_old_and_the_new_rate_are_tried_once_more() -> None:
    """On a line that loses frames a module may not answer in time at the first try."""
    rig = Rig({"baud": 57600, "mute": True})
    rig.bench.module.plan(rig.clock() + 10.0, lambda _at_s: rig.bench.change(mute=False))
    found = rig.run(find_rate(57600, 38400), outlives=True)
    assert (found.baud_rate, found.tried[:2], found.tried[6:]) == (57600, (57600, 38400), (57600,))


def came(frames: int = 0, echoes: int = 0, rejected: int = 0) -> Counters:
    by_role = Counter({Role.ECHO: echoes})
    return Counters(frames=frames, by_role=by_role, rejected_bytes=Counter({Reason.NO_HEADER: rejected}))


@pytest.mark.parametrize(
    ("counters", "silence"),
    [
        (came(), Silence.NOTHING),
        (came(2, 2), Silence.ECHO),
        (came(2, 1), Silence.OTHER_FRAMES),
        (came(2, 2, 1), Silence.GARBAGE),
        (came(1, 0, 1), Silence.OTHER_FRAMES),
        (came(1, 0, 100), Silence.GARBAGE),
        (came(0, 0, 1), Silence.GARBAGE),
    ],
)
def test_a_silence_is_told_by_what_came(counters: Counters, silence: Silence) -> None:
    assert what_came(counters) is silence


# As pymavlink packs them: a heartbeat, and two messages of a busy line.
_HEARTBEAT = "fe 09 42 01 01 00 00 00 00 00 02 03 51 04 03 aa 8a"
_ATTITUDES = (
    "fd 1c 00 00 ff 01 01 1e 00 00 e8 03 00 00 cd cc cc 3d cd cc 4c 3e 9a 99 99 3e 00 00 00 00 00 00 00 00 00 00"
    "00 3f 59 04 fd 1c 00 00 00 01 01 1e 00 00 e9 03 00 00 cd cc cc 3d cd cc 4c 3e 9a 99 99 3e 00 00 00"
)


@pytest.mark.parametrize(
    "noise",
    [
        bytes.fromhex(_HEARTBEAT),
        bytes.fromhex(_ATTITUDES),
        b"$M>\x03\x01\x00\x01\x2f\x2c",
        b"$X>\x00\x64\x00\x00\x00\x8f",
    ],
)
def test_a_flight_controller_is_told_by_what_it_says(noise: bytes) -> None:
    counters = came(rejected=len(noise))
    assert what_came(counters, noise) is Silence.FLIGHT_CONTROLLER
    assert what_came(counters, noise[::-1]) is Silence.GARBAGE


@pytest.mark.parametrize("place", [44, 45])  # the number of the second message, and its system
def test_two_first_bytes_of_mavlink_are_no_flight_controller_by_chance(place: int) -> None:
    noise = bytearray.fromhex(_ATTITUDES)
    noise[place] ^= 4
    assert what_came(came(rejected=len(noise)), bytes(noise)) is Silence.GARBAGE


def test_a_search_sends_nothing_but_questions_and_leaves_the_port_where_it_was() -> None:
    rig = Rig({"mute": True}, baud_rate=57600)
    found = rig.run(find_rate(9600), outlives=True)
    assert found.baud_rate is None
    assert found.tried == (9600, *(rate for rate in BAUD_RATES if rate != 9600))
    assert rig.line.baud_rate == 57600
    assert {request.hazard for request in rig.line.requests} == {Hazard.NONE}


def test_behind_a_plain_socket_only_its_own_rate_is_tried() -> None:
    rig = Rig({"uptime": 60, "baud": 9600})
    rig.line.port = "socket://127.0.0.1:4001"
    assert rig.run(find_rate(), outlives=True).tried == (115200,)
    assert rig.line.baud_rate == 115200

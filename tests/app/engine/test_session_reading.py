"""What only reads, on the simulated module: everything is said as it is, and nothing is changed or guessed."""

from collections.abc import Callable

import pytest

from app.engine.device import How
from app.procedures.find import find_rate
from app.procedures.handshake import Silence, handshake
from app.procedures.history import read_history
from app.procedures.read import READABLE, read_everything
from app.simulator.memory import record_frame
from protocol.catalogue import Hazard
from tests.support.line.sim_line import settled_rig


def test_reading_everything_says_what_the_module_holds() -> None:
    rig = settled_rig(boots=37, cell=4.0)
    everything = rig.run(read_everything())
    assert everything.errors == {}
    assert everything.values == {
        "boot_count": 37,
        "cell_voltage_v": 4.0,
        "charging": False,
        "light_v": pytest.approx(0.3),
        "light_threshold_v": 1.8,
        "attitude_threshold_deg": 60,
        "freefall_acceleration_g": 0.5,
        "freefall_time_s": 1.6,
    }
    view = rig.session.device.view(rig.clock.now_s)
    assert view.values["freefall_time_s"].how is How.READ
    assert view.values["acceleration_g"].value == 1.0
    assert "attitude_trigger" not in view.values
    assert view.values["baud_rate"].value == 115200


@pytest.mark.parametrize("procedure", [handshake, read_everything, read_history, find_rate])
@pytest.mark.parametrize("options", [{}, {"drop": 0.3}, {"corrupt": 0.05}, {"double": 0.5}, {"stream-at-boot": True}])
@pytest.mark.promise("i")
def test_what_only_reads_sends_nothing_but_questions(procedure: Callable, options: dict) -> None:  # type: ignore[type-arg]
    rig = settled_rig(**options)
    rig.run(procedure())
    assert {request.hazard for request in rig.line.requests} <= {Hazard.NONE}


@pytest.mark.parametrize(
    "options",
    [
        {"voltage-code": "34"},
        {"voltage-code": "35"},
        {"ack": "one"},
        {"double": 1.0},
        {"split-ms": 30},
        {"delay-ms": 300},
        {"stream-at-boot": True, "rate": 1440},
    ],
)
def test_reading_everything_holds_in_every_dialect(options: dict[str, object]) -> None:
    rig = settled_rig(cell=3.8, **options)
    everything = rig.run(read_everything())
    assert everything.errors == {}
    assert everything.values["cell_voltage_v"] == 3.8


def test_half_of_the_replies_lost_is_said_and_never_guessed() -> None:
    holds = {
        "boot_count": 9,
        "cell_voltage_v": 3.8,
        "charging": False,
        "light_v": 0.3,
        "light_threshold_v": 1.8,
        "attitude_threshold_deg": 60,
        "freefall_acceleration_g": 0.5,
        "freefall_time_s": 1.6,
    }
    lost = 0
    for seed in range(20):
        rig = settled_rig(drop=0.5, seed=seed, cell=3.8, boots=9)
        everything = rig.run(read_everything())
        said = {*everything.values, *everything.errors}
        assert said >= holds.keys() or everything.is_silent
        assert everything.values == pytest.approx({key: holds[key] for key in everything.values})
        lost += len(everything.errors)
    assert lost > 10


def test_a_code_that_is_not_answered_is_one_error_among_values() -> None:
    rig = settled_rig(**{"mute-codes": "14"})
    everything = rig.run(read_everything())
    assert list(everything.errors) == ["light_v"]
    assert (everything.errors["light_v"].attempts, everything.errors["light_v"].waited_s) == (3, 1.0)
    assert len(everything.values) == len(READABLE) - 4, "the state is in the status"


@pytest.mark.parametrize(
    ("options", "silence"),
    [
        ({"mute": True}, Silence.NOTHING),
        ({"mute": True, "echo": True}, Silence.ECHO),
        ({"baud": 9600}, Silence.NOTHING),
        ({"baud": 57600, "stream-at-boot": True}, Silence.GARBAGE),
        ({"mute-codes": "01", "stream-at-boot": True}, Silence.OTHER_FRAMES),
    ],
)
def test_no_answer_says_what_was_seen_instead(options: dict[str, object], silence: Silence) -> None:
    rig = settled_rig(**options)
    start_s = rig.clock.now_s
    assert rig.run(handshake()) is silence
    assert rig.clock.now_s - start_s < 2


def test_only_what_comes_after_the_question_tells_why_nothing_answers() -> None:
    rig = settled_rig(mute=True, echo=True)
    assert rig.run(handshake()) is Silence.ECHO
    rig.bench.change(echo=False)
    assert rig.run(handshake()) is Silence.NOTHING


@pytest.mark.parametrize("rate", [4800, 9600, 19200, 38400, 57600, 115200])
def test_the_rate_is_found_wherever_it_is(rate: int) -> None:
    rig = settled_rig(baud=rate)
    found = rig.run(find_rate(115200))
    assert found.baud_rate == rate
    assert found.tried[0] == 115200
    assert found.tried[-1] == rate
    assert rig.line.baud_rate == rate


def test_a_late_answer_to_a_heartbeat_at_another_rate_finds_no_module() -> None:
    """A serial server passes whole bytes on, however late."""
    rig = settled_rig(baud=57600, delay_ms=1300)
    found = rig.run(find_rate(57600))
    assert found.baud_rate is None
    assert rig.line.baud_rate == 115200


def test_a_module_that_does_not_tell_its_boot_count_is_found() -> None:
    rig = settled_rig(baud=57600, **{"mute-codes": "23"})
    assert rig.run(find_rate(115200)).baud_rate == 57600


def test_no_rate_is_found_where_nothing_answers_and_the_port_keeps_its_own() -> None:
    rig = settled_rig(mute=True)
    found = rig.run(find_rate(57600))
    assert found.baud_rate is None
    assert found.tried == (57600, 115200, 38400, 19200, 9600, 4800)
    assert rig.line.baud_rate == 115200


@pytest.mark.parametrize("count", [0, 1, 9])
@pytest.mark.parametrize("records", ["together", "spaced", "pieces"])
@pytest.mark.parametrize("empty", ["none", "zeros", "ones"])
def test_e06_e07_all_records_and_no_empty_slot(count: int, records: str, empty: str) -> None:
    rig = settled_rig(history=count, records=records, **{"empty-slots": empty})
    history = rig.run(read_history())
    assert history.is_confirmed is history.is_answered is bool(count or empty != "none")
    assert len(history.records) == count
    assert history.empty_slots == (9 - count if empty != "none" else 0)


def test_records_lost_on_the_way_are_asked_for_again() -> None:
    complete = 0
    for seed in range(10):
        rig = settled_rig(history=9, corrupt=0.004, records="spaced", seed=seed)
        history = rig.run(read_history())
        assert {record.raw for record in history.records} <= {*map(record_frame, rig.bench.module.memory.records)}
        complete += len(history.records) == 9
    assert complete >= 8


def test_records_come_while_it_streams() -> None:
    rig = settled_rig(history=9, records="spaced", rate=1440, **{"stream-at-boot": True})
    assert len(rig.run(read_history()).records) == 9

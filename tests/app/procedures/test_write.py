"""Write and prove, against the simulated module in every dialect and on bad lines: "verified" is never a lie."""

from itertools import product
from typing import Any, Final

import pytest

from app.procedures.write import SetReply, WriteFault, Written, await_flags_free, read_back, write_verified
from app.procedures.write_all import SettingChange, WriteContext, WriteReport, write_all
from protocol.catalogue import BY_NAME, Command, Request
from protocol.fields import Value, ValueRefused
from tests.adversary.faults import DIALECTS, TROUBLES
from tests.faults.fault_table import truth
from tests.support.journals import FakeJournal
from tests.support.line.frames import at_each_frame, at_frame
from tests.support.line.odd_module import end_faults
from tests.support.line.sim_line import Rig
from tests.support.line.truth import settings_held
from tests.support.thorough import some

READABLE = {
    "light_threshold": 2.1,
    "attitude_threshold": 70,
    "freefall_acceleration": 0.4,
    "freefall_time": 1.2,
}
FLAGS = ("attitude_trigger", "freefall_trigger", "serial_output")


def held(rig: Rig, command: Command) -> Value:
    return settings_held(rig.bench.module)[command.key]


def write(rig: Rig, name: str, value: Value) -> Written:
    """After it was read, or when it may be set."""
    rig.run(await_flags_free(BY_NAME[name].set(value)))
    if BY_NAME[name].reads_back:
        rig.run(read_back(BY_NAME[name]))
    return rig.run(write_verified(BY_NAME[name], value))


@pytest.mark.parametrize("name", READABLE)
@pytest.mark.parametrize(("ack", "heard"), [("echo", SetReply.ECHO), ("one", SetReply.ONE)])
def test_a_value_that_stands_is_verified(name: str, ack: str, heard: SetReply) -> None:
    rig = Rig({"ack": ack})
    written = write(rig, name, READABLE[name])
    assert written.verified is True
    assert written.is_fine
    assert written.read_back == READABLE[name] == held(rig, BY_NAME[name])
    assert written.heard is (heard if BY_NAME[name].acknowledged_by_one else SetReply.ECHO)


@pytest.mark.parametrize(("name", "code"), list(product(FLAGS, ("16", "17"))))
def test_what_cannot_be_read_back_is_acknowledged_and_never_verified(name: str, code: str) -> None:
    rig = Rig({"freefall_ack": code})
    for value in (False, True, False):
        written = write(rig, name, value)
        assert (written.verified, written.read_back, written.fault) == (None, None, None)
        assert written.is_acknowledged
        assert held(rig, BY_NAME[name]) is value


@pytest.mark.promise("f")
def test_a_set_goes_out_once_and_is_read_back_twice() -> None:
    rig = Rig()
    write(rig, "freefall_time", 1.2)
    sent = [request for request in rig.line.requests if request.command.name == "freefall_time"]
    assert [request.is_set for request in sent] == [False, False, True, False, False]


@pytest.mark.parametrize("ack", ["echo", "one"])
@pytest.mark.parametrize(
    ("ways", "name", "wanted", "stands", "fault"),
    [
        ({"keeps": False}, "freefall_time", 1.2, 1.6, WriteFault.NOT_RETAINED),
        ({"keeps": False}, "freefall_acceleration", 0.4, 0.5, WriteFault.NOT_RETAINED),
        ({"keeps": False}, "attitude_threshold", 70, 60, WriteFault.NOT_RETAINED),
        ({"clamps": True}, "freefall_time", 0.1, 0.5, WriteFault.CLAMPED),
        ({"clamps": True}, "freefall_acceleration", 2.0, 0.6, WriteFault.CLAMPED),
        ({"clamps": True}, "attitude_threshold", 120, 90, WriteFault.CLAMPED),
        ({"refuses": True}, "freefall_time", 1.2, 1.6, WriteFault.REFUSED),
        ({"refuses": True}, "freefall_acceleration", 0.4, 0.5, WriteFault.REFUSED),
        ({"refuses": True}, "light_threshold", 2.1, 1.8, WriteFault.REFUSED),
    ],
)
def test_a_module_that_goes_its_own_way_is_shown_as_what_it_is(
    ack: str, ways: dict[str, Any], name: str, wanted: Value, stands: Value, fault: WriteFault
) -> None:
    written = write(Rig({"ack": ack, **ways}), name, wanted)
    assert (written.read_back, written.fault, written.verified) == (stands, fault, False)


def test_a_module_that_does_not_know_the_command() -> None:
    for name, fault in (("freefall_time", WriteFault.NO_READ_BACK), ("attitude_trigger", WriteFault.NO_REPLY)):
        written = write(Rig({"mute_codes": frozenset((0x16, 0x22))}), name, READABLE.get(name, False))
        assert (written.heard, written.fault) == (SetReply.NOTHING, fault)
        assert not written.is_fine


def test_a_set_that_was_lost_on_the_way_is_found_by_reading_back() -> None:
    rig = Rig()
    rig.run(write_verified(BY_NAME["freefall_time"], 1.5))
    _change_at(rig, "freefall_time", drop=1.0)
    written = write(rig, "freefall_time", 1.2)
    assert (written.heard, written.read_back, written.fault) == (SetReply.NOTHING, 1.5, WriteFault.LOST)


def _change_at(rig: Rig, name: str, **faults: Any) -> None:
    """Faults that begin with the set of `name` and end after it."""

    def change(request: Request) -> None:
        is_set = request.is_set and request.command is BY_NAME[name]
        rig.bench.change(**faults, direction="to-module") if is_set else end_faults(rig.bench)

    at_each_frame(rig.bench, change)


def test_nothing_is_sent_to_a_module_that_does_not_answer_the_fence() -> None:
    rig = Rig()
    write(rig, "freefall_time", 1.5)
    rig.bench.change(mute=True)
    for _ in range(2):
        written = write(rig, "freefall_time", 1.4)
        assert (written.heard, written.fault, written.verified) == (SetReply.NOT_SENT, WriteFault.NOT_SENT, False)
    assert held(rig, BY_NAME["freefall_time"]) == 1.5


@pytest.mark.parametrize(
    ("name", "after_frames"),
    [("freefall_time", 1), ("freefall_time", 2), ("freefall_time", 3), ("attitude_trigger", 1)],
)
def test_a_restart_in_the_middle_claims_nothing(name: str, after_frames: int) -> None:
    rig = Rig()
    write(rig, name, READABLE.get(name, True))
    at_frame(rig.bench, after_frames, rig.bench.restart, code=BY_NAME[name].code)
    written = write(rig, name, 1.7 if name == "freefall_time" else False)
    assert (written.fault, written.read_back) == (WriteFault.RESTARTED, None)
    assert not written.verified


@pytest.mark.promise("g")
def test_a_value_that_no_byte_carries_is_refused_before_anything_is_sent() -> None:
    rig = Rig()
    with pytest.raises(ValueRefused, match=r"0\.5 g and 0\.6 g"):
        rig.run(write_verified(BY_NAME["freefall_acceleration"], 0.55))
    assert rig.line.sent == b""


FAULTS: tuple[dict[str, Any], ...] = (
    {"drop": 0.3, "direction": "both"},
    {"corrupt": 0.05, "direction": "both"},
    {"corrupt": 0.12},
    {"double": 0.5, "direction": "both"},
    {"delay_ms": 180.0, "jitter_ms": 900.0},
    {"lose": 0.03, "garbage": 0.3, "split_ms": 5.0},
    {"drop": 0.15, "corrupt": 0.03, "double": 0.3, "jitter_ms": 400.0, "direction": "both"},
    {"echo": True, "double": 0.3},
    {"stream_at_boot": True, "drop": 0.2, "jitter_ms": 100.0},
)
WAYS: tuple[dict[str, Any], ...] = ({}, {"keeps": False}, {"clamps": True}, {"refuses": True})


@pytest.mark.parametrize("faults", FAULTS, ids="-".join)
def test_what_is_called_verified_is_what_the_module_holds(faults: dict[str, Any]) -> None:
    """Every dialect on every bad line, with several seeds."""
    verified = 0
    quirk_sets = product(("echo", "one"), ("16", "17"), WAYS, range(3))
    for ack, code, ways, seed in some(quirk_sets, one_in=3, first=FAULTS.index(faults)):
        rig = Rig({"ack": ack, "freefall_ack": code, "seed": seed * 97 + 3, **ways, **faults})
        for name, value in READABLE.items():
            written = write(rig, name, value)
            command = BY_NAME[name]
            if written.verified:
                verified += 1
                assert held(rig, command) == value == written.read_back
            else:
                assert written.fault is not None
        flag = write(rig, "freefall_trigger", False)
        assert flag.verified is None
    assert verified > 0


# "verified" is never a lie, and what moved without being written is named, whatever the module does


SETTLED_S = 1.0
"""Time after the report within which these modules make their late changes."""
_TOO_LATE: Final = ("changes after three reads", "silent restart at 1.6 s", "mute")
"""What happens after the last reading, which ends the report; and where nothing is written."""
WRITE_LIES: Final = {
    name: one.options
    for name, one in TROUBLES.items()
    if one.accident is None and not one.forges and name not in _TOO_LATE
}
WANTED: tuple[dict[str, Value], ...] = (
    {"freefall_time": 1.2},
    {"attitude_threshold": 130},
    {"freefall_acceleration": 0.9, "light_threshold": 2.1},
    {"attitude_trigger": False, "freefall_time": 0.2, "attitude_threshold": 75},
)
KEYS = ("attitude_threshold_deg", "freefall_acceleration_g", "freefall_time_s", "light_threshold_v")


def write_to(options: dict[str, Any], wanted: dict[str, Value]) -> tuple[WriteReport, list[str]]:
    """Write these; return the report, and what it claims and the module did not hold `SETTLED_S` later."""
    rig = Rig({"uptime": 60, "noise": 0} | options)
    boots, before = rig.bench.module.memory.boot_count, truth(rig.bench, rig.clock.now_s)
    changes = [SettingChange(BY_NAME[name], value) for name, value in wanted.items()]
    context = WriteContext(journal=FakeJournal(), accepted_risks=frozenset(changes))
    report = rig.run(write_all(changes, context), limit_s=300.0)
    has_restarted = rig.bench.module.memory.boot_count != boots
    rig.step_for(SETTLED_S)
    holds, found = truth(rig.bench, rig.clock.now_s), []
    for written in report.results:
        key = written.command.key
        if written.verified and holds[key] != written.target:
            found.append(f"{key} verified as {written.target}, and it holds {holds[key]}")
        if written.verified and has_restarted:
            found.append(f"{key} verified over a restart")
    commands = [written.command for written in report.results] + [change.command for change in report.changed]
    named = {command.key for command in (*commands, *report.unread)}
    if report.is_fine:
        moved = [key for key in KEYS if key not in named and before[key] != holds[key]]
        found += [f"{key} moved from {before[key]} to {holds[key]} unreported" for key in moved]
    return report, found


@pytest.mark.parametrize("lie", WRITE_LIES)
@pytest.mark.promise("f")
def test_no_lie_is_verified(lie: str) -> None:
    cases = enumerate(product(DIALECTS.values(), WANTED))
    for seed, (quirks, wanted) in some(cases, one_in=50, first=7 * [*WRITE_LIES].index(lie)):  # of nearly 5,000
        _report, faults = write_to({**quirks, **WRITE_LIES[lie], "seed": seed}, wanted)
        assert faults == [], (quirks, wanted)


@pytest.mark.parametrize("name", ["21", "20", "15"])
def test_cross_talk_between_settings_is_named(name: str) -> None:
    """It may be another module that says so."""
    report, _faults = write_to({"cross_talk": f"22:{name}=14"}, {"freefall_time": 1.2})
    assert report.results[0].fault is WriteFault.CONTRADICTED
    assert not report.results[0].verified
    assert [one.command.code for one in report.changed] == [int(name, 16)]
    assert not report.is_fine


@pytest.mark.parametrize(
    ("lie", "fault"),
    [
        ({"revert_ms": 20}, WriteFault.REVERTED),
        ({"revert_ms": 500}, WriteFault.REVERTED),
        ({"clamp_ms": 500}, WriteFault.REVERTED),
        ({"silent_restart_ms": 30}, WriteFault.RESTARTED),
        ({"silent_restart_ms": 500}, WriteFault.RESTARTED),
        ({"mute_codes": "20/6"}, WriteFault.NO_LAST_READING),
    ],
)
def test_what_happens_after_the_acknowledgement_is_found(lie: dict[str, Any], fault: WriteFault) -> None:
    report, _faults = write_to(lie, {"attitude_threshold": 130})
    assert [(result.fault, result.verified) for result in report.results] == [(fault, False)]
    assert fault is not WriteFault.REVERTED or report.results[0].read_back not in (None, 130)


def test_a_flag_is_claimed_no_longer_after_a_silent_restart() -> None:
    report, _faults = write_to({"silent_restart_ms": 400}, {"attitude_trigger": False})
    assert [(result.fault, result.verified) for result in report.results] == [(WriteFault.RESTARTED, None)]

"""What a module does other than it says: each lie of the simulated module, and what it leaves alone."""

import pytest

from app.simulator.bench import SimulatedBench
from app.simulator.defects import CHANGEABLE_CODES, read_raw
from app.simulator.memory import Memory, invent_records
from app.simulator.module import SimulatedModule
from app.simulator.options import as_text, parse_options, setup_from
from app.simulator.physics import Physics
from app.simulator.quirks import Occasion, Rule
from app.text.user_error import UserError
from protocol.catalogue import BY_CODE, STATUS, TRIGGER_RECORDS, Request
from protocol.frame import Frame, encode_reply
from protocol.messages import decode_record
from protocol.stream import StreamParser
from tests.support.line.sim_line import FakeClock, SimulatedLine
from tests.support.line.simulated import booted, receive, say, tick

HEARTBEAT = "42 61 01 a5 5a 00"
SET_ACCELERATION_4 = "42 61 21 02 04 27"
ASK_THRESHOLD = "42 61 20 01 00 21"
SET_THRESHOLD_70 = "42 61 20 02 46 68"
ENABLE_ATTITUDE = "42 61 16 02 00 18"
ACTIVATE = "42 61 10 02 01 13"
LOCK = "42 61 10 02 00 12"
ZERO = "42 61 25 01 00 26"
SHUT_DOWN = "42 61 12 02 01 15"
ASK_BOOTS = "42 61 23 01 00 24"


def running(*, history: int = 0, **options: str) -> SimulatedModule:
    """A module that has booted a minute ago, with options as one types them."""
    memory = Memory(boot_count=36)
    invent_records(memory, history, seed=1, has_odd_voltage=False)
    quirks = setup_from(parse_options({"empty_slots": "none"} | options)).quirks
    return booted(SimulatedModule(Physics(drain_v_per_h=0.0), quirks, memory=memory))


def values(module: SimulatedModule, code: int, count: int, now_s: float = 0.0) -> list[int]:
    """D4 of that many answers to the same query."""
    return [receive(module, BY_CODE[code].query().encode(), now_s)[4] for _ in range(count)]


@pytest.mark.parametrize(
    "text", ["21:20", "16:17=01,16:20=0A", "21:20=14/2@500", "22:20@0.5"]
)  # fmt: skip
def test_a_rule_reads_back_as_it_was_typed(text: str) -> None:
    quirks = setup_from(parse_options({"cross-talk": text})).quirks
    assert as_text(quirks.cross_talk) == text
    assert quirks.cross_talk[0].cause == int(text[:2], 16)


@pytest.mark.parametrize(
    ("name", "text", "said"),
    [
        ("cross_talk", "21>20", "CODE:CODE[=HEX]"),
        ("cross_talk", "99:20", "01|10|11"),
        ("cross_talk", "21:32", "10|13|15"),
        ("read_changes", "20=14", "CODE:CODE[=HEX]"),
        ("mute_codes", "33/0", "CODE[/N]"),
        ("mute_codes", "99/2", "01|10|11"),
        ("drop_records", "10", "1|2|3"),
        ("drop_records", "x", "RECORD[/N]"),
        ("double_codes", "01/2", "CODE"),
    ],
)
def test_what_means_nothing_is_refused_with_what_is_expected(name: str, text: str, said: str) -> None:
    with pytest.raises(UserError, match=name) as refused:
        parse_options({name: text})
    assert said in str(refused.value)


def test_rules_in_the_query_of_a_url() -> None:
    from app.port_urls.protocol_sim import open_bench

    bench = open_bench("sim://lies-in-a-url?cross_talk=21:20=14/2@500&mute_codes=35/2")
    assert bench.module.quirks.cross_talk == (Rule(0x21, 0x20, 0x14, 2, 500.0),)
    assert bench.module.quirks.mute_codes == {Occasion(0x35, 2)}


@pytest.mark.parametrize("cause", ["15", "16", "17", "20", "21", "22", "10"])
@pytest.mark.parametrize("effect", sorted(CHANGEABLE_CODES))
def test_writing_one_setting_changes_any_other(cause: str, effect: int) -> None:
    module = running(cross_talk=f"{cause}:{effect:02X}=01")
    before = read_raw(module, effect)
    frame = Request(BY_CODE[int(cause, 16)], 0x02, 0x00).encode()
    answer = receive(module, frame, 0.0)
    assert answer[-2] == 0x00, "the acknowledgement says nothing of it"
    assert read_raw(module, effect) == 0x01 != before or before == 0x01


def test_cross_talk_without_a_value_writes_the_same_byte() -> None:
    module = running(cross_talk="21:20")
    assert say(module, ASK_THRESHOLD) == "41 75 20 01 3c 5d"
    say(module, "42 61 21 01 00 22")
    assert module.memory.attitude_threshold == 60, "a query changes nothing"
    assert say(module, SET_ACCELERATION_4) == "41 75 21 01 04 26"
    assert module.memory.attitude_threshold == 4


def test_cross_talk_only_the_second_time_and_later() -> None:
    module = running(cross_talk="21:20=14/2@500")
    say(module, SET_ACCELERATION_4, 0.0)
    tick(module, 1.0)
    assert module.memory.attitude_threshold == 60
    say(module, SET_ACCELERATION_4, 1.0)
    tick(module, 1.499)
    assert module.memory.attitude_threshold == 60
    tick(module, 1.501)
    assert module.memory.attitude_threshold == 20


def test_enabling_a_trigger_disables_the_other_and_changes_a_threshold() -> None:
    module = running(cross_talk="16:17=01,16:20=C8")
    assert say(module, ENABLE_ATTITUDE) == "41 75 16 01 00 17"
    assert not module.state.freefall_is_enabled
    assert module.memory.attitude_threshold == 200


def test_zeroing_can_have_a_side_effect_too() -> None:
    module = running(cross_talk="25:20=05")
    assert say(module, ZERO) == "41 75 25 01 01 27"
    assert module.memory.attitude_threshold == 5


def test_a_setting_goes_back() -> None:
    module = running(revert_ms="20")
    assert say(module, SET_THRESHOLD_70) == "41 75 20 01 46 67"
    assert say(module, ASK_THRESHOLD, 0.019) == "41 75 20 01 46 67"
    assert say(module, ASK_THRESHOLD, 0.021) == "41 75 20 01 3c 5d"


def test_a_trigger_flag_goes_back() -> None:
    module = running(revert_ms="20")
    say(module, "42 61 16 02 01 19")
    assert not module.state.attitude_is_enabled
    tick(module, 0.03)
    assert module.state.attitude_is_enabled


def test_a_setting_is_clamped_later() -> None:
    module = running(clamp_ms="500")
    assert say(module, "42 61 20 02 1e 40") == "41 75 20 01 1e 3f"
    assert say(module, ASK_THRESHOLD, 0.49) == "41 75 20 01 1e 3f"
    assert say(module, ASK_THRESHOLD, 0.51) == "41 75 20 01 37 58"


def test_a_setting_changes_after_it_was_read_the_second_time() -> None:
    module = running(read_changes="20:20=14/2@50")
    assert values(module, 0x20, 2) == [60, 60]
    assert values(module, 0x20, 1, 0.04) == [60]
    assert values(module, 0x20, 2, 0.06) == [20, 20]


def test_a_setting_changes_after_something_else_was_read() -> None:
    module = running(read_changes="32:20=C8/2")
    receive(module, STATUS.query().encode(), 0.0)
    assert module.memory.attitude_threshold == 60
    receive(module, STATUS.query().encode(), 0.0)
    assert module.memory.attitude_threshold == 200


def test_a_silent_restart_after_an_acknowledgement() -> None:
    module = running(silent_restart_ms="30")
    say(module, ACTIVATE, -1.0)
    tick(module, -0.9)
    say(module, "42 61 16 02 01 19", -0.5)
    assert not module.state.attitude_is_enabled
    boots = module.memory.boot_count
    assert tick(module, 0.0) == b"", "it says nothing of it"
    assert module.memory.boot_count == boots + 1
    assert module.state.attitude_is_enabled, "what does not survive is gone"
    assert say(module, ASK_BOOTS, 1.0) == encode_reply(0x23, boots + 1).hex(" ")


def test_a_query_restarts_nothing() -> None:
    module = running(silent_restart_ms="30")
    say(module, ASK_BOOTS)
    tick(module, 1.0)
    assert module.memory.boot_count == 37


def test_what_it_had_to_say_is_lost_with_a_silent_restart() -> None:
    module = running(silent_restart_ms="5", double_codes="20", double_ms="10")
    assert say(module, SET_THRESHOLD_70) == "41 75 20 01 46 67"
    assert tick(module, 1.0) == b""


def test_a_silent_restart_at_a_given_time_loses_the_activation() -> None:
    module = running(restart_at_s="70")
    module.activate(is_active=True)
    assert tick(module, 9.99) == b""
    assert module.state.is_active
    assert tick(module, 10.01) == b""
    assert not module.state.is_active
    assert module.memory.boot_count == 38
    tick(module, 81.0)
    assert module.memory.boot_count == 39, "each time that it has run this long"


def test_a_restart_time_that_has_passed_already_restarts_once() -> None:
    module = running()
    tick(module, 500.0)
    module.quirks = setup_from(parse_options({"restart_at_s": "100"})).quirks
    tick(module, 501.0)
    assert module.memory.boot_count == 38


def test_a_line_wakes_for_what_it_does_by_itself() -> None:
    line = SimulatedLine(FakeClock(), {"restart_at_s": 63.0, "stream_at_boot": True, "stream": "acknowledged"})
    assert line.bench.module.next_due(line.clock()) is not None


def test_a_restart_that_loses_the_settings() -> None:
    module = running(forgets="yes")
    say(module, SET_THRESHOLD_70)
    assert module.memory.attitude_threshold == 70
    module.restart(1.0)
    assert module.memory.attitude_threshold == 60


def record_boots(module: SimulatedModule) -> list[int]:
    raw = receive(module, TRIGGER_RECORDS.query().encode(), 0.0)
    records = [decode_record(piece.raw) for piece in StreamParser().feed(raw)]
    return [record.raw[4] for record in records]


def test_records_are_left_out_in_the_pass_that_was_named() -> None:
    everything = record_boots(running(history=4))
    module = running(history=4, drop_records="1/2,2,4/1")
    first, _, third, fourth = everything
    assert record_boots(module) == [first, third]
    assert record_boots(module) == [third, fourth]
    assert record_boots(module) == [first, third, fourth]


def test_a_code_falls_silent_from_the_third_time_on() -> None:
    module = running(mute_codes="20/3,14")
    assert say(module, ASK_THRESHOLD) == "41 75 20 01 3c 5d"
    assert say(module, SET_THRESHOLD_70) == "41 75 20 01 46 67"
    assert say(module, ASK_THRESHOLD) == ""
    assert say(module, "42 61 20 02 3c 5e") == ""
    assert module.memory.attitude_threshold == 70, "no answer and no effect"
    assert say(module, "42 61 14 01 01 16") == ""


@pytest.mark.parametrize(("after_ms", "second_s"), [("0", 0.0), ("50", 0.05)])
def test_chosen_answers_come_twice(after_ms: str, second_s: float) -> None:
    module = running(double_codes="01,20", double_ms=after_ms)
    sent = module.receive(bytes.fromhex(HEARTBEAT), 0.0) + module.collect(1.0)
    assert [one.data.hex(" ") for one in sent] == ["41 75 01 a5 5a 00"] * 2
    assert sent[1].at_s == pytest.approx(second_s, abs=0.002)
    assert len(receive(module, bytes.fromhex(ASK_BOOTS), 2.0) + tick(module, 3.0)) == 6


def test_a_doubled_shutdown_is_said_twice_and_done_once() -> None:
    module = running(double_codes="12")
    assert say(module, SHUT_DOWN) == "41 75 12 01 01 14 41 75 12 01 01 14"
    assert not module.is_on


@pytest.mark.parametrize(
    ("rule", "answers"),
    [
        ("20:22", "41 75 22 01 a0 c3 41 75 20 01 3c 5d"),
        ("20:22=05", "41 75 22 01 05 28 41 75 20 01 3c 5d"),
        ("20:16", "41 75 16 01 00 17 41 75 20 01 3c 5d"),
        ("20:12", "41 75 12 01 01 14 41 75 20 01 3c 5d"),
        ("20:01", "41 75 01 a5 5a 00 41 75 20 01 3c 5d"),
        ("20:32", "41 75 32 00 0a 00 00 3c 41 75 20 01 3c 5d"),
    ],
)
def test_a_foreign_answer_comes_first(rule: str, answers: str) -> None:
    module = running(foreign_replies=rule)
    assert say(module, ASK_THRESHOLD) == answers
    assert module.is_on
    assert module.memory.attitude_threshold == 60


def test_a_foreign_answer_comes_later() -> None:
    module = running(foreign_replies="20:22@500")
    assert say(module, ASK_THRESHOLD) == "41 75 20 01 3c 5d"
    assert tick(module, 0.499) == b""
    assert tick(module, 0.501).hex(" ") == "41 75 22 01 a0 c3"


def frame_times(jitter_ms: str) -> list[float]:
    module = running(stream_jitter_ms=jitter_ms)
    say(module, "42 61 13 02 01 16")
    return [sent.at_s for sent in module.collect(4.0)]


def test_the_stream_jitters_and_loses_nothing() -> None:
    even, uneven = frame_times("0"), frame_times("15")
    late = [after - before for before, after in zip(even, uneven, strict=False)]
    assert abs(len(even) - len(uneven)) <= 1
    assert all(-1e-9 <= one <= 0.0151 for one in late)
    assert max(late) > 0.01
    assert uneven == sorted(uneven)
    assert frame_times("15") == uneven, "the same each time"


def test_an_activation_without_effect() -> None:
    module = running(activates="no")
    assert say(module, ACTIVATE) == "41 75 10 01 01 12"
    assert not module.state.is_active
    assert module.status(0.0)[6] == 0x00


def test_locking_without_effect() -> None:
    module = running(locks="no")
    say(module, ACTIVATE)
    assert say(module, LOCK) == "41 75 10 01 00 11"
    assert module.state.is_active


def test_an_activation_is_reported_late_and_so_is_locking() -> None:
    module = running(active_late_ms="500")
    say(module, ACTIVATE)
    assert module.state.is_active
    assert [module.reports_active(at_s) for at_s in (0.0, 0.49, 0.51)] == [False, False, True]
    assert say(module, "42 61 30 01 00 31", 0.4) == "41 75 30 01 00 31"
    assert module.status(0.4)[6] == 0x00
    say(module, LOCK, 1.0)
    assert not module.state.is_active
    assert [module.reports_active(at_s) for at_s in (1.49, 1.51)] == [True, False]


def test_zeroing_without_effect() -> None:
    module = running(zeroes="no")
    module.world.tilt_deg = 7
    assert say(module, ZERO) == "41 75 25 01 01 27"
    assert module.tilt_deg(0.0) == 7


def test_a_shutdown_without_effect() -> None:
    module = running(shuts_down="no")
    assert say(module, SHUT_DOWN) == "41 75 12 01 01 14"
    assert module.is_on
    assert say(module, HEARTBEAT) == "41 75 01 a5 5a 00"


def test_an_honest_module_needs_no_plans() -> None:
    module = running()
    for frame in (SET_THRESHOLD_70, ACTIVATE, ZERO, LOCK):
        say(module, frame)
    assert module.next_due(0.0) is None


def test_lies_can_be_told_while_it_runs_and_count_from_then_on() -> None:
    clock = FakeClock()
    bench = SimulatedBench(clock=clock)
    receive(bench.module, bytes.fromhex(ASK_THRESHOLD), clock())
    bench.change(mute_codes=frozenset((Occasion(0x20, 2),)))
    answers = [receive(bench.module, bytes.fromhex(ASK_THRESHOLD), clock()) for _ in range(2)]
    assert [bool(answer) for answer in answers] == [True, False]


def test_an_inserted_record_is_a_whole_frame() -> None:
    module = running(history=1, foreign_replies="20:35")
    pieces = StreamParser().feed(receive(module, bytes.fromhex(ASK_THRESHOLD), 0.0))
    assert [len(piece.raw) for piece in pieces if isinstance(piece, Frame)] == [16, 6]

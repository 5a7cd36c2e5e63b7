"""What a module may be told to do: the dialects of the vendor's table, faults and lies, one by one."""

import json
import sys
from pathlib import Path

import pytest

from tests.module.line import Line, now
from tests.module.module import BY_ATTITUDE, BY_FALL, BY_SERIAL, Module
from tests.module.options import Options, from_words
from tests.support.patience import PATIENCE_S
from tests.support.processes import PROGRAM, ran, running

SET_60, ASK_20, ASK_22 = "42 61 20 02 3c 5e", "42 61 20 01 00 21", "42 61 22 01 00 23"
ACTIVATE, ASK_STATUS, ASK_RECORDS = "42 61 10 02 01 13", "42 61 32 01 00 33", "42 61 35 01 00 36"
HEARTBEAT = "41 75 01 a5 5a 00"


def said(module: Module, question: str, at: float = 1.0) -> str:
    module.hear(bytes.fromhex(question), at)
    return module.speak(at).hex(" ")


@pytest.mark.parametrize(
    ("options", "question", "answer"),
    [
        (["misprinted_sum=true"], ASK_20, "41 75 20 01 3c 50"),
        (['acknowledged_by_one=["22"]'], "42 61 22 02 a0 c4", "41 75 22 01 01 24"),
        (["voltage_code=52"], "42 61 34 01 00 35", "41 75 34 01 c8 fd"),
        (["freefall_code=22"], "42 61 17 02 01 1a", "41 75 16 01 01 18"),
        (["empty_slot=null"], ASK_RECORDS, ""),
        (["empty_slot=255", "records_at_once=1"], ASK_RECORDS, "41 75 35 01 ff ff ff ff ff ff ff ff ff ff ff 2b"),
        (["records_at_once=1", "record_bytes=14"], ASK_RECORDS, "41 75 35 01 00 00 00 00 00 00 00 00 00 00"),
        ([], "42 61 13 01 00 14", ""),
        (['baud_answer="none"'], "42 61 24 02 02 28", ""),
        (["lowest_attitude_deg=70"], SET_60, "41 75 20 01 3c 5d"),
        (["light_closed=30", "light_open=3"], "42 61 14 01 01 16", "41 75 14 01 1e 33"),
        (["long_sum_short=true"], ASK_STATUS, "41 75 32 02 0a 00 00 3e"),
        (['instead={"30":"01 01"}'], "42 61 30 01 00 31", "41 75 30 01 01 32"),
        (['lost_queries={"20":1}'], ASK_20, ""),
        (['lost_answers={"20":1}'], SET_60, ""),
        (['query_copies={"22":[0]}'], ASK_22, "41 75 22 01 a0 c3 41 75 22 01 a0 c3"),
        (['second={"22":[0,"01 5a"]}'], ASK_22, "41 75 22 01 a0 c3 41 75 22 01 5a 7d"),
    ],
)
def test_an_answer(options: list[str], question: str, answer: str) -> None:
    assert said(Module(from_words(options)), question) == answer


def test_the_rate_changes_behind_the_old_answer_or_before_the_new_one() -> None:
    for how, at_answer in (("old", 115200), ("new", 9600)):
        module = Module(Options(baud_answer=how))
        assert said(module, "42 61 24 02 02 28") == "41 75 24 01 02 27"
        assert module.rate == at_answer
        module.speak(1.02)
        assert module.rate == 9600


def test_the_rate_changes_with_the_restart() -> None:
    module = Module(Options(baud_at_once=False))
    said(module, "42 61 24 02 02 28")
    module.speak(1.1)
    assert module.rate == 115200
    module.restart(2.0)
    module.speak(3.0)
    assert module.rate == 9600


def test_e15_what_survives_a_restart() -> None:
    for survives in (True, False):
        module = Module(
            Options(activation_survives=survives, output_survives=survives, flags_survive=survives, stream_hz=0)
        )
        for question in (ACTIVATE, "42 61 13 02 01 16", "42 61 16 02 01 19", "42 61 17 02 01 1a"):
            said(module, question)
        module.restart(2.0)
        module.speak(3.0)
        assert [module.settings[code] for code in (0x10, 0x13, 0x16, 0x17)] == [int(survives)] * 4


def test_it_fires_by_itself_only_where_it_is_active_and_enabled() -> None:
    module = Module()
    module.readings.tilt_deg = 61
    module.speak(1.0)
    assert not module.triggered
    said(module, "42 61 16 02 01 19")
    said(module, ACTIVATE)
    assert not module.triggered
    module.readings.acceleration = 0
    module.speak(2.0)
    module.speak(3.5)
    assert not module.triggered
    module.speak(3.7)
    assert [record[5] for record in module.records] == [BY_FALL]
    module = Module()
    module.readings.tilt_deg = 60
    said(module, ACTIVATE)
    module.speak(1.1)
    assert [record[5] for record in module.records] == [BY_ATTITUDE]


def test_deploy() -> None:
    locked = Module()
    said(locked, "42 61 11 02 01 14")
    assert not locked.triggered
    active = Module(Options(forbidding_holds_back=True))
    said(active, ACTIVATE)
    said(active, "42 61 11 02 00 13")
    said(active, "42 61 11 02 01 14")
    assert not active.triggered
    active.options.forbidding_holds_back = False
    said(active, "42 61 11 02 00 13")
    said(active, "42 61 11 02 01 14")
    assert [record[5] for record in active.records] == [BY_SERIAL]


def test_a_module_that_is_shut_down_is_silent_until_it_is_switched_on() -> None:
    module = Module()
    assert said(module, "42 61 12 02 01 15") == "41 75 12 01 01 14"
    module.speak(1.1)
    assert said(module, ASK_20, 1.2) == ""
    module.restart(2.0, off_s=0.0)
    assert module.speak(3.0).hex(" ") == f"{HEARTBEAT} {HEARTBEAT}"
    assert said(module, ASK_20, 3.1) == "41 75 20 01 3c 5d"


def test_a_setting_reverts_by_itself() -> None:
    module = Module(Options(reverts={0x22: (0.8, None)}))
    said(module, "42 61 22 02 5a 7e")
    assert said(module, ASK_22, 1.5) == "41 75 22 01 5a 7d"
    assert said(module, ASK_22, 1.9) == "41 75 22 01 a0 c3"


def test_answers_wait_for_each_other_unless_told_otherwise() -> None:
    slow = Options(delays={0x20: 0.5})
    module = Module(slow)
    said(module, ASK_20)
    assert said(module, ASK_22) == ""
    assert module.speak(1.5).hex(" ") == "41 75 20 01 3c 5d 41 75 22 01 a0 c3"
    slow.in_order = False
    said(module, ASK_20, 2.0)
    assert said(module, ASK_22, 2.0) == "41 75 22 01 a0 c3"


def test_silence_and_heartbeats_that_nobody_asked_for() -> None:
    module = Module(Options(heartbeat_every_s=0.5))
    assert module.speak(0.6).hex(" ") == HEARTBEAT
    module.be_silent(0.7, 1.0)
    assert module.speak(1.2) == b""
    assert said(module, SET_60, 1.3) == ""
    assert said(module, ASK_20, 1.75).endswith("41 75 20 01 3c 5d")


def test_it_streams() -> None:
    module = Module(Options(stream_hz=10))
    said(module, "42 61 13 02 01 16")
    frames = sum(len(module.speak(1.0 + tenths / 10 + 0.01)) for tenths in range(1, 11)) / 8
    assert frames == 10


def test_bytes_are_lost_and_turned_the_same_way_each_time() -> None:
    def heard(seed: int) -> bytes:
        module = Module(Options(lose=0.1, flip=0.05), seed=seed)
        return b"".join(bytes.fromhex(said(module, ASK_20, at)) for at in range(1, 200))

    assert heard(1) == heard(1)
    assert heard(1) != heard(2)
    assert 0 < len(heard(1)) < 199 * 6


@pytest.mark.skipif(sys.platform == "win32", reason="Windows has no pseudo-terminals")
def test_at_another_rate_each_hears_garbage() -> None:
    module = Module(now=now())
    module.settings[0x24] = 2
    module.rate = 9600
    with Line(module) as line:
        wrong = ran(*PROGRAM, "read", "--json", "--port", line.port)
        assert wrong.returncode == 3
        assert module.log.got() == []
        right = ran(*PROGRAM, "find", "--json", "--port", line.port)
    assert json.loads(right.stdout)["baud_rate"] == 9600


@pytest.mark.skipif(sys.platform == "win32", reason="Windows has no pseudo-terminals")
def test_as_a_process(tmp_path: Path) -> None:
    log, link = tmp_path / "log.jsonl", tmp_path / "module"
    with running(sys.executable, "-m", "tests.module", "--log", log, "--link", link, "voltage_code=52") as process:
        port = process.out.readline().strip()
        assert port == str(link)
        process.told.write("set 20 77\n")
        process.told.flush()
        read = ran(*PROGRAM, "read", "--json", "--port", port)
        assert json.loads(read.stdout)["settings"]["attitude_threshold_deg"] == 77
        process.told.close()
        assert process.process.wait(PATIENCE_S) == 0
    entries = [json.loads(line) for line in log.read_text(encoding="utf-8").splitlines()]
    assert "41 75 34 01 c8 fd" in [entry["frame"] for entry in entries if entry["kind"] == "sent"]


@pytest.mark.skipif(sys.platform == "win32", reason="Windows has no pseudo-terminals")
def test_two_modules_on_one_line_answer_both() -> None:
    first, second = Module(now=now(), name="first"), Module(now=now(), name="second")
    with Line(first, second) as line:
        ran(*PROGRAM, "read", "--json", "--port", line.port)
    assert first.log.sent(0x20)
    assert second.log.sent(0x20)

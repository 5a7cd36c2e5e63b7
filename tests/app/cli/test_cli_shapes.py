"""What the sub-commands print, byte for byte: the contract that other programs are written against."""

import io
import json
import os
import stat
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest

from app.cli import history as records
from app.cli import read as found
from app.preflight.reading_object import SETTING_KEYS
from app.procedures.history import History
from app.procedures.write_all import SettingChange
from app.system.files import write_whole
from app.terminal import console
from app.terminal.arguments import RATES
from app.terminal.setting_words import parse_settings
from app.text import i18n
from app.text.durations import stopwatch
from protocol.catalogue import BAUD_RATES, BY_NAME, SERIAL_OUTPUT, SETTINGS
from protocol.events import Unanswered
from protocol.messages import TriggerRecord, decode_record

RECORD = bytes.fromhex("41753501 0100 6C02 3C05 A000 010C EB7E")
"""The table's worked example."""

EVERYTHING: dict[str, bool | int | float] = {
    "tilt_deg": 7,
    "acceleration_g": 1.0,
    "triggered": False,
    "active": False,
    "boot_count": 37,
    "cell_voltage_v": 4.0,
    "charging": False,
    "light_v": 0.3,
    "attitude_threshold_deg": 60,
    "freefall_acceleration_g": 0.5,
    "freefall_time_s": 1.6,
    "light_threshold_v": 1.8,
    "baud_rate": 115200,
}


@pytest.fixture
def record() -> TriggerRecord:
    decoded = decode_record(RECORD)
    assert isinstance(decoded, TriggerRecord)
    return decoded


@pytest.fixture
def chinese(tmp_path: Path) -> Iterator[None]:
    """A few Chinese texts, so that this does not depend on what is translated today."""
    path = tmp_path / "zh.ts"
    texts = {"Tilt": "倾角", "Acceleration": "加速度", "unknown": "未知"}
    messages = "".join(
        f"<message><source>{one}</source><translation>{two}</translation></message>" for one, two in texts.items()
    )
    path.write_text(f"<TS><context><name>dps-s</name>{messages}</context></TS>", encoding="utf-8")
    i18n.set_language(str(path))
    yield
    i18n.set_language(i18n.ENGLISH)


@pytest.mark.parametrize(
    ("attempts", "text"),
    [
        (0, "no reply"),
        (1, "no reply"),
        (2, "no reply within 0.4 s, asked 2 times"),
    ],
)
def test_errors_say_how_often_it_was_asked(attempts: int, text: str, chinese: None) -> None:
    why = found.unanswered_reason(Unanswered(BY_NAME["light"].query(), attempts, 0.4, 0.0))
    assert why.in_english() == text


def test_setting_keys_are_the_catalogues() -> None:
    assert SETTING_KEYS == (
        "attitude_threshold_deg", "freefall_acceleration_g", "freefall_time_s", "light_threshold_v",
        "attitude_trigger", "freefall_trigger", "serial_output", "baud_rate",
    )  # fmt: skip
    assert set(SETTING_KEYS) == {command.key for command in SETTINGS}
    assert RATES == BAUD_RATES


def test_chinese_columns_line_up(chinese: None) -> None:
    lines = found.page_of(found.Findings("p", 115200, None, EVERYTHING))
    columns = {
        console.display_width(line[: line.index(value)])
        for line, value in (
            (next(line for line in lines if "倾角" in line), "7°"),
            (next(line for line in lines if "加速度" in line), "1.0 g"),
            (next(line for line in lines if "Boot count" in line), "37"),
            (next(line for line in lines if "未知" in line), "未知"),
        )
    }
    assert len(columns) == 1


def test_csv_file_is_replaced_as_a_whole(tmp_path: Path, record: TriggerRecord) -> None:
    path = tmp_path / "records.csv"
    path.write_bytes(b"older")
    path.chmod(0o640)
    link = tmp_path / "link.csv"
    link.symlink_to(path)
    write_whole(link, records.csv_of(History((record,))).encode())
    assert path.read_bytes().startswith(b"boot_count,uptime_s,")
    assert stat.S_IMODE(path.stat().st_mode) == 0o640
    assert link.is_symlink()
    assert sorted(one.name for one in tmp_path.iterdir()) == ["link.csv", "records.csv"]


@pytest.mark.skipif(sys.platform == "win32", reason="named pipes in folders are POSIX")
def test_csv_goes_into_a_pipe_that_stays_one(tmp_path: Path, record: TriggerRecord) -> None:
    pipe = tmp_path / "pipe"
    os.mkfifo(pipe)
    reader = os.open(pipe, os.O_RDONLY | os.O_NONBLOCK)
    try:
        write_whole(pipe, records.csv_of(History((record,))).encode())
        assert os.read(reader, 4096).startswith(b"boot_count,uptime_s,")
    finally:
        os.close(reader)
    assert pipe.is_fifo()


def test_history_page_marks_the_implausible(record: TriggerRecord) -> None:
    page = records.page_of(History((record,), 8, is_confirmed=True))
    assert page[1] == (
        "1           1:48            attitude  60°       0.5 g, 1.60 s  yes     no        1.2 V  4.70 V (implausible)"
    )
    assert page[-1] == "Empty slots: 8."
    assert records.page_of(History((), 0, is_confirmed=True)) == ["The module keeps no trigger records."]
    assert records.page_of(History()) == ["No records came."]
    doubtful = records.page_of(History(seen_once=(record,), is_answered=True))
    assert doubtful[1].startswith("1 (?)")
    assert "(?) Seen in one reading only. Read again." in doubtful


@pytest.mark.parametrize(("seconds", "text"), [(0, "0:00"), (108, "1:48"), (65535, "18:12:15")])
def test_durations(seconds: int, text: str) -> None:
    assert stopwatch(seconds) == text


@pytest.mark.parametrize(("text", "value"), [("true", True), ("False", False), ("on", True), ("off", False)])
def test_flags_are_read(text: str, value: bool) -> None:
    assert parse_settings([f"serial_output={text}"]) == [SettingChange(SERIAL_OUTPUT, value)]


def test_widths_count_columns() -> None:
    assert console.display_width("倾角 7°") == 7
    assert console.padded("倾角", 6) == "倾角  "
    assert console.columns([("甲", "b"), ("1", "2"), ("333", "")]) == ["甲   b", "1    2", "333"]


def test_json_of_a_broken_name_is_json() -> None:
    raw = io.BytesIO()
    out = io.TextIOWrapper(raw, encoding="utf-8", errors="backslashreplace")
    out.write(console.as_json({"port": "/tmp/\udcff"}))
    out.flush()
    assert json.loads(raw.getvalue()) == {"port": "/tmp/\udcff"}

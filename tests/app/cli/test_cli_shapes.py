"""What the sub-commands print, byte for byte: the contract that other programs are written against."""

import argparse
import csv
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
from app.cli.settings import set as setting
from app.engine.setting_changes import ChangedSetting
from app.preflight.reading_object import SETTING_KEYS
from app.procedures.history import History
from app.procedures.write import SetReply, Written
from app.procedures.write_all import SettingChange, WriteReport
from app.settings.values import parse_value
from app.system.files import write_whole
from app.terminal import console
from app.terminal.arguments import RATES, seconds
from app.terminal.setting_words import parse_settings
from app.text import i18n
from app.text.durations import stopwatch
from app.text.messages import message
from app.text.user_error import UserError
from app.trigger_records.fields import fields_of
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


def test_read_json_is_the_contract() -> None:
    values = {key: value for key, value in EVERYTHING.items() if key != "cell_voltage_v"}
    why = found.unanswered_reason(Unanswered(BY_NAME["cell_voltage"].query(), 3, 1.0, 0.0))
    findings = found.Findings("/dev/ttyUSB0", 115200, 0.00287, values, {"cell_voltage_v": why})
    assert console.as_json(found.json_of(findings)) == (
        '{"link": {"port": "/dev/ttyUSB0", "baud_rate": 115200, "round_trip_ms": 2.9}, '
        '"status": {"tilt_deg": 7, "acceleration_g": 1.0, "triggered": false, "active": false}, '
        '"boot_count": 37, "cell_voltage_v": null, "charging": false, "light_v": 0.3, '
        '"settings": {"attitude_threshold_deg": 60, "freefall_acceleration_g": 0.5, "freefall_time_s": 1.6, '
        '"light_threshold_v": 1.8, "attitude_trigger": null, "freefall_trigger": null, "serial_output": null, '
        '"baud_rate": 115200}, '
        '"errors": {"cell_voltage_v": "no reply within 1.0 s, asked 3 times"}}'
    )


def test_read_json_keeps_its_shape_with_nothing_known() -> None:
    shape = found.json_of(found.Findings("p", 9600))
    assert shape["status"] == dict.fromkeys(("tilt_deg", "acceleration_g", "triggered", "active"))
    assert shape["link"] == {"port": "p", "baud_rate": 9600, "round_trip_ms": None}
    assert list(shape) == [
        "link",
        "status",
        "boot_count",
        "cell_voltage_v",
        "charging",
        "light_v",
        "settings",
        "errors",
    ]


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


def test_the_page_shows_units_and_says_unknown() -> None:
    values = EVERYTHING | {"serial_output": True, "triggered": True}
    del values["light_v"]
    why = message("no reply within {seconds:.1f} s, asked {attempts} times", seconds=1.0, attempts=3)
    page = "\n".join(found.page_of(found.Findings("/dev/ttyUSB0", 115200, 0.0029, values, {"light_v": why})))
    assert page == (
        "/dev/ttyUSB0, 115200 baud, 2.9 ms\n"
        "\n"
        "Status\n"
        "  Tilt                              7°\n"
        "  Acceleration                      1.0 g\n"
        "  Triggered                         triggered\n"
        "  Active                            locked\n"
        "  Cell voltage                      4.00 V\n"
        "  Charging                          no\n"
        "  Light                             unknown (no reply within 1.0 s, asked 3 times)\n"
        "  Boot count                        37\n"
        "\n"
        "Settings\n"
        "  Attitude threshold                60°\n"
        "  Free-fall acceleration threshold  0.5 g\n"
        "  Free-fall time                    1.60 s\n"
        "  Light threshold                   1.8 V\n"
        "  Attitude trigger                  unknown (cannot be read)\n"
        "  Free-fall trigger                 unknown (cannot be read)\n"
        "  Serial output                     yes\n"
        "  Baud rate                         115200 baud"
    )


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


def test_history_json_is_the_contract(record: TriggerRecord) -> None:
    assert console.as_json(records.json_of(History((record,), 0, is_confirmed=True, is_answered=True))) == (
        '{"records": [{"boot_count": 1, "uptime_s": 108, "sources": ["attitude"], "attitude_threshold_deg": 60, '
        '"freefall_acceleration_g": 0.5, "freefall_time_s": 1.6, "serial_connected": true, "charging": false, '
        '"light_v": 1.2, "cell_voltage_v": 4.7, "implausible": ["cell_voltage_v"], '
        '"raw": "41 75 35 01 01 00 6C 02 3C 05 A0 00 01 0C EB 7E", "confirmed": true}], "empty_slots": 0, '
        '"answered": true, "complete": true}'
    )
    assert records.json_of(History((), 9, is_answered=True)) == {
        "records": [],
        "empty_slots": 9,
        "answered": True,
        "complete": False,
    }
    once = records.json_of(History(seen_once=(record,), is_answered=True))["records"]
    assert isinstance(once, list)
    assert [one["confirmed"] for one in once] == [False]


def test_csv_has_units_in_its_head(record: TriggerRecord) -> None:
    rows = list(csv.reader(io.StringIO(records.csv_of(History((record,))))))
    assert rows == [
        [*fields_of(record), "confirmed"],  # the names of the JSON
        [
            *("1", "108", "attitude", "60", "0.5", "1.6", "true", "false", "1.2", "4.7", "cell_voltage_v"),
            "41 75 35 01 01 00 6C 02 3C 05 A0 00 01 0C EB 7E",
            "true",
        ],
    ]


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


def test_a_failed_csv_leaves_the_old_file(
    tmp_path: Path, record: TriggerRecord, monkeypatch: pytest.MonkeyPatch
) -> None:
    path = tmp_path / "records.csv"
    path.write_bytes(b"older")

    def fail(_number: int) -> None:
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(os, "fsync", fail)
    with pytest.raises(OSError, match="No space"):
        write_whole(path, records.csv_of(History((record,))).encode())
    assert path.read_bytes() == b"older"
    assert [one.name for one in tmp_path.iterdir()] == ["records.csv"]


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


def test_set_json_is_the_contract() -> None:
    written = Written(command=SERIAL_OUTPUT, wanted=True, heard=SetReply.ECHO)
    found = WriteReport(results=(written,), changed=(ChangedSetting(BY_NAME["freefall_time"], 1.6, 0.2),))
    assert console.as_json(setting.json_of(found)) == (
        '{"results": {"serial_output": {"wanted": true, "before": null, "acknowledged": true, '
        '"read_back": null, "verified": null, "verified_age_s": null, "error": null}}, '
        '"changed": {"freefall_time_s": {"before": 1.6, "after": 0.2}}, "unread": []}'
    )


@pytest.mark.parametrize(("text", "value"), [("true", True), ("False", False), ("on", True), ("off", False)])
def test_flags_are_read(text: str, value: bool) -> None:
    assert parse_settings([f"serial_output={text}"]) == [SettingChange(SERIAL_OUTPUT, value)]


@pytest.mark.parametrize(
    "words",
    [
        ["serial_output"],
        ["serial_output="],
        ["serial_output=1"],
        ["serial_output=true", "serial_output=false"],
        ["attitude_threshold_deg=60.5"],
        ["deploy=true"],
        ["activation=true"],
    ],
)
def test_unfit_wishes_are_refused(words: list[str]) -> None:
    with pytest.raises(console.Refused):
        parse_settings(words)


def test_all_faults_are_said_at_once() -> None:
    with pytest.raises(console.Refused) as caught:
        parse_settings(["serial_output=true", "serial_output=maybe", "nonsense", "x=1"])
    assert len(str(caught.value).splitlines()) == 3


@pytest.mark.parametrize(
    ("name", "text", "value"),
    [("freefall_time", "1.6", 1.6), ("attitude_threshold", "60", 60), ("baud_rate", "9600", 9600)],
)
def test_numbers_go_through_the_catalogue(name: str, text: str, value: float) -> None:
    field = BY_NAME[name].write
    assert field is not None
    assert parse_value(field, text) == value


@pytest.mark.parametrize(("name", "text"), [("freefall_time", "1.605"), ("light_threshold", "26"), ("baud_rate", "x")])
def test_what_a_byte_cannot_carry_is_refused(name: str, text: str) -> None:
    field = BY_NAME[name].write
    assert field is not None
    with pytest.raises(UserError):
        parse_value(field, text)


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


@pytest.mark.parametrize("text", ["0", "-1", "nan", "inf", "soon"])
def test_seconds_are_above_zero(text: str) -> None:
    with pytest.raises(argparse.ArgumentTypeError):
        seconds(text)

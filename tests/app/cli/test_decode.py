"""`dps-s decode`: the lines, the exit codes, and bytes as people write them."""

import io
import json
import os
import sys
import threading
from pathlib import Path

import pytest

from tests.support.cli_line import Program
from tests.support.patience import PATIENCE_S
from tests.support.processes import PROGRAM, running
from tests.vendor.frames import BY_ID

pytest_plugins = ["tests.support.cli_fixtures"]

STATUS = "41 75 32 07 0A 00 01 44"
MISPRINT = "41 75 20 01 3C 50"
LIKE_A_VOLTAGE = BY_ID["trigger-record-that-begins-like-a-voltage"].hex


def objects(text: str) -> list[dict[str, object]]:
    return [json.loads(line) for line in text.splitlines()]


def test_asked_counts_until_the_host_is_heard(dps_s: Program) -> None:
    words = ["--json", "--asked", "cell_voltage", LIKE_A_VOLTAGE[:17], BY_ID["status-query"].hex, LIKE_A_VOLTAGE]
    assert [one["command"] for one in objects(dps_s(["decode", *words]).out)] == [
        "cell_voltage",
        "status",
        "trigger_records",
    ]


@pytest.mark.parametrize("name", ["not-there.hex", "no-folder/41", "folder"])
def test_a_file_that_cannot_be_read_is_named(
    name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, dps_s: Program
) -> None:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "folder").mkdir()
    assert dps_s(["decode", name], 2).err.startswith(f"{name} cannot be read: ")


def test_two_files_are_refused_and_neither_is_said_to_be_no_file(tmp_path: Path, dps_s: Program) -> None:
    files = [tmp_path / "a.txt", tmp_path / "b.txt"]
    for file in files:
        file.write_text(STATUS, encoding="utf-8")
    printed = dps_s(["decode", *map(str, files)], 2)
    assert printed.out == ""
    assert "expected 41 75 32, FILE, -" in printed.err


@pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="Windows has no such pipes")
def test_a_pipe_with_a_name_is_read(tmp_path: Path, dps_s: Program) -> None:
    """As in a shell: dps-s decode <(…)."""
    pipe = tmp_path / "pipe"
    os.mkfifo(pipe)
    writer = threading.Thread(target=pipe.write_text, args=(f"{STATUS}\n", "ascii"))
    writer.start()
    assert [one["hex"] for one in objects(dps_s(["decode", "--json", str(pipe)]).out)] == [STATUS]
    writer.join()


def test_standard_input_is_read_to_its_end(monkeypatch: pytest.MonkeyPatch, dps_s: Program) -> None:
    monkeypatch.setattr(sys, "stdin", io.StringIO(f"\ufeff{STATUS[:11]}\n{STATUS[11:]} {MISPRINT}"))
    assert [one["hex"] for one in objects(dps_s(["decode", "--json", "-"], 4).out)] == [STATUS, MISPRINT]


def test_bad_standard_input_is_refused_after_what_came_before(monkeypatch: pytest.MonkeyPatch, dps_s: Program) -> None:
    monkeypatch.setattr(sys, "stdin", io.StringIO(f"{STATUS}\nxyz\n{STATUS}\n"))
    printed = dps_s(["decode", "--json", "-"], 2)
    assert [one["hex"] for one in objects(printed.out)] == [STATUS]
    assert "xyz: neither hex nor a file" in printed.err


def test_binary_input_is_refused_in_a_sentence(monkeypatch: pytest.MonkeyPatch, dps_s: Program, tmp_path: Path) -> None:
    monkeypatch.setattr(sys, "stdin", io.TextIOWrapper(io.BytesIO(b"Au\xff\xfe"), encoding="utf-8"))
    assert "cannot be read: unknown kind of file" in dps_s(["decode", "-"], 2).err
    (tmp_path / "check.pdf").write_bytes(b"%PDF\xff\xfe")
    assert "cannot be read: unknown kind of file" in dps_s(["decode", str(tmp_path / "check.pdf")], 2).err


def test_lines_come_while_the_input_goes_on_and_a_closed_output_is_no_error() -> None:
    with running(*PROGRAM, "decode", "--json", "-") as decode:
        decode.told.write(f"{STATUS}\n")
        decode.told.flush()
        assert json.loads(decode.out.readline())["hex"] == STATUS  # the input is still open
        decode.out.close()
        decode.told.write(f"{STATUS}\n")
        decode.told.close()
        assert decode.errors.read() == ""
        assert decode.process.wait(timeout=PATIENCE_S) == 4

"""`dps-s decode`: the lines, the exit codes, and bytes as people write them."""

import io
import json
import sys
from pathlib import Path

import pytest

from tests.support.cli_line import Program
from tests.support.patience import PATIENCE_S
from tests.support.processes import PROGRAM, running
from tests.vendor.frames import BY_ID

pytest_plugins = ["tests.support.cli_fixtures"]

STATUS = "41 75 32 07 0A 00 01 44"
LIKE_A_VOLTAGE = BY_ID["trigger-record-that-begins-like-a-voltage"].hex


def objects(text: str) -> list[dict[str, object]]:
    return [json.loads(line) for line in text.splitlines()]


@pytest.mark.parametrize("name", ["not-there.hex", "no-folder/41", "folder"])
def test_a_file_that_cannot_be_read_is_named(
    name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, dps_s: Program
) -> None:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "folder").mkdir()
    assert dps_s(["decode", name], 2).err.startswith(f"{name} cannot be read: ")


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

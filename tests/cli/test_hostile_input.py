"""Malicious addresses, names and files are refused or shown as they are, in bounded time, and never obeyed."""

import json
import os
from datetime import UTC, datetime
from pathlib import Path
from types import SimpleNamespace

import pytest

from app import __main__ as program
from app.engine import ports as port_list
from app.engine.transport import PortError, PortTrouble, open_line
from app.settings.profiles import ProfileRefused, parse_profile
from app.system.files import write_whole
from app.terminal import console
from app.text.messages import visible, visible_json
from protocol.messages import Noise
from protocol.stream import StreamParser
from tests.support.processes import PROGRAM, ROOT, ran
from ui.files.file_dialogs import default_name

ESCAPE = "\x1b]0;owned\x07\x9b31m\u202e\u2066"
HUGE = ("1" + "0" * 4000, "0x" + "F" * 6000)


# Addresses


@pytest.mark.parametrize(
    "address",
    [
        "spy:///dev/null?file={file}",
        "SPY:///dev/null?file={file}",
        "alt:///dev/null?class=PosixPollSerial",
        "hwgrep://.",
        "cp2110://0001:004a:00",
        "nothing://x",
        "://",
        "capture://{file}",
        " capture://{file}",
    ],
)
@pytest.mark.promise("g")
def test_an_address_that_writes_files_or_loads_code_is_refused(
    address: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    file = tmp_path / "written"
    address = address.format(file=file)
    with pytest.raises(PortError) as refused:
        open_line(address, 115200)
    assert refused.value.trouble is PortTrouble.UNSUPPORTED
    assert program.main(["read", "--port", address]) == console.USAGE_ERROR
    said = capsys.readouterr().err
    assert said.count("\n") == 1
    assert "is no serial port" in said
    assert not file.exists()


@pytest.mark.promise("i")
def test_what_was_recorded_is_no_port(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    address = f"capture://{tmp_path}/flight.mcap?speed=5"
    for words in (
        ["read", "--port", address],
        ["monitor", "--port", address],
        ["record", "--port", address, str(tmp_path / "a.csv")],
        ["preflight", "--port", address, "--port", "sim://b"],
        ["activate", "--port", address, "--yes"],
        ["gui", "--port", address],
    ):
        assert program.main(words) == console.USAGE_ERROR
        assert "dps-s FILE opens a file" in capsys.readouterr().err
    monkeypatch.setenv("DPS_S_PORT", address)
    assert program.main(["read"]) == console.USAGE_ERROR
    assert list(tmp_path.iterdir()) == []


def test_addresses_that_lead_to_a_module_are_opened() -> None:
    for address in ("loop://", "sim://demo?lifelike"):
        open_line(address, 115200).close()
    with pytest.raises(PortError) as missing:
        open_line("rfc2217://127.0.0.1:1?timeout=0.2&ign_set_control", 115200)
    assert missing.value.trouble is PortTrouble.MISSING


# The list of ports


@pytest.mark.parametrize(
    "failing",
    ["raise SystemError('boom')", "return [object()]", "import time; time.sleep(10)"],
    ids=["error", "nonsense", "hangs"],
)
@pytest.mark.promise("k")
def test_a_failing_list_of_ports_is_reported_in_one_sentence(failing: str, tmp_path: Path) -> None:
    (tmp_path / "sitecustomize.py").write_text(
        f"import serial.tools.list_ports as one\ndef comports(*_a, **_k):\n    {failing}\none.comports = comports\n",
        encoding="utf-8",
    )
    path = os.pathsep.join((str(tmp_path), str(ROOT)))
    ended = ran(*PROGRAM, "ports", "--json", PYTHONPATH=path, LANGUAGE="en", LC_ALL="C.UTF-8")
    assert ended.returncode == console.NO_LINK, ended
    assert json.loads(ended.stdout)["error"]["code"] == "no_port"
    assert ended.stderr.strip() == port_list.NOT_LISTED


# What is printed


def test_control_characters_are_shown_and_not_obeyed() -> None:
    shown = visible(f"a{ESCAPE}\ud800\r\tb\n", keep="\n")
    assert shown == ("a[U+001B]]0;owned[U+0007][U+009B]31m[U+202E][U+2066][U+D800]  b\n")
    assert visible("M-07 伞仓 3.8 V …") == "M-07 伞仓 3.8 V …"
    text = visible_json(json.dumps({ESCAPE: ESCAPE}, ensure_ascii=False))
    assert text.isprintable()
    assert json.loads(text) == {ESCAPE: ESCAPE}


@pytest.mark.parametrize(
    "words",
    [
        ["decode", ESCAPE],
        ["read", "--port", f"spy://{ESCAPE}"],
        ["read", "--port", "loop://", "--baud", ESCAPE],
        ["set", f"freefall_time_s={ESCAPE}", "--port", "loop://"],
        ["preflight", "--port", "loop://", "--profile", f"/{ESCAPE}.toml"],
        ["verify", f"/{ESCAPE}"],
        ["simulate", f"--{ESCAPE}"],
        ["ports", f"--{ESCAPE}"],
        ["recordings", "export", ESCAPE, f"/nowhere/{ESCAPE}.csv"],
        [ESCAPE],
    ],
    ids=lambda words: words[0] if words[0].isprintable() else "no command",
)
@pytest.mark.promise("g")
def test_no_command_prints_typed_control_characters(words: list[str], capsys: pytest.CaptureFixture[str]) -> None:
    assert program.main(words) in (console.USAGE_ERROR, console.NO_LINK)
    printed = capsys.readouterr()
    both = (printed.out + printed.err).replace("\n", "")
    assert both
    assert both.isprintable(), both


def test_the_name_of_an_adapter_cannot_control_the_terminal(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    one = SimpleNamespace(device="/dev/ttyUSB0", product=ESCAPE, description=None, manufacturer=ESCAPE,
                          serial_number=ESCAPE, vid=1, pid=2, location="1-2")  # fmt: skip
    monkeypatch.setattr("serial.tools.list_ports.comports", lambda: [one])
    for words in ["ports"], ["ports", "--json"]:
        assert program.main(words) == 0
        assert capsys.readouterr().out.replace("\n", "").isprintable()


# Files


@pytest.mark.promise("g")
def test_nothing_is_written_through_the_link_of_another_user(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    victim, link = tmp_path / "victim", tmp_path / "link"
    victim.write_text("mine", encoding="utf-8")
    link.symlink_to(victim)
    write_whole(link, b"mine, too")
    assert victim.read_text(encoding="utf-8") == "mine, too"
    assert link.is_symlink()
    monkeypatch.setattr(os, "geteuid", lambda: link.lstat().st_uid + 1)
    write_whole(link, b"theirs")
    assert victim.read_text(encoding="utf-8") == "mine, too"


def test_a_name_of_82_chinese_characters_fits(tmp_path: Path) -> None:
    path = tmp_path / f"{'伞' * 82}.csv"
    write_whole(path, b"whole")
    assert path.read_bytes() == b"whole"
    assert [one.name for one in tmp_path.iterdir()] == [path.name]
    suggested = default_name("𠀀" * 300, ".mcap", datetime(2026, 1, 2, tzinfo=UTC))
    write_whole(tmp_path / suggested, b"whole")


@pytest.mark.parametrize("number", HUGE, ids=["decimal", "hexadecimal"])
@pytest.mark.parametrize(
    "line",
    [
        "[limits]\ntilt_max_deg = {}",
        "[settings]\nattitude_threshold_deg = {}",
        "[settings]\nattitude_trigger = {}",
        "format = {}",
    ],
)
@pytest.mark.promise("g")
def test_a_number_of_thousands_of_digits_is_refused_in_a_short_sentence(line: str, number: str) -> None:
    with pytest.raises(ProfileRefused) as refused:
        parse_profile(line.format(number).encode())
    assert len(refused.value.sentence) < 200


@pytest.mark.parametrize("header", [b"Au", b"Ba"])
def test_any_count_of_consecutive_headers_is_one_rejection(header: bytes) -> None:
    """Six megabytes of headers once took a minute, with a rejection for each."""
    data = header * 100_000
    whole, cut = StreamParser(), StreamParser()
    pieces = [*whole.feed(data), *whole.flush()]
    assert len(pieces) < 10
    again = [piece for first in range(0, len(data), 4097) for piece in cut.feed(data[first : first + 4097])]
    again += cut.flush()
    for found in pieces, again:
        assert b"".join(piece.raw for piece in found) == data
        assert all(isinstance(piece, Noise) for piece in found)

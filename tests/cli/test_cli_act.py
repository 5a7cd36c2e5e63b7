"""`dps-s activate | lock | zero | shutdown | fired`."""

import json
from pathlib import Path

import numpy as np
import pytest

import app.__main__ as program
from app.safety.journal import REQUESTS, Act, Outcome
from app.store.fact_store import open_file
from app.system.files import data_folder
from tests.files.records.test_record import signed_record
from tests.support.cli_line import Printed, Program, bench_of
from tests.support.flights import log_bytes as made
from tests.support.records.stored import audit, open_store

pytest_plugins = ["tests.support.cli_fixtures"]
pytestmark = pytest.mark.usefixtures("speaks_english", "no_waiting")
ACTS = {0x10, 0x11, 0x12, 0x24, 0x25}


def acts(wire: list[bytes]) -> list[bytes]:
    return [frame for frame in wire if frame[2] in ACTS]


def recorded() -> list[tuple[Act, Outcome]]:
    store = open_store()
    try:
        return [(entry.act, entry.outcome) for entry in audit(store)]
    finally:
        store.close()


@pytest.mark.parametrize("name", ["activate", "lock", "zero", "shutdown"])
def test_with_yes_it_is_done_once_and_recorded(name: str, port: str, dps_s: Program, wire: list[bytes]) -> None:
    options = {"lock": "?active=yes", "zero": "?tilt=4"}.get(name, "")
    assert dps_s([name, "--port", port + options, "--yes"]).out.startswith(("The module ", "Acknowledged"))
    assert acts(wire) == [REQUESTS[Act(name)].encode()]
    assert recorded() == [(Act(name), Outcome.CONFIRMED)]
    module = bench_of(port).module
    assert module.state.is_active is (name == "activate")
    assert module.is_on is (name != "shutdown")
    assert module.memory.zero_tilt_deg == (4 if name == "zero" else 0)


def test_without_a_store_only_locking_is_done(port: str, dps_s: Program, wire: list[bytes]) -> None:
    data_folder().parent.mkdir(parents=True)
    data_folder().write_text("in the way", encoding="utf-8")
    assert "The audit log cannot be written." in dps_s(["activate", "--port", port, "--yes"], 1).err
    assert acts(wire) == []
    assert program.main(["lock", "--port", port, "--yes"]) == 0
    assert acts(wire) == [REQUESTS[Act.LOCK].encode()]


@pytest.mark.parametrize(("module", "code"), [("?mute=yes", 3), ("?active=yes&mute_codes=10", 1)])
def test_lock_is_sent_before_anything_is_answered(
    module: str, code: int, port: str, dps_s: Program, wire: list[bytes]
) -> None:
    said = dps_s(["lock", "--port", port + module, "--yes"], code).err
    assert REQUESTS[Act.LOCK].encode() in wire[:2], "the link itself asks for the boot count when a port is opened"
    assert "not confirmed: treat the module as ACTIVE." in said


def test_lock_leaves_before_any_file_is_opened(
    port: str, dps_s: Program, wire: list[bytes], monkeypatch: pytest.MonkeyPatch
) -> None:
    sent: list[list[bytes]] = []

    def noted(path: Path) -> object:
        sent.append(wire.copy())
        return open_file(path)

    monkeypatch.setattr("app.store.fact_store.open_file", noted)
    dps_s(["lock", "--port", port])
    assert REQUESTS[Act.LOCK].encode() in sent[0]


# `dps-s verify`: its exit codes and its JSON.


def test_verify_says_intact_whoever_signed_and_altered(tmp_path: Path, dps_s: Program) -> None:
    path = tmp_path / "record.json"
    text = signed_record("worst").text
    path.write_text(text, encoding="utf-8")
    printed = dps_s(["verify", str(path)], 0).out
    assert printed.startswith("INTACT: NO-GO")
    assert "Signed by an unknown key" in printed
    told = json.loads(dps_s(["verify", str(path), "--json"], 0).out)
    assert (told["state"], told["verdict"], told["follows"], told["signed_by"]) == (
        "intact", "NO-GO", "NO-GO", "unknown_key",
    )  # fmt: skip
    path.write_text(text.replace("Li Wei", "Li Bo"), encoding="utf-8")
    assert dps_s(["verify", str(path)], 1).out.startswith("ALTERED")
    told = json.loads(dps_s(["verify", str(path), "--json"], 1).out)
    assert (told["state"], told["signed_by"], told["signer"]) == ("altered", "nobody", None)
    path.write_text("{}", encoding="utf-8")
    for words in (["verify", str(path)], ["verify", str(tmp_path / "none")], ["verify", "a\0b"]):
        printed_json = json.loads(dps_s([*words, "--json"], 2).out)
        assert printed_json["error"]["code"] == "unreadable"


TIMES = np.arange(500) / 50


@pytest.fixture
def calm(tmp_path: Path) -> Path:
    path = tmp_path / "calm.ulg"
    path.write_bytes(made.ulog_bytes(made.ulog_attitude(TIMES, 12.0) + made.ulog_force(TIMES, 1.0)))
    return path


@pytest.fixture
def crash(tmp_path: Path) -> Path:
    """Tips over after 4 s to 61.4°, falls for 2 s after 6 s, and hits the ground from 20 m."""
    path = tmp_path / "crash.bin"
    falls = (TIMES >= 6) & (TIMES < 8)
    force = np.select([falls, (TIMES >= 8) & (TIMES < 8.1)], [0.3, 9.0], 1.0)
    rows = made.dataflash_attitude(TIMES, np.where(TIMES >= 4, 61.4, 5.0)) + made.dataflash_force(TIMES, force)
    rows += made.dataflash_altitude(TIMES, 20 - 5 * np.clip(TIMES - 6, 0, 2) ** 2)
    path.write_bytes(made.dataflash_bytes(rows))
    return path


def fired(capsys: pytest.CaptureFixture[str], *words: object) -> tuple[int, Printed]:
    code = program.main(["fired", *map(str, words)])
    return code, Printed(capsys)


def test_json_is_the_contract(calm: Path, crash: Path, capsys: pytest.CaptureFixture[str]) -> None:
    code, printed = fired(capsys, calm, crash, "--json")
    first, second = map(json.loads, printed.out.splitlines())
    assert code == 4
    assert printed.err.startswith(
        "Judged with: attitude_threshold_deg=60 freefall_acceleration_g=0.5 freefall_time_s=1.6 "
    )
    assert first == {
        "log": str(calm), "fires": [], "tilt_max_deg": 12.0, "longest_fall_s": 0.0, "not_judged_s": 0.0, "problems": [],
        "answer": "does_not_fire",
    }  # fmt: skip
    assert second == {
        "log": str(crash),
        "fires": [
            {"t_s": 4.0, "source": "attitude", "tilt_deg": 61},
            {"t_s": 7.6, "source": "freefall", "tilt_deg": 61},
        ],
        "tilt_max_deg": 61.4,
        "longest_fall_s": 1.98,
        "not_judged_s": 0.0,
        "problems": [],
        "answer": "fires",
    }  # fmt: skip


def test_none_fires_with_other_thresholds(calm: Path, crash: Path, capsys: pytest.CaptureFixture[str]) -> None:
    words = ("--thresholds", "attitude_threshold_deg=62", "freefall_time_s=1.99", crash, calm)
    code, printed = fired(capsys, *words)
    assert code == 0
    assert "0 of 2 fire." in printed.out
    assert "Judged with: attitude_threshold_deg=62 freefall_acceleration_g=0.5 freefall_time_s=1.99 " in printed.out
    assert "Vendor defaults, not of a module: freefall_acceleration_g, attitude_trigger" in printed.out
    assert fired(capsys, crash, "--thresholds", "attitude_trigger=false", "freefall_trigger=false")[0] == 0
    assert fired(capsys, crash, "--thresholds", "attitude_trigger=false")[0] == 4


@pytest.mark.parametrize(("word", "hint"), [
    ("atitude_threshold_deg=62", " (did you mean attitude_threshold_deg?)"), ("light_threshold_v=1", ""),
])  # fmt: skip
def test_without_a_threshold_that_is_none_nothing_is_judged(
    crash: Path, capsys: pytest.CaptureFixture[str], word: str, hint: str
) -> None:
    code, printed = fired(capsys, crash, "--thresholds", word)
    assert code == 2
    assert printed.out == ""
    assert "expected attitude_threshold_deg|freefall_acceleration_g" in printed.err
    assert printed.err.rstrip().endswith(hint)
    named_alike = crash.with_name("a=b.ulg")
    named_alike.write_bytes(crash.read_bytes())
    assert fired(capsys, "--thresholds", "freefall_time_s=1.2", named_alike)[0] == 4  # a log all the same


def test_for_people(crash: Path, capsys: pytest.CaptureFixture[str]) -> None:
    code, printed = fired(capsys, crash, "--must")
    assert code == 4
    assert "at 4.00 s: attitude, 61°  " in printed.out
    assert "The vendor's defaults miss 0 of 1" in printed.out
    assert "1 of 1 fire." in printed.out


def test_what_cannot_be_read_is_said_and_the_others_are_judged(
    crash: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    bad = tmp_path / "bad.bin"
    bad.write_bytes(b"nothing")
    code, printed = fired(capsys, tmp_path, "--json")
    assert code == 4
    lines = [json.loads(line) for line in printed.out.splitlines()]
    assert [(line["log"], line["answer"]) for line in lines] == [(str(bad), "unreadable"), (str(crash), "fires")]
    assert lines[0]["fires"] is None
    assert lines[0]["problems"] == ["no column names in the first line."]
    assert f"\n{bad}: no column names in the first line.\n" in printed.err
    crash.unlink()
    assert fired(capsys, tmp_path, "--json")[0] == 2


def test_a_log_that_holds_too_little_is_not_judged(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """Without acceleration nobody knows of a fall; where it fires all the same, it fires."""
    path = tmp_path / "tilt.csv"
    path.write_text("time_s,tilt_deg\n" + "".join(f"{row / 10},20\n" for row in range(100)), encoding="utf-8")
    code, printed = fired(capsys, path, "--json")
    line = json.loads(printed.out)
    assert (code, line["answer"], line["fires"]) == (2, "not_judged", None)
    assert line["not_judged_s"] == pytest.approx(9.9)
    assert "1 of 1 not judged." in fired(capsys, path)[1].out
    assert fired(capsys, path, "--thresholds", "freefall_trigger=false")[0] == 0
    assert fired(capsys, path, "--thresholds", "attitude_threshold_deg=15")[0] == 4

"""`dps-s fired`: what it prints and how it ends."""

import json
from pathlib import Path

import numpy as np
import pytest

import app.__main__ as program
from tests.support.cli_line import Printed
from tests.support.flights import log_bytes as made

pytest_plugins = ["tests.support.cli_fixtures"]
pytestmark = pytest.mark.usefixtures("speaks_english")

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
    }  # fmt: skip


def test_none_fires_with_other_thresholds(calm: Path, crash: Path, capsys: pytest.CaptureFixture[str]) -> None:
    words = ("--thresholds", "attitude_threshold_deg=62", "freefall_time_s=1.99", crash, calm)
    code, printed = fired(capsys, *words)
    assert code == 0
    assert "0 of 2 would have fired." in printed.out
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


def test_a_difference_between_the_readings_is_said(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = tmp_path / "swing.ulg"
    swing = np.where((TIMES >= 4) & (TIMES < 4.1), 70.0, 0.0)
    path.write_bytes(made.ulog_bytes(made.ulog_attitude(TIMES, swing) + made.ulog_force(TIMES, 1.0)))
    code, printed = fired(capsys, path, "--json")
    assert code == 4
    (problem,) = json.loads(printed.out)["problems"]
    assert problem.startswith("angle lasts 0.2 s, ")
    assert problem.endswith(": would not fire.")


def test_for_people(crash: Path, capsys: pytest.CaptureFixture[str]) -> None:
    code, printed = fired(capsys, crash, "--must")
    assert code == 4
    assert "at 4.00 s: attitude, 61°; 0.02 s after the loss of control, 0 m lower" in printed.out
    assert "after the impact" not in printed.out
    assert "Proposal: attitude_threshold_deg=" in printed.out
    assert "1 of 1 would have fired." in printed.out


def test_a_proposal_for_flights_that_must_not_fire(calm: Path, crash: Path, capsys: pytest.CaptureFixture[str]) -> None:
    _, printed = fired(capsys, calm, crash, "--must-not")
    proposed = printed.out.partition("Proposal: ")[2].splitlines()[0].split()
    assert fired(capsys, calm, crash, "--thresholds", *proposed)[0] == 0
    _, printed = fired(capsys, calm, crash, "--must-not", "--json")
    assert len(printed.out.splitlines()) == 2
    assert "Proposal: " in printed.err


def test_what_cannot_be_read_is_said_and_the_others_are_judged(
    calm: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    bad = tmp_path / "bad.bin"
    bad.write_bytes(b"nothing")
    code, printed = fired(capsys, tmp_path, "--json")
    assert code == 2
    assert [json.loads(line)["log"] for line in printed.out.splitlines()] == [str(calm)]
    assert printed.err.endswith(f"\n{bad}: unknown kind of file.\n")


def test_a_csv_file_with_chosen_columns(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = tmp_path / "a.csv"
    path.write_text("when,angle\n" + "".join(f"{n / 50},{n % 100}\n" for n in range(200)), encoding="utf-8")
    code, printed = fired(capsys, path, "--column", "time_s=when", "--column", "tilt_deg=angle", "--json")
    assert code == 4
    assert [one["t_s"] for one in json.loads(printed.out)["fires"]] == [1.2, 3.2]

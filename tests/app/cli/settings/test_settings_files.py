"""Settings as a file: saved, compared, shown before they are written."""

import json
from pathlib import Path

import pytest

from app.settings.profile_file import read_profile
from tests.support.cli_line import bench_of, run_here

pytest_plugins = ["tests.support.cli_fixtures"]
pytestmark = pytest.mark.usefixtures("speaks_english")


def test_what_is_saved_says_its_origin_and_can_be_written_again(
    port: str, tmp_path: Path, capsys: pytest.CaptureFixture[str], wire: list[bytes]
) -> None:
    path = tmp_path / "M-07.toml"
    run_here(capsys, ["save", "-p", port, str(path), "--module", "M-07"])
    assert not [frame for frame in wire if frame[3] == 0x02]
    text = path.read_text(encoding="utf-8")
    shown = json.loads(run_here(capsys, ["read", "-p", port, "--json"]).out)
    for line in (f"# Port: {port}, 115200 baud", f"# Boot count: {shown['boot_count']}", "# SIMULATED MODULE",
                 "# Settings code: ", "# attitude_trigger: cannot be read"):  # fmt: skip
        assert line in text
    profile = read_profile(path)
    assert profile.name == "M-07"
    assert profile.settings == {key: value for key, value in shown["settings"].items() if value is not None}
    assert "unchanged" in run_here(capsys, ["set", "--profile", str(path), "-p", port, "--dry-run"]).out
    assert run_here(capsys, ["save", "-p", port, "-"]).out.endswith(text[text.index("[settings]") :])


def test_a_file_is_replaced_only_with_force(port: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = tmp_path / "a.toml"
    path.write_text("precious", encoding="utf-8")
    assert "--force" in run_here(capsys, ["save", "-p", port, str(path)], 2).err
    assert path.read_text(encoding="utf-8") == "precious"
    run_here(capsys, ["save", "-p", port, str(path), "--force"])
    assert read_profile(path).settings


def test_a_setting_that_is_not_read_is_left_out_and_said(
    port: str, hasty: None, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = tmp_path / "a.toml"
    port = f"{port}?mute_codes=22"
    assert "freefall_time_s" in run_here(capsys, ["save", "-p", port, str(path)], 4).err
    assert "freefall_time_s" not in read_profile(path).settings
    assert "# freefall_time_s: no reply" in path.read_text(encoding="utf-8")
    shown = run_here(capsys, ["set", "freefall_time_s=1.4", "--dry-run", "-p", port], 4).out
    assert shown == "freefall_time_s  unknown → 1.4: not written (dry run)\n"
    profile = tmp_path / "b.toml"
    profile.write_text("freefall_time_s = 1.6\nattitude_threshold_deg = 60\n", encoding="utf-8")
    assert run_here(capsys, ["diff", str(profile), "-p", port], 4).out.splitlines()[1:] == [
        f"freefall_time_s  1.6{' ' * (len(str(profile)) - 3)}  unknown"
    ]


def test_a_dry_run_writes_nothing(port: str, capsys: pytest.CaptureFixture[str], wire: list[bytes]) -> None:
    words = ["set", "freefall_time_s=1.4", "light_threshold_v=1.8", "attitude_trigger=true", "-p", port, "--dry-run"]
    assert run_here(capsys, words).out.splitlines() == [
        "freefall_time_s    1.6 → 1.4: not written (dry run)",
        "light_threshold_v  1.8: unchanged",
        "attitude_trigger   unknown → true: not written (dry run)",
    ]
    shown = json.loads(run_here(capsys, [*words, "--json"]).out)["results"]
    assert (shown["freefall_time_s"]["before"], shown["freefall_time_s"]["wanted"]) == (1.6, 1.4)
    assert shown["freefall_time_s"]["verified"] is None
    assert not [frame for frame in wire if frame[3] == 0x02]
    assert bench_of(port).module.memory.freefall_time == 160


def test_differences(port: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    one, other = tmp_path / "1.toml", tmp_path / "2.toml"
    one.write_text("freefall_time_s = 1.6\n", encoding="utf-8")
    other.write_text("freefall_time_s = 1.4\nattitude_trigger = true\n", encoding="utf-8")
    assert run_here(capsys, ["diff", str(one), "-p", port]).out == "The settings are equal.\n"
    assert run_here(capsys, ["diff", str(one), str(one)]).out == "The settings are equal.\n"
    rows = [line.split() for line in run_here(capsys, ["diff", str(one), str(other)], 1).out.splitlines()]
    assert rows == [[str(one), str(other)], ["freefall_time_s", "1.6", "1.4"], ["attitude_trigger", "–", "true"]]
    shown = json.loads(run_here(capsys, ["diff", str(other), "-p", port, "--json"], 1).out)
    assert shown == {"differences": {"freefall_time_s": [1.4, 1.6], "attitude_trigger": [True, None]}}
    run_here(capsys, ["diff", str(one), str(other), "-p", port], 2)
    run_here(capsys, ["diff", str(tmp_path / "none.toml"), "-p", port], 2)

"""The bundle on a system with neither Python nor Qt."""

import json
import re
import shutil
import sys
from pathlib import Path

import numpy as np
import pytest

from app.cli.commands import ENTRIES
from tests.support.flights import log_bytes as made
from tests.system.packages.programs import ROOT, Program, check_reading, check_window, simulated

LARGEST_MB = 240


def test_it_says_the_one_version(program: Program, version: str) -> None:
    done = program.run("--version")
    assert (done.returncode, done.stdout) == (0, f"DPS-S Configurator {version}\n")


def test_the_window_comes_up_and_shows_the_simulated_module(program: Program, tmp_path: Path) -> None:
    check_window(program, tmp_path / "evidence")


def test_one_process_reads_what_another_simulates(program: Program) -> None:
    check_reading(program)


def test_every_command_is_there(program: Program) -> None:
    """Creating the completion script imports the modules of all commands in one process."""
    script = program.run("completion", "bash")
    assert script.returncode == 0, script.stderr
    assert [entry.name for entry in ENTRIES if entry.name not in script.stdout] == []


def test_a_check_leaves_a_report_that_can_be_verified(program: Program, tmp_path: Path) -> None:
    report = tmp_path / "check.pdf"
    with simulated(program, "--cell", "4.1") as port:
        done = program.run("preflight", "--port", port, "--enable-triggers", "--report", str(report))
    assert done.returncode in (0, 1), done.stderr
    assert report.read_bytes().startswith(b"%PDF-")
    verified = program.run("verify", str(report))
    assert verified.returncode == 0, verified.stdout


def test_it_records(program: Program, tmp_path: Path) -> None:
    done = program.run("record", "--port", "sim://", "--seconds", "1", str(tmp_path / "session.mcap"))
    assert done.returncode == 0, done.stderr
    assert (tmp_path / "session.mcap").read_bytes().startswith(b"\x89MCAP")


def test_it_speaks_chinese(program: Program) -> None:
    done = program.run("ports", LC_ALL=None, LANG="zh_CN.UTF-8", LANGUAGE="zh_CN", PYTHONUTF8="1")
    assert "串口" in done.stdout


def test_it_judges_flight_logs(program: Program, tmp_path: Path) -> None:
    times = np.arange(0, 5, 0.05)
    names = ["0.ulg", "1.ulg"]
    for name in names:
        (tmp_path / name).write_bytes(made.ulog_bytes(times, 12 * times, 1.0))
    done = program.run("fired", str(tmp_path), "--thresholds", "attitude_threshold_deg=55", "--json")
    assert done.returncode == 4, done.stderr
    said = [json.loads(line) for line in done.stdout.splitlines()]
    assert [Path(one["log"]).name for one in said] == names
    assert all(one["fires"][0]["source"] == "attitude" for one in said)


def test_it_can_ask_an_archive_server(program: Program) -> None:
    done = program.run("archive", "sync", "postgresql://li@127.0.0.1:1/dps_s?sslrootcert=system")
    assert done.returncode == 3
    assert "Connection refused" in done.stderr, "PostgreSQL's library is not inside"


def test_every_file_of_the_program_that_is_no_module_is_inside(bundle: Path) -> None:
    internal = bundle / "_internal" if sys.platform != "darwin" else bundle.parent / "Resources"
    for top in ("app", "ui"):
        for path in (ROOT / top).rglob("*"):
            if path.is_file() and path.suffix not in (".py", ".pyc") and path.name != "py.typed":
                place = internal / path.relative_to(ROOT)
                assert place.read_bytes() == path.read_bytes(), place


def test_nothing_that_is_not_used_makes_it_large(bundle: Path) -> None:
    files = [path for path in bundle.rglob("*") if path.is_file() and not path.is_symlink()]
    assert sum(path.stat().st_size for path in files) < LARGEST_MB * 1e6
    unused = re.compile(r"Qt6?(Qml|Quick|Network|Pdf|WebEngine|Sql|Designer)|tcl|tk8|readline")
    assert [path.name for path in files if unused.search(path.name)] == []


def test_whose_works_it_brings_is_told(bundle: Path, dist: Path, version: str) -> None:
    papers = bundle if sys.platform != "darwin" else bundle.parent / "Resources"
    notices = (papers / "NOTICES.txt").read_text(encoding="utf-8")
    for name in ("Python", "Qt", "numpy", "pyserial", "cryptography", "psycopg-binary", "mcap"):
        assert f"\n{name}" in notices, name
    assert "pytest" not in notices
    assert {"GPL-3.0.txt", "LGPL-3.0.txt"} == {path.name for path in (papers / "licences").iterdir()}
    listed = json.loads((papers / "sbom.cdx.json").read_text(encoding="utf-8"))
    assert listed == json.loads(next(dist.glob("*.cdx.json")).read_text(encoding="utf-8"))
    assert listed["metadata"]["component"]["version"] == version
    names = {component["name"] for component in listed["components"]}
    assert {"PySide6_Essentials", "numpy", "pyserial", "mcap", "psycopg"} <= names
    assert not {"pytest", "mypy", "setuptools", "pip"} & names


@pytest.mark.filterwarnings("ignore:Python 3.14 will:DeprecationWarning")  # its filter is there since 3.11.4
def test_the_packed_bundle_starts(bundle: Path, dist: Path, tmp_path: Path, version: str) -> None:
    if sys.platform == "darwin":
        assert next(dist.glob("*.dmg")).stat().st_size > 1e7
        return
    packed = next(path for path in dist.iterdir() if path.name in (f"{bundle.name}.zip", f"{bundle.name}.tar.gz"))
    shutil.unpack_archive(packed, tmp_path)
    command = tmp_path / bundle.name / ("dps-s.exe" if sys.platform == "win32" else "dps-s")
    done = Program((str(command),), tmp_path / "home").run("--version")
    assert done.stdout.strip().endswith(version)

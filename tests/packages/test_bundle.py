"""The bundle on a system with neither Python nor Qt."""

import hashlib
import json
import os
import re
import shutil
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from cyclonedx.schema import SchemaVersion
from cyclonedx.validation.json import JsonStrictValidator
from mcap.reader import make_reader

from app.cli.commands import ENTRIES
from app.engine import ports
from app.flights.many_logs import FEW_LOGS
from app.recordings.library import recordings_folder
from tests.packages.programs import ROOT, Program, check_reading, check_window, simulated
from tests.support.flights import log_bytes as made
from tests.support.records.recordings_made import recorded

LARGEST_MB = 205
INSIDE = ("mcap.reader", "mcap.writer", "psycopg", "zstandard", "lz4.frame", "app.cli.preflight", "ui.pages.live.page")
OUTSIDE = ("PySide6.QtNetwork", "PySide6.QtQml", "PySide6.QtTest", "pytest", "pyqtgraph.opengl", "readline")


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
    assert [entry.name for entry in ENTRIES if f"_{entry.name}_option_strings=" not in script.stdout] == []
    told = program.run(ENTRIES[1].name, "--help")
    assert (told.returncode, f"dps-s {ENTRIES[1].name}" in told.stdout) == (0, True)


def test_a_check_leaves_a_report_that_can_be_verified(program: Program, tmp_path: Path) -> None:
    report = tmp_path / "check.pdf"
    with simulated(program, "--cell", "4.1") as port:
        done = program.run("preflight", "--port", port, "--enable-triggers", "--report", str(report))
    assert done.returncode in (0, 1), done.stderr
    assert report.read_bytes().startswith(b"%PDF-")
    verified = program.run("verify", str(report))
    assert verified.returncode == 0, verified.stdout
    assert "INTACT" in verified.stdout


def test_it_speaks_chinese(program: Program) -> None:
    done = program.run("--help", LC_ALL=None, LANG="zh_CN.UTF-8", LANGUAGE="zh_CN", PYTHONUTF8="1")
    assert "串口" in done.stdout


def test_listing_the_ports_in_a_process_of_its_own(
    program: Program, bundle: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(sys, "frozen", True, raising=False)
    window = "dps-s-window.exe" if sys.platform == "win32" else "dps-s"
    monkeypatch.setattr(sys, "executable", str(bundle / window))
    assert ports._scan_in_process(60) == ports.scan()


def test_flight_logs_are_read_in_processes_of_its_own(program: Program, tmp_path: Path) -> None:
    times = np.arange(0, 5, 0.05)
    rows = made.ulog_attitude(times, 12 * times) + made.ulog_force(times, 1.0)
    names = [f"{number}.ulg" for number in range(2 * FEW_LOGS)]
    for name in names:
        (tmp_path / name).write_bytes(made.ulog_bytes(rows))
    done = program.run("fired", str(tmp_path), "--thresholds", "attitude_threshold_deg=55", "--json")
    assert done.returncode == 4, done.stderr
    assert done.stderr.startswith("Judged with: attitude_threshold_deg=55 ")
    said = [json.loads(line) for line in done.stdout.splitlines()]
    assert [Path(one["log"]).name for one in said] == names
    assert all(one["fires"][0]["source"] == "attitude" for one in said)


def test_mcap_and_its_compressions_are_inside(bundle: Path) -> None:
    archive = bundle / ("dps-s.exe" if sys.platform == "win32" else "dps-s")
    viewer = [sys.executable, "-m", "PyInstaller.utils.cliutils.archive_viewer", "--list", "--recursive", "--brief"]
    listed = subprocess.run([*viewer, str(archive)], capture_output=True, text=True, check=True).stdout
    modules = {line.strip() for line in listed.splitlines()}
    assert set(INSIDE) <= modules
    assert not modules & set(OUTSIDE)
    internal = bundle / "_internal" if sys.platform != "darwin" else bundle.parent / "Frameworks"
    assert list(internal.glob("zstandard/backend_c*"))
    assert list(internal.glob("lz4/frame/_frame*"))


def test_it_can_ask_an_archive_server(program: Program) -> None:
    done = program.run("archive", "sync", "postgresql://li:secret@127.0.0.1:1/dps_s?sslrootcert=system")
    assert done.returncode == 3
    assert "Connection refused" in done.stderr, "PostgreSQL's library is not inside"
    assert "secret" not in done.stderr


def test_every_file_of_the_program_that_is_no_module_is_inside(bundle: Path) -> None:
    internal = bundle / "_internal" if sys.platform != "darwin" else bundle.parent / "Resources"
    for top in ("app", "ui"):
        for path in (ROOT / top).rglob("*"):
            if path.is_file() and path.suffix not in (".py", ".pyc") and path.name != "py.typed":
                place = internal / path.relative_to(ROOT)
                assert place.read_bytes() == path.read_bytes(), place


def test_a_recording_becomes_mcap(program: Program, tmp_path: Path) -> None:
    recorded(recordings_folder())
    target = tmp_path / "session.mcap"
    homes = {name: value for name, value in os.environ.items() if name.startswith(("HOME", "XDG_DATA", "WIN_PD_"))}
    done = program.run("recordings", "export", "latest", str(target), **homes)
    assert done.returncode == 0, done.stderr
    with target.open("rb") as file:
        topics = {channel.topic for _, channel, _ in make_reader(file).iter_messages()}
    assert {"/status", "/line/rx"} <= topics


def test_nothing_that_is_not_used_makes_it_large(bundle: Path) -> None:
    files = [path for path in bundle.rglob("*") if path.is_file() and not path.is_symlink()]
    assert sum(path.stat().st_size for path in files) < LARGEST_MB * 1e6
    unused = re.compile(r"Qt6?(Qml|Quick|Network|Pdf|WebEngine|Sql|Designer)|tcl|tk8")
    assert [path.name for path in files if unused.search(path.name)] == []


def test_nothing_names_the_machine_that_built_it(bundle: Path) -> None:
    """No file contains a path of this checkout, its .venv or its Python, except Python's compiled library."""
    folders = {str(ROOT).encode(), sys.prefix.encode(), sys.base_prefix.encode()} - {b"/usr", b"/usr/local"}
    files = [path for path in bundle.rglob("*") if path.is_file() and not path.name.startswith("libpython3")]
    assert [path.name for path in files if any(folder in path.read_bytes() for folder in folders)] == []


def test_everything_in_it_is_listed_with_its_licence(bundle: Path, dist: Path, version: str) -> None:
    papers = bundle if sys.platform != "darwin" else bundle.parent / "Resources"
    listed = json.loads((papers / "sbom.cdx.json").read_text(encoding="utf-8"))
    assert (papers / "sbom.cdx.json").read_bytes() == next(dist.glob("*.cdx.json")).read_bytes()
    assert listed["metadata"]["component"]["version"] == version
    assert JsonStrictValidator(SchemaVersion.V1_6).validate_str(json.dumps(listed)) is None
    names = {component["name"] for component in listed["components"]}
    assert {"CPython", "Qt", "PySide6_Essentials", "shiboken6", "numpy", "pyqtgraph", "pyserial", "mcap"} <= names
    assert {"HarfBuzz-NG", "LibPNG", "PCRE2", "OpenBLAS", "LAPACK", "OpenSSL", "psycopg", "libpq"} <= names
    assert not {"pytest", "mypy", "hypothesis", "setuptools", "pip"} & names
    stated = {"licences/dps-s-configurator"}
    for component in listed["components"]:
        assert component["licenses"], component["name"]
        properties = {one["name"]: one["value"] for one in component["properties"]}
        folder = properties["dps-s:licence-texts"]
        texts = [path.read_bytes() for path in (papers / folder).iterdir() if path.is_file()]
        assert texts, f"{component['name']} has no licence text"
        assert all(text.strip() for text in texts)
        stated.add(folder)
    folders = {
        path.parent.relative_to(papers).as_posix() for path in (papers / "licences").rglob("*") if path.is_file()
    }
    assert folders == stated


def test_the_sums_in_the_list_are_those_of_the_files(bundle: Path) -> None:
    papers = bundle if sys.platform != "darwin" else bundle.parent / "Resources"
    internal = bundle / "_internal" if sys.platform != "darwin" else bundle.parent / "Frameworks"
    listed = json.loads((papers / "sbom.cdx.json").read_text(encoding="utf-8"))
    files = [file for component in listed["components"] for file in component.get("components", [])]
    for file in files:
        content = (internal / file["name"]).read_bytes()
        assert hashlib.sha256(content).hexdigest() == file["hashes"][0]["content"], file["name"]
    names = {file["name"] for file in files}
    libraries = {path for path in internal.rglob("*.so*") if not path.is_symlink()}
    assert {path.relative_to(internal).as_posix() for path in libraries} <= names


@pytest.mark.filterwarnings("ignore:Python 3.14 will:DeprecationWarning")  # its filter is there since 3.11.4
def test_the_packed_bundle_is_the_folder(bundle: Path, dist: Path, tmp_path: Path, version: str) -> None:
    if sys.platform == "darwin":
        packed = next(dist.glob("*.dmg"))
        assert packed.stat().st_size > 1e7
        return
    packed = next(path for path in dist.iterdir() if path.name.startswith(bundle.name) and _is_archive(path))
    shutil.unpack_archive(packed, tmp_path)
    unpacked = tmp_path / bundle.name
    assert _names(unpacked) == _names(bundle)
    done = Program((str(unpacked / ("dps-s.exe" if sys.platform == "win32" else "dps-s")),), tmp_path / "home").run(
        "--version"
    )
    assert done.stdout.strip().endswith(version)


def _is_archive(path: Path) -> bool:
    return path.name.endswith((".tar.gz", ".zip"))


def _names(folder: Path) -> set[str]:
    return {path.relative_to(folder).as_posix() for path in folder.rglob("*")}

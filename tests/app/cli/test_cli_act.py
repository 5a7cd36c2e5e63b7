"""`dps-s activate | lock | zero | shutdown`: nothing without --yes, refused while a condition is open, recorded."""

from contextlib import closing
from pathlib import Path

import pytest

import app.__main__ as program
from app.records.record import Record, as_text
from app.safety.acts import REQUESTS, Act
from app.safety.journal import Outcome
from app.stations.station import fingerprint_of
from app.store.database import FILE_NAME
from app.store.store import open_store
from app.system.folders import data_folder
from tests.app.records.test_filing import FRAME, file_one
from tests.app.records.test_record import checked_record
from tests.support.cli_line import bench_of, run_here
from tests.support.records.kept_facts import tamper
from tests.support.records.stations_made import station

pytest_plugins = ["tests.support.cli_fixtures"]
pytestmark = pytest.mark.usefixtures("speaks_english")
ACTS = {0x10, 0x11, 0x12, 0x24, 0x25}


def acts(wire: list[bytes]) -> list[bytes]:
    return [frame for frame in wire if frame[2] in ACTS]


def recorded() -> list[tuple[Act, Outcome]]:
    store = open_store()
    try:
        return [(entry.act, entry.outcome) for entry in store.audit()]
    finally:
        store.close()


@pytest.mark.parametrize("name", ["activate", "lock", "zero", "shutdown"])
def test_with_yes_it_is_done_once_and_recorded(
    name: str, port: str, capsys: pytest.CaptureFixture[str], wire: list[bytes]
) -> None:
    options = {"lock": "?active=yes", "zero": "?tilt=4"}.get(name, "")
    assert run_here(capsys, [name, "--port", port + options, "--yes"]).out.startswith(("The module ", "Acknowledged"))
    assert acts(wire) == [REQUESTS[Act(name)].encode()]
    assert recorded() == [(Act(name), Outcome.CONFIRMED)]
    module = bench_of(port).module
    assert module.state.is_active is (name == "activate")
    assert module.is_on is (name != "shutdown")
    assert module.memory.zero_tilt_deg == (4 if name == "zero" else 0)


def test_without_a_store_only_locking_is_done(port: str, capsys: pytest.CaptureFixture[str], wire: list[bytes]) -> None:
    data_folder().parent.mkdir(parents=True)
    data_folder().write_text("in the way", encoding="utf-8")
    assert "The audit log cannot be written." in run_here(capsys, ["activate", "--port", port, "--yes"], 1).err
    assert acts(wire) == []
    assert program.main(["lock", "--port", port, "--yes"]) == 0
    assert acts(wire) == [REQUESTS[Act.LOCK].encode()]


# `dps-s verify`: its exit codes, whose signatures it believes, and the audit log.


@pytest.fixture
def record(tmp_path: Path) -> Path:
    """Of a station that is not known."""
    return _written(tmp_path / "record.json", checked_record("worst"))


def _written(path: Path, record: Record) -> Path:
    path.write_text(as_text(record), encoding="utf-8")
    return path


def test_a_station_is_believed_by_its_fingerprint_until_it_is_forgotten(
    record: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    fingerprint = fingerprint_of(station().public)
    assert program.main(["verify", str(record)]) == 1
    out = capsys.readouterr().out
    assert out.startswith("UNKNOWN STATION")
    assert fingerprint in out
    assert program.main(["verify", str(record), "--trust", "0000-0000-0000-0000-0000"]) == 1
    assert "Not trusted" in capsys.readouterr().err
    assert program.main(["verify", str(record)]) == 1
    capsys.readouterr()
    assert program.main(["verify", str(record), "--trust", fingerprint.lower(), "--name", "Hangar 2"]) == 0
    assert capsys.readouterr().out.startswith("INTACT: NO-GO, signed by Hangar 2.")
    assert program.main(["verify", str(record)]) == 0
    capsys.readouterr()
    assert program.main(["verify", "--stations"]) == 0
    first, second = capsys.readouterr().out.splitlines()
    assert first.endswith("  this computer")
    assert second == f"{fingerprint}  Hangar 2"
    assert program.main(["verify", "--revoke", fingerprint]) == 0
    assert capsys.readouterr().err == f"{fingerprint}  Hangar 2\n"
    assert program.main(["verify", str(record)]) == 1
    assert capsys.readouterr().out.startswith("REVOKED STATION: signed by Hangar 2,")
    assert program.main(["verify", "--stations"]) == 0
    assert capsys.readouterr().out.splitlines()[1] == f"{fingerprint}  Hangar 2 (revoked)"
    assert program.main(["verify", "--forget", fingerprint]) == 0
    assert program.main(["verify", "--forget", fingerprint]) == 1
    assert program.main(["verify", str(record)]) == 1


def test_no_station_is_taken_over_from_what_is_altered_or_not_signed(
    record: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    fingerprint = fingerprint_of(station().public)
    altered = _written(record, {**checked_record("worst"), "verdict": "GO"})
    assert program.main(["verify", str(altered), "--trust", fingerprint]) == 1
    unsigned = _written(record, {**checked_record("worst"), "signature": ""})
    assert program.main(["verify", str(unsigned), "--trust", fingerprint]) == 1
    capsys.readouterr()
    program.main(["verify", "--stations"])
    assert len(capsys.readouterr().out.splitlines()) == 1


def test_this_computers_own_records_are_intact(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    with closing(open_store()) as store:
        own = file_one(store, "M-07").record
    assert program.main(["verify", str(_written(tmp_path / "own.json", own))]) == 0
    assert "signed by this computer." in capsys.readouterr().out


def test_the_audit_log_is_verified(capsys: pytest.CaptureFixture[str]) -> None:
    assert program.main(["verify", "--log"]) == 2
    assert "No audit log." in capsys.readouterr().err
    assert not data_folder().exists()
    with closing(open_store()) as store:
        for _ in range(3):
            store.begin(Act.LOCK, FRAME, {}, port="p", origin="window")
    assert program.main(["verify", "--log"]) == 0
    assert "intact; entries: 3" in capsys.readouterr().out
    tamper(data_folder() / FILE_NAME, "DELETE FROM facts WHERE number = 2")
    assert program.main(["verify", "--log"]) == 1
    assert capsys.readouterr().out == "Entry 2 was removed.\n"


def test_an_audit_log_that_cannot_be_opened_is_not_said_to_be_none(capsys: pytest.CaptureFixture[str]) -> None:
    (data_folder() / FILE_NAME).mkdir(parents=True)
    assert program.main(["verify", "--log"]) == 2
    said = capsys.readouterr().err
    assert FILE_NAME in said
    assert "No audit log." not in said

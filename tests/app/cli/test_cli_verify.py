"""`dps-s verify`: its exit codes, whose signatures it believes, and the audit log."""

from contextlib import closing
from pathlib import Path

import pytest

from app import __main__ as program
from app.records.record import Record, as_text
from app.safety.acts import Act
from app.stations.station import fingerprint_of
from app.store.database import FILE_NAME
from app.store.store import data_folder, open_store
from tests.app.records.test_filing import FRAME, file_one
from tests.app.records.test_record import checked_record
from tests.support.records.kept_facts import tamper
from tests.support.records.stations_made import station


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
    assert not data_folder().exists()
    with closing(open_store()) as store:
        for _ in range(3):
            store.begin(Act.LOCK, FRAME, {}, port="p", origin="window")
    assert program.main(["verify", "--log"]) == 0
    assert "intact; entries: 3" in capsys.readouterr().out
    tamper(data_folder() / FILE_NAME, "DELETE FROM facts WHERE number = 2")
    assert program.main(["verify", "--log"]) == 1
    assert capsys.readouterr().out == "Entry 2 was removed.\n"


@pytest.mark.parametrize("words", [[], ["x", "--log"], ["--log", "--stations"], ["--trust", "x"]])
def test_what_does_not_go_together_is_used_wrongly(words: list[str], capsys: pytest.CaptureFixture[str]) -> None:
    assert program.main(["verify", *words]) == 2
    assert "--trust" in capsys.readouterr().err

"""Forgeries made with the program's own functions are never called intact."""

import json
import sys
from collections.abc import Mapping
from contextlib import closing
from pathlib import Path
from typing import Any
from zipfile import ZipFile

import pytest

from app.records.check_store import KeptRecords
from app.records.record import Record, as_text, seal
from app.records.report_html import body
from app.records.verification import (
    CONTENT,
    REQUIRED,
    SIGNATURE,
    Chain,
    RecordState,
    Verification,
    contradictions,
    verdict_from,
    verify,
    verify_bytes,
)
from app.stations.known import KNOWN_FILE, KnownStation, Stations
from app.stations.station import KEY_FILE, encoded, fingerprint_of, own_station
from app.store.store import open_store
from app.text.i18n import set_language
from app.text.user_error import UserError
from tests.app.records.test_filing import file_one
from tests.app.records.test_record import checked_record
from tests.support.processes import ran_code
from tests.support.records.stations_made import find_station, station


def _copy(record: Mapping[str, object]) -> Any:
    return json.loads(as_text(record))


def _passed(record: Record) -> Any:
    """A forged copy in which every check passes."""
    forged = _copy(record)
    for one in forged["checks"]:
        one["result"] = "pass"
    return forged


def _signed(kind: str = "go", **circumstances: Any) -> Record:
    return checked_record(kind, **circumstances)


def _verified(record: Mapping[str, object]) -> Verification:
    return verify(record, find_station=find_station)


def _words(verification: Verification) -> str:
    return " ".join(sentence.translated() for sentence in verification.sentences())


# The forgeries


def test_a_no_go_record_that_was_sealed_again_as_go_contradicts_itself() -> None:
    forged = seal({**_signed("worst"), "verdict": "GO"})
    assert SIGNATURE in _verified(forged).altered
    unsigned = seal({**_signed("worst"), "verdict": "GO", "station": None})
    found = _verified(unsigned)
    assert found.state is RecordState.CONTRADICTORY
    assert "stated GO, but the checks give NO-GO" in _words(found)
    assert _words(found).startswith("CONTRADICTS ITSELF")
    assert "INTACT" not in _words(found)


@pytest.mark.parametrize("result", ["fail", "unknown", "", "PASS", None, 1, ["pass"]])
def test_a_go_with_a_check_that_does_not_hold_contradicts_itself(result: object) -> None:
    for verdict in ("GO", "READY"):
        forged = {**_copy(_signed()), "verdict": verdict, "station": None}
        forged["checks"][10]["result"] = result
        assert _verified(seal(forged)).state is RecordState.CONTRADICTORY


def test_missing_duplicate_and_differing_checks_contradict() -> None:
    record = {**_copy(_signed()), "station": None}
    for name in sorted(REQUIRED):
        without = {**record, "checks": [one for one in record["checks"] if one["id"] != name]}
        assert _verified(seal(without)).state is RecordState.CONTRADICTORY
    doubled = {**record, "checks": [*record["checks"], record["checks"][0]]}
    assert _verified(seal(doubled)).state is RecordState.CONTRADICTORY
    other = _copy(record)
    other["read"]["settings"]["attitude_threshold_deg"] = 200
    found = _verified(seal(other))
    assert "judged 60, read 200" in _words(found)
    undone = _copy(record)
    undone["manual"][0] = {"text": "Canopy", "is_done": False, "is_required": True}
    assert _verified(seal(undone)).state is RecordState.CONTRADICTORY
    active = _copy(record)
    active["read"]["status"]["active"] = not active["read"]["status"]["active"]
    assert _verified(seal(active)).state is RecordState.CONTRADICTORY


def test_a_consistent_forgery_is_not_signed_by_a_known_station() -> None:
    forged = _passed(_signed("worst"))
    forged["read"]["settings"] = _signed()["read"]["settings"]  # type: ignore[index]
    forged["read"]["boot_count"] = next(one["measured"] for one in forged["checks"] if one["id"] == "boot_count")
    for one in forged["checks"]:
        sound: Any = next(sound for sound in _signed()["checks"] if sound["id"] == one["id"])  # type: ignore[attr-defined]
        one["measured"] = sound["measured"]
    forged["read"] = _copy(_signed())["read"]
    forged["verdict"] = verdict_from(forged).value
    assert not list(contradictions(forged))
    assert _verified(seal({**forged, "station": None})).state is RecordState.NOT_SIGNED
    assert _verified(seal(forged, station("stranger"))).state is RecordState.UNKNOWN_STATION
    # A known station's key with the signature of another station or record.
    claimed = seal({**forged, "station": encoded(station().public)})
    for signature in (seal(forged, station("stranger"))["signature"], _signed()["signature"], "", None, 7, "x" * 88):
        assert _verified({**claimed, "signature": signature}).altered == (SIGNATURE,)
    assert _verified(claimed).altered == (SIGNATURE,)
    for state in (RecordState.NOT_SIGNED, RecordState.UNKNOWN_STATION):
        assert "INTACT" not in Verification(state=state, record=forged).sentences()[0].translated()


def test_a_second_record_with_the_same_number_is_found(tmp_path: Path) -> None:
    with closing(open_store(tmp_path)) as store:
        kept, find = KeptRecords(store.database), Stations(tmp_path).find
        first = file_one(store, "M-07").record
        assert verify(first, kept, find).state is RecordState.INTACT
        assert verify(first, kept, find).chain is Chain.FIRST
        own = own_station(tmp_path)
        second = seal({**first, "who": "Somebody else"}, own)
        found = verify(second, kept, find)
        assert (found.state, found.chain) == (RecordState.CHAIN_BROKEN, Chain.DOUBLED)
        assert "another record here has the same number" in _words(found)
        for number in (2**70, -1, 1.0, True, "1", None):
            assert verify(seal({**first, "number": number}, own), kept, find).state is not RecordState.INTACT
        unnamed = file_one(store, adapter="A").record
        assert verify(unnamed, kept, find).state is RecordState.INTACT
        assert verify(seal({**unnamed, "adapter": "B"}, own), kept, find).chain is Chain.FIRST


def test_a_page_that_says_go_around_a_no_go_record(qapp: object) -> None:
    """Only the record is signed, so the answer is what the record says, and says so."""
    from tests.support.records.printing import print_report

    record, go = _signed("worst"), _signed()
    found = verify_bytes(print_report(body(go), as_text(record).encode()), find_station=find_station)
    assert found.record == record
    words = _words(found)
    assert words.startswith("INTACT: NO-GO, signed by hangar.")
    assert "Record 1 of M-07: NO-GO," in words
    assert "Its checks give NO-GO." in words
    assert "Only the record in the report is signed" in words
    assert "Only the record in the report is signed" not in _words(_verified(record))
    set_language("zh_CN")
    assert "NO-GO" not in _words(found)  # as the check itself says it


def test_a_report_that_carries_two_records_is_none(qapp: object) -> None:
    """One could be shown to a person and the other to a program."""
    from tests.support.records.printing import print_report

    record, go = (as_text(one).encode() for one in (_signed("worst"), _signed()))
    pdf = print_report("<p>x</p>", record)
    second = b"\n9999 0 obj\n<</Type /EmbeddedFile>>\nstream\n" + go + b"\nendstream\nendobj\n"
    for both in (pdf + second, pdf.replace(b"1 0 obj", second.strip() + b"\n1 0 obj", 1)):
        found = verify_bytes(both, find_station=find_station)
        assert found.state is RecordState.UNREADABLE
        assert "several records" in _words(found)


@pytest.mark.parametrize("suffix", ["json", "html", "pdf"])
def test_what_version_3_wrote_is_still_answered_by_its_record(suffix: str) -> None:
    """Its pages had a seal of their own, which nobody checks any more: only the record in them counts."""
    with ZipFile(Path(__file__).with_name("version_3.zip")) as old:
        data = old.read(f"version_3.{suffix}")
    found = verify_bytes(data)
    assert (found.state, found.altered, found.is_report) == (RecordState.UNKNOWN_STATION, (), suffix != "json")
    assert "Record 1 of M-07: NO-GO (void), 2026-11-23T21:00:00+00:00, checked by: Li." in _words(found)
    assert found.signer is not None
    if suffix != "pdf":
        forged = data.replace(b"M-07", b"M-08")
        assert verify_bytes(forged).altered == (CONTENT,)
    known = verify_bytes(data, find_station=lambda public: KnownStation(public, "hangar"))
    assert known.state is RecordState.INTACT


def test_the_signature_of_a_revoked_station_counts_no_more(tmp_path: Path) -> None:
    record, stations = _signed(), Stations(tmp_path)
    public = station().public
    stations.trust(public, "Hangar")
    assert verify(record, find_station=stations.find).state is RecordState.INTACT
    assert stations.remove(fingerprint_of(public), is_revoked=True) is not None
    found = verify(record, find_station=stations.find)
    assert (found.state, found.signer) == (RecordState.REVOKED_STATION, public)
    assert _words(found).startswith("REVOKED STATION: signed by Hangar,")
    assert stations.remove("0000", is_revoked=True) is None
    assert stations.remove(fingerprint_of(public)) is not None
    assert stations.revoked() == {encoded(public)}, "it stays revoked"
    stations.trust(public, "Hangar")  # a person compared the fingerprint again
    assert verify(record, find_station=stations.find).state is RecordState.INTACT


# What is sound is not accused


def test_an_older_unsigned_record_is_reported_as_unsigned() -> None:
    old = {**_copy(_signed("worst")), "version": 1}
    del old["station"]
    del old["adapter"]
    found = _verified(seal(old))
    assert found.state is RecordState.NOT_SIGNED
    assert _words(found).startswith("NOT SIGNED")
    assert [verdict_from({**_signed(), "version": version}).value for version in (1, 2)] == ["GO", "READY"]


def test_a_simulated_module_is_reported() -> None:
    assert "SIMULATED" in _words(_verified(seal({**_signed(), "is_simulated": True}, station())))


# Keys


def test_the_key_is_kept_and_only_this_user_can_read_it(tmp_path: Path) -> None:
    one = own_station(tmp_path / "data")
    assert own_station(tmp_path / "data").public == one.public
    if sys.platform != "win32":
        assert (tmp_path / "data" / KEY_FILE).stat().st_mode & 0o777 == 0o600
        (tmp_path / "data" / KEY_FILE).chmod(0o644)
        own_station(tmp_path / "data")
        assert (tmp_path / "data" / KEY_FILE).stat().st_mode & 0o777 == 0o600
    assert [path.name for path in (tmp_path / "data").iterdir()] == [KEY_FILE]
    assert fingerprint_of(bytes(32)) == "6668-7AAD-F862-BD77-6C8F", "as people noted it of earlier versions"


@pytest.mark.parametrize("content", [b"", b"no key", b"-----BEGIN PRIVATE KEY-----\nAAAA\n-----END PRIVATE KEY-----\n"])
def test_a_damaged_key_is_never_replaced_and_records_stay_unsigned(tmp_path: Path, content: bytes) -> None:
    (tmp_path / KEY_FILE).write_bytes(content)
    with pytest.raises(UserError, match=r"\w"):
        own_station(tmp_path)
    with closing(open_store(tmp_path)) as store:
        filed = file_one(store, "M-07")
        assert filed.station_trouble is not None
        assert filed.trouble is None
        kept = KeptRecords(store.database)
        assert verify(filed.record, kept, Stations(tmp_path).find).state is RecordState.NOT_SIGNED
    assert (tmp_path / KEY_FILE).read_bytes() == content


def test_stations_are_known_until_they_are_forgotten(tmp_path: Path) -> None:
    stations, other = Stations(tmp_path), station("other").public
    assert stations.known() == ()
    own = own_station(tmp_path)
    stations.trust(other, "Hangar\n2\u202e")
    stations.trust(station("third").public, "")
    assert [one.is_own for one in stations.known()] == [True, False, False]
    found = stations.find(other)
    assert found is not None
    assert found.name == "Hangar 2[U+202E]"
    assert stations.find(own.public) == stations.known()[0]
    with (tmp_path / KNOWN_FILE).open("ab") as file:
        file.write(b"\xff\xfe nonsense\n" + b"A" * 60 + b" x\n\n")
    assert len(stations.known()) == 3
    assert stations.remove(fingerprint_of(other).lower().replace("-", " ")) == found
    assert stations.remove(fingerprint_of(other)) is None
    assert stations.find(other) is None


def test_reading_records_does_not_load_the_cryptography_library() -> None:
    """Loading it takes longer than a reply of the module."""
    code = "import sys, app.records.filing, app.records.verification; print('cryptography' in sys.modules)"
    assert ran_code(code).stdout == "False\n"

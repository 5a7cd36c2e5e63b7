"""What was altered is never called intact, whoever made it; who signed is said, and is no trust."""

import json
import sys
import tracemalloc
import zlib
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

import pytest
from msgspec.structs import replace

from app.records.record import FORMAT, MAX_DOCUMENT_BYTES, canonical, read_document
from app.records.report import report_html, write_report
from app.records.verification import (
    LARGEST_FILE,
    RecordState,
    StationNames,
    Verification,
    is_of_row,
    verify,
    verify_bytes,
)
from app.store.rows import PreflightCheck, Row
from app.store.station import KEY_FILE, own_station, shown_key
from app.text.i18n import set_language
from app.text.messages import UserError
from tests.files.records.test_record import signed_record
from tests.support.processes import ran_code
from tests.support.records.printing import print_report
from tests.support.records.stations_made import station
from ui.files import report_printer

NOBODY = StationNames(None)


def plain(kind: str = "go") -> Any:
    """The document as JSON, to be forged."""
    return json.loads(signed_record(kind).text)


def signed_again(record: Mapping[str, object], name: str = "hangar") -> bytes:
    """A forgery made with the program's own functions: whoever has a key can sign what he likes."""
    by = station(name)
    signature = by.private.sign(b"dps-s pre-flight record 5\n" + canonical(record)).hex()
    document = {"format": FORMAT, "record": record, "station": by.key, "signature": signature}
    return canonical(document)


def state_of(data: bytes) -> RecordState | None:
    """None where it is no record."""
    try:
        return verify_bytes(data, NOBODY).state
    except UserError:
        return None


def words(verification: Verification) -> str:
    return " ".join(sentence.translated() for sentence in verification.sentences())


def reordered(value: Any) -> Any:
    """The same content, every object with its fields the other way round."""
    if isinstance(value, dict):
        return {name: reordered(part) for name, part in reversed(value.items())}
    return [reordered(part) for part in value] if isinstance(value, list) else value


# Intact


def test_intact_in_every_form(qapp: object, tmp_path: Path) -> None:
    for kind in ("go", "worst", "silent"):
        signed = signed_record(kind)
        json_path, pdf_path = write_report(tmp_path / "r.pdf", signed, report_printer.print_pages)
        for path in (json_path, pdf_path):
            verification = verify_bytes(path.read_bytes(), NOBODY)
            assert verification.state is RecordState.INTACT, path
            assert verification.record == signed.record
            assert verification.is_report == (path == pdf_path)
        # As saved by an editor: other white space and order.
        again = json.dumps(reordered(json.loads(signed.text)), ensure_ascii=True, indent=4)
        assert verify_bytes(again.encode(), NOBODY).state is RecordState.INTACT


def test_fields_of_a_newer_version_stay_under_the_signature() -> None:
    newer = plain()["record"] | {"humidity": 40}
    data = signed_again(newer)
    assert state_of(data) is RecordState.INTACT
    assert state_of(data.replace(b'"humidity":40', b'"humidity":41')) is RecordState.ALTERED
    assert state_of(signed_again(newer | {"version": 6})) is None


# Forgeries


@pytest.mark.promise("f")
def test_every_changed_byte_is_noticed() -> None:
    data = signed_record("silent").text.encode()
    for place in range(0, len(data), 31):
        damaged = bytearray(data)
        damaged[place] ^= 0x01
        assert state_of(bytes(damaged)) is not RecordState.INTACT, data[max(0, place - 20) : place + 20]


def test_a_signature_of_another_kind_of_document_or_of_another_key_does_not_fit() -> None:
    document = plain()
    bare = station().private.sign(canonical(document["record"])).hex()
    other = station("other").key
    assert state_of(canonical(document | {"signature": bare})) is RecordState.ALTERED
    assert state_of(canonical(document | {"station": other})) is RecordState.ALTERED
    assert state_of(canonical(document | {"station": "00" * 32})) is RecordState.ALTERED
    assert state_of(canonical({"format": FORMAT, "record": document["record"]})) is None


@pytest.mark.promise("f")
def test_a_no_go_record_that_was_signed_again_as_go_contradicts_itself() -> None:
    forged = plain("worst")["record"] | {"verdict": "GO"}
    found = verify_bytes(signed_again(forged), NOBODY)
    assert found.state is RecordState.CONTRADICTORY
    assert "stated GO, but the checks give NO-GO" in words(found)
    assert "INTACT" not in words(found)


@pytest.mark.parametrize("result", ["fail", "unknown", "PASS", None])
def test_a_go_with_a_check_that_does_not_hold_is_never_intact(result: object) -> None:
    for verdict in ("GO", "READY"):
        forged = plain()["record"] | {"verdict": verdict}
        forged["checks"][10]["result"] = result
        assert state_of(signed_again(forged)) is not RecordState.INTACT


def _undone(record: Any) -> None:
    record["manual"][0] = {"text": "Canopy", "is_done": False, "is_required": True}


def _skipped(record: Any) -> None:
    record["manual"][0] = {"text": "Canopy", "is_done": None, "is_required": True}


def _switched(record: Any) -> None:
    record["read"]["status"]["active"] = not record["read"]["status"]["active"]


def _voided(record: Any) -> None:
    record["void"] = "restarted"


@pytest.mark.parametrize("forge", [_undone, _skipped, _switched, _voided])
def test_what_does_not_follow_contradicts(forge: Callable[[Any], None]) -> None:
    record = plain()["record"]
    forge(record)
    assert state_of(signed_again(record)) is RecordState.CONTRADICTORY


# Reports


@pytest.mark.promise("f")
def test_a_page_that_says_go_around_a_no_go_record(qapp: object) -> None:
    """The page is only a view, so the answer is what the record says, and says so."""
    worst = signed_record("worst")
    found = verify_bytes(print_report(report_html(signed_record()), worst.text.encode()), NOBODY)
    assert found.record == worst.record
    assert words(found).startswith("INTACT: NO-GO.")
    assert "Its checks give NO-GO." in words(found)
    assert "Only the record in the report is signed" in words(found)
    assert "Only the record" not in words(verify_bytes(worst.text.encode(), NOBODY))
    set_language("zh_CN")
    assert "NO-GO" not in words(found)  # as the check itself says it


@pytest.mark.promise("f")
def test_a_report_that_carries_two_records_is_none(qapp: object) -> None:
    """One could be shown to a person and the other to a program."""
    pdf = print_report("<p>x</p>", signed_record("worst").text.encode())
    go = signed_record().text.encode()
    second = b"\n9999 0 obj\n<</Type /EmbeddedFile>>\nstream\n" + go + b"\nendstream\nendobj\n"
    packed = second.replace(go, zlib.compress(go))
    for both in (pdf + second, pdf + packed, pdf.replace(b"1 0 obj", second.strip() + b"\n1 0 obj", 1)):
        with pytest.raises(UserError, match="several records"):
            verify_bytes(both, NOBODY)


def test_whatever_is_damaged_in_a_report_its_record_is_intact_or_not_called_so(qapp: object) -> None:
    signed = signed_record("silent")
    pdf = print_report(report_html(signed), signed.text.encode())
    states = set()
    for place in range(0, len(pdf), 397):
        data = pdf[:place] + bytes((pdf[place] ^ 1,)) + pdf[place + 1 :]
        state = state_of(data)
        states.add(state)
        if state is RecordState.INTACT:
            assert verify_bytes(data, NOBODY).record == signed.record
    assert {RecordState.INTACT, None} <= states


# Strangers' files


@pytest.mark.parametrize("data", [
    b"", b"[]", b"\xff\xfe", b"%PDF-1.4 nothing", b"<html></html>", b'{"format": "dps-s pre-flight record"}',
    b'%PDF-1.4 stream\n{"dps-s pre-flight record": \nendstream',
])  # fmt: skip
def test_other_files_are_not_records(data: bytes) -> None:
    assert state_of(data) is None


def test_a_number_that_is_no_json_and_a_doubled_field_are_refused() -> None:
    text = signed_record().text
    for forged in (
        text.replace('"frames_left_out":0', '"frames_left_out":NaN'),
        text.replace('"frames_left_out":0', '"frames_left_out":1e999'),
        text.replace('"frames_left_out":0', '"frames_left_out":1,"frames_left_out":0'),
        text.replace('"who":"Li Wei"', '"who":"\\ud800"'),
    ):
        assert forged != text
        assert state_of(forged.encode()) is None


def test_a_document_beyond_what_a_fact_may_hold_is_refused_also_where_it_is_only_padded() -> None:
    padded = signed_record().text.encode() + b" " * MAX_DOCUMENT_BYTES
    with pytest.raises(UserError, match="too large"):
        verify_bytes(padded, NOBODY)


@pytest.mark.parametrize("data", [
    b"[" * LARGEST_FILE, b'{"a":' * 2_000_000, b"%PDF-" + b"stream\n" * 2_200_000, b"%PDF-" + b"endstream" * 1_700_000,
    b"%PDF-" + b"stream\nendstream" * 900_000,
    b"%PDF-" + (b"stream\n" + zlib.compress(bytes(10**8)) + b"endstream") * 160,
    b"x" * (LARGEST_FILE + 1), b'{"record":' + b"[{}," * 200_000, b"[" + b"{}," * (MAX_DOCUMENT_BYTES // 3 - 1) + b"0]",
    b'{"record":{"a":' + b"9" * 800_000 + b"}}",
], ids=range(10))  # fmt: skip
def test_a_hostile_file_is_refused_with_little_memory(data: bytes) -> None:
    tracemalloc.start()
    try:
        assert state_of(data) is None
        assert tracemalloc.get_traced_memory()[1] < 100_000_000
    finally:
        tracemalloc.stop()


# Who signed


@pytest.mark.promise("f")
def test_who_signed_is_said_and_is_no_trust() -> None:
    key, other = station().key, station("other").key
    document = read_document(signed_record().text.encode())
    told = {
        "this station": StationNames(key),
        "unknown key": StationNames(other),
        "known in the archive as Hangar 2": StationNames(other, ((key, "Hangar 2"), (other, "Field"))),
        "known in the archive as Hangar, Hangar 2": StationNames(None, ((key, "Hangar"), (key, "Hangar 2"))),
    }
    for what, names in told.items():
        found = verify(document, names)
        assert found.state is RecordState.INTACT
        assert what in words(found)
        assert shown_key(key) in words(found)
    doubled = verify(document, StationNames(None, ((key, "Hangar"), (other, "Hangar"))))
    assert f"Hangar is also the name of other keys: {shown_key(other)}." in words(doubled)


def test_an_altered_record_names_nobody_as_its_signer() -> None:
    document = plain()
    document["record"]["who"] = "Somebody"
    found = verify_bytes(canonical(document), StationNames(station().key))
    assert found.state is RecordState.ALTERED
    assert "this station" not in words(found)


@pytest.mark.promise("g")
def test_a_row_of_a_check_carries_the_record_that_it_speaks_of() -> None:
    """Asked once, where a row of another station comes in."""
    text = signed_record().text
    check = PreflightCheck(verdict="READY", is_void=False, is_simulated=False, document=text)
    row = Row("", "preflight_check", "M-07", station().key, "2026-11-21T06:03:06.000000+00:00", "")
    assert is_of_row(check, row)
    assert not is_of_row(replace(check, verdict="GO"), row)
    assert not is_of_row(replace(check, is_void=True), row)
    assert not is_of_row(replace(check, is_simulated=True), row)
    assert not is_of_row(check, row._replace(module="M-08"))
    assert not is_of_row(check, row._replace(station=station("other").key))
    assert not is_of_row(check, row._replace(made_at="2026-11-28T06:03:06.000000+00:00"))
    for document in (text.replace("Li Wei", "Li Bo"), "\ud800", "{}"):
        assert not is_of_row(replace(check, document=document), row)
    forged = signed_again(plain("worst")["record"] | {"verdict": "READY"}).decode()
    assert not is_of_row(replace(check, document=forged), row)


# Keys


def test_the_key_is_kept_and_only_this_user_can_read_it(tmp_path: Path) -> None:
    one = own_station(tmp_path / "data")
    assert own_station(tmp_path / "data").key == one.key
    if sys.platform != "win32":
        assert (tmp_path / "data" / KEY_FILE).stat().st_mode & 0o777 == 0o600
        (tmp_path / "data" / KEY_FILE).chmod(0o644)
        own_station(tmp_path / "data")
        assert (tmp_path / "data" / KEY_FILE).stat().st_mode & 0o777 == 0o600
    assert [path.name for path in (tmp_path / "data").iterdir()] == [KEY_FILE]
    assert shown_key("00" * 32) == "6668-7AAD-F862-BD77-6C8F", "as people noted it of earlier versions"


def test_reading_records_does_not_load_the_cryptography_library() -> None:
    """Loading it takes longer than a reply of the module."""
    code = "import sys, app.records.filing, app.records.verification; print('cryptography' in sys.modules)"
    assert ran_code(code).stdout == "False\n"

"""What was altered is never called intact, whoever made it; who signed is said, and is no trust."""

import json
import sys
import tracemalloc
import zlib
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

import pytest

from app.records.record import FORMAT, MAX_DOCUMENT_BYTES, canonical
from app.records.report import report_html, write_report
from app.records.verification import LARGEST_FILE, RecordState, StationNames, verify_bytes
from app.store.station import KEY_FILE, own_station, shown_key
from app.text.i18n import set_language
from app.text.messages import UserError
from tests.files.records.test_record import signed_record
from tests.support.records.stored import print_report, station
from ui.files import report_printer

NOBODY = StationNames()


def plain(kind: str = "go") -> Any:
    """The document as JSON, to be forged."""
    return json.loads(signed_record(kind).text)


def signed_again(record: Mapping[str, object]) -> bytes:
    """A forgery made with the program's own functions: whoever has a key can sign what he likes."""
    by = station()
    signature = by.private.sign(b"dps-s pre-flight record 5\n" + canonical(record)).hex()
    return canonical({"format": FORMAT, "record": record, "station": by.key, "signature": signature})


def state_of(data: bytes) -> RecordState | None:
    """None where it is no record."""
    try:
        return verify_bytes(data, NOBODY).state
    except UserError:
        return None


def words(data: bytes, names: StationNames = NOBODY) -> str:
    return " ".join(sentence.translated() for sentence in verify_bytes(data, names).sentences())


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
        document = dict(reversed(plain(kind).items()))
        again = json.dumps(document | {"record": dict(reversed(document["record"].items()))}, indent=4)
        assert state_of(again.encode()) is RecordState.INTACT


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
    for forged in ({"signature": bare}, {"station": station("other").key}, {"station": "00" * 32}):
        assert state_of(canonical(document | forged)) is RecordState.ALTERED
    assert state_of(canonical({"format": FORMAT, "record": document["record"]})) is None


def _item(is_done: bool | None) -> dict[str, object]:
    return {"text": "Canopy", "is_done": is_done, "is_required": True}


@pytest.mark.parametrize(
    ("kind", "forge"),
    [
        ("worst", lambda record: record.update(verdict="GO")),
        ("go", lambda record: record.update(verdict="GO")),
        ("go", lambda record: record["checks"][10].update(result="fail")),
        ("go", lambda record: record["checks"][10].update(result="unknown")),
        ("go", lambda record: record["manual"].append(_item(is_done=False))),
        ("go", lambda record: record["manual"].append(_item(is_done=None))),
        ("go", lambda record: record["read"]["status"].update(active=True)),
        ("go", lambda record: record.update(void="restarted")),
    ],
    ids=range(8),
)
@pytest.mark.promise("f")
def test_what_was_signed_again_and_does_not_follow_contradicts_itself(kind: str, forge: Callable[[Any], None]) -> None:
    record = plain(kind)["record"]
    forge(record)
    assert state_of(signed_again(record)) is RecordState.CONTRADICTORY
    told = words(signed_again(record))
    assert f"stated {record['verdict']}, but the checks give " in told
    assert "INTACT" not in told


# Reports


@pytest.mark.promise("f")
def test_a_page_that_says_go_around_a_no_go_record(qapp: object) -> None:
    """The page is only a view, so the answer is what the record says, and says so."""
    worst = signed_record("worst")
    report = print_report(report_html(signed_record()), worst.text.encode())
    assert verify_bytes(report, NOBODY).record == worst.record
    assert words(report).startswith("INTACT: NO-GO.")
    assert "Only the record in the report is signed" in words(report)
    assert "Only the record" not in words(worst.text.encode())
    set_language("zh_CN")
    assert "NO-GO" not in words(report)  # as the check itself says it


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


def test_a_number_that_is_no_json_a_doubled_field_and_a_padded_document_are_refused() -> None:
    text = signed_record().text
    for forged in (
        text.replace('"measured":3.9', '"measured":NaN'),
        text.replace('"measured":3.9', '"measured":1e999'),
        text.replace('"measured":3.9', '"measured":3.8,"measured":3.9'),
        text.replace('"who":"Li Wei"', '"who":"\\ud800"'),
        text + " " * MAX_DOCUMENT_BYTES,
    ):
        assert forged != text
        assert state_of(forged.encode()) is None


@pytest.mark.parametrize("data", [
    b"", b"[]", b"\xff\xfe", b"%PDF-1.4 nothing", b"<html></html>", b'{"format": "dps-s pre-flight record"}',
    b'%PDF-1.4 stream\n{"dps-s pre-flight record": \nendstream',
    b"[" * LARGEST_FILE, b'{"a":' * 2_000_000, b"%PDF-" + b"stream\n" * 2_200_000, b"%PDF-" + b"endstream" * 1_700_000,
    b"%PDF-" + b"stream\nendstream" * 900_000,
    b"%PDF-" + (b"stream\n" + zlib.compress(bytes(10**8)) + b"endstream") * 160,
    b"x" * (LARGEST_FILE + 1), b'{"record":' + b"[{}," * 200_000, b"[" + b"{}," * (MAX_DOCUMENT_BYTES // 3 - 1) + b"0]",
    b'{"record":{"a":' + b"9" * 800_000 + b"}}",
], ids=range(17))  # fmt: skip
def test_another_or_a_hostile_file_is_refused_with_little_memory(data: bytes) -> None:
    tracemalloc.start()
    try:
        assert state_of(data) is None
        assert tracemalloc.get_traced_memory()[1] < 100_000_000
    finally:
        tracemalloc.stop()


# Who signed


@pytest.mark.promise("f")
def test_who_signed_is_said_and_is_no_trust() -> None:
    key, other, data = station().key, station("other").key, signed_record().text.encode()
    for said, names in {
        "this station": StationNames(key),
        "unknown key": StationNames(other),
        "known in the archive as Hangar 2": StationNames(other, ((key, "Hangar 2"), (other, "Field"))),
        "known in the archive as Hangar, Hangar 2": StationNames(None, ((key, "Hangar"), (key, "Hangar 2"))),
        f"Hangar is also the name of other keys: {shown_key(other)}.": StationNames(
            None, ((key, "Hangar"), (other, "Hangar"))
        ),
    }.items():
        assert verify_bytes(data, names).state is RecordState.INTACT
        assert said in words(data, names)
        assert shown_key(key) in words(data, names)
    altered = data.replace(b"Li Wei", b"Li Bo")
    assert words(altered, StationNames(key)).startswith("ALTERED")
    assert "Signed by" not in words(altered, StationNames(key))


def test_of_a_simulated_module_it_is_said_that_the_record_is_no_evidence() -> None:
    simulated = plain()["record"] | {"is_simulated": True}
    assert "SIMULATED MODULE: no evidence." in words(signed_again(simulated))
    assert "SIMULATED" not in words(signed_again(plain()["record"]))


def test_the_key_is_kept_and_only_this_user_can_read_it(tmp_path: Path) -> None:
    path = tmp_path / "data" / KEY_FILE
    one = own_station(path.parent)
    path.chmod(0o644)
    assert own_station(path.parent).key == one.key
    assert sys.platform == "win32" or path.stat().st_mode & 0o777 == 0o600
    assert shown_key("00" * 32) == "6668-7AAD-F862-BD77-6C8F", "as people noted it of earlier versions"

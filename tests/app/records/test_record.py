"""Records are sealed and chained, alterations are found; reports are escaped and fit one page; what stands on a
label.
"""

import base64
import json
import re
from collections.abc import Mapping, Sequence
from datetime import UTC, datetime, timedelta, timezone
from functools import cache
from html import unescape
from html.parser import HTMLParser
from pathlib import Path
from typing import Any
from unittest.mock import patch

import pytest

from app import version
from app.engine.target import is_simulated
from app.records.check_store import KeptRecords, measured_in
from app.records.labels import MAX_NAME_LENGTH, Label, Paper, label_body
from app.records.record import Record, as_text, canonical, seal
from app.records.report_files import check_target, suggested_name, write_report
from app.records.report_html import body
from app.records.verification import CONTENT, Chain, RecordState, Verification
from app.records.verification import verify as verify_record
from app.records.verification import verify_bytes as verify_file_bytes
from app.settings.profiles import ManualLine
from app.text.i18n import set_language
from app.text.messages import UserMessage, clean, message, message_from_json
from app.text.user_error import UserError
from tests.support.records.preflight_rig import FAULTS, Fault, check
from tests.support.records.printing import print_report
from tests.support.records.stations_made import find_station, station
from ui.files import report_printer

AT = datetime(2026, 11, 21, 14, 3, 5, tzinfo=timezone(timedelta(hours=8), "CST"))
HOSTILE = (
    "</script><script>alert(1)</script>", "<img src=x onerror=alert(1)>", "&lt;b&gt;\"'`", "../../etc/passwd",
    "C:\\con", "=HYPERLINK(\"http://x\")", "{0.__class__}", "{x:999999999}", "\u202egnp.exe", "\u2067مرحبا",
    "🪂" * 90, "\0\x1b[31m", "\ud800", "a\nb\r\nc\td", "x" * 1_000_000, "%s%n", "<!-- ", "]]>", "　", "",
)  # fmt: skip


@cache
def _checked(kind: str) -> Any:
    items = (ManualLine("Lines and canopy looked at", is_done=True), ManualLine("Hatch free"))
    manual = Fault(frozenset(), profile={"manual": items, "name": "H6"})
    match kind:
        case "go":
            return check(manual)
        case "worst":
            names = ("fired", "tilted", "charging", "attitude threshold", "new records", "another module", "slow")
            return check(manual, *(FAULTS[name] for name in names))
    return check(manual, options={"mute": "yes"})


PERSON = {"who": "Li Wei", "module": "M-07", "aircraft": "B-1234"}


def checked_record(kind: str = "go", **circumstances: Any) -> Record:
    """A record signed by a known station."""
    checked = _checked(kind)
    person = PERSON | {name: circumstances.pop(name) for name in PERSON if name in circumstances}
    record: Record = checked.record({"at": AT, **circumstances}, station(), **person)
    return record


_record = checked_record


class _Kept(KeptRecords):
    """A store of these records, by hash."""

    def __init__(self, records: Mapping[object, Record]) -> None:
        self._records = records

    def record(self, hash_: str) -> Record | None:
        return self._records.get(hash_)

    def same_number(self, record: Mapping[str, object]) -> str | None:
        return None


def _find(*records: Record) -> _Kept:
    return _Kept({str(record["hash"]): record for record in records})


def verify(record: Mapping[str, object], kept: _Kept | None = None) -> Verification:
    return verify_record(record, kept, find_station)


def verify_bytes(data: bytes) -> Verification:
    return verify_file_bytes(data, find_station=find_station)


def test_a_record_contains_everything_about_the_check() -> None:
    record = _record()
    assert record["verdict"] == "READY"
    assert record["at"] == "2026-11-21T14:03:05+08:00"
    assert record["zone"] == "CST"
    assert (record["who"], record["module"], record["aircraft"]) == ("Li Wei", "M-07", "B-1234")
    assert record["program"] == {"name": "DPS-S Configurator", "version": version()}
    read: Any = record["read"]
    assert read["settings"]["attitude_trigger"] is True
    assert measured_in(record).items() >= {"cell_voltage_v": 3.9, "boot_count": 37, "heartbeats_lost": 0}.items()
    frames: Any = record["frames"]
    assert [0.0, "out", "42 61 23 01 00 24"] in frames
    assert any(way == "in" and raw.startswith("41 75 32") for _, way, raw in frames)
    assert json.loads(as_text(record)) == record
    with pytest.raises(ValueError, match="zone"):
        _record(at=datetime(2026, 1, 1))  # noqa: DTZ001


def test_intact_in_every_form(qapp: object, tmp_path: Path) -> None:
    for kind in ("go", "worst", "silent"):
        record = _record(kind)
        json_path, pdf_path = write_report(tmp_path / "r.pdf", record, report_printer.print_pages)
        for path in (json_path, pdf_path):
            verification = verify_bytes(path.read_bytes())
            assert verification.state is RecordState.INTACT, path
            assert verification.record == record
            assert verification.is_report == (path == pdf_path)
        # As saved by an editor: other white space and order.
        again = json.dumps(dict(reversed(record.items())), ensure_ascii=True, indent=4)
        assert verify_bytes(again.encode()).state is RecordState.INTACT


def test_each_alteration_is_found() -> None:
    record = _record()
    checks: Any = record["checks"]
    altered = []
    for place in range(len(checks)):
        for key, value in (("result", "fail"), ("measured", 123), ("why", "x"), ("id", "other")):
            altered.append(json.loads(as_text(record)))
            altered[-1]["checks"][place][key] = value
    altered += [{name: value for name, value in record.items() if name != key} for key in set(record) - {"format"}]
    altered += [record | {"approved": True}, record | {"checks": checks[::-1]}, record | {"version": 3}]
    assert CONTENT not in verify(record).altered
    for one in altered:
        verification = verify(one)
        assert verification.state in (RecordState.ALTERED, RecordState.UNREADABLE)
        assert "INTACT" not in verification.sentences()[0].translated()


def test_every_changed_byte_is_noticed() -> None:
    """A flipped byte anywhere (except in white space) makes the file altered or unreadable."""
    record = _record("silent")
    data = canonical(record)
    for place in range(0, len(data), 7):
        damaged = bytearray(data)
        damaged[place] ^= 0x01
        assert verify_bytes(bytes(damaged)).state is not RecordState.INTACT, data[max(0, place - 20) : place + 20]


def test_a_recomputed_hash_breaks_the_chain_or_differs_from_the_store() -> None:
    first = _record("worst")
    second = _record(number=2, previous=first["hash"])
    assert verify(second, _find(first, second)).chain is Chain.LINKED
    assert verify(second, _find(second)).chain is Chain.NOT_AT_HAND
    forged = seal(first | {"remarks": "x"}, station())
    assert not verify(forged, _find(first, second)).is_known_here
    tampered = {**first, "verdict": "GO"}
    assert verify(second, _Kept({first["hash"]: tampered})).state is RecordState.CHAIN_BROKEN
    assert verify(seal(second | {"number": 7}, station()), _find(first)).state is RecordState.CHAIN_BROKEN
    assert verify(seal(second | {"previous": None}, station()), _find(first)).state is RecordState.CHAIN_BROKEN
    assert verify(_record(number=0)).chain is Chain.ALONE


@pytest.mark.parametrize("data", [
    b"", b"{", b"[]", b"null", b"\xff\xfe", b'{"format": 1}', b"%PDF-1.4 nothing", b"<html></html>", b"[" * 100_000,
    b'{"format": "dps-s pre-flight record", "version": 1, "version": 1}',
    b'{"format": "dps-s pre-flight record", "version": 5}',
    b'{"format": "dps-s pre-flight record", "version": 1, "at": NaN}',
    b'%PDF-1.4 stream\n{"dps-s pre-flight record": \nendstream', b"x" * 1000,
])  # fmt: skip
def test_other_files_are_not_records(data: bytes) -> None:
    assert verify_bytes(data).state is RecordState.UNREADABLE


def test_whatever_is_damaged_in_a_report_its_record_is_intact_or_not_called_so(qapp: object) -> None:
    record = _record("silent")
    pdf = print_report(body(record), as_text(record).encode())
    places = range(0, len(pdf), 97)
    found = [verify_bytes(pdf[:place] + bytes((pdf[place] ^ 1,)) + pdf[place + 1 :]) for place in places]
    assert {one.state for one in found} >= {RecordState.INTACT, RecordState.UNREADABLE}
    assert all(one.record == record for one in found if one.state is RecordState.INTACT)


class _Tags(HTMLParser):
    def __init__(self) -> None:
        super().__init__()
        self.tags: set[str] = set()
        self.attributes: set[str] = set()

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.tags.add(tag)
        self.attributes |= {name for name, _ in attrs}


@pytest.mark.parametrize("kind", ["go", "worst", "silent"])
def test_the_page_says_what_was_measured_why_it_matters_and_what_to_do(kind: str) -> None:
    record: Any = _record(kind)
    said = " ".join(unescape(re.sub(r"<[^>]*>", " ", body(record))).split())
    for one in record["checks"]:
        told = [message_from_json(one[key]).translated() for key in ("shown", "limit", "do")]
        for part in told[:2] if one["result"] == "pass" else (one["title"], one["why"], *told):
            assert part in said, one["id"]
    for part in (
        "Module M-07", "B-1234", "Li Wei", "Lines and canopy looked at", "Hatch free", "Skipped: 1.",
        record["verdict"], "Previous record: none",
    ):  # fmt: skip
        assert part in said


def test_hostile_names_do_no_harm(qapp: object, tmp_path: Path) -> None:
    sound = _Tags()
    sound.feed(body(_record()))
    for text in HOSTILE:
        items = (ManualLine(text, is_done=True),)
        checked = check(Fault(frozenset(), profile={"manual": items, "name": text}))
        names = {"who": text, "module": text, "aircraft": text}
        record = checked.record({"at": AT}, station(), **names)
        printed = body(record)
        tags = _Tags()
        tags.feed(printed)
        assert tags.tags <= sound.tags
        assert tags.attributes <= sound.attributes
        assert "<script" not in printed
        assert verify(record).state is RecordState.INTACT
        assert len(as_text(record)) < 200_000
        name = suggested_name(record)
        assert re.fullmatch(r"[\w\- ]{1,60}", name)
        assert (tmp_path / name).resolve().parent == tmp_path
        pdf = print_report(printed, as_text(record).encode())
        assert pdf.count(b"/Type /Page\n") == 1


def test_a_hostile_record_prints_and_is_not_trusted(qapp: object) -> None:
    """Any value of any type in any place."""
    for value in (None, 7, [], {}, [[1]], "<b>", {"text": "{a}", "values": {"a": {"text": "{a:9999999999}"}}}, [None]):
        record = dict.fromkeys(_record(), value) | {"format": "dps-s pre-flight record", "version": 1}
        assert verify(record).state is not RecordState.INTACT
        assert "<b><b>" not in body(record)
        assert print_report(body(record), b"{}").startswith(b"%PDF")
    deep: dict[str, object] = {"text": "{a}"}
    for _ in range(300):
        deep = {"text": "{a}", "values": {"a": deep}}
    assert len(message_from_json(deep).translated()) < 10


def test_three_megabytes_are_verified() -> None:
    record = seal(_record() | {"remarks": "x" * 3_000_000}, station())
    assert verify_bytes(as_text(record).encode()).state is RecordState.INTACT
    assert len(body(record)) < 60_000


@pytest.mark.parametrize("language", ["en", "zh_CN"])
@pytest.mark.parametrize("kind", ["go", "worst", "silent"])
def test_it_is_one_page_in_both_languages(qapp: object, language: str, kind: str) -> None:
    set_language(language)
    pdf = print_report(body(_record(kind)), b"{}")
    assert pdf.count(b"/Type /Page\n") == 1
    assert b"/FontFile" in pdf


@pytest.mark.parametrize("text", ["检查伞绳" * 50, "word " * 40, "W" * 200])
def test_forty_manual_items_and_every_check_failed_fit_one_page(qapp: object, text: str) -> None:
    items = tuple(ManualLine(text) for _ in range(40))
    checked = check(Fault(frozenset(), {"mute": "yes"}, profile={"manual": items, "name": text}))
    record = checked.record({"at": AT}, who=text, module=text, aircraft=text)
    document = report_printer._document
    with patch.object(report_printer, "_document", wraps=document) as made:
        assert print_report(body(record), b"{}").count(b"/Type /Page\n") == 1
    html, room, writer, size_pt = made.call_args.args
    larger = document(html, room, writer, size_pt + report_printer.STEP_PT)
    assert larger.size().height() > room.height()


def test_a_report_that_does_not_fit_is_refused(qapp: object) -> None:
    with pytest.raises(RuntimeError, match="one page"):
        print_report("<p>x</p>" * 500, b"{}")
    assert print_report("<p>x</p>", b"{}").startswith(b"%PDF")


def test_the_target_is_checked_before_anything_is_sent(tmp_path: Path) -> None:
    check_target(tmp_path / "r.pdf")
    for wrong in (tmp_path / "r.txt", tmp_path / "none" / "r.pdf"):
        with pytest.raises(UserError):
            check_target(wrong)
    (tmp_path / "r.json").write_text('{"mine": 1}', encoding="utf-8")
    with pytest.raises(UserError, match="another kind of file"):
        check_target(tmp_path / "r.pdf")
    (tmp_path / "r.json").write_text(as_text(_record()), encoding="utf-8")
    check_target(tmp_path / "r.pdf")


def test_a_printer_that_fails_loses_nothing(tmp_path: Path) -> None:
    def broken(_bodies: Sequence[str], _paper: Paper, _attached: bytes | None) -> bytes:
        raise RuntimeError("no fonts")

    record = _record()
    with pytest.raises(RuntimeError):
        write_report(tmp_path / "r.pdf", record, broken)
    assert json.loads((tmp_path / "r.json").read_text(encoding="utf-8")) == record
    assert sorted(path.name for path in tmp_path.iterdir()) == ["r.json"]


def test_placeholders_in_a_records_texts_are_not_formatted() -> None:
    assert message("{a} {b}", a="{b}", b="2").translated() == "{b} 2"
    assert UserMessage("{missing}").in_english() == "{missing}"
    assert message("{seconds:.1f} s old", seconds=3.14).in_english() == "3.1 s old"
    both = message("{one} {other}", one=message("x"), other="y")
    assert message_from_json(both.to_json()) == both
    assert clean("\u202eabc\n") == "[U+202E]abc "
    assert len(clean("x" * 1000)) == 400


def test_a_simulated_module_is_no_evidence() -> None:
    record = _record()
    assert record["is_simulated"] is False
    assert "SIMULATED" not in body(record)
    assert "SIMULATED MODULE: no evidence." in body(record | {"is_simulated": True})
    assert is_simulated("SIM://bench?cell=4")
    assert not is_simulated("/dev/ttyUSB0")


def test_times_have_the_local_zone() -> None:
    assert "UTC+08:00" in body(_record())
    assert "00:00:00 UTC<" in body(_record(at=datetime(2026, 1, 2, tzinfo=UTC)))


LABELLED_AT = datetime(2026, 11, 24, tzinfo=UTC)


@pytest.mark.parametrize(
    ("name", "shown"),
    [
        ("M-07", "M-07"),
        ("伞仓 07", "伞仓 07"),
        (" <b>&\x1b[31m\u202e ", "&lt;b&gt;&amp;[U+001B][31m[U+202E]"),
        ("M" * MAX_NAME_LENGTH, "M" * MAX_NAME_LENGTH),
    ],
)
def test_a_label_has_name_date_code_and_a_picture(name: str, shown: str) -> None:
    body = label_body(Label(name, LABELLED_AT, "K7QF-3M2X"))
    assert f"<b>{shown}</b>" in body
    assert "<br>2026-11-24<br>K7QF-3M2X<" in body
    picture = re.search(r'src="data:image/png;base64,([^"]+)"', body)
    assert picture is not None
    assert base64.b64decode(picture[1]).startswith(b"\x89PNG")
    assert "<br>2026-11-24</td>" in label_body(
        Label(name, LABELLED_AT)
    )  # no code is better than one of half the settings


@pytest.mark.parametrize("name", ["", "   ", "M" * (MAX_NAME_LENGTH + 1)])
def test_a_name_that_no_scanner_reads_has_no_label(name: str) -> None:
    with pytest.raises(UserError, match="at most 60"):
        label_body(Label(name, LABELLED_AT))

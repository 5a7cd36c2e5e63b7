"""A record holds everything about a check; what is printed of it is escaped, whole and on one page."""

import re
from collections.abc import Sequence
from datetime import datetime, timedelta, timezone
from functools import cache
from html import unescape
from html.parser import HTMLParser
from pathlib import Path
from typing import Any

import msgspec
import pytest

from app.guided.results import GuidedKind, GuidedVerdict, StoredTest
from app.modules.labels import Paper
from app.preflight.checks import CheckResult
from app.records.record import NOTES, Record, SignedRecord, sign
from app.records.report import check_target, report_html, write_report
from app.settings.profiles import ManualLine
from app.text.i18n import set_language, tr
from app.text.messages import UserError, message_from_json
from tests.support.records.preflight_rig import FAULTS, Fault, check
from tests.support.records.stored import print_report, station

AT = datetime(2026, 11, 21, 14, 3, 5, tzinfo=timezone(timedelta(hours=8), "CST"))
HOSTILE = (
    "</script><script>alert(1)</script>", "&lt;b&gt;\"'`", "../../etc/passwd", "C:\\con", "{{ 7 * 7 }}",
    "\u202egnp.exe", "🪂" * 90, "\0\x1b[31m", "\ud800", "x" * 1_000_000, "<!-- ", "",
)  # fmt: skip


@cache
def _checked(kind: str) -> Any:
    items = (ManualLine("Lines and canopy looked at", is_done=True), ManualLine("Hatch free"))
    manual = Fault(profile={"manual": items, "name": "H6"})
    match kind:
        case "go":
            return check(manual)
        case "worst":
            names = ("fired", "tilted", "charging", "attitude threshold", "new records", "another module", "slow")
            return check(manual, *(FAULTS[name] for name in names))
    return check(manual, Fault(options={"mute": True}))


PERSON = {"who": "Li Wei", "module": "M-07", "aircraft": "B-1234"}


def signed_record(kind: str = "go", **changes: Any) -> SignedRecord:
    """A record signed by the station "hangar"; `changes`: fields that are other ones."""
    record: Record = _checked(kind).record({"at": AT}, **PERSON)
    return sign(msgspec.structs.replace(record, **changes), station())


def printed(kind: str = "go", **changes: Any) -> str:
    return report_html(signed_record(kind, **changes))


def test_a_record_has_also_what_is_not_printed() -> None:
    record = signed_record().record
    assert (record.at, record.zone) == (AT, "CST")
    assert record.cell_voltage_v == 3.9
    assert record.read["settings"]["attitude_trigger"] is True


@pytest.mark.parametrize("kind", ["go", "worst", "silent"])
def test_the_page_says_what_was_measured_why_it_matters_and_what_to_do(kind: str) -> None:
    record = signed_record(kind).record
    said = " ".join(unescape(re.sub(r"<[^>]*>", " ", printed(kind))).split())
    for one in record.checks:
        told = [message_from_json(part).translated() for part in (one.shown, one.limit, one.do)]
        shown = told[:2] if one.result is CheckResult.PASS else [one.title, one.why, *told]
        for part in shown:
            assert part in said, one.id
    names = ("Module M-07", "B-1234", "Li Wei", "Lines and canopy looked at", "Hatch free", "Skipped: 1.")
    for part in (*names, record.verdict.value, *NOTES):
        assert part in said


class _Tags(HTMLParser):
    def __init__(self) -> None:
        super().__init__()
        self.tags: set[str] = set()
        self.attributes: set[str] = set()

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.tags.add(tag)
        self.attributes |= {name for name, _ in attrs}


def test_hostile_names_do_no_harm(qapp: object, tmp_path: Path) -> None:
    sound = _Tags()
    sound.feed(printed())
    for text in HOSTILE:
        items = (ManualLine(text, is_done=True),)
        checked = check(Fault(profile={"manual": items, "name": text}))
        signed = sign(checked.record({"at": AT}, who=text, module=text, aircraft=text), station())
        page = report_html(signed)
        tags = _Tags()
        tags.feed(page)
        assert tags.tags <= sound.tags
        assert tags.attributes <= sound.attributes
        assert "<script" not in page
        assert "49" not in re.findall(r"<b>([^<]*)</b>", page)
        assert len(signed.text) < 200_000
        assert print_report(page, signed.text.encode()).count(b"/Type /Page\n") == 1


@pytest.mark.promise("g")
def test_a_strangers_messages_print_as_plain_text(qapp: object) -> None:
    """A record that is well signed may still hold any JSON where a message is."""
    deep: dict[str, object] = {"text": "{a}"}
    for _ in range(30):
        deep = {"text": "{a}", "values": {"a": deep}}
    hostile = {"text": "<b><b>", "values": []}, "<b><b>\u202e\x1b", {"text": "{a:9999999999}"}
    for kept in ({}, {"text": 7}, deep, *hostile):
        checks = [msgspec.structs.replace(one, shown=kept, do=kept) for one in signed_record("worst").record.checks]
        test = StoredTest(kind=GuidedKind.TILT, verdict=GuidedVerdict.PASSED, at="<b><b>", measured=[{"name": kept}])
        page = printed("worst", checks=checks, tests=[test])
        assert not re.search("<b><b>|\u202e|\x1b", page)
        assert print_report(page, b"{}").startswith(b"%PDF")


@pytest.mark.parametrize("language", ["en", "zh_CN"])
@pytest.mark.parametrize("kind", ["go", "worst", "silent", "检查伞绳" * 50, "W" * 200])
def test_it_is_one_page_in_both_languages(qapp: object, language: str, kind: str) -> None:
    """Also with forty manual items, every check failed and long names."""
    set_language(language)
    if kind in ("go", "worst", "silent"):
        page = printed(kind)
    else:
        items = tuple(ManualLine(kind) for _ in range(40))
        checked = check(Fault(options={"mute": True}, profile={"manual": items, "name": kind}))
        page = report_html(sign(checked.record({"at": AT}, who=kind, module=kind, aircraft=kind), station()))
    pdf = print_report(page, b"{}")
    assert pdf.count(b"/Type /Page\n") == 1
    assert b"/FontFile" in pdf
    assert all(tr(note) in page for note in NOTES), "what no check can prove"
    with pytest.raises(RuntimeError, match="one page"):
        print_report("<p>x</p>" * 500, b"{}")


def test_the_target_is_checked_before_anything_is_sent(tmp_path: Path) -> None:
    check_target(tmp_path / "r.pdf")
    for wrong in (tmp_path / "r.txt", tmp_path / "none" / "r.pdf"):
        with pytest.raises(UserError):
            check_target(wrong)
    (tmp_path / "r.json").write_text('{"mine": 1}', encoding="utf-8")
    with pytest.raises(UserError, match="another kind of file"):
        check_target(tmp_path / "r.pdf")
    (tmp_path / "r.json").write_text(signed_record().text, encoding="utf-8")
    check_target(tmp_path / "r.pdf")


def test_a_printer_that_fails_loses_nothing(tmp_path: Path) -> None:
    def broken(_bodies: Sequence[str], _paper: Paper, _attached: bytes | None) -> bytes:
        raise RuntimeError("no fonts")

    signed = signed_record()
    with pytest.raises(RuntimeError):
        write_report(tmp_path / "r.pdf", signed, broken)
    assert (tmp_path / "r.json").read_text(encoding="utf-8") == signed.text
    assert sorted(path.name for path in tmp_path.iterdir()) == ["r.json"]


def test_a_simulated_module_is_no_evidence() -> None:
    assert "SIMULATED" not in printed()
    assert "SIMULATED MODULE: no evidence." in printed(is_simulated=True)

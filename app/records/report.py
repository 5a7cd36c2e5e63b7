"""The report of a check: a page for the printer, and the PDF that carries the record.

Made from the record alone, so that it prints the same years later.

Writes FILE.pdf with FILE.json, the document alone, beside it, each atomically. What is read may be a stranger's: the
work on it grows with its length and no faster.
"""

import hashlib
import re
import unicodedata
import zlib
from collections.abc import Callable, Iterable, Iterator, Mapping
from contextlib import suppress
from datetime import tzinfo
from pathlib import Path
from typing import Any

from app.guided.results import TITLES, VERDICT_WORDS, GuidedKind, stored_test
from app.modules.labels import A4, Printer
from app.preflight.checks import RESULT_WORDS, CheckResult
from app.preflight.verdict import MANUAL_WORDS, Verdict, verdict_sentence
from app.records.record import FORMAT, MAX_DOCUMENT_BYTES, Record, SignedRecord
from app.settings.profiles import ActivatedBy
from app.store.station import fingerprint_of
from app.system.clock import DAY, local_time
from app.system.files import write_whole
from app.text.i18n import tr
from app.text.messages import UserError, in_brackets, join_sentences, message, message_from_json
from app.text.template import page
from protocol.translatable import marked

# More manual items, or more checks against it, crowd the page.
_ONE_COLUMN = 8


def report_html(signed: SignedRecord) -> str:
    record = signed.record
    against = sum(check.result is not CheckResult.PASS for check in record.checks)
    return page(
        "report.html",
        record=record,
        word=verdict_sentence(record.verdict, ActivatedBy(record.activated_by)).translated(),
        under=_under(record),
        words={result: tr(word) for result, word in RESULT_WORDS.items()},
        manual_words={state: tr(word) for state, word in MANUAL_WORDS.items()},
        is_crowded=len(record.manual) > _ONE_COLUMN and against > _ONE_COLUMN,
        tests=_tests(record.tests, record.at.tzinfo),
        station=fingerprint_of(bytes.fromhex(signed.station)),
        digest=hashlib.sha256(signed.text.encode()).hexdigest(),
    )


def _under(record: Record) -> str:
    """Below the verdict: what restricts it, and how many checks passed."""
    results = [check.result for check in record.checks]
    passed = results.count(CheckResult.PASS)
    looks = results.count(CheckResult.WARN)
    sentences = [caveat.translated() for caveat in record.caveats]
    if record.verdict is not Verdict.NO_GO and record.void is None:
        sentences.append(tr("Passed: {count}; warnings: {looks}.", count=passed, looks=looks))
    else:
        failed = len(results) - passed - looks
        sentences.append(tr("{count} of {all} checks not OK.", count=failed, all=len(results)))
    if record.void is not None:
        sentences.append(tr("Void: {why}", why=_why_void(record)))
    skipped = sum(item.is_done is None for item in record.manual)
    if skipped:
        sentences.append(tr("Skipped: {count}.", count=skipped))
    return join_sentences(sentences)


def _why_void(record: Record) -> str:
    """The sentence with which the check of the connection says it."""
    for check in record.checks:
        if check.id == "connection":
            return message_from_json(check.shown).translated()
    return record.void or ""


def _tests(tests: Iterable[Mapping[str, Any]], zone: tzinfo | None) -> list[dict[str, str]]:
    """Those that this version knows."""
    known = []
    for fields in list(tests)[: len(GuidedKind)]:
        test = stored_test(fields, str(fields.get("at")))
        if test is None:
            continue
        when = f"{local_time(test.at, DAY, zone)}, {test.who or '—'}"
        known.append(
            {
                "title": tr(TITLES[test.kind]),
                "verdict": test.verdict.value,
                "word": tr(VERDICT_WORDS[test.verdict]),
                "when": f"{when}, {tr('simulated')}" if test.is_simulated else when,
                "measured": "; ".join(_measured_text(row) for row in test.measured[:10]),
            }
        )
    return known


def _measured_text(row: Mapping[str, object]) -> str:
    name = message_from_json(row.get("name")).translated()
    shown = message_from_json(row.get("shown")).translated()
    tolerance = message_from_json(row.get("tolerance")).translated()
    return f"{name}: {shown}{in_brackets(tolerance) if tolerance else ''}"


LARGEST_FILE = 16_000_000
MAX_NAME_LENGTH = 60
# Of a PDF; ours have a dozen.
_MAX_STREAMS = 200
_NOT_IN_NAMES = re.compile(r"[^\w\-]+")
_RESERVED = re.compile(r"(?i)(con|prn|aux|nul|com\d|lpt\d)")


def is_report(data: bytes) -> bool:
    """Whether this is a PDF, not a bare document."""
    return data.startswith(b"%PDF-")


def document_in(data: bytes) -> bytes:
    """The bytes of the document. Raises `UserError`, also where a report carries several: a person could be shown one
    and a program told another."""
    if len(data) > LARGEST_FILE:
        raise UserError(marked("too large"))
    if not is_report(data):
        return data
    carried = list(_carried_in_pdf(data, FORMAT))
    if len(carried) > 1:
        raise UserError(marked("several records"))
    if not carried:
        raise UserError(marked("unknown kind of file"))
    return carried[0]


def carries(kind: str, data: bytes) -> bool:
    """Whether this is a document of this format, or a PDF with one."""
    if not is_report(data):
        return data.lstrip()[:1] == b"{" and kind.encode() in data
    with suppress(UserError):
        return any(True for _ in _carried_in_pdf(data, kind))
    return False


def _carried_in_pdf(data: bytes, kind: str) -> Iterator[bytes]:
    """The JSON documents of this format that are attached to a PDF. Raises `UserError` for one that has more parts than
    any report, as another document could hide in them."""
    end = 0
    for _ in range(_MAX_STREAMS):
        start = data.find(b"stream", end)
        end = data.find(b"endstream", start + 1)
        if start < 0 or end < 0:
            return
        stream = data[start + len(b"stream") : end].lstrip(b"\r\n")
        end += len(b"endstream")
        for content in (stream, _inflated(stream)):
            if content.lstrip()[:1] == b"{" and kind.encode() in content:
                yield content
                break
    raise UserError(marked("too large"))


def _inflated(data: bytes) -> bytes:
    """At most one byte more than a document may have."""
    try:
        return zlib.decompressobj().decompress(data, MAX_DOCUMENT_BYTES + 1)
    except zlib.error:
        return b""


def is_record(data: bytes) -> bool:
    """The document, or the report that carries it."""
    return carries(FORMAT, data)


def check_target(path: Path, is_ours: Callable[[bytes], bool] = is_record) -> None:
    """Raises `UserError` where the PDF, and its JSON beside it, cannot be written there. `is_ours`: whether a file of
    this content may be replaced."""
    if path.suffix.lower() != ".pdf":
        why = message(marked("expected {expected}"), expected=".pdf")
        raise UserError(marked("{value}: {why}."), value=path.name, why=why)
    if not path.parent.is_dir():
        raise UserError(marked("There is no folder {folder}."), folder=path.parent)
    for target in (path, path.with_suffix(".json")):
        if target.exists() and not is_ours(_content(target)):
            text = marked("{file} exists and is another kind of file.")
            raise UserError(text, file=target)


def _content(path: Path) -> bytes:
    with suppress(OSError), path.open("rb") as file:
        return file.read(LARGEST_FILE)
    return b""


def write_report(path: Path, signed: SignedRecord, printer: Printer) -> tuple[Path, ...]:
    """Writes the document before it prints, so that a failing printer loses nothing; returns the files written. Raises
    `UserError` as `check_target`, `OSError` or `RuntimeError`; files written before that remain."""
    check_target(path)
    json_path, plain = path.with_suffix(".json"), signed.text.encode()
    write_whole(json_path, plain)
    write_whole(path, printer([report_html(signed)], A4, plain))
    return json_path, path


def suggested_name(record: Record) -> str:
    """A valid file name without suffix for any module name: "M-07 2026-11-21 1403 GO"."""
    return file_name(record.module or "", f"{record.at:%Y-%m-%d %H%M}", record.verdict.value)


def file_name(*parts: str) -> str:
    """A valid file name without suffix from any texts."""
    words = []
    for part in parts:
        word = unicodedata.normalize("NFKC", part[:MAX_NAME_LENGTH])
        words.append(_NOT_IN_NAMES.sub("_", word).strip("_"))
    name = " ".join(word for word in words if word)[:MAX_NAME_LENGTH]
    return f"DPS-S {name}" if _RESERVED.match(name) else name

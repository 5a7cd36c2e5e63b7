"""The report of a check: HTML for the printer, in the language in use, and the files in which it is kept.

Made from the record alone, so that it prints the same years later. FILE.pdf carries the document, and FILE.json beside
it is the document alone.
"""

import hashlib
from contextlib import suppress
from pathlib import Path

from app.guided.results import TITLES, VERDICT_WORDS, GuidedKind
from app.modules.labels import A4, Printer
from app.preflight.checks import RESULT_WORDS, CheckResult
from app.preflight.verdict import MANUAL_WORDS, verdict_sentence
from app.records.record import FORMAT, Record, SignedRecord
from app.records.verification import LARGEST_FILE
from app.settings.profiles import ActivatedBy
from app.store.station import shown_key
from app.system.clock import DAY, local_time
from app.system.files import write_whole
from app.text.i18n import tr
from app.text.messages import UserError, in_brackets, join_sentences, message_from_json
from app.text.template import page
from protocol.translatable import marked

# More manual items, or more checks against it, crowd the page.
ONE_COLUMN = 8
# How Qt writes into a PDF which program made it.
_CREATOR = "DPS-S Configurator".encode("utf-16-be")


def report_html(signed: SignedRecord) -> str:
    record = signed.record
    results = [check.result for check in record.checks]
    passed, looks = results.count(CheckResult.PASS), results.count(CheckResult.WARN)
    # Below the verdict: what restricts it, and how many checks passed.
    under = [caveat.translated() for caveat in record.caveats]
    under.append(tr("Passed: {count} of {all}; warnings: {looks}.", count=passed, all=len(results), looks=looks))
    if record.void is not None:
        # The sentence with which the check of the connection says it.
        why = [message_from_json(check.shown).translated() for check in record.checks if check.id == "connection"]
        under.append(tr("Void: {why}", why=why[0] if why else record.void))
    skipped = sum(item.is_done is None for item in record.manual)
    if skipped:
        under.append(tr("Skipped: {count}.", count=skipped))
    return page(
        "report.html",
        record=record,
        word=verdict_sentence(record.verdict, ActivatedBy(record.activated_by)).translated(),
        under=join_sentences(under),
        words={result: tr(word) for result, word in RESULT_WORDS.items()},
        manual_words={state: tr(word) for state, word in MANUAL_WORDS.items()},
        is_crowded=min(len(record.manual), len(results) - passed) > ONE_COLUMN,
        tests=_tests(record),
        station=shown_key(signed.station),
        digest=hashlib.sha256(signed.text.encode()).hexdigest(),
    )


def _tests(record: Record) -> list[dict[str, str]]:
    tests = []
    for test in record.tests[: len(GuidedKind)]:
        measured = []
        for row in test.measured[:10]:
            name, shown, tolerance = (
                message_from_json(row.get(part)).translated() for part in ("name", "shown", "tolerance")
            )
            measured.append(f"{name}: {shown}{in_brackets(tolerance) if tolerance else ''}")
        when = f"{local_time(test.at, DAY, record.at.tzinfo)}, {test.who or '—'}"
        told = {"title": tr(TITLES[test.kind]), "verdict": test.verdict.value, "word": tr(VERDICT_WORDS[test.verdict])}
        told["when"] = f"{when}, {tr('simulated')}" if test.is_simulated else when
        tests.append({**told, "measured": "; ".join(measured)})
    return tests


# Its files


def check_target(path: Path, kind: str = FORMAT) -> None:
    """Raise `UserError` where the PDF, and its JSON beside it, cannot be written there: only what this program made is
    replaced."""
    if path.suffix.lower() != ".pdf":
        raise UserError(marked("{file}: the name of a report ends in .pdf."), file=path.name)
    if not path.parent.is_dir():
        raise UserError(marked("There is no folder {folder}."), folder=path.parent)
    for target in (path, path.with_suffix(".json")):
        content = b""
        with suppress(OSError), target.open("rb") as file:
            content = file.read(LARGEST_FILE)
        if target.exists() and kind.encode() not in content and _CREATOR not in content:
            raise UserError(marked("{file} exists and is another kind of file."), file=target)


def write_report(path: Path, signed: SignedRecord, printer: Printer) -> tuple[Path, ...]:
    """Writes the document before it prints, so that a failing printer loses nothing; returns the files written. Raises
    `UserError` as `check_target`, `OSError` or `RuntimeError`; files written before that remain."""
    check_target(path)
    json_path, plain = path.with_suffix(".json"), signed.text.encode()
    write_whole(json_path, plain)
    write_whole(path, printer([report_html(signed)], A4, plain))
    return json_path, path

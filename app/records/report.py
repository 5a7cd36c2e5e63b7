"""The report of a check, as HTML for the printer, in the language in use.

Made from the record alone, so that it prints the same years later.
"""

import hashlib
from collections.abc import Iterable, Mapping
from datetime import tzinfo
from typing import Any

from app.guided.results import TITLES, VERDICT_WORDS, GuidedKind, stored_test
from app.preflight.findings import RESULT_WORDS, CheckResult
from app.preflight.verdict import MANUAL_WORDS, Verdict, verdict_sentence
from app.records.record import Record, SignedRecord
from app.settings.profiles import ActivatedBy
from app.stations.station import fingerprint_of
from app.system.wall_clock import DAY, local_time
from app.text.i18n import tr
from app.text.messages import message_from_json
from app.text.sentences import in_brackets, join_sentences
from app.text.template import page

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

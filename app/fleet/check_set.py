"""Pre-flight checks of several modules: verdicts, reasons, a report of each and a first page."""

import json
from collections import Counter
from collections.abc import Iterable, Sequence
from functools import partial
from pathlib import Path
from typing import NamedTuple

from app.modules.labels import A4, Printer
from app.preflight.module_checks import RecordsWord, records_word
from app.preflight.verdict import Verdict
from app.records.filing import Filed, local_now
from app.records.report_files import carries, check_target, suggested_name, write_report
from app.system.files import write_whole
from app.text.i18n import tr
from app.text.messages import UserMessage, clean
from app.text.sentences import join_names
from app.text.template import page
from protocol.translatable import marked

# Marks a first page; what counts is each module's own record.
FIRST_PAGE = "dps-s pre-flight set"
NOT_CHECKED = marked("not checked")


class SetMember(NamedTuple):
    """`filed` None: the module was not reached, `trouble` says why."""

    port: str
    name: str = ""
    filed: Filed | None = None
    trouble: UserMessage | None = None

    @property
    def verdict(self) -> Verdict | None:
        return None if self.filed is None else self.filed.assessment.verdict

    @property
    def word(self) -> RecordsWord | None:
        """What a person can say of its trigger records."""
        return None if self.filed is None else records_word(self.filed.assessment.case)

    @property
    def why(self) -> str:
        """What stands against it, translated; empty for GO and READY."""
        if self.trouble is not None:
            return self.trouble.translated()
        titles = () if self.filed is None else self.filed.assessment.titles_against
        return join_names(title.translated() for title in titles)


def word_of(verdict: Verdict | None) -> str:
    return tr(NOT_CHECKED if verdict is None else verdict.value)


def summary(verdicts: Iterable[Verdict | None]) -> str:
    """ "2 GO, 1 READY, 1 NO-GO"."""
    counts = Counter(verdicts)
    order = (Verdict.GO, Verdict.READY, Verdict.NO_GO, None)
    return join_names(f"{counts[verdict]} {word_of(verdict)}" for verdict in order if counts[verdict])


def check_set_target(path: Path) -> None:
    """Raise `UserError` if the reports cannot be written there."""
    check_target(path, partial(carries, FIRST_PAGE), beside=".pdf")


def write_set_reports(path: Path, members: Sequence[SetMember], printer: Printer) -> tuple[Path, ...]:
    """Write the report of each module, "FILE 01 M-07 … GO", and FILE.pdf, a first page that names them. Returns what
    was written. Raises `UserError`, `OSError` or `RuntimeError`; what was written before that stays."""
    check_set_target(path)
    rows: list[dict[str, str]] = []
    written: list[Path] = []
    for number, member in enumerate(members, 1):
        report = ""
        if member.filed is not None:
            report = f"{path.stem} {number:02} {suggested_name(member.filed.record)}.pdf"
            written += write_report(path.with_name(report), member.filed.exported, printer)
        rows.append(
            {
                "verdict": (member.verdict or Verdict.NO_GO).value,
                "word": word_of(member.verdict),
                "title": clean(member.name) or tr("Unnamed"),
                "port": member.port,
                "why": member.why,
                "report": report,
            }
        )
    first = page(
        "checks.html",
        title=tr("Pre-flight check, modules: {count}", count=len(members)),
        at=local_now().isoformat(sep=" ", timespec="minutes"),
        summary=summary(member.verdict for member in members),
        members=rows,
    )
    write_whole(path, printer([first], A4, json.dumps({"format": FIRST_PAGE}).encode()))
    return (*written, path)

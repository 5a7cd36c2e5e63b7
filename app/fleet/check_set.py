"""Pre-flight checks of several modules: verdicts, reasons, a report of each and a first page."""

import json
from collections import Counter
from collections.abc import Sequence
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

FIRST_PAGE = "dps-s pre-flight set"
"""Marks a first page; what counts is each module's own record."""
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
    def title(self) -> str:
        return clean(self.name) or tr("Unnamed")

    @property
    def against(self) -> tuple[UserMessage, ...]:
        return () if self.filed is None else self.filed.assessment.titles_against

    @property
    def word(self) -> RecordsWord | None:
        """What a person can say of its trigger records."""
        return None if self.filed is None else records_word(self.filed.assessment.case)

    @property
    def why(self) -> str:
        """What stands against it, translated; empty for GO and READY."""
        if self.trouble is not None:
            return self.trouble.translated()
        return join_names(title.translated() for title in self.against)


def word_of(verdict: Verdict | None) -> str:
    return tr(NOT_CHECKED if verdict is None else verdict.value)


def summary(members: Sequence[SetMember]) -> str:
    """ "2 GO, 1 READY, 1 NO-GO"."""
    counts = Counter(member.verdict for member in members)
    order = (Verdict.GO, Verdict.READY, Verdict.NO_GO, None)
    return join_names(f"{counts[verdict]} {word_of(verdict)}" for verdict in order if counts[verdict])


def first_page(members: Sequence[SetMember], reports: Sequence[str]) -> str:
    """The table of all modules as HTML, with the names of their reports."""
    rows = []
    for member, report in zip(members, reports, strict=True):
        verdict = member.verdict or Verdict.NO_GO
        rows.append(
            {
                "verdict": verdict.value,
                "word": word_of(member.verdict),
                "title": member.title,
                "port": member.port,
                "why": member.why,
                "report": report,
            }
        )
    return page(
        "checks.html",
        title=tr("Pre-flight check, modules: {count}", count=len(members)),
        at=local_now().isoformat(sep=" ", timespec="minutes"),
        summary=summary(members),
        members=rows,
    )


def check_set_target(path: Path) -> None:
    """Raise `UserError` if the reports cannot be written there."""
    check_target(path, partial(carries, FIRST_PAGE), beside=".pdf")


def write_set_reports(path: Path, members: Sequence[SetMember], printer: Printer) -> tuple[Path, ...]:
    """Write the report of each module, "FILE 01 M-07 … GO", and FILE.pdf, a first page that names them. Returns what
    was written. Raises `UserError`, `OSError` or `RuntimeError`; what was written before that stays."""
    check_set_target(path)
    names, written = list[str](), list[Path]()
    for number, member in enumerate(members, 1):
        names.append("")
        if member.filed is not None:
            names[-1] = f"{path.stem} {number:02} {suggested_name(member.filed.record)}.pdf"
            written += write_report(path.with_name(names[-1]), member.filed.exported, printer)
    write_whole(path, printer([first_page(members, names)], A4, json.dumps({"format": FIRST_PAGE}).encode()))
    return (*written, path)

"""Pre-flight checks of several modules: verdicts, reasons, and one report of all."""

import html
import json
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from app.preflight.module_checks import RecordsWord, records_word
from app.preflight.verdict import Verdict
from app.records.filing import Filed, local_now
from app.records.report_files import Printer, check_target, suggested_name, write_report
from app.records.report_html import VERDICT_STYLES
from app.system.files import write_whole
from app.text.i18n import tr
from app.text.messages import UserMessage, clean
from app.text.sentences import join_names
from protocol.translatable import marked

FORMAT = "dps-s pre-flight set"
NOT_CHECKED = marked("not checked")


@dataclass(frozen=True, slots=True)
class SetMember:
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
        return join_names(one.translated() for one in self.against)


def word_of(verdict: Verdict | None) -> str:
    return tr(NOT_CHECKED if verdict is None else verdict.value)


def summary(members: Sequence[SetMember]) -> str:
    """ "2 GO, 1 READY, 1 NO-GO"."""
    counts = Counter(one.verdict for one in members)
    order = (Verdict.GO, Verdict.READY, Verdict.NO_GO, None)
    return join_names(f"{counts[verdict]} {word_of(verdict)}" for verdict in order if counts[verdict])


def plain_set(members: Sequence[SetMember]) -> dict[str, object]:
    """For JSON: verdict, reasons in English, and the hash of each module's own record."""
    return {
        "format": FORMAT,
        "at": local_now().isoformat(timespec="seconds"),
        "modules": [
            {
                "port": one.port,
                "module": one.name or None,
                "verdict": None if one.verdict is None else one.verdict.value,
                "against": [each.in_english() for each in one.against],
                "trouble": None if one.trouble is None else one.trouble.in_english(),
                "hash": None if one.filed is None else one.filed.record.get("hash"),
            }
            for one in members
        ],
    }


def report_body(members: Sequence[SetMember]) -> str:
    """The table of all modules as HTML."""
    head = "".join(
        f'<td style="color:#555555">{html.escape(tr(text))}</td>'
        for text in (marked("Verdict"), marked("Module"), marked("Port"), marked("Why not"))
    )
    rows = []
    for one in members:
        _, colour = VERDICT_STYLES[one.verdict or Verdict.NO_GO]
        cells = (one.title, clean(one.port), clean(one.why))
        rows.append(
            f'<tr><td bgcolor="{colour}"><font color="#ffffff"><b>{html.escape(word_of(one.verdict))}</b></font></td>'
            + "".join(f"<td>{html.escape(cell)}</td>" for cell in cells)
            + "</tr>"
        )
    title = html.escape(tr("Pre-flight check, modules: {count}", count=len(members)))
    at = html.escape(local_now().isoformat(sep=" ", timespec="minutes"))
    return (
        f'<p><font size="5"><b>{title}</b></font> {at}</p><p>{html.escape(summary(members))}</p>'
        f'<table width="100%" cellpadding="4" cellspacing="0" border="1"><tr>{head}</tr>{"".join(rows)}</table>'
    )


def check_set_target(path: Path) -> None:
    """Raise `UserError` if the reports cannot be written there."""
    check_target(path, lambda target: _is_ours(target.with_suffix(".json")))


def _is_ours(path: Path) -> bool:
    try:
        found = json.loads(path.read_bytes())
    except (OSError, ValueError, RecursionError):
        return False
    return isinstance(found, dict) and found.get("format") == FORMAT


def write_set_reports(path: Path, members: Sequence[SetMember], printer: Printer | None) -> tuple[Path, ...]:
    """Write FILE.pdf and FILE.json about all, and "FILE 01 M-07 … GO" for each module.

    Returns what was written. Raises `OSError` or `RuntimeError`; what was written before that stays.
    """
    plain = json.dumps(plain_set(members), ensure_ascii=False, indent=1).encode()
    json_path = path.with_suffix(".json")
    write_whole(json_path, plain)
    written = [json_path]
    for number, one in enumerate(members, 1):
        if one.filed is not None:
            name = f"{path.stem} {number:02} {suggested_name(one.filed.record)}.pdf"
            written += write_report(path.with_name(name), one.filed.record, printer)
    if printer is not None:
        write_whole(path, printer(report_body(members), plain))
        written.append(path)
    return tuple(written)

"""Texts of the verdict banner."""

from app.preflight.checks import CHECKS
from app.preflight.findings import CheckResult
from app.preflight.verdict import VERDICT_WORDS, Assessment, Verdict, meaning_of
from app.records.record import caveats
from app.safety.last_known import LAST_HEARD_ACTIVE, keep_away
from app.text.durations import duration
from app.text.i18n import tr
from app.text.sentences import capitalised, join_names, join_sentences
from ui.pages.preflight.controller import PreflightController, Standing
from ui.pages.preflight.verdict import Announcement

MAX_NAMED = 5
"""Checks named in the banner; the rows name all."""


def announcement(work: PreflightController) -> Announcement:
    standing, assessment = work.standing, work.assessment
    match standing:
        case Standing.CHECKING:
            return _checking(work)
        case Standing.VOID if work.void is not None:
            lines = (tr("The results below are void. Check again."),)
            return Announcement(standing, tr("VOID"), capitalised(work.void.message.translated()), lines)
        case Standing.GO | Standing.READY if assessment is not None:
            return _passed(work, assessment)
        case Standing.NO_GO if assessment is not None:
            return _failed(work, assessment)
        case _:
            return _not_checked(work)


def _not_checked(work: PreflightController) -> Announcement:
    """What to do first. A module that was just powered up always needs its triggers enabled."""
    head = tr("Start the check.") if work.can_check else tr("Connect a module.")
    lines = [tr("Set the aircraft level and do not touch it.")]
    if work.can_check and work.reported_active:
        lines = [tr("The module is ACTIVE: to enable triggers, lock it first."), tr("Do not touch the aircraft.")]
    elif work.can_check and work.may_fire:
        lines = [tr(LAST_HEARD_ACTIVE), keep_away()]
    elif work.can_check and not work.are_triggers_known:
        head = tr("Enable triggers and check")
        lines.insert(0, tr("Trigger state is unknown after power-up. Enable the triggers to set it."))
    return Announcement(Standing.NOT_CHECKED, tr("NOT CHECKED"), head, tuple(lines))


def _checking(work: PreflightController) -> Announcement:
    report = work.progress
    doing = tr("Link") if report is None else tr(report.doing)
    share = 0.0 if report is None or not report.total else report.done / report.total
    return Announcement(Standing.CHECKING, tr("CHECKING"), doing, (tr("Do not touch the aircraft."),), progress=share)


def _passed(work: PreflightController, assessment: Assessment) -> Announcement:
    verdict = assessment.verdict
    head = capitalised(meaning_of(verdict, assessment.case.expectations.activated_by).translated())
    if verdict is Verdict.READY and work.reported_active is not False:
        head = tr("Reading again…")  # it may be active by now
    warnings = sum(one.finding.result is CheckResult.WARN for one in assessment.checks)
    what = tr("All {count} checks passed; warnings: {looks}.", count=len(CHECKS), looks=warnings)
    skipped = sum(item.is_done is None for item in assessment.manual)
    if skipped:
        what = join_sentences((what, tr("Skipped: {count}.", count=skipped)))
    caveat, signature = _footer(work)
    return Announcement(work.standing, tr(VERDICT_WORDS[verdict]), head, (*filter(None, (caveat,)), what, signature))


def _failed(work: PreflightController, assessment: Assessment) -> Announcement:
    names = [one.translated() for one in assessment.titles_against]
    named = join_names(names[:MAX_NAMED])
    if len(names) > MAX_NAMED:
        named = tr("{names} and {count} more", names=named, count=len(names) - MAX_NAMED)
    head = capitalised(meaning_of(Verdict.NO_GO, assessment.case.expectations.activated_by).translated())
    # Checks are named by what must hold: "Parachute bay closed" alone would be read as the opposite of the fault.
    lines = (tr("Not met: {names}", names=named), *filter(None, _footer(work)))
    return Announcement(Standing.NO_GO, tr(VERDICT_WORDS[Verdict.NO_GO]), head, lines)


def _footer(work: PreflightController) -> tuple[str, str]:
    """Caveats of the record, may be empty; then whose record it is, and how long a GO or READY holds."""
    if work.filed is None:
        return "", ""
    record, left_s = work.filed.record, work.expires_in_s
    parts = [str(record[key]) for key in ("module", "aircraft", "who") if record.get(key)]
    parts.append(str(record.get("at", ""))[11:19])
    if left_s is not None:
        unit_s = 1 if left_s < 120 else 60
        parts.append(tr("holds for {time}", time=duration(left_s // unit_s * unit_s)))  # never longer than it does
    return join_sentences(one.translated() for one in caveats(record)), " · ".join(parts)

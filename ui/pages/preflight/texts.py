"""Texts of the verdict banner."""

from typing import NamedTuple

from app.preflight.checks import CHECKS
from app.preflight.findings import CheckResult
from app.preflight.verdict import VERDICT_WORDS, Verdict, meaning_of
from app.records.record import caveats
from app.text.i18n import tr
from app.text.sentences import begun, listed, together
from ui.pages.preflight.controller import PreflightController, Standing
from ui.pages.preflight.verdict import Announcement

MOST_NAMED = 5
"""Checks that are named in the banner; the rows name all."""


def announcement(work: PreflightController, *, is_connected: bool) -> Announcement:
    standing = work.standing
    match standing:
        case Standing.NOT_CHECKED:
            return Announcement(standing, tr("NOT CHECKED"), *_before(work, is_connected=is_connected))
        case Standing.CHECKING:
            return _checking(work)
        case Standing.VOID:
            why = begun(work.void.said.in_words()) if work.void is not None else ""
            lines = (tr("The results below are void. Check again."),)
            return Announcement(standing, tr("VOID"), why, lines)
        case Standing.GO | Standing.READY | Standing.NO_GO:
            return _judged(work, standing)


class _Before(NamedTuple):
    head: str
    lines: tuple[str, ...]


def _before(work: PreflightController, *, is_connected: bool) -> _Before:
    """What to do first. A module that has just been started always needs its triggers enabled."""
    start = tr("Start the check.")
    if is_connected and work.reported_active:
        what = tr("The module is ACTIVE: to enable triggers, lock it first.")
        return _Before(start, (what, tr("Do not touch the aircraft.")))
    if is_connected and work.may_fire:
        return _Before(start, (tr("Last heard ACTIVE: treat it as ready to fire."),))
    level = tr("Set the aircraft level and do not touch it.")
    if is_connected and not work.are_triggers_known:
        why = tr("Trigger state is unknown after power-up. Enable the triggers to set it.")
        return _Before(tr("Enable triggers and check"), (why, level))
    return _Before(start if is_connected else tr("Connect a module."), (level,))


def _checking(work: PreflightController) -> Announcement:
    report = work.progress
    doing = tr("Link") if report is None else tr(report.doing)
    share = 0.0 if report is None or not report.total else report.done / report.total
    lines = (tr("Do not touch the aircraft."),)
    return Announcement(Standing.CHECKING, tr("CHECKING"), doing, lines, progress=share)


def _judged(work: PreflightController, standing: Standing) -> Announcement:
    assessment = work.assessment
    if assessment is None:
        return Announcement(standing, "")
    verdict = assessment.verdict
    word = tr(VERDICT_WORDS[verdict])
    head = begun(meaning_of(verdict, assessment.case.expectations.activated_by).in_words())
    if verdict is Verdict.READY and work.reported_active is not False:
        head = tr("Reading again…")  # it may be active by now
    if verdict is not Verdict.NO_GO:
        looks = sum(one.finding.result is CheckResult.WARN for one in assessment.checks)
        what = tr("All {count} checks hold; warnings: {looks}.", count=len(CHECKS), looks=looks)
        skipped = sum(item.is_done is None for item in assessment.manual)
        if skipped:
            what = together((what, tr("Skipped: {count}.", count=skipped)))
        beside, *foot = _foot(work)
        return Announcement(standing, word, head, (*filter(None, (beside,)), what, *foot))
    names = [one.in_words() for one in assessment.titles_against]
    named = listed(names[:MOST_NAMED])
    if len(names) > MOST_NAMED:
        named = tr("{names} and {count} more", names=named, count=len(names) - MOST_NAMED)
    # Checks are named by what has to be so: "Parachute bay closed" alone would be read as the opposite of the fault.
    lines = (tr("Not met: {names}", names=named), *filter(None, _foot(work)))
    return Announcement(standing, word, head, lines)


def _foot(work: PreflightController) -> tuple[str, ...]:
    """What stands beside the verdict, "" for nothing; then whose record it is, and how long a GO or READY holds."""
    filed = work.filed
    if filed is None:
        return ("",)
    record = filed.record
    beside = together([one.in_words() for one in caveats(record)])
    parts = [str(record[key]) for key in ("module", "aircraft", "who") if record.get(key)]
    at = str(record.get("at", ""))[11:19]
    parts.append(at)
    left_s = work.expires_in_s
    if left_s is not None:
        minutes = int(left_s) // 60
        parts.append(
            tr("holds for {minutes} min", minutes=minutes)
            if minutes
            else tr("holds for {seconds} s", seconds=int(left_s))
        )
    return (beside, " · ".join(parts))

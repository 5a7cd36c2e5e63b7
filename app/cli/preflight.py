"""`dps-s preflight`: checks whether the module is fit to fly.

Exit code 0 for GO and READY, 1 for NO-GO, 3 if no module answers. Sends queries only, and with --enable-triggers the
two settings that enable the automatic triggers. With --activate --yes a module that is READY is activated, once, and
read again in the same conversation: GO, or NO-GO. The check is kept in the store if there is one. Several ports are
checked one after the other.
"""

import argparse

from app.cli.act import permit_for, refuse_without_yes
from app.engine.conversation import Interrupted
from app.engine.target import is_simulated
from app.limits.past import Past
from app.preflight.checks import RESULT_WORDS, CheckResult, Person
from app.preflight.evidence import Evidence
from app.preflight.reading_object import ReadJson, readings_of
from app.preflight.run import activate_ready, run_preflight
from app.preflight.verdict import MANUAL_WORDS, Assessment, Judged, Verdict, blocks_go, verdict_sentence
from app.records.filing import Filed, file_check
from app.records.report import check_target, write_report
from app.safety.journal import Act, Outcome
from app.safety.left_active import note_go
from app.settings.profile_file import read_profile
from app.settings.profiles import NO_PROFILE, ManualLine, Profile
from app.terminal import console
from app.terminal.connection import LOST, connected
from app.terminal.records import CommandStore, refuse_another, say_not_kept
from app.terminal.results import Result, Value
from app.text.i18n import tr
from app.text.messages import UserMessage, clean, in_brackets, join_names


class CheckJson(Result):
    id: str
    result: CheckResult
    measured: Value
    limit: str
    why: str
    do: str


class PreflightJson(Result):
    verdict: Verdict
    checks: list[CheckJson]
    read: ReadJson
    simulated: bool
    softer_limits: list[str]


def add_arguments(parser: argparse.ArgumentParser) -> None:
    console.add_file(parser, "--profile", metavar="FILE", help="profile that says how the module should be set")
    parser.add_argument("--enable-triggers", action="store_true", help="enable both automatic triggers first")
    parser.add_argument("--activate", action="store_true", help="enable, check, activate if READY, and read again: GO")
    console.add_file(parser, "--report", metavar="FILE.pdf", help="write the report, and the record beside it")
    console.add_module(parser, "name of the module")
    parser.add_argument("--aircraft", default="", metavar="NAME", help="aircraft")
    parser.add_argument("--who", default="", metavar="NAME", help="who checks")
    parser.add_argument("--done", type=int, action="append", metavar="N", help="item N of the profile is in order")
    console.add_flags(parser, "--yes", "--records-reviewed")


def run(args: argparse.Namespace) -> int:
    if args.activate:
        refuse_without_yes(args, Act.ACTIVATE)
    for option, given in (("--module", args.module), ("--activate", args.activate), ("--report", args.report)):
        if given and len(args.ports) > 1:
            raise console.Refused(tr("{option} takes one port only.", option=option))
    profile = NO_PROFILE if args.profile is None else read_profile(args.profile)
    for number in args.done or ():
        if not 1 <= number <= len(profile.manual):
            raise console.Refused(tr("No manual item {number} in the profile.", number=number))
    profile = profile.answered(dict.fromkeys(args.done or (), True))
    if args.report is not None:
        check_target(args.report)
    codes: list[int] = []
    for port in args.ports:
        if len(args.ports) > 1 and not args.json:
            console.write_lines([port])
        try:
            with CommandStore(port, args.module) as store:
                codes.append(_check(args, profile, store))
        except LOST as error:
            if len(args.ports) == 1:
                raise
            codes.append(console.fail(error, is_json=args.json))
    # The gravest code wins: one module that must not fly is not hidden by a port where none answers.
    return next((code for code in (console.ANSWER_NO, console.NO_LINK, console.PARTIAL) if code in codes), 0)


def _check(args: argparse.Namespace, profile: Profile, store: CommandStore) -> int:
    """Check the module at one port, judge, keep and print it; returns the exit code. Raises what keeps a conversation
    from beginning."""
    evidence, is_enabling = Evidence(port=store.port), args.enable_triggers or args.activate
    person = Person(
        who=args.who,
        module=args.module,
        aircraft=args.aircraft,
        are_records_reviewed=args.records_reviewed,
        is_same_module=args.same_module,
    )

    def judge(found: Evidence, past: Past | None = None) -> Filed:
        """And keep it. `past`: the module's history before the check, where it was read already."""
        return file_check(found, profile, person, store=store, adapter=store.where.adapter, past=past)

    filed: Filed | None = None
    past: Past | None = None
    is_refused = False
    with connected(store.port, args.baud, journal=store.journal) as opened:
        refuse_another(opened.conversation, store, args)
        try:
            opened.run(run_preflight(evidence, is_enabling=is_enabling, journal=store.journal))
            if args.activate:
                # READY is kept, then the module is activated and judged again. Anything but READY sends nothing.
                filed = judge(evidence)  # the store may be slow; the conversation goes on meanwhile
                ready = filed.assessment
                if ready.verdict is Verdict.READY:
                    permit = permit_for(Act.ACTIVATE, opened)
                    performed, evidence = opened.run(activate_ready(ready, store.journal, permit))
                    say = console.note if performed.outcome is Outcome.CONFIRMED else console.notify
                    say(performed.sentence)
                    is_refused = performed.outcome is Outcome.NOT_SENT
                    if evidence is not ready.case.evidence:
                        filed, past = None, ready.case.past
        # READY said nothing about whoever answers now, so the check is judged again, with its interruption.
        except Interrupted as ended:
            evidence.note_error(ended)
            filed = None
    if filed is None:  # only now, as LOCK that is owed does not wait for the store
        filed = judge(evidence, past)
        if filed.assessment.verdict is Verdict.GO:
            store.write(lambda facts: note_go(facts, store.run))

    def write_files(filed: Filed = filed) -> None:
        console.note(join_names(map(str, write_report(args.report, filed.exported, args.printer))))

    # The report comes first, as printing fails where nobody reads.
    is_written = args.report is None or console.wrote(args.report, write_files)
    console.emit(args, contract_of(filed.assessment), page_of(filed))
    if filed.trouble is not None:
        say_not_kept(filed.trouble)
    if filed.assessment.verdict is Verdict.NO_GO or is_refused:
        return console.ANSWER_NO
    return console.SUCCESS if is_written else console.PARTIAL


def contract_of(assessment: Assessment) -> PreflightJson:
    """Return the check in English, with the manual items last, as "manual_1" …"""
    checks = [_result_of(judged) for judged in assessment.checks]
    checks += [_result_of_item(number, item) for number, item in enumerate(assessment.case.profile.manual, 1)]
    return PreflightJson(
        verdict=assessment.verdict,
        checks=checks,
        read=readings_of(assessment.case.evidence),
        simulated=is_simulated(assessment.case.evidence.port),
        softer_limits=list(assessment.softened),
    )


def _result_of(judged: Judged) -> CheckJson:
    check, finding = judged
    measured = None if finding.result is CheckResult.UNKNOWN else finding.measured
    why = check.why
    if finding.result is not CheckResult.PASS:
        why += f" Found: {finding.shown.in_english().removesuffix('.')}."
    return CheckJson(check.id, finding.result, measured, finding.limit.in_english(), why, judged.do.in_english())


def _result_of_item(number: int, item: ManualLine) -> CheckJson:
    result, measured = CheckResult.UNKNOWN if blocks_go(item) else CheckResult.WARN, "skipped"
    if item.is_done is not None:
        result, measured = (CheckResult.PASS, "done") if item.is_done else (CheckResult.FAIL, "not in order")
    return CheckJson(f"manual_{number}", result, measured, "done", clean(item.text), "Look at it and tick it.")


def page_of(filed: Filed) -> list[console.Line]:
    """The verdict with its caveats, then every check; if it did not pass, why it matters and what to do."""
    assessment = filed.assessment
    is_no_go = assessment.verdict is Verdict.NO_GO
    verdict = verdict_sentence(assessment.verdict, assessment.case.profile.activated_by).translated()
    lines: list[console.Line] = [(verdict, console.BAD if is_no_go else console.GOOD)]
    lines += [caveat.translated() for caveat in filed.record.caveats]
    lines += [""] if is_no_go else [tr("Valid now only; not monitored afterwards."), ""]
    rows: list[tuple[str, ...]] = []
    for check in assessment.checks:
        finding = check.finding
        shown = finding.shown.translated() + in_brackets(finding.limit.translated())
        rows.append((tr(RESULT_WORDS[finding.result]), UserMessage(check.check.title).translated(), shown))
        if finding.result is not CheckResult.PASS:
            rows.append(("", "", f"{UserMessage(check.check.why).translated()} → {check.do.translated()}"))
    rows += [(tr(MANUAL_WORDS[item.is_done]), clean(item.text)) for item in assessment.case.profile.manual]
    return [*lines, *console.columns(rows)]

"""`dps-s preflight`: checks whether the module is fit to fly.

Exit code 0 for GO and READY, 1 for NO-GO, 3 if no module answers or it stops answering. Sends queries only, and with
--enable-triggers the two settings that enable the automatic triggers. With --activate --yes a module that is READY is
activated, once, and read again in the same connection: GO, or NO-GO. The check is kept in the store if there is one.
"""

import argparse
import threading
import time
from collections.abc import Sequence
from itertools import chain, repeat
from math import inf
from pathlib import Path

import msgspec

from app.cli.results import CheckJson, ErrorJson, FailureJson, PreflightJson
from app.engine.procedure import await_asking
from app.fleet.check_set import SetMember, check_set_target, summary, word_of, write_set_reports
from app.limits.past import Past
from app.preflight.activation import activate_ready
from app.preflight.contract import contract_of
from app.preflight.evidence import Disturbance, Evidence
from app.preflight.findings import RESULT_WORDS, CheckResult, Person
from app.preflight.run import run_preflight
from app.preflight.verdict import MANUAL_WORDS, Verdict, verdict_sentence
from app.records.filing import Filed, file_check
from app.records.report_files import check_target, write_report
from app.safety.acts import EFFECTS, Act
from app.safety.journal import Outcome
from app.safety.permit import Origin, Permit
from app.settings.profile_file import read_profile
from app.settings.profiles import NO_PROFILE, Profile
from app.store.fact_store import Store
from app.terminal import console
from app.terminal.arguments import add_file, add_json, add_module, add_port, add_same_module, add_yes, any_name
from app.terminal.command_journal import in_background, opened_store, records_on
from app.terminal.connection import Conversation, LinkTrouble, connected, link_trouble, module_is_silent
from app.terminal.console import Colour, coloured
from app.terminal.interruption import Interruption
from app.terminal.stored_history import may_be_another
from app.text.i18n import tr
from app.text.messages import UserMessage, clean
from app.text.sentences import in_brackets, join_names, join_sentences, not_written
from app.text.user_error import ErrorCode, UserError

_WAIT_S = 0.1


def add_arguments(parser: argparse.ArgumentParser) -> None:
    add_port(parser, takes_several=True)
    add_file(parser, "--profile", type=Path, metavar="FILE", help="profile that says how the module should be set")
    parser.add_argument("--enable-triggers", action="store_true", help="enable both automatic triggers first")
    parser.add_argument("--activate", action="store_true", help="enable, check, activate if READY, and read again: GO")
    add_yes(parser)
    add_file(parser, "--report", type=Path, metavar="FILE.pdf", help="write the report, and the record beside it")
    add_module(parser, "name of the module")
    parser.add_argument("--aircraft", type=any_name, default="", metavar="NAME", help="aircraft")
    parser.add_argument("--who", type=any_name, default="", metavar="NAME", help="who checks")
    parser.add_argument(
        "--done", type=int, action="append", default=[], metavar="N", help="manual item N of the profile is in order"
    )
    parser.add_argument(
        "--records-reviewed",
        action="store_true",
        help="the trigger records were judged; a module that never answers their query is new",
    )
    add_same_module(parser)
    add_json(parser)


def run(args: argparse.Namespace) -> int:
    if args.activate and not args.yes:
        if not args.json:
            console.write_lines([tr(EFFECTS[Act.ACTIVATE])])
        console.refuse_without("--yes")
    ports = [args.port] if isinstance(args.port, str) else list(dict.fromkeys(args.port))
    is_one = len(ports) == 1
    if not is_one and (args.activate or args.module is not None):
        option = "--module" if args.module is not None else "--activate"
        raise console.Refused(tr("{option} takes one port only.", option=option))
    profile = _profile(args.profile, args.done)
    if args.report is not None:
        (check_target if is_one else check_set_target)(args.report)
    with opened_store() as (store, troubles):
        checks = [_PortCheck(args, port, profile, store, troubles) for port in ports]
        if is_one:
            checks[0].gather()
        else:
            _gather_all(checks)
        # All are filed before anything is printed, which fails where nobody reads.
        for check in checks:
            if check.error is None:
                check.file()
        members = [check.member() for check in checks]
    code = _conclude_all(args, members)
    return console.ANSWER_NO if checks[0].is_refused and code == console.SUCCESS else code


class _PortCheck:
    """The check on one port. `trouble`: a sentence if the link was lost meanwhile; `error`: why nothing was read."""

    def __init__(
        self, args: argparse.Namespace, port: str, profile: Profile, store: Store, troubles: list[UserMessage]
    ) -> None:
        self._args, self._profile, self._store = args, profile, store
        self.port = port
        self._records = records_on(store, troubles, port, origin="preflight", module=(args.module or "").strip())
        self.trouble: str | None = None
        self.error: BaseException | None = None
        self.is_refused = False
        """The activation was not sent."""
        self._evidence = Evidence(port=port)
        self._past: Past | None = None
        """The module's history before the check, where it was read already."""
        self._filed: Filed | None = None
        """Where it was judged already."""

    def gather(self, interruption: Interruption | None = None) -> None:
        """Run the check, and activate in the same connection. Raises the errors that mean "no link"."""
        args, store, journal = self._args, self._store, self._records.journal
        with (
            connected(
                self.port,
                args.baud,
                on_batch=lambda batch: self._evidence.listen(batch.events),
                interruption=interruption,
            ) as conversation,
            LinkTrouble() as link,
        ):
            is_enabling = (args.enable_triggers or args.activate) and not (
                args.module and not args.same_module and may_be_another(conversation, store, args.module)
            )
            try:
                conversation.run(run_preflight(self._evidence, is_enabling=is_enabling, journal=journal))
                if args.activate:
                    self._activate(conversation)
            except KeyboardInterrupt:
                if is_enabling:
                    console.notify(tr("Interrupted; may have been carried out."))
                raise
        if link.sentence is not None:
            self.trouble = link.sentence
            self._evidence.disturbance = self._evidence.disturbance or Disturbance.DISCONNECTED
            self._filed = None
        elif self._evidence.disturbance is Disturbance.SILENT:
            self.trouble = module_is_silent(self.port, conversation.device)

    def file(self) -> Filed:
        """Judge and keep it."""
        if self._filed is None:
            args = self._args
            person = Person(who=args.who, module=args.module, aircraft=args.aircraft,
                            are_records_reviewed=args.records_reviewed, is_same_module=args.same_module,
                            is_named_by_option=True)  # fmt: skip
            self._filed = file_check(
                self._evidence, self._profile, person, store=self._store,
                adapter=self._records.adapter(), past=self._past,
            )  # fmt: skip
        return self._filed

    def member(self) -> SetMember:
        """Raises what is no lost link."""
        trouble = self.trouble if self.error is None else link_trouble(self.error)
        if self.error is not None and trouble is None:
            raise self.error
        filed = None if self.error is not None else self.file()
        return SetMember(self.port, "", filed, UserMessage(trouble) if trouble else None)

    def _activate(self, conversation: Conversation) -> None:
        """READY is kept, then the module is activated and judged again. Anything but READY sends nothing."""
        filing = in_background(self.file)
        conversation.run(await_asking(filing, inf))
        filed = filing.result()
        if filed.assessment.verdict is not Verdict.READY:
            return
        permit = Permit(Act.ACTIVATE, Origin.COMMAND_LINE, time.monotonic())
        performed, evidence = conversation.run(activate_ready(filed.assessment, self._records.journal, permit))
        self.is_refused = performed.outcome is Outcome.NOT_SENT
        (console.note if performed.outcome is Outcome.CONFIRMED else console.notify)(performed.sentence)
        if evidence is not filed.assessment.case.evidence:
            self._evidence, self._filed, self._past = evidence, None, filed.assessment.case.past


def _gather_all(checks: Sequence[_PortCheck]) -> None:
    """One thread for each port; the main thread waits for all, and for Ctrl-C."""
    with Interruption() as interruption:

        def gather(check: _PortCheck) -> None:
            try:
                check.gather(interruption)
            except BaseException as error:  # noqa: BLE001  reported or raised in the main thread
                check.error = error

        threads = [
            threading.Thread(target=gather, args=(check,), name=f"dps-s {check.port}", daemon=True) for check in checks
        ]
        for thread in threads:
            thread.start()
        while alive := [thread for thread in threads if thread.is_alive()]:
            console.show_progress(f"{len(checks) - len(alive)}/{len(checks)}")
            alive[0].join(_WAIT_S)
        console.clear_progress()
        interruption.check()


def _conclude_all(args: argparse.Namespace, members: Sequence[SetMember]) -> int:
    """Print the checks and write the reports; returns the exit code."""
    codes: list[int] = []
    has_titles = len(members) > 1 and not args.json
    try:
        for member in members:
            if has_titles:
                console.write_lines([*([""] if codes else []), member.port])
            codes.append(_conclude(args, member))
        if has_titles:
            rows = [(word_of(member.verdict), member.port, member.why) for member in members]
            console.write_lines(["", summary(members), *console.columns(rows)])
    finally:  # also where nobody reads
        if args.report is not None and not _write_reports(args, members):
            codes.append(console.PARTIAL)
    return next(filter(codes.__contains__, (console.ANSWER_NO, console.NO_LINK, console.PARTIAL)), console.SUCCESS)


def _write_reports(args: argparse.Namespace, members: Sequence[SetMember]) -> bool:
    """Write and print the names of the files; whether that succeeded."""
    try:
        if len(members) == 1 and members[0].filed is not None:
            written = write_report(args.report, members[0].filed.exported, args.printer)
        else:
            written = write_set_reports(args.report, members, args.printer)
    except (UserError, OSError, RuntimeError, ImportError) as error:
        console.notify(not_written(args.report, error))
        return False
    console.note(join_names(map(str, written)))
    return True


def _conclude(args: argparse.Namespace, member: SetMember) -> int:
    """Print one check; returns its exit code."""
    filed, trouble = member.filed, member.trouble
    if filed is not None:
        try:
            console.emit(args, _result(filed, trouble), page_of(filed))
        finally:  # also where nobody reads
            if filed.trouble is not None:
                console.notify(join_sentences((filed.trouble.sentence, tr("Not kept."))))
    if trouble is not None:
        console.notify(trouble.translated())
        if filed is not None:
            return console.ANSWER_NO
        if args.json:
            failure = FailureJson(code=ErrorCode.NO_LINK, message=trouble.translated(), hint="")
            console.write_lines([console.as_json(ErrorJson(error=failure))])
        return console.NO_LINK
    return console.ANSWER_NO if member.verdict is Verdict.NO_GO else console.SUCCESS


def _result(filed: Filed, trouble: UserMessage | None) -> PreflightJson:
    """What was found; where the conversation ended meanwhile, with a check that says so."""
    found = msgspec.convert(contract_of(filed.assessment), PreflightJson)
    if trouble is None:
        return found
    broken = CheckJson(
        id="connection",
        result="fail",
        measured=None,
        limit="unbroken",
        why=trouble.in_english(),
        do="Check again.",
    )
    return msgspec.structs.replace(found, verdict="NO-GO", checks=[*found.checks, broken])


def _profile(profile: Path | None, done: Sequence[int]) -> Profile:
    """Raises `UserError`."""
    parsed = NO_PROFILE if profile is None else read_profile(profile)
    wrong = [number for number in done if not 1 <= number <= len(parsed.manual)]
    if wrong:
        raise console.Refused(tr("No manual item {number} in the profile.", number=wrong[0]))
    return parsed.answered(dict.fromkeys(done, True))


# For people


def page_of(filed: Filed) -> list[str]:
    """The verdict with its caveats, then every check; if it did not pass, why it matters and what to do."""
    assessment = filed.assessment
    verdict = verdict_sentence(assessment.verdict, assessment.case.profile.activated_by).translated()
    lines = [coloured(verdict, Colour.BAD if assessment.verdict is Verdict.NO_GO else Colour.GOOD)]
    lines += [caveat.translated() for caveat in filed.record.caveats]
    if assessment.verdict is not Verdict.NO_GO:
        lines.append(tr("Valid now only; not monitored afterwards."))
    lines.append("")
    rows: list[tuple[str, ...]] = []
    colours: list[Colour | None] = []
    for check in assessment.checks:
        word = tr(RESULT_WORDS[check.finding.result])
        shown = check.finding.shown.translated() + in_brackets(check.finding.limit.translated())
        rows.append((word, UserMessage(check.check.title).translated(), shown))
        colours.append({CheckResult.PASS: None, CheckResult.WARN: Colour.CAUTION}.get(check.finding.result, Colour.BAD))
        if check.finding.result is not CheckResult.PASS:
            rows.append(("", "", f"{UserMessage(check.check.why).translated()} → {check.do.translated()}"))
            colours.append(None)
    rows += [(tr(MANUAL_WORDS[item.is_done]), clean(item.text)) for item in assessment.manual]
    return [*lines, *map(coloured, console.columns(rows), chain(colours, repeat(None)))]

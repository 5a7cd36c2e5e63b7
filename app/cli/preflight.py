"""`dps-s preflight`: checks whether the module is fit to fly.

Exit code 0 for GO and READY, 1 for NO-GO, 3 if no module answers. Sends queries only, and with --enable-triggers the
two settings that enable the automatic triggers. With --activate --yes a module that is READY is activated, once, and
read again in the same conversation: GO, or NO-GO. The check is kept in the store if there is one.
"""

import argparse
import threading
from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor, wait
from dataclasses import dataclass, field
from itertools import chain, repeat
from pathlib import Path
from typing import Literal

import msgspec

from app.cli.act import pay_owed_lock, refuse_without_yes
from app.engine.conversation import Interrupted
from app.fleet.check_set import SetMember, check_set_target, summary, word_of, write_set_reports
from app.limits.past import Past
from app.preflight.activation import activate_ready
from app.preflight.contract import contract_of
from app.preflight.evidence import Evidence
from app.preflight.findings import RESULT_WORDS, CheckResult, Person
from app.preflight.reading_object import ReadJson
from app.preflight.run import run_preflight
from app.preflight.verdict import MANUAL_WORDS, Verdict, verdict_sentence
from app.records.filing import Filed, file_check
from app.records.report_files import check_target, write_report
from app.safety.acts import Act
from app.safety.journal import Outcome
from app.safety.left_active import note_go
from app.safety.permit import Origin, Permit
from app.settings.profile_file import read_profile
from app.settings.profiles import NO_PROFILE, Profile
from app.store.fact_store import Store
from app.system.clock import steady_time
from app.terminal import console
from app.terminal.arguments import (
    add_file,
    add_json,
    add_module,
    add_port,
    add_reviewed,
    add_same_module,
    add_yes,
    any_name,
)
from app.terminal.connection import LOST, OpenPort, connected, loss_sentence
from app.terminal.console import Colour, coloured
from app.terminal.interruption import check_signals, signals_noted
from app.terminal.records import Records, name_given, opened_store, records_on, refuse_another
from app.terminal.results import Result, Value
from app.text.i18n import tr
from app.text.messages import UserMessage, clean
from app.text.sentences import in_brackets, join_names, join_sentences, not_written
from app.text.user_error import ErrorCode, UserError

_WAIT_S = 0.1


class CheckJson(Result):
    id: str
    result: Literal["pass", "fail", "warn", "unknown"]
    measured: Value
    limit: str
    why: str
    do: str


class PreflightJson(Result):
    verdict: Literal["GO", "READY", "NO-GO"]
    checks: list[CheckJson]
    read: ReadJson
    simulated: bool
    softer_limits: list[str]


def add_arguments(parser: argparse.ArgumentParser) -> None:
    add_port(parser)
    parser.set_defaults(takes_several=True)
    add_file(parser, "--profile", type=Path, metavar="FILE", help="profile that says how the module should be set")
    parser.add_argument("--enable-triggers", action="store_true", help="enable both automatic triggers first")
    parser.add_argument("--activate", action="store_true", help="enable, check, activate if READY, and read again: GO")
    add_yes(parser)
    add_file(parser, "--report", type=Path, metavar="FILE.pdf", help="write the report, and the record beside it")
    add_module(parser, "name of the module")
    parser.add_argument("--aircraft", type=any_name, default="", metavar="NAME", help="aircraft")
    parser.add_argument("--who", type=any_name, default="", metavar="NAME", help="who checks")
    text = "manual item N of the profile is in order"
    parser.add_argument("--done", type=int, action="append", default=[], metavar="N", help=text)
    add_reviewed(parser)
    add_same_module(parser)
    add_json(parser)


def run(args: argparse.Namespace) -> int:
    if args.activate:
        refuse_without_yes(args, Act.ACTIVATE)
    ports = args.ports
    if len(ports) > 1 and (args.activate or args.module is not None):
        option = "--module" if args.module is not None else "--activate"
        raise console.Refused(tr("{option} takes one port only.", option=option))
    profile = _profile(args.profile, args.done)
    if args.report is not None:
        (check_target if len(ports) == 1 else check_set_target)(args.report)
    with opened_store() as (store, troubles):
        checks: list[_PortCheck] = []
        for port in ports:
            records = records_on(store, troubles, port, origin="preflight", module=name_given(args))
            checks.append(_PortCheck(args, profile, store, records))
        if len(checks) == 1:
            checks[0].gather()
        else:
            _gather_all(checks)
        # All are filed before anything is printed, which fails where nobody reads.
        members = [check.member() for check in checks]
    code = _conclude_all(args, members)
    return console.ANSWER_NO if checks[0].is_refused and code == console.SUCCESS else code


@dataclass
class _PortCheck:
    """The check on one port."""

    args: argparse.Namespace
    profile: Profile
    store: Store
    records: Records
    evidence: Evidence = field(default_factory=Evidence)
    # The module's history before the check, where it was read already.
    past: Past | None = None
    # Where it was judged already.
    filed: Filed | None = None
    # Why nothing was read.
    error: BaseException | None = None
    # The activation was not sent.
    is_refused: bool = False

    @property
    def port(self) -> str:
        return self.records.port

    def gather(self) -> None:
        """Run the check, and activate in the same conversation. Raises what keeps a conversation from beginning."""
        args, journal = self.args, self.records.journal
        self.evidence.port = self.port
        with connected(
            self.port,
            args.baud,
            on_batch=lambda batch: self.evidence.listen(batch.events),
            journal=journal if args.activate else None,
        ) as opened:
            refuse_another(opened.conversation, self.records, args)
            is_enabling = args.enable_triggers or args.activate
            try:
                opened.run(run_preflight(self.evidence, is_enabling=is_enabling, journal=journal))
                if args.activate:
                    self._activate(opened)
            except Interrupted as ended:
                self.evidence.note_error(ended)
            except KeyboardInterrupt:
                if is_enabling:
                    console.notify(tr("Interrupted; may have been carried out."))
                raise

    def file(self) -> Filed:
        """Judge and keep it."""
        if self.filed is None:
            args = self.args
            person = Person(
                who=args.who,
                module=args.module,
                aircraft=args.aircraft,
                are_records_reviewed=args.records_reviewed,
                is_same_module=args.same_module,
                is_named_by_option=True,
            )
            adapter = self.records.find_adapter()
            self.filed = file_check(
                self.evidence, self.profile, person, store=self.store, adapter=adapter, past=self.past
            )
        return self.filed

    def member(self) -> SetMember:
        """Raises what is no lost link."""
        if self.error is None:
            return SetMember(self.port, "", self.file())
        if not isinstance(self.error, LOST):
            raise self.error
        return SetMember(self.port, "", None, UserMessage(loss_sentence(self.error)))

    def _activate(self, opened: OpenPort) -> None:
        """READY is kept, then the module is activated and judged again. Anything but READY sends nothing."""
        filing = threading.Thread(target=self.file, daemon=True)  # the store may be slow; the conversation goes on
        filing.start()
        while filing.is_alive():
            opened.wait()
        ready = self.file().assessment
        if ready.verdict is not Verdict.READY:
            return
        permit = Permit(Act.ACTIVATE, Origin.COMMAND_LINE, steady_time(), opened.number)
        performed, evidence = opened.run(activate_ready(ready, self.records.journal, permit))
        self.is_refused = performed.outcome is Outcome.NOT_SENT
        if performed.outcome is Outcome.CONFIRMED:
            console.note(performed.sentence)
        else:
            console.notify(performed.sentence)
        pay_owed_lock(opened)
        if evidence is ready.case.evidence:
            return
        self.evidence, self.filed, self.past = evidence, None, ready.case.past
        if self.file().assessment.verdict is Verdict.GO:
            self.store.write(lambda facts: note_go(facts, self.records.known_as.run))


def _gather_all(checks: Sequence[_PortCheck]) -> None:
    """One thread for each port; the main thread waits for all, and for Ctrl-C."""

    def gather(check: _PortCheck) -> None:
        try:
            check.gather()
        except BaseException as error:  # noqa: BLE001  reported or raised in the main thread
            check.error = error

    with signals_noted():
        with ThreadPoolExecutor(len(checks)) as pool:
            left = {pool.submit(gather, check) for check in checks}
            while left:
                console.show_progress(f"{len(checks) - len(left)}/{len(checks)}")
                left = wait(left, _WAIT_S).not_done
        console.clear_progress()
        check_signals()


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
            console.write_lines(["", summary(member.verdict for member in members), *console.columns(rows)])
    finally:  # also where nobody reads
        if args.report is not None and not _write_reports(args, members):
            codes.append(console.PARTIAL)
    return next((code for code in (console.ANSWER_NO, console.NO_LINK, console.PARTIAL) if code in codes), 0)


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
    if filed is None:
        sentence = "" if trouble is None else trouble.translated()
        console.notify(sentence)
        if args.json:
            console.write_failure(ErrorCode.NO_LINK, sentence)
        return console.NO_LINK
    try:
        console.emit(args, msgspec.convert(contract_of(filed.assessment), PreflightJson), page_of(filed))
    finally:  # also where nobody reads
        if filed.trouble is not None:
            console.notify(join_sentences((filed.trouble.sentence, tr("Not kept."))))
    return console.ANSWER_NO if member.verdict is Verdict.NO_GO else console.SUCCESS


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

"""`dps-s set NAME=VALUE …`, `dps-s set --profile FILE`: writes settings and verifies them.

All values are checked before the first one is sent; if one is invalid nothing is sent and the exit code is 2. Each set
is sent once and read back, and all settings are read again at the end. What cannot be read back is only acknowledged.
A value that takes protection away, or is against the vendor's advice, is written with --accept-risk only: without it
nothing is opened, and the exit code is 2. The baud rate needs no such consent, and comes last, as the conversation ends
with it.
Exit code 1 if a setting was not verified, another one changed, or the conversation ended meanwhile; 3 if nothing could
be sent for that; 4 if questions are answered twice, as by two modules. --dry-run only reads, and shows before → after;
exit code 4 if a setting was not read.
"""

import argparse
from collections.abc import Sequence
from contextlib import suppress

from app.cli.act import permit_for
from app.cli.read import is_answered_twice
from app.cli.save import read_module
from app.engine.conversation import Interrupted
from app.procedures.read import ANSWERED_TWICE, SETTING_KEYS
from app.procedures.write import (
    SettingChange,
    WriteContext,
    WriteFault,
    WriteReport,
    Written,
    change_baud,
    why_not_verified,
    write_all,
)
from app.safety.consequences import consequences
from app.safety.journal import Act, Journal
from app.settings.values import SETTINGS_BY_KEY
from app.terminal import console
from app.terminal.connection import OpenPort, connected
from app.terminal.records import CommandStore
from app.terminal.results import Result, SettingName, Value
from app.terminal.setting_words import parse_settings, settings_of_profile, typed
from app.text.i18n import tr
from app.text.messages import UserMessage, labelled
from protocol.catalogue import BAUD_RATE
from protocol.fields import Value as SettingValue


class SetResultJson(Result):
    """`read_back` and `verified` are null for what cannot be read back: acknowledged is all there is to know."""

    wanted: Value
    acknowledged: bool | None
    read_back: Value
    verified: bool | None
    error: str | None


class SetJson(Result):
    results: dict[SettingName, SetResultJson]


def add_arguments(parser: argparse.ArgumentParser) -> None:
    names = f"{', '.join(SETTING_KEYS)}; triggers and output: true or false"
    parser.add_argument("wishes", nargs="*", metavar="NAME=VALUE", help=names)
    console.add_file(parser, "--profile", metavar="FILE", help="write all settings of this profile")
    console.add_flags(parser, "--accept-risk")
    parser.add_argument("--dry-run", action="store_true", help="only show what would change")
    parser.add_argument("--unlock", action="store_true", help="write although the module may fire")


def run(args: argparse.Namespace) -> int:
    if bool(args.wishes) == (args.profile is not None):
        raise console.Refused(tr("expected {expected}", expected="NAME=VALUE … | --profile FILE"))
    wishes = parse_settings(args.wishes)
    if args.profile is not None:
        settings = settings_of_profile(args.profile)
        wishes = [SettingChange(SETTINGS_BY_KEY[key], value) for key, value in settings.items()]
    warn(wishes)
    if args.dry_run:
        return _show(wishes, args)
    console.require("--accept-risk", is_given=args.accept_risk or not any(wish.risks for wish in wishes))
    report, is_doubled = _write(wishes, args)
    answer, rows = SetJson({}), list[tuple[str, str]]()
    for written in report.results:
        key, why = written.command.key, why_not_verified(written, report)
        acknowledged = None if why is None and not written.is_sent else written.is_acknowledged
        error = None if why is None else why.in_english()
        answer.results[key] = SetResultJson.of(written, wanted=written.target, acknowledged=acknowledged, error=error)
        rows.append((key, _sentence(written, report.before.get(key), why)))
    console.emit(args, answer, console.columns(rows))
    if report.interrupted is not None:
        console.notify(report.interrupted.sentence)
    if is_doubled:
        console.notify(ANSWERED_TWICE.translated())
    if report.is_fine:
        return console.PARTIAL if is_doubled else console.SUCCESS
    is_sent = any(written.is_sent for written in report.results)
    return console.NO_LINK if report.interrupted is not None and not is_sent else console.ANSWER_NO


def warn(wishes: Sequence[SettingChange]) -> None:
    # What a value takes away is told, accepted or not.
    for wish in wishes:
        for consequence in consequences(wish.command, wish.value):
            if consequence.is_risk:
                what = consequence.message.translated()
                console.notify(tr("Warning: {name}: {what}", name=wish.command.key, what=what))


def _show(wishes: Sequence[SettingChange], args: argparse.Namespace) -> int:
    # Sends queries only.
    module = read_module(args)
    answer, rows = SetJson({}), list[tuple[str, str]]()
    for wish in wishes:
        key, before = wish.command.key, module.values.get(wish.command.key)
        error = None if before == wish.value else "not written: dry run"
        answer.results[key] = SetResultJson(wish.value, None, before, None, error)
        changed = labelled(f"{typed(before)} → {typed(wish.value)}", tr("not written (dry run)"))
        rows.append((key, labelled(typed(wish.value), tr("unchanged")) if error is None else changed))
    console.emit(args, answer, console.columns(rows))
    return module.notify_missing()


def _write(wishes: Sequence[SettingChange], args: argparse.Namespace) -> tuple[WriteReport, bool]:
    """What became of each, and whether questions were answered twice. The baud rate comes last, as the conversation
    ends with it."""
    is_doubled = False
    with CommandStore(args.port) as store, connected(args.port, args.baud) as opened:
        context = WriteContext(
            journal=store.journal,
            is_unlocked=args.unlock,
            accepted_risks=frozenset(wishes if args.accept_risk else ()),
            keep_as_found=store.keep_as_found,
        )
        report = opened.run(write_all([wish for wish in wishes if wish.command is not BAUD_RATE], context))
        report.before = {**report.before, BAUD_RATE.key: opened.connection.baud_rate}
        # Two modules that take the same set verify it both, so only a second answer tells them apart.
        if report.interrupted is None:
            with suppress(Interrupted):
                is_doubled = opened.run(is_answered_twice())
        for wish in wishes:
            if wish.command is BAUD_RATE:
                report.results = [*report.results, _write_rate(wish, report, store.journal, opened)]
    return report, is_doubled


def _write_rate(wish: SettingChange, report: WriteReport, journal: Journal, opened: OpenPort) -> Written:
    """`report`: of all that was written before; gets the reason why the rate was not."""
    old_rate = opened.connection.baud_rate
    if wish.value == old_rate:
        # The module just answered at this rate: a dangerous frame that changes nothing is not sent.
        return Written(*wish, read_back=old_rate, fault=None)
    if report.refusals or report.interrupted is not None:
        return Written(*wish, fault=WriteFault.NOT_ALLOWED if report.refusals else WriteFault.NOT_SENT)
    change = change_baud(int(wish.value), journal, permit=permit_for(Act.CHANGE_BAUD, opened))
    changed = opened.run(change, outlives=True)
    report.refusals, report.interrupted = changed.refusals, changed.interrupted
    return changed.results[0]


def _sentence(written: Written, before: SettingValue | None, why: UserMessage | None) -> str:
    shown = typed(written.target)
    if why is not None:
        read_back = "" if written.read_back is None else f" → {typed(written.read_back)}"
        return labelled(shown, tr("NOT verified ({why})", why=why.translated() + read_back))
    if before is not None and before != written.target:
        shown = f"{typed(before)} → {shown}"
    if not written.is_sent:
        return labelled(shown, tr("unchanged"))
    return labelled(shown, tr("verified") if written.verified else tr("acknowledged (cannot be read back)"))

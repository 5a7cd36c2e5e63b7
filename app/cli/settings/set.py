"""`dps-s set NAME=VALUE …`, `dps-s set --profile FILE`: writes settings and verifies them.

All values are checked before the first one is sent; if one is invalid nothing is sent and the exit code is 2. Each set
is sent once and read back, and all settings are read again at the end. What cannot be read back is only acknowledged.
A value that takes protection away, or is against the vendor's advice, is written with --accept-risk only: without it
nothing is opened, and the exit code is 2.
Exit code 1 if a setting was not verified or another one changed, 3 if the link was lost. --dry-run only reads, and
shows before → after; exit code 4 if a setting was not read.
"""

import argparse
import time
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

from app.cli.results import ChangedJson, SetJson, SetResultJson
from app.cli.settings.save import notify_missing, read_module
from app.preflight.reading_object import SETTING_KEYS
from app.procedures.write import SetReply, WriteFault, Written
from app.procedures.write_all import (
    SettingChange,
    WriteContext,
    WriteReport,
    not_sent,
    unconfirmed,
    why_not_verified,
    write_all,
)  # fmt: skip
from app.safety.acts import Act
from app.safety.consequences import Weight, consequences
from app.safety.interlocks import Interlock, Refusal
from app.safety.permit import Origin, Permit
from app.settings.profiles import SETTINGS_BY_KEY
from app.terminal import console
from app.terminal.arguments import add_file, add_json, add_port, completed_as
from app.terminal.command_journal import records_of
from app.terminal.connection import LinkTrouble, connected
from app.terminal.console import Colour, coloured
from app.terminal.interruption import Interruption
from app.terminal.setting_words import parse_settings, settings_of_profile, typed
from app.text.i18n import tr
from app.text.messages import UserMessage
from app.text.sentences import join_names, labelled
from protocol.catalogue import BAUD_RATE, Command
from protocol.fields import Value


def add_arguments(parser: argparse.ArgumentParser) -> None:
    names = ", ".join(SETTING_KEYS)
    wishes = parser.add_argument(
        "wishes", nargs="*", metavar="NAME=VALUE", help=f"{names}; triggers and output: true or false"
    )
    completed_as(wishes, "_dps_s_settings")
    add_file(parser, "--profile", type=Path, metavar="FILE", help="write all settings of this profile")
    parser.add_argument("--accept-risk", action="store_true", help="write values that take protection away")
    parser.add_argument("--dry-run", action="store_true", help="only show what would change")
    parser.add_argument("--unlock", action="store_true", help="write although the module may fire")
    add_port(parser)
    add_json(parser)


def run(args: argparse.Namespace) -> int:
    wishes = _requested_values(args.wishes, args.profile)
    warn(wishes)
    if args.dry_run:
        return _show(wishes, args)
    if any(wish.risks for wish in wishes) and not args.accept_risk:
        console.refuse_without("--accept-risk")
    with Interruption():  # after the last frame a signal no longer keeps the result from being printed
        report, trouble = _write(wishes, args)
        console.emit(args, json_of(report), page_of(report))
        for sentence in (*_remarks(report), trouble):
            if sentence is not None:
                console.notify(sentence)
    if any(_is_link_lost(written, report.refusals) for written in report.results):
        return console.NO_LINK
    return console.SUCCESS if report.is_fine else console.ANSWER_NO


def _show(wishes: Sequence[SettingChange], args: argparse.Namespace) -> int:
    """Read the settings and print what would change; sends queries only."""
    module = read_module(args.port, args.baud)
    before = module.values
    rows = [(wish.command.key, before.get(wish.command.key), wish.value) for wish in wishes]
    unwritten = {key: _unwritten(target, old) for key, old, target in rows}
    lines = [
        (key, labelled(typed(target), tr("unchanged")) if old == target
         else labelled(f"{typed(old)} → {typed(target)}", tr("not written (dry run)")))
        for key, old, target in rows
    ]  # fmt: skip
    console.emit(args, SetJson(results=unwritten, changed={}, unread=[]), console.columns(lines))
    return notify_missing(module)


def _unwritten(target: Value, before: Value | None) -> SetResultJson:
    return SetResultJson(
        wanted=target,
        before=before,
        acknowledged=None,
        read_back=None,
        verified=None,
        verified_age_s=None,
        error=None if before == target else "not written: dry run",
    )


def _requested_values(words: Sequence[str], profile: Path | None) -> list[SettingChange]:
    if bool(words) == (profile is not None):
        raise console.Refused(tr("expected {expected}", expected="NAME=VALUE … | --profile FILE"))
    if profile is None:
        return parse_settings(words)
    return [SettingChange(SETTINGS_BY_KEY[key], value) for key, value in settings_of_profile(profile).items()]


def warn(wishes: Sequence[SettingChange]) -> None:
    """What a value takes away is told, accepted or not."""
    for wish in wishes:
        for consequence in consequences(wish.command, wish.value):
            if consequence.weight is not Weight.PLAIN:
                console.notify(tr("Warning: {name}: {what}", name=wish.command.key, what=consequence.sentence))


def _write(wishes: Sequence[SettingChange], args: argparse.Namespace) -> tuple[WriteReport, str | None]:
    """The results in the order of `wishes`, and a sentence if the link was lost."""
    heard: list[Written] = []
    begun: list[Command] = []
    report: WriteReport | None = None
    results: dict[Command, Written] = {}
    with (
        records_of(args.port) as records,
        connected(args.port, args.baud) as conversation,
        LinkTrouble() as link,
    ):
        old_rate = conversation.connection.baud_rate
        sent = sorted(wishes, key=lambda wish: wish.command is BAUD_RATE)
        if args.profile is not None and sent[-1] == SettingChange(BAUD_RATE, old_rate):
            # The module just answered at this rate: a dangerous frame that changes nothing is not sent.
            results[sent.pop().command] = Written(command=BAUD_RATE, target=old_rate, heard=SetReply.UNNEEDED,
                                                  read_back=old_rate, verified=True)  # fmt: skip
        context = WriteContext(
            journal=records.journal,
            permit=Permit(Act.CHANGE_BAUD, Origin.COMMAND_LINE, time.monotonic()),
            is_unlocked=args.unlock,
            accepted_risks=frozenset(wishes if args.accept_risk else ()),
            store_snapshot=records.store_snapshot,
            on_written=heard.append,
            on_begun=begun.append,
        )
        try:
            report = conversation.run(write_all(sent, context))
        except KeyboardInterrupt:
            _tell_interrupted(WriteReport(results=tuple(unconfirmed(heard))), sent, begun)
            raise
    report = report or WriteReport(results=tuple(unconfirmed(heard)))
    results |= {result.command: result for result in report.results}
    for wish in sent:
        if wish.command not in results:
            fault = WriteFault.PORT_LOST if wish.command in begun else WriteFault.PORT_LOST_BEFORE
            results[wish.command] = not_sent(wish, fault)
    before = {**report.before, "baud_rate": old_rate}
    return replace(report, before=before, results=tuple(results[wish.command] for wish in wishes)), link.sentence


def _tell_interrupted(heard: WriteReport, sent: Sequence[SettingChange], begun: Sequence[Command]) -> None:
    """`sent` in the order of writing, one after the other."""
    doubtful, unsent = tr("Interrupted; may have been carried out."), tr("not sent: {why}", why=tr("interrupted"))
    left = [wish.command for wish in sent[len(heard.results) :]]
    rows = [(command.key, doubtful if command in begun else unsent) for command in left]
    for line in (*page_of(heard), *console.columns(rows)):
        console.notify(line)


def _is_link_lost(written: Written, refusals: Sequence[Refusal]) -> bool:
    is_refused = written.fault is WriteFault.NOT_ALLOWED and all(
        refusal.condition is not Interlock.ONLINE for refusal in refusals
    )
    return written.heard is SetReply.NOT_SENT and not is_refused


def json_of(report: WriteReport) -> SetJson:
    results: dict[str, SetResultJson] = {}
    for result in report.results:
        is_needed, why = result.heard is not SetReply.UNNEEDED, why_not_verified(result, report.refusals)
        has_age = report.read_at is not None and bool(result.verified) and is_needed
        results[result.command.key] = SetResultJson(
            wanted=result.target,
            before=report.before.get(result.command.key),
            acknowledged=result.is_acknowledged if is_needed else None,
            read_back=result.read_back,
            verified=result.verified,
            verified_age_s=round(max(0.0, time.monotonic() - (report.read_at or 0.0)), 3) if has_age else None,
            error=None if why is None else why.in_english(),
        )
    changed = {change.command.key: ChangedJson(before=change.before, after=change.after) for change in report.changed}
    return SetJson(results=results, changed=changed, unread=[command.key for command in report.unread])


def _remarks(report: WriteReport) -> list[str]:
    """Sentences about settings that were not written: changed, or not read."""
    changed = [f"{setting.command.key} {typed(setting.before)} → {typed(setting.after)}" for setting in report.changed]
    unread = [command.key for command in report.unread]
    return [
        *([tr("Changed without being written: {names}.", names=join_names(changed))] if changed else []),
        *([tr("Could not read: {names}. Read again or check the wiring.", names=join_names(unread))] if unread else []),
    ]


def page_of(report: WriteReport) -> list[str]:
    rows = [
        (
            result.command.key,
            _sentence(result, report.before.get(result.command.key), why_not_verified(result, report.refusals)),
        )
        for result in report.results
    ]
    tones = [
        Colour.GOOD if result.verified else Colour.CAUTION if result.is_fine else Colour.BAD
        for result in report.results
    ]
    return [coloured(line, tone) for line, tone in zip(console.columns(rows), tones, strict=True)]


def _sentence(written: Written, before: Value | None, why: UserMessage | None) -> str:
    shown = typed(written.target)
    if why is not None:
        read_back = "" if written.read_back is None else f" → {typed(written.read_back)}"
        return labelled(shown, tr("NOT verified ({why})", why=why.translated() + read_back))
    if before is not None and before != written.target:
        shown = f"{typed(before)} → {shown}"
    if written.heard is SetReply.UNNEEDED:
        return labelled(shown, tr("unchanged"))
    if written.verified:
        return labelled(shown, tr("verified"))
    return labelled(shown, tr("acknowledged (cannot be read back)"))

"""`dps-s set NAME=VALUE …`, `dps-s set --profile FILE`: writes settings and verifies them.

All values are checked before the first one is sent; if one is bad nothing is sent and the exit code is 2. A set goes
onto the wire once and is read back, and all settings are read again at the end. What cannot be read back is only ever
acknowledged. Exit code 1 where one of them is not what was wanted or another setting changed, 3 where the link was
lost.
"""

import argparse
import time
from collections.abc import Sequence
from dataclasses import replace
from typing import TYPE_CHECKING

from app.terminal.console import (
    DONE,
    NO_LINK,
    SAID_NO,
    USED_WRONGLY,
    TableRow,
    add_json_argument,
    add_port_arguments,
    as_json,
    say,
    two_columns,
    write_lines,
)
from app.text.i18n import tr
from app.text.sentences import listed
from protocol.translatable import marked

if TYPE_CHECKING:
    from app.procedures.write import Written
    from app.procedures.write_all import SettingChange, WriteReport
    from app.safety.interlocks import Refusal
    from app.text.messages import UserMessage
    from protocol.catalogue import Command
    from protocol.fields import Value


class InvalidWord(ValueError):
    """A word of the command line that is no setting with a value for it; the text is a sentence for people."""


def add_parser(subparsers: "argparse._SubParsersAction[argparse.ArgumentParser]") -> None:
    parser = subparsers.add_parser(
        "set",
        description=tr(
            "Change settings: {names}. Triggers and serial output take true or false. Each is read back, and all are "
            "read again at the end; what cannot be read back is only ever acknowledged, never verified. Exit code 1 "
            "where one differs from what was given, or another one changed.",
            names=_names(),
        ),
    )
    parser.add_argument("wishes", nargs="*", metavar="NAME=VALUE", help=tr("for example freefall_time_s=1.6"))
    parser.add_argument("--profile", metavar="FILE", help=tr("all settings of this profile"))
    parser.add_argument(
        "--unlock", action="store_true", help=tr("write also while the module is active, or may be: it can fire")
    )
    add_port_arguments(parser)
    add_json_argument(parser)
    parser.set_defaults(run=run)


def run(args: argparse.Namespace) -> int:
    try:
        wishes = _wishes(args.wishes, args.profile)
    except InvalidWord as error:
        say(str(error))
        return USED_WRONGLY
    _warn(wishes)
    report, trouble = _write(wishes, args)
    write_lines([as_json(json_of(report))] if args.json else page_of(report))
    for sentence in (*_remarks(report), trouble):
        if sentence is not None:
            say(sentence)
    if any(_is_link_lost(written, report.refusals) for written in report.results):
        return NO_LINK
    return DONE if report.is_fine else SAID_NO


def _wishes(words: Sequence[str], profile: str | None) -> "list[SettingChange]":
    if bool(words) == (profile is not None):
        raise InvalidWord(tr("dps-s set needs NAME=VALUE … or --profile FILE, and not both."))
    if profile is None:
        return parse(words)
    from pathlib import Path

    from app.procedures.write_all import SettingChange
    from app.settings.profile_file import ProfileRefused, read_profile
    from app.settings.profiles import SETTINGS_BY_KEY

    try:
        settings = read_profile(Path(profile)).settings
    except ProfileRefused as error:
        raise InvalidWord("\n".join(error.sentences)) from error
    if not settings:
        raise InvalidWord(tr("{path} holds no settings.", path=profile))
    return [SettingChange(SETTINGS_BY_KEY[key], value) for key, value in settings.items()]


def parse(words: Sequence[str]) -> "list[SettingChange]":
    """Every word checked; raises `InvalidWord` with all that is wrong."""
    from app.procedures.write_all import SettingChange
    from app.settings.values import NotAValue, parse_value
    from protocol.catalogue import SETTINGS

    offered = {command.key: command for command in SETTINGS}
    wishes: dict[str, SettingChange] = {}
    faults: list[str] = []
    for word in words:
        name, equals, text = word.partition("=")
        command = offered.get(name)
        if not equals:
            faults.append(tr("“{word}” is not of the form NAME=VALUE.", word=word))
        elif command is None or command.write is None:
            faults.append(tr("“{name}” cannot be set; what can: {names}.", name=name, names=_names()))
        elif name in wishes:
            faults.append(tr("{name} is given twice.", name=name))
        else:
            try:
                wishes[name] = SettingChange(command, parse_value(command.write, text))
            except NotAValue as error:
                faults.append(tr("{name}: {why}.", name=name, why=error.why.in_words()))
    if faults:
        raise InvalidWord("\n".join(faults))
    return list(wishes.values())


def _warn(wishes: "Sequence[SettingChange]") -> None:
    """Against advice is a warning, never a refusal."""
    from app.settings.consequences import Weight, consequences

    for wish in wishes:
        for consequence in consequences(wish.command, wish.value):
            if consequence.weight is not Weight.PLAIN:
                say(tr("Warning: {name}: {what}", name=wish.command.key, what=consequence.sentence))


def _write(wishes: "Sequence[SettingChange]", args: argparse.Namespace) -> "tuple[WriteReport, str | None]":
    """The results in the order of the wishes, and the sentence about a line that was lost."""
    from app.procedures.write import Heard, WriteFault, Written
    from app.procedures.write_all import Leave, WriteReport, unconfirmed, write_all
    from app.safety.acts import Act
    from app.safety.permit import Origin, Permit
    from app.terminal.command_journal import adapter_of, records_of
    from app.terminal.connection import connected, link_trouble

    heard: list[Written] = []
    trouble: str | None = None
    found: dict[Command, Written] = {}
    with (
        records_of(args.port, adapter_of(args.port)) as records,
        connected(args.port, args.baud) as conversation,
    ):
        for wish in wishes:
            if args.profile is not None and wish.command.key == "baud_rate" and wish.value == conversation.baud_rate:
                # It has just answered at this rate; a dangerous frame that changes nothing is not sent.
                found[wish.command] = Written(
                    command=wish.command, wanted=wish.value, heard=Heard.UNNEEDED, stands=wish.value, verified=True
                )
        leave = Leave(
            journal=records.journal,
            permit=Permit(Act.CHANGE_BAUD, Origin.COMMAND_LINE, time.monotonic()),
            is_unlocked=args.unlock,
            keep_snapshot=records.keep_snapshot,
            on_written=heard.append,
        )
        sent = [wish for wish in wishes if wish.command not in found]
        try:
            report = conversation.run(write_all(sent, leave))
        except Exception as error:
            trouble = link_trouble(error)
            if trouble is None:
                raise
            report = WriteReport(results=tuple(unconfirmed(heard)))
    found |= {one.command: one for one in report.results}
    fault = WriteFault.PORT_LOST
    for wish in sorted(sent, key=lambda one: one.command.key == "baud_rate"):
        if wish.command not in found:
            verified = False if wish.command.reads_back or wish.command.key == "baud_rate" else None
            found[wish.command] = Written(
                command=wish.command, wanted=wish.value, heard=Heard.NOT_SENT, verified=verified, fault=fault
            )
            fault = WriteFault.PORT_LOST_BEFORE
    return replace(report, results=tuple(found[wish.command] for wish in wishes)), trouble


def why_unfit(written: "Written", refusals: "Sequence[Refusal]") -> "UserMessage | None":
    """Why it is not what was wanted."""
    from app.procedures.write import WriteFault
    from app.text.messages import listed, said

    fault = written.fault
    if fault is WriteFault.NO_REPLY and written.waited_s is not None:
        return said(marked("no reply within {seconds:.1f} s; it may have been carried out"), seconds=written.waited_s)
    if fault is WriteFault.NOT_ALLOWED and refusals:
        return said(marked("not sent: {why}"), why=listed([refusal.message for refusal in refusals], between=" "))
    return None if fault is None else said(fault.value)


def _is_link_lost(written: "Written", refusals: "Sequence[Refusal]") -> bool:
    from app.procedures.write import Heard, WriteFault
    from app.safety.interlocks import Interlock

    is_refused = written.fault is WriteFault.NOT_ALLOWED and all(
        one.condition is not Interlock.ONLINE for one in refusals
    )
    return written.heard is Heard.NOT_SENT and not is_refused


def json_of(report: "WriteReport") -> dict[str, object]:
    """The object of `dps-s set --json`."""
    from app.procedures.write import Heard

    results: dict[str, object] = {}
    for one in report.results:
        is_needed, why = one.heard is not Heard.UNNEEDED, why_unfit(one, report.refusals)
        has_age = report.read_at is not None and bool(one.verified) and is_needed
        results[one.command.key] = {
            "wanted": one.wanted,
            "acknowledged": one.is_acknowledged if is_needed else None,
            "read_back": one.stands,
            "verified": one.verified,
            "verified_age_s": round(max(0.0, time.monotonic() - (report.read_at or 0.0)), 3) if has_age else None,
            "error": None if why is None else why.in_english(),
        }
    return {
        "results": results,
        "changed": {one.command.key: {"before": one.before, "after": one.after} for one in report.changed},
        "unread": [command.key for command in report.unread],
    }


def _remarks(report: "WriteReport") -> list[str]:
    """What else there is to say: settings that nobody wrote."""
    return [
        tr("{name} was not written and changed from {before} to {after}.", name=one.command.key,
           before=_typed(one.before), after=_typed(one.after))
        for one in report.changed
    ] + [tr("{name} could not be read again: it may have changed.", name=one.key) for one in report.unread]  # fmt: skip


def page_of(report: "WriteReport") -> list[str]:
    rows = [TableRow(one.command.key, _sentence(one, why_unfit(one, report.refusals))) for one in report.results]
    return two_columns(rows, indent=0)


def _sentence(written: "Written", why: "UserMessage | None") -> str:
    from app.procedures.write import Heard

    wanted = _typed(written.wanted)
    if why is not None and written.stands is not None:
        stands = _typed(written.stands)
        return tr("{value}: NOT verified ({why}); it is {stands}", value=wanted, why=why.in_words(), stands=stands)
    if why is not None:
        return tr("{value}: NOT verified ({why})", value=wanted, why=why.in_words())
    if written.heard is Heard.UNNEEDED:
        return tr("{value}: was so already", value=wanted)
    if written.verified:
        return tr("{value}: verified", value=wanted)
    return tr("{value}: acknowledged (cannot be read back)", value=wanted)


def _typed(value: "Value") -> str:
    """As one would type it."""
    return str(value).lower() if isinstance(value, bool) else f"{value:g}"


def _names() -> str:
    from app.preflight.reading_object import SETTING_KEYS

    return listed(SETTING_KEYS)

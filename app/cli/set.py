"""`dps-s set NAME=VALUE …`, `dps-s set --profile FILE`: writes settings and verifies them.

All values are checked before the first one is sent; if one is bad nothing is sent and the exit code is 2. A set goes
onto the wire once and is read back, and all settings are read again at the end. What cannot be read back is only ever
acknowledged. Exit code 1 where one of them is not what was wanted or another setting changed, 3 where the link was
lost.
"""

import argparse
import time
from collections.abc import Sequence
from dataclasses import dataclass
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

if TYPE_CHECKING:
    from app.engine.setting_changes import ChangedSetting
    from app.procedures.write import Written
    from app.safety.interlocks import Refusal
    from protocol.catalogue import Command
    from protocol.fields import Field, Value


class InvalidWord(ValueError):
    """A word of the command line that is no setting with a value for it; the text is a sentence for people."""


@dataclass(frozen=True, slots=True)
class Wish:
    """A checked value for one setting, in the field's unit."""

    command: "Command"
    value: "Value"


@dataclass(frozen=True, slots=True)
class SettingResult:
    """What became of one wish. `error`: English, for JSON; `words`: the same for people, in their language.

    `is_acknowledged` None: nothing had to be sent.
    """

    wanted: "Value"
    is_acknowledged: bool | None
    read_back: "Value | None" = None
    verified: bool | None = None
    error: str | None = None
    words: str | None = None
    is_link_lost: bool = False
    verified_age_s: float | None = None
    """Since the last reading."""


@dataclass(frozen=True, slots=True, kw_only=True)
class SetOutcome:
    """What became of all wishes, by key, in their order. `trouble`: the sentence about a line that was lost."""

    results: dict[str, SettingResult]
    changed: "Sequence[ChangedSetting]" = ()
    """Settings that were not written."""
    unread: "Sequence[Command]" = ()
    """Settings that were not written and could not be read again."""
    trouble: str | None = None

    @property
    def is_fine(self) -> bool:
        return all(one.error is None for one in self.results.values()) and not self.changed and not self.unread


def add_parser(subparsers: "argparse._SubParsersAction[argparse.ArgumentParser]") -> None:
    parser = subparsers.add_parser(
        "set",
        description=tr(
            "Change settings: {names}. Triggers and serial output take true or false. Each is read back, and all are "
            "read again at the end; what cannot be read back is only ever acknowledged, never verified. Exit code 1 "
            "where one is not what was wanted or another one changed.",
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
    found = _write(wishes, args)
    write_lines([as_json(json_of(found))] if args.json else page_of(found.results))
    for sentence in _remarks(found):
        say(sentence)
    if any(result.is_link_lost for result in found.results.values()):
        return NO_LINK
    return DONE if found.is_fine else SAID_NO


def _wishes(words: Sequence[str], profile: str | None) -> list[Wish]:
    if bool(words) == (profile is not None):
        raise InvalidWord(tr("dps-s set needs NAME=VALUE … or --profile FILE, and not both."))
    if profile is None:
        return parse(words)
    from pathlib import Path

    from app.settings.profile_file import ProfileRefused, read_profile
    from app.settings.profiles import SETTINGS_BY_KEY

    try:
        settings = read_profile(Path(profile)).settings
    except ProfileRefused as error:
        raise InvalidWord("\n".join(error.sentences)) from error
    if not settings:
        raise InvalidWord(tr("{path} holds no settings.", path=profile))
    return [Wish(SETTINGS_BY_KEY[key], value) for key, value in settings.items()]


def parse(words: Sequence[str]) -> list[Wish]:
    """Every word checked; raises `InvalidWord` with all that is wrong."""
    from protocol.catalogue import SETTINGS

    offered = {command.key: command for command in SETTINGS}
    wishes: dict[str, Wish] = {}
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
                wishes[name] = Wish(command, parse_value(command.write, text))
            except ValueError as error:
                faults.append(tr("{name}: {why}.", name=name, why=error))
    if faults:
        raise InvalidWord("\n".join(faults))
    return list(wishes.values())


def parse_value(field: "Field", text: str) -> "Value":
    """`text` in the field's unit, exactly as it will be sent; raises `ValueError`, its text in the language in use."""
    from app.settings import values

    try:
        return values.parse_value(field, text)
    except values.NotAValue as error:
        raise ValueError(error.why.in_words()) from error


def _warn(wishes: Sequence[Wish]) -> None:
    """Against advice is a warning, never a refusal."""
    from app.settings.consequences import Weight, consequences

    for wish in wishes:
        for consequence in consequences(wish.command, wish.value):
            if consequence.weight is not Weight.PLAIN:
                say(tr("Warning: {name}: {what}", name=wish.command.key, what=consequence.sentence))


def _write(wishes: Sequence[Wish], args: argparse.Namespace) -> SetOutcome:
    from app.procedures.write_all import Leave, SettingChange, WriteReport, unconfirmed, write_all
    from app.safety.acts import Act
    from app.safety.permit import Origin, Permit
    from app.terminal.command_journal import adapter_of, records_of
    from app.terminal.connection import connected, link_trouble

    written: list[Written] = []
    report = WriteReport(results=())
    trouble: str | None = None
    found: dict[str, SettingResult] = {}
    with (
        records_of(args.port, adapter_of(args.port)) as records,
        connected(args.port, args.baud) as conversation,
    ):
        sent = list(wishes)
        for wish in wishes:
            if args.profile is not None and wish.command.key == "baud_rate" and wish.value == conversation.baud_rate:
                # It has just answered at this rate; a dangerous frame that changes nothing is not sent.
                found[wish.command.key] = SettingResult(wish.value, None, read_back=wish.value, verified=True)
                sent.remove(wish)
        leave = Leave(
            journal=records.journal,
            permit=Permit(Act.CHANGE_BAUD, Origin.COMMAND_LINE, time.monotonic()),
            is_unlocked=args.unlock,
            keep_snapshot=records.keep_snapshot,
            on_written=written.append,
        )
        try:
            report = conversation.run(write_all([SettingChange(wish.command, wish.value) for wish in sent], leave))
            written = list(report.results)
        except Exception as error:
            trouble = link_trouble(error)
            if trouble is None:
                raise
            written = unconfirmed(written)
    age_s = None if report.read_at is None else max(0.0, time.monotonic() - report.read_at)
    found |= {one.command.key: result_of(one, report.refusals, age_s=age_s) for one in written}
    is_first_lost = True
    for wish in sorted(sent, key=lambda one: one.command.key == "baud_rate"):
        if wish.command.key not in found:
            found[wish.command.key] = _lost(wish, may_be_done=is_first_lost)
            is_first_lost = False
    results = {wish.command.key: found[wish.command.key] for wish in wishes}
    return SetOutcome(results=results, changed=report.changed, unread=report.unread, trouble=trouble)


def result_of(written: "Written", refusals: "Sequence[Refusal]" = (), *, age_s: float | None = None) -> SettingResult:
    from app.procedures.write import Heard, WriteFault
    from app.safety.interlocks import Interlock

    error = words = None
    fault = written.fault
    if fault is WriteFault.NO_REPLY and written.waited_s is not None:
        error = f"no reply within {written.waited_s:.1f} s; it may have been carried out"
        words = tr("no reply within {seconds:.1f} s; it may have been carried out", seconds=written.waited_s)
    elif fault is WriteFault.NOT_ALLOWED and refusals:
        error = "not sent: " + " ".join(refusal.message.in_english() for refusal in refusals)
        words = tr("not sent: {why}", why=" ".join(refusal.sentence for refusal in refusals))
    elif fault is not None:
        error, words = fault.value, tr(fault.value)
    is_refused = fault is WriteFault.NOT_ALLOWED and all(one.condition is not Interlock.ONLINE for one in refusals)
    return SettingResult(
        written.wanted,
        written.is_acknowledged,
        read_back=written.stands,
        verified=written.verified,
        error=error,
        words=words,
        is_link_lost=written.heard is Heard.NOT_SENT and not is_refused,
        verified_age_s=age_s if written.verified else None,
    )


def _lost(wish: Wish, *, may_be_done: bool) -> SettingResult:
    if may_be_done:
        error = "the port was lost; it may have been carried out"
        words = tr("the port was lost; it may have been carried out")
    else:
        error, words = "not sent: the port was lost", tr("not sent: the port was lost")
    verified = False if wish.command.reads_back or wish.command.key == "baud_rate" else None
    return SettingResult(
        wish.value, is_acknowledged=False, verified=verified, error=error, words=words, is_link_lost=True
    )


def json_of(found: SetOutcome) -> dict[str, object]:
    """The object of `dps-s set --json`."""
    return {
        "results": {
            name: {
                "wanted": result.wanted,
                "acknowledged": result.is_acknowledged,
                "read_back": result.read_back,
                "verified": result.verified,
                "verified_age_s": None if result.verified_age_s is None else round(result.verified_age_s, 3),
                "error": result.error,
            }
            for name, result in found.results.items()
        },
        "changed": {one.command.key: {"before": one.before, "after": one.after} for one in found.changed},
        "unread": [command.key for command in found.unread],
    }


def _remarks(found: SetOutcome) -> list[str]:
    """What else there is to say: settings that nobody wrote, and a line that was lost."""
    remarks = [
        tr("{name} was not written and changed from {before} to {after}.", name=one.command.key,
           before=_typed(one.before), after=_typed(one.after))
        for one in found.changed
    ]  # fmt: skip
    remarks += [tr("{name} could not be read again: it may have changed.", name=one.key) for one in found.unread]
    return remarks if found.trouble is None else [*remarks, found.trouble]


def page_of(results: dict[str, SettingResult]) -> list[str]:
    return two_columns([TableRow(name, _sentence(result)) for name, result in results.items()], indent=0)


def _sentence(result: SettingResult) -> str:
    wanted = _typed(result.wanted)
    if result.error is not None:
        if result.read_back is not None:
            stands = _typed(result.read_back)
            return tr("{value}: NOT verified ({why}); it is {stands}", value=wanted, why=result.words, stands=stands)
        return tr("{value}: NOT verified ({why})", value=wanted, why=result.words)
    if result.is_acknowledged is None:
        return tr("{value}: was so already", value=wanted)
    if result.verified:
        return tr("{value}: verified", value=wanted)
    return tr("{value}: acknowledged (cannot be read back)", value=wanted)


def _typed(value: "Value") -> str:
    """As one would type it."""
    return str(value).lower() if isinstance(value, bool) else f"{value:g}"


def _names() -> str:
    from app.preflight.reading_object import SETTING_KEYS

    return ", ".join(SETTING_KEYS)

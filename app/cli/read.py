"""`dps-s read`: reads everything once.

Exit code 0; 3 if nothing was read; 4 if something is missing, or the module fell silent. What was read is also printed
when the link is lost. An unknown value is null in JSON and "unknown" with the reason in the text, never a default.
"""

import argparse
import math
from collections.abc import Mapping
from types import MappingProxyType
from typing import NamedTuple

from app.engine.address_lock import sets_rate
from app.engine.device import MAX_LAG_S, STATUS_KEYS, StaleReason
from app.engine.procedure import Pause, Procedure, TwoModules
from app.engine.worker import Batch
from app.limits.out_of_limits import LimitsInUse, line_outside, outside_of
from app.preflight.reading_object import LIVE_KEYS, SETTING_KEYS, ReadJson, reading_object
from app.procedures.read import Everything, read_everything, undisturbed
from app.terminal import console
from app.terminal.arguments import add_json, add_port
from app.terminal.connection import Conversation, LinkTrouble, connected, module_is_silent
from app.text.i18n import tr
from app.text.messages import UserMessage, message
from app.text.sentences import in_brackets, join_names
from app.text.user_error import ErrorCode
from protocol.catalogue import BAUD_RATE, BY_NAME, SETTINGS
from protocol.events import FellSilent, Received, Unanswered
from protocol.fields import Choice, Quantity, Value
from protocol.translatable import marked

SECOND_ANSWER_S = 0.05
"""Longer than two modules that hear the same question are apart."""
_PORT_LOST = message(marked("port lost"))
_FELL_SILENT = message(marked("no reply"))
_RESTARTED = message(marked("the module restarted"))
_GROUPS = {
    marked("Status"): (*STATUS_KEYS, "cell_voltage_v", "charging", "light_v", "boot_count"),
    marked("Settings"): SETTING_KEYS,
}
_COMMANDS = {command.key: command for command in BY_NAME.values() if command.reply is not None}
_OF_STATUS = {
    "tilt_deg": (marked("Tilt"), BY_NAME["attitude_threshold"]),
    "acceleration_g": (marked("Acceleration"), BY_NAME["freefall_acceleration"]),
    "triggered": (marked("Triggered"), BY_NAME["triggered"]),
    "active": (marked("Active"), BY_NAME["active"]),
}
"""Title, and a command whose reply has the same unit."""
_WORDS = {
    ("active", True): marked("active"), ("active", False): marked("locked"),
    ("triggered", True): marked("triggered"), ("triggered", False): marked("not triggered"),
}  # fmt: skip
"""Instead of "yes" and "no"."""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    add_port(parser)
    add_json(parser)


def run(args: argparse.Namespace) -> int:
    silence = _Silence()
    with connected(args.port, args.baud, on_batch=silence.on_batch) as conversation:
        findings, trouble = _read(conversation, args.port, silence)
    has_something = any(key != "baud_rate" for key in findings.values)
    if has_something or trouble is None or args.json:
        console.emit(args, json_of(findings), page_of(findings))
    if trouble is not None:
        console.notify(trouble)
    elif findings.errors:
        names = join_names(findings.errors)
        console.notify(tr("Could not read: {names}. Read again or check the wiring.", names=names))
    if trouble is not None and not has_something:
        return console.NO_LINK
    return console.PARTIAL if findings.errors or trouble is not None else console.SUCCESS


class _Silence:
    """The last one after which something answered again: it may be another module."""

    def __init__(self) -> None:
        self._is_silent = False
        self.ended_at = -math.inf

    def on_batch(self, batch: Batch) -> None:
        for event in batch.events:
            if isinstance(event, FellSilent):
                self._is_silent = True
            elif isinstance(event, Received) and self._is_silent:
                self._is_silent, self.ended_at = False, event.at


class Findings(NamedTuple):
    """`values` and `errors` by key ("light_v"); `errors` has one key, "status", for all of the status."""

    port: str
    baud_rate: int
    round_trip_s: float | None = None
    """Median."""
    values: Mapping[str, Value] = MappingProxyType({})
    errors: Mapping[str, UserMessage] = MappingProxyType({})
    lag_s: float | None = None
    has_damaged: bool = False
    """Invalid bytes were received."""


def _read(conversation: Conversation, port: str, silence: _Silence) -> tuple[Findings, str | None]:
    """What was read, and a sentence if reading ended early."""
    everything: Everything | None = None
    with LinkTrouble() as link:
        everything = conversation.run(_read_and_listen())
        if everything is None:
            raise console.Refused(tr("The module restarted. Read again."), ErrorCode.INTERRUPTED)
    if everything is None:
        if isinstance(link.error, TwoModules):
            return _findings(conversation, port, {}, link.error.message, since=math.inf), link.sentence
        return _findings(conversation, port, {}, _PORT_LOST, since=silence.ended_at), link.sentence
    errors = {key: unanswered_reason(unanswered) for key, unanswered in everything.errors.items()}
    errors |= everything.contradictions
    if not everything.is_silent:
        return _findings(conversation, port, errors, _RESTARTED, since=everything.began_at), None
    findings = _findings(conversation, port, errors, _FELL_SILENT, since=silence.ended_at)
    return findings, module_is_silent(port, conversation.device)


def _read_and_listen() -> Procedure[Everything | None]:
    """Read everything; a second module on this line answers a little later, also the last question."""
    everything = yield from undisturbed(read_everything)
    yield Pause(SECOND_ANSWER_S)
    return everything


def unanswered_reason(unanswered: Unanswered) -> UserMessage:
    if unanswered.attempts <= 1:
        return _FELL_SILENT
    text = marked("no reply within {seconds:.1f} s, asked {attempts} times")
    return message(text, seconds=unanswered.waited_s, attempts=unanswered.attempts)


def _findings(
    conversation: Conversation, port: str, errors: dict[str, UserMessage], why_missing: UserMessage, *, since: float
) -> Findings:
    """All values that are known now were read in this conversation, those before `since` perhaps from another module.
    `why_missing` is the reason for values that are neither known nor in `errors`."""
    known = {key: reading for key, reading in conversation.device.values.items() if reading.at >= since}
    values = {key: reading.value for key, reading in known.items() if reading.stale_reason is not StaleReason.RESTARTED}
    for key in STATUS_KEYS:
        if key in errors:
            values.pop(key, None)  # 30 or 31 and the status do not agree
    unreadable = {command.key for command in SETTINGS if not command.reads_back} | {BAUD_RATE.key}
    missing = {*STATUS_KEYS, *LIVE_KEYS, *SETTING_KEYS} - unreadable - set(values)
    blamed = {"status" if key in STATUS_KEYS and key not in errors else key for key in missing}
    if sets_rate(port):
        values["baud_rate"] = conversation.connection.baud_rate
    else:
        values.pop("baud_rate", None)  # behind a plain socket nobody here knows it
    link = conversation.link
    return Findings(
        port,
        conversation.connection.baud_rate,
        link.round_trip_median_s if link is not None else None,
        values,
        {key: errors.get(key, why_missing) for key in sorted(blamed)},
        link.lag_s if link is not None else None,
        has_damaged=link is not None and link.counters.rejected > 0,
    )


# What is printed


def json_of(findings: Findings) -> ReadJson:
    return reading_object(
        port=findings.port,
        baud_rate=findings.baud_rate,
        round_trip_s=findings.round_trip_s,
        values=findings.values,
        errors={key: why.in_english() for key, why in findings.errors.items()},
    )


def page_of(findings: Findings) -> list[str]:
    """The lines for people."""
    lag_s, round_trip_s = findings.lag_s, findings.round_trip_s
    head = tr("{port}, {rate} baud", port=findings.port, rate=findings.baud_rate)
    if lag_s is not None and lag_s > MAX_LAG_S:
        head = join_names((head, f"{lag_s:.1f} s"))
    elif round_trip_s is not None:
        head = join_names((head, f"{1000 * round_trip_s:.1f} ms"))
    line = line_outside(
        lag_s=lag_s, round_trip_s=round_trip_s, has_damaged=findings.has_damaged, in_use=LimitsInUse()
    )  # fmt: skip
    lines = [head if line is None else line.beside(head)]
    rows = console.columns([_row(key, findings) for keys in _GROUPS.values() for key in keys], indent=2)
    for title, keys in _GROUPS.items():
        lines += ["", tr(title), *rows[: len(keys)]]
        del rows[: len(keys)]
    return lines


def _row(key: str, findings: Findings) -> tuple[str, str]:
    title, command = _OF_STATUS[key] if key in _OF_STATUS else (_COMMANDS[key].title, _COMMANDS[key])
    value = findings.values.get(key)
    if value is None:
        why = findings.errors.get(key) or findings.errors.get("status" if key in STATUS_KEYS else key)
        return tr(title), tr("unknown") + in_brackets(tr("cannot be read") if why is None else why.translated())
    if isinstance(value, bool):
        word = _WORDS.get((key, value)) or (marked("yes") if value else marked("no"))
        text = tr(word)
    else:
        reply = command.reply
        text = reply.text(reply.encode(value)) if isinstance(reply, Quantity) else str(value)
        text = f"{value} {tr(reply.unit)}" if isinstance(reply, Choice) else text
    outside = outside_of(key, findings.values, LimitsInUse())
    return tr(title), text if outside is None else outside.beside(text)

"""`dps-s read`: reads everything once.

Exit code 0; 3 if no module answers, or its conversation ended meanwhile; 4 if something is missing. An unknown value is
null in JSON and "unknown" with the reason in the text, never a default.
"""

import argparse
from typing import NamedTuple

from app.engine.conversation import STATUS_KEYS, Interrupted
from app.engine.procedure import EngineView, Inspect, Pause, Procedure
from app.engine.target import sets_rate
from app.limits.out_of_limits import LimitsInUse, line_outside, outside_of
from app.preflight.reading_object import LIVE_KEYS, SETTING_KEYS, ReadJson, reading_object
from app.procedures.read import ANSWERED_TWICE, NO_REPLY, Everything, contradictions, read_everything
from app.terminal import console
from app.terminal.arguments import add_json, add_port
from app.terminal.connection import OpenPort, connected
from app.text.i18n import tr
from app.text.messages import UserMessage, message
from app.text.sentences import in_brackets, join_names
from protocol.catalogue import BAUD_RATE, BY_NAME, SERIAL_OUTPUT, SETTINGS
from protocol.events import Unanswered
from protocol.fields import Choice, Quantity, Value
from protocol.timing import SLOW_S
from protocol.translatable import marked

# Longer than two modules that hear the same question are apart.
SECOND_ANSWER_S = 0.05
# The key of what is said of the line, or of the conversation.
LINE = "link"
_GROUPS = {
    marked("Status"): (*STATUS_KEYS, "cell_voltage_v", "charging", "light_v", "boot_count"),
    marked("Settings"): SETTING_KEYS,
}
_UNREADABLE = {command.key for command in SETTINGS if not command.reads_back}
_COMMANDS = {command.key: command for command in BY_NAME.values() if command.reply is not None}
# Title, and a command whose reply has the same unit.
_OF_STATUS = {
    "tilt_deg": (marked("Tilt"), BY_NAME["attitude_threshold"]),
    "acceleration_g": (marked("Acceleration"), BY_NAME["freefall_acceleration"]),
    "triggered": (marked("Triggered"), BY_NAME["triggered"]),
    "active": (marked("Active"), BY_NAME["active"]),
}
_WORDS = {
    ("active", True): marked("active"),
    ("active", False): marked("locked"),
    ("triggered", True): marked("triggered"),
    ("triggered", False): marked("not triggered"),
}


class Findings(NamedTuple):
    """`values` and `errors` by key ("light_v"); `errors` has one key, "status", for all of the status, and one, "link",
    for the line."""

    port: str
    baud_rate: int
    values: dict[str, Value]
    errors: dict[str, UserMessage]
    round_trip_s: float | None = None
    has_damaged: bool = False


def add_arguments(parser: argparse.ArgumentParser) -> None:
    add_port(parser)
    add_json(parser)


def run(args: argparse.Namespace) -> int:
    everything = Everything()
    ended: Interrupted | None = None
    is_doubled = False
    with connected(args.port, args.baud) as opened:
        try:
            is_doubled = opened.run(_read_and_listen(everything))
        except Interrupted as error:
            ended = error
        findings = _findings(opened, args.port, everything, ended)
    if is_doubled:
        findings.errors[LINE] = ANSWERED_TWICE
    console.emit(args, json_of(findings), page_of(findings))
    if ended is not None:
        console.notify(ended.sentence)
        return console.NO_LINK
    unread = [key for key in findings.errors if key != LINE]
    if unread:
        console.notify(tr("Could not read: {names}. Read again or check the wiring.", names=join_names(unread)))
    if is_doubled:
        console.notify(ANSWERED_TWICE.translated())
    return console.PARTIAL if findings.errors else console.SUCCESS


def _read_and_listen(everything: Everything) -> Procedure[bool]:
    """Whether questions are answered twice: a second module on this line answers a little later, also the last one."""
    yield from read_everything(everything)
    yield Pause(SECOND_ANSWER_S)
    view: EngineView = yield Inspect()
    return view.told.is_answered_twice(view.now)


def _findings(opened: OpenPort, port: str, everything: Everything, ended: Interrupted | None) -> Findings:
    """`ended`: where the conversation ended before everything was read."""
    why_ended = None if ended is None else ended.message
    link, status = opened.link, everything.status
    values = dict(everything.values)
    errors = {key: unanswered_reason(unanswered) for key, unanswered in everything.errors.items()}
    if status is not None:
        against = everything.contradictions
        if ended is not None:
            against = contradictions(values.get("active"), values.get("triggered"), status)
        values |= {key: getattr(status, key) for key in STATUS_KEYS if key not in against}
        errors |= against
    unproven = ("active", "triggered") if status is None else tuple(against)  # 30 and 31 alone prove nothing
    for key in unproven:
        values.pop(key, None)
    if ended is not None and ended.contradiction is not None:
        values.pop(ended.contradiction.before.command.key, None)  # which of the two holds nobody knows
    if ended is None and opened.conversation.is_streaming:
        values[SERIAL_OUTPUT.key] = True
    if sets_rate(port):  # behind a plain socket nobody here knows it
        values[BAUD_RATE.key] = opened.connection.baud_rate
    for key in (*STATUS_KEYS, *LIVE_KEYS, *SETTING_KEYS):
        if key not in values and key not in _UNREADABLE and key not in errors:
            blamed = "status" if key in STATUS_KEYS else key
            errors.setdefault(blamed, why_ended or message(NO_REPLY))
    if why_ended is not None:
        errors[LINE] = why_ended
    return Findings(
        port=port,
        baud_rate=opened.connection.baud_rate,
        values=values,
        errors=dict(sorted(errors.items())),
        round_trip_s=None if link is None else link.round_trip_median_s,
        has_damaged=link is not None and link.counters.rejected > 0,
    )


def unanswered_reason(unanswered: Unanswered) -> UserMessage:
    if unanswered.attempts <= 1:
        return message(NO_REPLY)
    text = marked("no reply within {seconds:.1f} s, asked {attempts} times")
    return message(text, seconds=unanswered.waited_s, attempts=unanswered.attempts)


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
    round_trip_s = findings.round_trip_s
    head = tr("{port}, {rate} baud", port=findings.port, rate=findings.baud_rate)
    if round_trip_s is not None:
        is_slow = round_trip_s > SLOW_S
        head = join_names((head, f"{round_trip_s:.1f} s" if is_slow else f"{1000 * round_trip_s:.1f} ms"))
    line = line_outside(
        lag_s=round_trip_s, round_trip_s=round_trip_s, has_damaged=findings.has_damaged, in_use=LimitsInUse()
    )
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
    reply = command.reply
    text = str(value)
    if isinstance(value, bool):
        word = _WORDS.get((key, value), marked("yes") if value else marked("no"))
        text = tr(word)
    elif isinstance(reply, Quantity):
        text = reply.text(reply.encode(value))
    elif isinstance(reply, Choice):
        text = f"{value} {tr(reply.unit)}"
    threshold_v = findings.values.get("light_threshold_v")
    if key == "light_v" and threshold_v is not None:
        # Nobody has measured here whether an open bay reads more or less, so nothing is said of the bay.
        below, above = (
            marked("below the threshold, direction unknown"),
            marked("above the threshold, direction unknown"),
        )
        text += in_brackets(tr(below if value < threshold_v else above))
    outside = None if key == "light_v" else outside_of(key, findings.values, LimitsInUse())
    return tr(title), text if outside is None else outside.beside(text)

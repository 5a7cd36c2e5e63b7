"""`dps-s read`: reads everything once.

Exit code 0; 3 if no module answers, or its conversation ended meanwhile; 4 if something is missing. An unknown value is
null in JSON and "unknown" with the reason in the text, never a default.
"""

import argparse

from app.engine.conversation import STATUS_KEYS, Interrupted
from app.engine.procedure import EngineView, Inspect, Pause, Procedure
from app.engine.target import sets_rate
from app.limits.limits import LimitsInUse, outside_of
from app.preflight.reading_object import LIVE_KEYS, SETTING_KEYS, reading_object
from app.procedures.read import ANSWERED_TWICE, NO_REPLY, Everything, contradictions, read_everything
from app.terminal import console
from app.terminal.arguments import add, add_port
from app.terminal.connection import OpenPort, connected
from app.text.i18n import tr
from app.text.messages import UserMessage, in_brackets, join_names, message
from protocol.catalogue import BAUD_RATE, BY_NAME, SERIAL_OUTPUT, SETTINGS
from protocol.events import Unanswered
from protocol.fields import Choice, Quantity, Value
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
Values = dict[str, Value]
# Why a value is not known, by its key; "status" stands for all of the status, "link" for the line.
Errors = dict[str, UserMessage]


def add_arguments(parser: argparse.ArgumentParser) -> None:
    add_port(parser)
    add(parser, "--json")


def run(args: argparse.Namespace) -> int:
    everything = Everything()
    ended: Interrupted | None = None
    is_doubled = False
    with connected(args.port, args.baud) as opened:
        try:
            opened.run(read_everything(everything))
            is_doubled = opened.run(is_answered_twice())
        except Interrupted as error:
            ended = error
        values, errors = _findings(opened, args.port, everything, ended)
    if is_doubled:
        errors[LINE] = ANSWERED_TWICE
    rate = opened.connection.baud_rate
    round_trip_s = None if opened.link is None else opened.link.round_trip_median_s
    answer = reading_object(
        port=args.port,
        baud_rate=rate,
        round_trip_s=round_trip_s,
        values=values,
        errors={key: why.in_english() for key, why in sorted(errors.items())},
    )
    head = tr("{port}, {rate} baud", port=args.port, rate=rate)
    if round_trip_s is not None:
        head = join_names((head, f"{1000 * round_trip_s:.1f} ms"))
    console.emit(args, answer, [head, *page_of(values, errors)])
    if ended is not None:
        console.notify(ended.sentence)
        return console.NO_LINK
    unread = sorted(key for key in errors if key != LINE)
    if unread:
        console.notify(tr("Could not read: {names}. Read again or check the wiring.", names=join_names(unread)))
    if is_doubled:
        console.notify(ANSWERED_TWICE.translated())
    return console.PARTIAL if errors else console.SUCCESS


def is_answered_twice() -> Procedure[bool]:
    """Whether questions are: a second module on this line answers a little later, also the last one."""
    yield Pause(SECOND_ANSWER_S)
    view: EngineView = yield Inspect()
    return view.told.is_answered_twice(view.now)


def _findings(opened: OpenPort, port: str, everything: Everything, ended: Interrupted | None) -> tuple[Values, Errors]:
    """`ended`: where the conversation ended before everything was read."""
    why_ended, status = None if ended is None else ended.message, everything.status
    values = dict(everything.values)
    errors = {key: unanswered_reason(unanswered) for key, unanswered in everything.errors.items()}
    against = everything.contradictions
    if ended is not None:
        against = contradictions(values.pop("active", None), values.pop("triggered", None), status)
        if ended.contradiction is not None:
            values.pop(ended.contradiction.before.command.key, None)  # which of the two holds nobody knows
    if status is not None:
        values |= {key: getattr(status, key) for key in STATUS_KEYS if key not in against}
        errors |= against  # without a status 30 and 31 prove nothing
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
    return values, errors


def unanswered_reason(unanswered: Unanswered) -> UserMessage:
    if unanswered.attempts <= 1:
        return message(NO_REPLY)
    text = marked("no reply within {seconds:.1f} s, asked {attempts} times")
    return message(text, seconds=unanswered.waited_s, attempts=unanswered.attempts)


def page_of(values: Values, errors: Errors) -> list[str]:
    """The lines for people."""
    rows = console.columns([_row(key, values, errors) for keys in _GROUPS.values() for key in keys], indent=2)
    lines: list[str] = []
    for title, keys in _GROUPS.items():
        lines += ["", tr(title), *rows[: len(keys)]]
        del rows[: len(keys)]
    return lines


def _row(key: str, values: Values, errors: Errors) -> tuple[str, str]:
    title, command = _OF_STATUS[key] if key in _OF_STATUS else (_COMMANDS[key].title, _COMMANDS[key])
    value, reply = values.get(key), command.reply
    if value is None:
        why = errors.get(key) or errors.get("status" if key in STATUS_KEYS else key)
        return tr(title), tr("unknown") + in_brackets(tr("cannot be read") if why is None else why.translated())
    text = str(value)
    if isinstance(value, bool):
        word = _WORDS.get((key, value), marked("yes") if value else marked("no"))
        text = tr(word)
    elif isinstance(reply, Quantity):
        text = reply.text(reply.encode(value))
    elif isinstance(reply, Choice):
        text = f"{value} {tr(reply.unit)}"
    # Nobody has measured here whether an open bay reads more or less light, so nothing is said of the bay.
    outside = None if key == "light_v" else outside_of(key, values, LimitsInUse())
    return tr(title), text if outside is None else outside.beside(text)

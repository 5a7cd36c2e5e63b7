"""`dps-s read`: reads everything once.

Exit code 0; 3 if no module answers, or its conversation ended meanwhile; 4 if something is missing. An unknown value is
null in JSON and "unknown" with the reason in the text, never a default.
"""

import argparse
from collections.abc import Mapping

from app.engine.conversation import STATUS_KEYS, ConversationView, Interrupted
from app.engine.procedure import EngineView, Inspect, Pause, Procedure
from app.engine.target import is_socket
from app.procedures.read import ANSWERED_TWICE, LIVE_KEYS, SETTING_KEYS, Readings, read_everything
from app.terminal import console
from app.terminal.connection import connected
from app.text.i18n import tr
from app.text.messages import UserMessage, in_brackets, join_names, message
from protocol.catalogue import BAUD_RATE, BY_NAME, READABLE_SETTINGS, SERIAL_OUTPUT, STATUS_PARTS
from protocol.fields import Choice, Value
from protocol.translatable import marked

# Longer than two modules that hear the same question are apart.
SECOND_ANSWER_S = 0.05
_STATUS_TITLES = (marked("Tilt"), marked("Acceleration"), marked("Triggered"), marked("Active"))
# Title and field of each value.
_SHOWN = {one.key: (one.title, one.reply) for one in BY_NAME.values() if one.reply is not None}
_SHOWN |= {part.name: (title, part.field) for part, title in zip(STATUS_PARTS, _STATUS_TITLES, strict=True)}


def run(args: argparse.Namespace) -> int:
    read, seen = Readings(), ConversationView()
    ended: Interrupted | None = None
    is_doubled = False
    with connected(args.port, args.baud) as opened:
        try:
            opened.run(read_everything(read))
            is_doubled = opened.run(is_answered_twice(read.answered_at))
            seen = opened.conversation
        except Interrupted as error:
            ended = error
    values = dict(read.values)
    if ended is not None and ended.contradiction is not None:
        values.pop(ended.contradiction.before.command.key, None)  # which of the two holds nobody knows
    # Why a value is not known, by its key; "status" stands for all of the status.
    late = marked("no reply within {seconds:.1f} s, asked {attempts} times")
    errors = {key: message(late, seconds=one.waited_s, attempts=one.attempts) for key, one in read.errors.items()}
    if read.status is not None:
        against = read.contradictions
        values |= {key: getattr(read.status, key) for key in STATUS_KEYS if key not in against}
        errors |= against
    if seen.is_streaming:
        values[SERIAL_OUTPUT.key] = True
    rate = opened.connection.baud_rate
    if not is_socket(args.port):  # behind a plain socket nobody here knows it
        values[BAUD_RATE.key] = rate
    if ended is not None:
        for key in (*STATUS_KEYS, *LIVE_KEYS, *(command.key for command in READABLE_SETTINGS)):
            if key not in values and key not in errors:
                errors.setdefault("status" if key in STATUS_KEYS else key, ended.message)
    unread = sorted(errors)
    if ended is not None or is_doubled:
        errors["link"] = ANSWERED_TWICE if ended is None else ended.message

    if args.json:
        from app.preflight.reading_object import reading_object

        answer = reading_object(
            port=args.port,
            baud_rate=rate,
            round_trip_s=seen.lag_s,
            values=values,
            errors=errors,
        )
        console.emit(args, answer, ())
    else:
        page = [tr("{port}, {rate} baud", port=args.port, rate=rate)]
        if seen.lag_s is not None:
            page = [join_names((*page, f"{1000 * seen.lag_s:.1f} ms"))]
        live_keys = (*STATUS_KEYS, "cell_voltage_v", "charging", "light_v", "boot_count")
        lines = console.columns([_row(key, values, errors) for key in (*live_keys, *SETTING_KEYS)])
        rows = [f"  {line}" for line in lines]
        page += ["", tr("Status"), *rows[: len(live_keys)], "", tr("Settings"), *rows[len(live_keys) :]]
        console.emit(args, None, page)
    if ended is not None:
        console.notify(ended.sentence)
        return console.NO_LINK
    if unread:
        console.notify(tr("Could not read: {names}. Read again or check the wiring.", names=join_names(unread)))
    if is_doubled:
        console.notify(ANSWERED_TWICE.translated())
    return console.PARTIAL if errors else console.SUCCESS


def is_answered_twice(first_at: float | None = None) -> Procedure[bool]:
    """Whether questions are, as a second module on this line answers a little later. `first_at`: when the first of
    several was answered, which is as good a proof; else it is waited for a second answer to the last one."""
    view: EngineView = yield Inspect()
    yield Pause((view.now if first_at is None else first_at) + SECOND_ANSWER_S - view.now)
    view = yield Inspect()
    return view.lasting.is_answered_twice(view.now)


def _row(key: str, values: Mapping[str, Value], errors: Mapping[str, UserMessage]) -> tuple[str, str]:
    from app.limits.limits import cell_outside
    from app.settings.profiles import NO_PROFILE

    value, (title, field) = values.get(key), _SHOWN[key]
    if value is None:
        why = errors.get(key) or errors.get("status" if key in STATUS_KEYS else key)
        return tr(title), tr("unknown") + in_brackets(tr("cannot be read") if why is None else why.translated())
    text = field.text(field.encode(value))
    shown = f"{value} {tr(field.unit)}" if isinstance(field, Choice) else tr(text)
    if key == "cell_voltage_v":
        outside = cell_outside(float(value), NO_PROFILE, is_charging=values.get("charging"))
        shown = shown if outside is None else outside.beside(shown)
    return tr(title), shown

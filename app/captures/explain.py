"""Explains one frame: flat named values for programs (`meaning`), one sentence for people (`sentence`).

A module frame is explained as the answer to what was asked. Three states of knowledge:

    asked is a Request    the very frame that the host sent
    asked is a Command    which command it was, not the value that was sent (`dps-s decode --asked`)
    asked is None         nothing is known

Where that leaves the meaning open, it says so: 01 from 21 or 22 is "received" or a value, so the value is null
(E2); 16 answers 16 or 17, so both are named (E4).
"""

from app.text.i18n import tr
from app.trigger_records.fields import JsonValue, record_values, source_word
from protocol.catalogue import COMMANDS, SET, STATUS_PARTS, Command, Request
from protocol.fields import Choice, Done, Flag, Quantity
from protocol.frame import Direction, Frame, Noise, decode_request
from protocol.messages import (
    Acknowledgement,
    EmptySlot,
    Heartbeat,
    Message,
    Reading,
    Status,
    TriggerRecord,
    decode,
)
from protocol.translatable import marked

Asked = Request | Command | None
"""What a JSON line holds beside a name."""

_EITHER_OR = 0x01
"""D4 that the table uses for "received" (E2) and that is a value as well."""

_ACTS: dict[tuple[str, int], str] = {
    ("activation", 0x00): marked("lock the module"),
    ("activation", 0x01): marked("activate the module"),
    ("deploy", 0x00): marked("forbid deploying over serial"),
    ("deploy", 0x01): marked("deploy the parachute"),
    ("shutdown", 0x01): marked("shut the module down"),
    ("serial_output", 0x00): marked("switch the serial output off"),
    ("serial_output", 0x01): marked("switch the serial output on"),
    ("attitude_trigger", 0x00): marked("enable the attitude trigger"),
    ("attitude_trigger", 0x01): marked("disable the attitude trigger"),
    ("freefall_trigger", 0x00): marked("enable the free-fall trigger"),
    ("freefall_trigger", 0x01): marked("disable the free-fall trigger"),
    ("zero_sensor", 0x00): marked("zero the sensor"),
}
"""Requests that read better in words of their own, by D4."""

_ANSWERS: dict[tuple[str, bool], str] = {
    ("activation", False): marked("module locked"),
    ("activation", True): marked("module active"),
    ("deploy", False): marked("deploying over serial forbidden"),
    ("deploy", True): marked("parachute deployed"),
    ("shutdown", True): marked("module shuts down"),
    ("serial_output", False): marked("serial output off"),
    ("serial_output", True): marked("serial output on"),
    ("attitude_trigger", False): marked("attitude trigger disabled"),
    ("attitude_trigger", True): marked("attitude trigger enabled"),
    ("freefall_trigger", False): marked("free-fall trigger disabled"),
    ("freefall_trigger", True): marked("free-fall trigger enabled"),
    ("zero_sensor", True): marked("sensor zeroed"),
    ("active", False): marked("not active"),
    ("active", True): marked("active"),
    ("triggered", False): marked("not triggered"),
    ("triggered", True): marked("triggered"),
    ("charging", False): marked("not charging"),
    ("charging", True): marked("charging"),
}
"""Replies of yes or no in words of their own."""


def meaning(frame: Frame, asked: Asked = None) -> dict[str, JsonValue]:
    """The command and the values that the frame carries, units in the names; in English, never translated."""
    if frame.direction is Direction.HOST_TO_MODULE:
        return _meaning_of_request(decode_request(frame.raw))
    return _meaning_of_message(read_reply(frame.raw, asked), asked)


def sentence(piece: Frame | Noise, asked: Asked = None) -> str:
    """One line for a person, in the language in use; rejected bytes are explained by their reason."""
    if isinstance(piece, Noise):
        return tr("no frame: {why}", why=tr(piece.fault.text, **piece.fault.values))
    if piece.direction is Direction.HOST_TO_MODULE:
        return _words_of_request(decode_request(piece.raw))
    return _words_of_message(read_reply(piece.raw, asked), asked)


def read_reply(raw: bytes, asked: Asked) -> Message:
    """The valid module frame `raw` as the answer to `asked`, as far as that is known."""
    if not isinstance(asked, Command):
        return decode(raw, asked)
    if asked.can_be_asked:
        return decode(raw, asked.query())
    # What was sent is not known, so what came is taken for its echo: the reply is all there is to tell.
    return decode(raw, asked.query() if asked.write is None else Request(asked, control=SET, data=raw[4]))


def _command(asked: Asked) -> Command | None:
    return asked.command if isinstance(asked, Request) else asked


def _is_value_open(reading: Reading, asked: Asked) -> bool:
    """The reply may be "received" or a value, and what was asked does not tell which (E2)."""
    is_either = reading.command.acknowledged_by_one and reading.raw == _EITHER_OR
    return is_either and _command(asked) is not reading.command


def _may_answer(reading: Reading, asked: Asked) -> tuple[Command, ...]:
    """The commands that this reply can belong to, where its code and what was asked leave it open (E4)."""
    if _command(asked) is reading.command:
        return ()
    others = (other for other in COMMANDS if reading.command.code in other.extra_reply_codes)
    same_reply = tuple(other for other in others if other.reply == reading.command.reply)
    return (reading.command, *same_reply) if same_reply else ()


def _is_only_received(message: Acknowledgement, asked: Asked) -> bool:
    """The reply says "received" and does not repeat the value; with the sent value unknown, 01 says no more."""
    if message.raw != _EITHER_OR or not message.request.command.acknowledged_by_one:
        return False
    return isinstance(asked, Command) or not message.is_echo


def _meaning_of_request(request: Request) -> dict[str, JsonValue]:
    command = request.command
    named: dict[str, JsonValue] = {"command": command.name}
    if request.is_set and command.write is not None and command.write_key is not None:
        named[command.write_key] = command.write.decode(request.data)
    return named


def _meaning_of_message(message: Message, asked: Asked) -> dict[str, JsonValue]:
    match message:
        case Heartbeat():
            return {"command": "heartbeat"}
        case Status():
            return {"command": "status"} | {part.name: getattr(message, part.name) for part in STATUS_PARTS}
        case TriggerRecord():
            return {"command": "trigger_records"} | record_values(message)
        case EmptySlot():
            return {"command": "trigger_records", "empty": True}
        case Reading():
            return _meaning_of_reading(message, asked)
        case Acknowledgement():
            return _meaning_of_acknowledgement(message, asked)


def _meaning_of_reading(reading: Reading, asked: Asked) -> dict[str, JsonValue]:
    command = reading.command
    named: dict[str, JsonValue] = {"command": command.name}
    if command.reply_key is None:
        return named
    if _is_value_open(reading, asked):
        # A baud rate cannot be asked for, so its reply is an acknowledgement whatever was sent.
        return named | ({command.reply_key: None} if command.can_be_asked else {"acknowledged": True})
    named[command.reply_key] = reading.value
    possible = _may_answer(reading, asked)
    return named | {"may_answer": [one.name for one in possible]} if possible else named


def _meaning_of_acknowledgement(message: Acknowledgement, asked: Asked) -> dict[str, JsonValue]:
    command = message.request.command
    named: dict[str, JsonValue] = {"command": command.name}
    if _is_only_received(message, asked):
        return named | {"acknowledged": True}
    if not message.is_accepted:
        named["acknowledged"] = False
        if command.acknowledged_by_one:
            return named  # "anything else: failed", so what it carries need not be the value in force
    if command.reply is not None and command.reply_key is not None:
        named[command.reply_key] = command.reply.decode(message.raw)
    return named


def _inside(title: str) -> str:
    """A title in the language in use, as it stands within a sentence."""
    words = tr(title)
    return words[:1].lower() + words[1:]


def _value(field: Quantity | Flag | Choice | Done, raw: int) -> str:
    if isinstance(field, Choice):
        return f"{field.decode(raw)} {tr(field.unit)}"
    text = field.text(raw)
    return text if isinstance(field, Quantity) else tr(text)


def _words_of_request(request: Request) -> str:
    command = request.command
    act = _ACTS.get((command.name, request.data)) if request.is_set or not request.is_repeatable else None
    if act is not None:
        return tr(act)
    if command.name == "heartbeat":
        return tr("heartbeat")
    if request.is_set and command.write is not None:
        return tr("set {name} to {value}", name=_inside(command.title), value=_value(command.write, request.data))
    return tr("query: {name}", name=_inside(command.title))


def _words_of_message(message: Message, asked: Asked) -> str:
    match message:
        case Heartbeat():
            return tr("heartbeat")
        case Status():
            return tr(
                "status: tilt {tilt}°, {acceleration:.1f} g, {triggered}, {active}",
                tilt=message.tilt_deg,
                acceleration=message.acceleration_g,
                triggered=tr(_ANSWERS["triggered", message.triggered]),
                active=tr(_ANSWERS["active", message.active]),
            )
        case TriggerRecord():
            return _words_of_record(message)
        case EmptySlot():
            return tr("trigger record: slot never used")
        case Reading():
            if _is_value_open(message, asked):
                return tr("reply: {name}, a value or only “received”", name=_inside(message.command.title))
            possible = _may_answer(message, asked) or (message.command,)
            return tr("reply: {what}", what=tr(" or ").join(_what(one, message.raw) for one in possible))
        case Acknowledgement():
            return _words_of_acknowledgement(message, asked)


def _words_of_acknowledgement(message: Acknowledgement, asked: Asked) -> str:
    command = message.request.command
    if _is_only_received(message, asked):
        return tr("acknowledged: {name}, value not repeated", name=_inside(command.title))
    if message.is_accepted:
        return tr("acknowledged: {what}", what=_what(command, message.raw))
    return tr("not acknowledged: {name}, the answer is {raw:02X}", name=_inside(command.title), raw=message.raw)


def _what(command: Command, raw: int) -> str:
    """What a six-byte reply carries, in words: "cell voltage 3.80 V", "not charging"."""
    field = command.reply
    if field is None:
        return _inside(command.title)
    value = field.decode(raw)
    answer = _ANSWERS.get((command.name, value)) if isinstance(value, bool) else None
    if answer is not None:
        return tr(answer)
    return tr("{name} {value}", name=_inside(command.title), value=_value(field, raw))


def _words_of_record(record: TriggerRecord) -> str:
    minutes, seconds = divmod(record.uptime_s, 60)
    sources = ", ".join(source_word(name) for name in record.sources)
    words = tr(
        "trigger record: boot {boot}, {minutes} min {seconds} s after power-on, source {sources}; cell {cell:.2f} V",
        boot=record.boot_count,
        minutes=minutes,
        seconds=seconds,
        sources=sources or tr("unknown"),
        cell=record.cell_voltage_v,
    )
    return tr("{text} (implausible)", text=words) if record.implausible else words

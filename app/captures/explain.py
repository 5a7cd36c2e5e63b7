"""Explains one frame: flat named values for programs (`meaning`), one sentence for people (`sentence`).

A module frame is explained as the answer to what was asked:

    a Request    the frame that the host sent
    a Command    the command, but not the value that was sent (`dps-s decode --asked`)
    None         unknown

Ambiguous meanings are shown as such: 01 from 21 or 22 is "received" or a value, so the value is null (E2); 16 answers
16 or 17, so both are named (E4).
"""

from app.engine.conversation import reason_message
from app.settings.values import value_text
from app.text.i18n import tr
from app.text.sentences import join_names, labelled
from app.trigger_records.fields import JsonValue, record_values
from app.trigger_records.history import sentence as told
from protocol.catalogue import BY_NAME, COMMANDS, SET, STATUS, STATUS_PARTS, TRIGGER_RECORDS, Command, Request
from protocol.events import Began, Ended, Event, OutcomeUnknown, Unanswered
from protocol.fields import Done, Field
from protocol.frame import Direction, Frame, Noise, decode_request
from protocol.messages import Acknowledgement, EmptySlot, Heartbeat, Message, Reading, Status, TriggerRecord, decode
from protocol.translatable import marked

Asked = Request | Command | None

_EITHER_OR = 0x01
"""D4 that means "received" (E2), and is also a value."""

_ACTS: dict[tuple[str, int], str] = {
    ("activation", 0x00): marked("Lock"),
    ("activation", 0x01): marked("Activate"),
    ("deploy", 0x00): marked("Forbid serial trigger"),
    ("deploy", 0x01): marked("Deploy"),
}
"""Acts with names of their own, by command and D4."""


def meaning(frame: Frame, asked: Asked = None) -> dict[str, JsonValue]:
    """The command and the values of a frame, with units in their names; always in English."""
    if frame.direction is Direction.HOST_TO_MODULE:
        return _meaning_of_request(decode_request(frame.raw))
    return _meaning_of_message(read_reply(frame.raw, asked), asked)


def sentence(piece: Frame | Noise, asked: Asked = None) -> str:
    """One line for people, in the language in use; for rejected bytes the reason."""
    if isinstance(piece, Noise):
        return labelled(tr("no frame"), tr(piece.fault.text, **piece.fault.values))
    if piece.direction is Direction.HOST_TO_MODULE:
        return _request_text(decode_request(piece.raw))
    return _message_text(read_reply(piece.raw, asked), asked)


def link_sentence(event: Event) -> str:
    """What an event of the link says, in the language in use; "" for traffic."""
    match event:
        case Unanswered() if event.attempts == 0:
            return tr("not sent: the module stopped answering")
        case Unanswered():
            return tr(
                "no reply within {seconds:.1f} s, asked {attempts} times",
                seconds=event.waited_s,
                attempts=event.attempts,
            )
        case OutcomeUnknown():
            return tr("no reply within {seconds:.1f} s; may have been carried out", seconds=event.waited_s)
        case Began():
            return tr("the module answers")
        case Ended():
            return reason_message(event.reason, event.contradiction).translated()
        case _:
            return ""


def read_reply(raw: bytes, asked: Asked) -> Message:
    """Decode the valid module frame `raw` as the answer to `asked`."""
    if not isinstance(asked, Command):
        return decode(raw, asked)
    if asked.can_be_asked:
        return decode(raw, asked.query())
    # The value that was sent is unknown; the reply is taken for its echo.
    return decode(raw, asked.query() if asked.write is None else Request(asked, control=SET, data=raw[4]))


def _command(asked: Asked) -> Command | None:
    return asked.command if isinstance(asked, Request) else asked


def _is_value_open(reading: Reading, asked: Asked) -> bool:
    """Whether the reply may be "received" or a value, and `asked` does not tell which (E2)."""
    is_either = reading.command.acknowledged_by_one and reading.raw == _EITHER_OR
    return is_either and _command(asked) is not reading.command


def _may_answer(reading: Reading, asked: Asked) -> tuple[Command, ...]:
    """The commands that this reply may answer, if its code and `asked` leave that open (E4)."""
    if _command(asked) is reading.command:
        return ()
    others = (other for other in COMMANDS if reading.command.code in other.extra_reply_codes)
    same_reply = tuple(other for other in others if other.reply == reading.command.reply)
    return (reading.command, *same_reply) if same_reply else ()


def _is_only_received(message: Acknowledgement, asked: Asked) -> bool:
    """Whether the reply means "received" only; 01 does if the value that was sent is unknown."""
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
        # A baud rate cannot be queried, so its reply is always an acknowledgement.
        return named | ({command.reply_key: None} if command.can_be_asked else {"acknowledged": True})
    named[command.reply_key] = reading.value
    possible = _may_answer(reading, asked)
    return named | {"may_answer": [command.name for command in possible]} if possible else named


def _meaning_of_acknowledgement(message: Acknowledgement, asked: Asked) -> dict[str, JsonValue]:
    command = message.request.command
    named: dict[str, JsonValue] = {"command": command.name}
    if _is_only_received(message, asked):
        return named | {"acknowledged": True}
    if not message.is_accepted:
        named["acknowledged"] = False
        if command.acknowledged_by_one:
            return named  # "anything else: failed", so it need not carry the present value
    if command.reply is not None and command.reply_key is not None:
        named[command.reply_key] = command.reply.decode(message.raw)
    return named


def _inside(title: str) -> str:
    """A title in the language in use, for the middle of a sentence."""
    words = tr(title)
    return words[:1].lower() + words[1:]


def _request_text(request: Request) -> str:
    command = request.command
    if command.name == "heartbeat":
        return _inside(command.title)
    if request.is_set:
        return labelled(tr("set"), _value_text(command, command.write, request.data))
    return labelled(tr("query") if request.is_repeatable else tr("set"), _inside(command.title))


def _message_text(message: Message, asked: Asked) -> str:
    match message:
        case Heartbeat():
            return _inside(BY_NAME["heartbeat"].title)
        case Status():
            words = (
                f"{_inside(marked('Tilt'))} {message.tilt_deg}°",
                f"{message.acceleration_g:.1f} g",
                tr("triggered") if message.triggered else tr("not triggered"),
                tr("active") if message.active else tr("locked"),
            )
            return labelled(_inside(STATUS.title), join_names(words))
        case TriggerRecord():
            return labelled(_inside(TRIGGER_RECORDS.title), told(message).translated())
        case EmptySlot():
            return labelled(_inside(TRIGGER_RECORDS.title), tr("none"))
        case Reading():
            if _is_value_open(message, asked):
                return labelled(tr("reply"), f"{_inside(message.command.title)} ?")
            possible = _may_answer(message, asked) or (message.command,)
            values = (_value_text(command, command.reply, message.raw) for command in possible)
            return labelled(tr("reply"), " / ".join(values))
        case Acknowledgement():
            return _acknowledgement_text(message, asked)


def _acknowledgement_text(message: Acknowledgement, asked: Asked) -> str:
    command = message.request.command
    if _is_only_received(message, asked):
        return labelled(tr("acknowledged"), _inside(command.title))
    if message.is_accepted:
        return labelled(tr("acknowledged"), _value_text(command, command.reply, message.raw))
    return labelled(tr("not acknowledged"), f"{_inside(command.title)} ({message.raw:02X})")


def _value_text(command: Command, field: Field | None, raw: int) -> str:
    """Content of a set or a six-byte reply, such as "cell voltage 3.80 V"."""
    act = _ACTS.get((command.name, raw))
    if act is not None:
        return _inside(act)
    title = _inside(command.title)
    if field is None or isinstance(field, Done):
        return title
    text = field.text(raw)
    shown = value_text(command, field.decode(raw)) if command.is_setting else tr(text)
    return f"{title} {shown[:1].lower()}{shown[1:]}"

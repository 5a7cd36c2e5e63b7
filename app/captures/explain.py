"""Explains one frame: flat named values for programs (`meaning`), one sentence for people (`sentence`).

Ambiguous meanings are shown as such: 01 from 21 or 22 is "received" or a value, so the value is null (E2); 16 answers
16 or 17, so both are named (E4).
"""

from functools import lru_cache
from typing import Literal

from app.engine.conversation import reason_message
from app.settings.values import value_text
from app.text.i18n import tr
from app.text.messages import join_names, labelled
from app.trigger_records.history import JsonValue, record_values
from app.trigger_records.history import sentence as told
from protocol.catalogue import BY_NAME, COMMANDS, SET, STATUS, STATUS_PARTS, TRIGGER_RECORDS, Command, Request
from protocol.events import Began, Ended, Event, Received, Rejected, Role, Sent, Unanswered
from protocol.fields import Done, Field
from protocol.messages import (
    Acknowledgement,
    Direction,
    EmptySlot,
    Frame,
    Heartbeat,
    Message,
    Noise,
    Reading,
    Status,
    TriggerRecord,
    decode,
    decode_request,
)
from protocol.translatable import marked

# What a module frame answers: the frame that the host sent; only its command, but not the value that was sent
# (`dps-s decode --asked`); or unknown.
Asked = Request | Command | None

# D4 that means "received" (E2), and is also a value.
_EITHER_OR = 0x01
# Acts with names of their own, by command and D4.
_ACTS: dict[tuple[str, int], str] = {
    ("activation", 0x00): marked("Lock"),
    ("activation", 0x01): marked("Activate"),
    ("deploy", 0x00): marked("Forbid serial trigger"),
    ("deploy", 0x01): marked("Deploy"),
}


# What a six-byte reply says; "open": that it was received, or a value, as `asked` does not tell (E2).
_Said = Literal["value", "open", "received", "accepted", "refused"]


def meaning(frame: Frame, asked: Asked = None) -> dict[str, JsonValue]:
    """The command and the values of a frame, with units in their names; always in English."""
    if frame.direction is Direction.HOST_TO_MODULE:
        request = decode_request(frame.raw)
        command, named = request.command, dict[str, JsonValue](command=request.command.name)
        if request.is_set and command.write is not None and command.write_key is not None:
            named[command.write_key] = command.write.decode(request.data)
        return named
    answer = read_reply(frame.raw, asked)
    match answer:
        case Heartbeat():
            return {"command": "heartbeat"}
        case Status():
            return {"command": "status"} | {part.name: getattr(answer, part.name) for part in STATUS_PARTS}
        case TriggerRecord():
            return {"command": "trigger_records"} | record_values(answer)
        case EmptySlot():
            return {"command": "trigger_records", "empty": True}
    said, command, *others = _said_by(answer, asked)
    key = command.reply_key
    named = {"command": command.name}
    match said:
        case "received":
            return named | {"acknowledged": True}
        case "open" if key is not None:
            # A baud rate cannot be queried, so its reply is always an acknowledgement.
            return named | ({key: None} if command.can_be_asked else {"acknowledged": True})
        case "refused":
            named["acknowledged"] = False
            if command.acknowledged_by_one:
                return named  # "anything else: failed", so it need not carry the present value
    if command.reply is not None and key is not None:
        named[key] = command.reply.decode(answer.raw)
    if others:
        named["may_answer"] = [one.name for one in (command, *others)]
    return named


def sentence(piece: Frame | Noise, asked: Asked = None) -> str:
    """Return one line for people, in the language in use; for rejected bytes the reason."""
    if isinstance(piece, Noise):
        return labelled(tr("no frame"), tr(piece.reason.value))
    if piece.direction is Direction.HOST_TO_MODULE:
        request = decode_request(piece.raw)
        title = _inside(request.command.title)
        if request.command.name == "heartbeat":
            return title
        if request.is_set:
            return labelled(tr("set"), _value_text(request.command, request.command.write, request.data))
        return labelled(tr("query") if request.is_repeatable else tr("set"), title)
    answer = read_reply(piece.raw, asked)
    match answer:
        case Heartbeat():
            return _inside(BY_NAME["heartbeat"].title)
        case Status():
            words = (
                f"{_inside(marked('Tilt'))} {answer.tilt_deg}°",
                f"{answer.acceleration_g:.1f} g",
                tr("triggered") if answer.triggered else tr("not triggered"),
                tr("active") if answer.active else tr("locked"),
            )
            return labelled(_inside(STATUS.title), join_names(words))
        case TriggerRecord():
            return labelled(_inside(TRIGGER_RECORDS.title), told(answer).translated())
        case EmptySlot():
            return labelled(_inside(TRIGGER_RECORDS.title), tr("none"))
    said, command, *others = _said_by(answer, asked)
    title = _inside(command.title)
    match said:
        case "open":
            return labelled(tr("reply"), f"{title} ?")
        case "received":
            return labelled(tr("acknowledged"), title)
        case "accepted":
            return labelled(tr("acknowledged"), _value_text(command, command.reply, answer.raw))
        case "refused":
            return labelled(tr("not acknowledged"), f"{title} ({answer.raw:02X})")
        case "value":
            values = (_value_text(one, one.reply, answer.raw) for one in (command, *others))
            return labelled(tr("reply"), " / ".join(values))


@lru_cache(maxsize=4096)  # few frames differ, and a search in the traffic needs the sentences of all rows
def _frame_sentence(direction: Direction, raw: bytes, asked: Asked = None) -> str:
    return sentence(Frame(direction, raw), asked)


def event_sentence(event: Event) -> str:
    """Say in the language in use what an event of the link tells; "" for what its frames have told."""
    match event:
        case Sent():
            return _frame_sentence(Direction.HOST_TO_MODULE, event.raw)
        case Received(message=Acknowledgement(request=request)):
            return _frame_sentence(event.frame.direction, event.frame.raw, request)
        case Received(message=Reading(command=command)) if event.role is not Role.UNSOLICITED and command.can_be_asked:
            return _frame_sentence(event.frame.direction, event.frame.raw, command.query())
        case Received():
            return _frame_sentence(event.frame.direction, event.frame.raw)
        case Rejected():
            return sentence(event.noise)
        case Unanswered() if event.attempts == 0:
            return tr("not sent: the module stopped answering")
        case Unanswered() if event.may_be_done:
            return tr("no reply within {seconds:.1f} s; may have been carried out", seconds=event.waited_s)
        case Unanswered():
            text = marked("no reply within {seconds:.1f} s, asked {attempts} times")
            return tr(text, seconds=event.waited_s, attempts=event.attempts)
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
    if asked.can_be_asked or asked.write is None:
        return decode(raw, asked.query())
    # The value that was sent is unknown; the reply is taken for its echo.
    return decode(raw, Request(asked, control=SET, data=raw[4]))


def _said_by(message: Reading | Acknowledgement, asked: Asked) -> tuple[_Said, Command, *tuple[Command, ...]]:
    """What a six-byte reply says, and all commands that it may answer: more than one where its code leaves that open
    (E4)."""
    if isinstance(message, Reading):
        command = message.command
        if (asked.command if isinstance(asked, Request) else asked) is command:
            return "value", command
        if command.acknowledged_by_one and message.raw == _EITHER_OR:
            return "open", command
        under_its_code = (other for other in COMMANDS if command.code in other.extra_reply_codes)
        return "value", command, *(other for other in under_its_code if other.reply == command.reply)
    command = message.request.command
    is_either = message.raw == _EITHER_OR and command.acknowledged_by_one
    # Of a command alone the value that was sent is unknown.
    if is_either and (isinstance(asked, Command) or message.raw != message.request.data):
        return "received", command
    return "accepted" if message.is_accepted else "refused", command


def _inside(title: str) -> str:
    # A title in the language in use, for the middle of a sentence.
    words = tr(title)
    return words[:1].lower() + words[1:]


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

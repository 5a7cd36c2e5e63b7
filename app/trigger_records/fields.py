"""Fields of a trigger record in JSON, CSV and the archive, and texts of its sources."""

from app.text.messages import UserMessage, message
from protocol.catalogue import RECORD_PART
from protocol.messages import TriggerRecord
from protocol.translatable import marked

JsonValue = bool | int | float | str | list[str] | None
FIELDS = (*RECORD_PART, "implausible", "raw")
"""Names in JSON and in the head of the CSV; they include the unit."""

SOURCE_WORDS = {
    "serial": marked("serial"),
    "attitude": marked("attitude"),
    "pwm": "PWM",
    "freefall": marked("free fall"),
}
"""English, marked. Bits without a name of the vendor are missing."""


def source_message(source: str) -> UserMessage:
    """Text of one source; a bit without a name of the vendor is shown as such."""
    text = SOURCE_WORDS.get(source)
    return message(marked("unnamed ({bit})"), bit=source) if text is None else UserMessage(text)


def record_values(record: TriggerRecord) -> dict[str, JsonValue]:
    return {name: getattr(record, name) for name in RECORD_PART} | {"sources": list(record.sources)}


def fields_of(record: TriggerRecord) -> dict[str, JsonValue]:
    """`FIELDS` of a record: its values, the names of implausible ones, and its bytes."""
    return {
        **record_values(record),
        "implausible": list(record.implausible),
        "raw": record.raw.hex(" ").upper(),
    }

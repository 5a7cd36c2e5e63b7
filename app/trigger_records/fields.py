"""Fields of a trigger record in JSON, CSV and the archive, and the texts of its source."""

from app.text.i18n import tr
from app.text.messages import UserMessage, said
from protocol.catalogue import RECORD_PART
from protocol.messages import TriggerRecord
from protocol.translatable import marked

JsonValue = bool | int | float | str | list[str] | None
FIELDS = (*RECORD_PART, "implausible", "raw")
"""The names of the contract: the head of the CSV too, since they carry the units."""

SOURCE_WORDS = {
    "serial": marked("serial"),
    "attitude": marked("attitude"),
    "pwm": "PWM",
    "freefall": marked("free fall"),
}
"""English, marked. A bit that the vendor gives no name stands for itself."""


def source_message(source: str) -> UserMessage:
    """One source of a record in words; one that the vendor does not name by its bit."""
    text = SOURCE_WORDS.get(source)
    return said(marked("unnamed ({bit})"), bit=source) if text is None else UserMessage(text)


def record_values(record: TriggerRecord) -> dict[str, JsonValue]:
    """What the record says, by name."""
    return {name: getattr(record, name) for name in RECORD_PART} | {"sources": list(record.sources)}


def fields_of(record: TriggerRecord) -> dict[str, JsonValue]:
    """`FIELDS` of a record: what it says, what of that cannot be, and its bytes."""
    return {
        **record_values(record),
        "implausible": list(record.implausible),
        "raw": record.raw.hex(" ").upper(),
    }


def source_word(name: str) -> str:
    """In the language in use."""
    text = SOURCE_WORDS.get(name, name)
    return tr(text)

"""Generates docs/protocol.md from the catalogue and the prose in protocol_page.in.md.

python docs/generate/protocol_page.py             write the page
python docs/generate/protocol_page.py --check     exit 1 if it is out of date
"""

import argparse
import sys
from collections.abc import Iterable
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT))

from app.captures.explain import meaning, sentence  # noqa: E402  the packages lie beside this folder
from protocol.catalogue import (  # noqa: E402
    COMMANDS,
    DEFAULT_BAUD_RATE,
    HEARTBEAT_CODE,
    MAX_RECORDS,
    RECORD_CODE,
    RECORD_PARTS,
    SET,
    STATUS_PARTS,
    Command,
    FramePart,
    Hazard,
    Layout,
    Request,
)
from protocol.fields import Choice, Done, Field, Flag, Quantity  # noqa: E402
from protocol.messages import Direction, Frame, Status, TriggerRecord, decode, encode_long, encode_reply  # noqa: E402

PAGE = ROOT / "docs" / "protocol.md"
PROSE = Path(__file__).with_name("protocol_page.in.md")
BITS_PER_BYTE = 10  # start, eight data bits, stop
STATUS_EXAMPLE = Status(7, 1.0, triggered=False, active=True).encode()
RECORD_EXAMPLE = encode_long(RECORD_CODE, bytes.fromhex("01 01 00 6C 02 3C 05 A0 00 01 0C EB"))
UNITS = {"_deg": "°", "_g": " g", "_s": " s", "_v": " V"}
SAMPLE_BYTES = {0x14: 0x03, 0x15: 0x12, 0x23: 0x25, 0x34: 0xBE}
"""Example values where nothing is delivered: 0.3 V, 1.8 V, 37 starts, 3.80 V."""


def page() -> str:
    """The text of docs/protocol.md."""
    bytes_per_second = DEFAULT_BAUD_RATE // BITS_PER_BYTE
    return PROSE.read_text(encoding="utf-8").format(
        default_baud_rate=DEFAULT_BAUD_RATE,
        bytes_per_second=bytes_per_second,
        status_per_second=bytes_per_second // Layout.STATUS.value,
        exchange_ms=f"{2000 * Layout.SHORT.value / bytes_per_second:.2f}",
        status_drawing=drawing(STATUS_EXAMPLE, STATUS_PARTS, fixed=("header", "header", "code")),
        record_drawing=drawing(RECORD_EXAMPLE, RECORD_PARTS, fixed=("header", "header", "code", "control")),
        command_table=command_table(),
        example_table=example_table(),
        explanations=explanations(),
        status_example=spaced(STATUS_EXAMPLE),
        status_words=sentence(Frame(Direction.MODULE_TO_HOST, STATUS_EXAMPLE)).removeprefix("status: "),
        status_table=part_table(STATUS_EXAMPLE, STATUS_PARTS),
        record_example=spaced(RECORD_EXAMPLE),
        record_table=part_table(RECORD_EXAMPLE, RECORD_PARTS),
        records_kept=MAX_RECORDS,
    )


def spaced(raw: bytes) -> str:
    return raw.hex(" ").upper()


def table(heads: Iterable[str], rows: Iterable[Iterable[str]]) -> str:
    """A Markdown table."""
    heads = tuple(heads)
    lines = [heads, ["---"] * len(heads), *rows]
    return "\n".join("| " + " | ".join(cells) + " |" for cells in lines)


def drawing(raw: bytes, parts: tuple[FramePart, ...], *, fixed: tuple[str, ...]) -> str:
    """A long frame, one line per value: byte numbers, example bytes, meaning."""
    places = [(f"D{index}", raw[index : index + 1], what) for index, what in enumerate(fixed)]
    places += [(numbers_of(part), bytes_of(part, raw), without_unit(part.name)) for part in parts]
    places.append((f"D{len(raw) - 1}", raw[-1:], "sum"))
    return "\n".join(f"    {numbers:8}{spaced(example):8}{what}" for numbers, example, what in places)


def numbers_of(part: FramePart) -> str:
    return " ".join(f"D{part.first + index}" for index in range(part.length))


def bytes_of(part: FramePart, raw: bytes) -> bytes:
    return raw[part.first : part.first + part.length]


def without_unit(name: str) -> str:
    """The words of a value's name: "tilt_deg" is "tilt"."""
    suffix = next((suffix for suffix in UNITS if name.endswith(suffix)), "")
    return name.removesuffix(suffix).replace("_", " ")


def meaning_of(field: Field | None) -> str:
    """The meaning of a value byte in the table's words."""
    match field:
        case Quantity(per_unit=1, unit=unit):
            return f"1{unit}" if unit else "a count"
        case Quantity(per_unit=per_unit, unit=unit, decimals=decimals):
            return f"{1 / per_unit:.{decimals}f} {unit}"
        case Flag(lenient=True):
            return "01 yes, else no"
        case Flag(true=true):
            return f"{true:02X} yes, {1 - true:02X} no"
        case Choice(values=values):
            return ", ".join(f"{code:02X} {value}" for code, value in values.items())
        case Done():
            return "01"
        case None:
            return "–"


def hazard_of(command: Command) -> str:
    """The hazards of its requests: "changes; 01 dangerous"."""
    words = []
    if command.query_data is not None:
        words.append(f"query {command.query_hazard.value}" if command.write is not None else command.query_hazard.value)
    if command.write is not None:
        by_value = {raw: command.write_hazards.get(raw, Hazard.CHANGES) for raw in sorted(command.write.allowed)}
        if len(set(by_value.values())) == 1:
            hazard = next(iter(by_value.values())).value
            words.append(f"set {hazard}" if words else hazard)
        else:
            words += [f"{raw:02X} {hazard.value}" for raw, hazard in by_value.items()]
    return ", ".join(words)


def command_table() -> str:
    rows = []
    for command in COMMANDS:
        field = command.write or command.reply
        default = "" if command.default is None or command.write is None else command.write.text(command.default)
        if isinstance(command.write, Flag) and command.default is not None:
            default = f"{command.default:02X}, enabled" if command.write.decode(command.default) else "disabled"
        layout = {Layout.STATUS: "8 bytes, below", Layout.RECORD: "16 bytes, below"}.get(command.layout)
        advice = command.advice.text if command.advice is not None else ""
        cells = (f"{command.code:02X}", f"`{command.name}`", command.vendor_term, layout or meaning_of(field))
        rows.append((*cells, default, advice, hazard_of(command)))
    return table(("Code", "Name", "Vendor's word", "Value", "As delivered", "Vendor's advice", "Hazard"), rows)


def examples(command: Command) -> list[tuple[Request, bytes]]:
    """Requests of one command with the reply to each."""
    pairs = []
    if command.query_data is not None:
        pairs.append((command.query(), reply_to(command, SAMPLE_BYTES.get(command.code, command.default or 0x01))))
    if command.write is not None:
        chosen = sorted(command.write.allowed, reverse=True)
        if len(chosen) > 2:
            chosen = [SAMPLE_BYTES.get(command.code, command.default or 0x01)]
        pairs += [(Request(command, SET, raw), reply_to(command, raw)) for raw in chosen]
    return pairs


def reply_to(command: Command, raw: int) -> bytes:
    """The module's reply with the value byte `raw`."""
    if command.layout is Layout.STATUS:
        return STATUS_EXAMPLE
    if command.layout is Layout.RECORD:
        return RECORD_EXAMPLE
    if command.code == HEARTBEAT_CODE:
        return encode_long(HEARTBEAT_CODE, bytes((0xA5, 0x5A)))
    return encode_reply(command.code, raw)


def example_table() -> str:
    rows = []
    for command in COMMANDS:
        for request, reply in examples(command):
            sent = Frame(Direction.HOST_TO_MODULE, request.encode())
            came = Frame(Direction.MODULE_TO_HOST, reply)
            says = (sentence(sent), f"`{spaced(sent.raw)}`", f"`{spaced(reply)}`", sentence(came, request))
            also = "".join(f", or code {code:02X}" for code in sorted(command.extra_reply_codes))
            also += ", or 01 as value" if command.acknowledged_by_one and request.is_set else ""
            rows.append((*says[:2], says[2] + also, says[3]))
    return table(("Request", "Bytes", "Reply", "Which says"), rows)


def explanations() -> str:
    return "\n".join(f"- **{command.title}** ({command.code:02X}): {command.explanation}" for command in COMMANDS)


def reading(name: str, value: object) -> str:
    """A formatted value: 60 of "tilt_deg" is "60°"."""
    if isinstance(value, bool):
        return "yes" if value else "no"
    if isinstance(value, list):
        return ", ".join(value)
    return str(value) + next((unit for suffix, unit in UNITS.items() if name.endswith(suffix)), "")


def part_table(raw: bytes, parts: tuple[FramePart, ...]) -> str:
    """The values of a long frame, each with its example bytes and formatted value."""
    values = meaning(Frame(Direction.MODULE_TO_HOST, raw))
    message = decode(raw)
    implausible = message.implausible if isinstance(message, TriggerRecord) else ()
    rows = []
    for part in parts:
        reads = reading(part.name, values[part.name]) + (" (implausible, E12)" if part.name in implausible else "")
        rows.append((numbers_of(part), f"`{part.name}`", part.meaning, spaced(bytes_of(part, raw)), reads))
    return table(("Byte", "Name", "Meaning", "Example", "Reads"), rows)


def main(arguments: list[str] | None = None) -> int:
    """Write or check the page; exit code 1 if it is out of date."""
    parser = argparse.ArgumentParser(description="Write docs/protocol.md from the catalogue.")
    parser.add_argument("--check", action="store_true", help="write nothing; exit 1 when the page is out of date")
    options = parser.parse_args(arguments)
    text = page()
    if options.check:
        is_current = PAGE.exists() and PAGE.read_text(encoding="utf-8") == text
        if not is_current:
            print(f"{PAGE} is out of date: run python docs/generate/protocol_page.py", file=sys.stderr)
        return 0 if is_current else 1
    PAGE.parent.mkdir(exist_ok=True)
    PAGE.write_text(text, encoding="utf-8", newline="\n")
    return 0


if __name__ == "__main__":
    sys.exit(main())

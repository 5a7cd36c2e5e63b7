"""Exactly these requests are dangerous, and no entry of the catalogue lacks anything. The table: `tests.vendor`."""

import pytest

from protocol.catalogue import (
    COMMANDS,
    RECORD_PARTS,
    SET,
    SETTINGS,
    STATUS_PARTS,
    Command,
    FramePart,
    Hazard,
    Layout,
    Request,
)
from protocol.fields import Quantity

DANGEROUS = {
    "42 61 10 02 01",  # activate
    "42 61 11 02 00",  # forbid deploying: for how long, nobody knows (E15)
    "42 61 11 02 01",  # fire
    "42 61 12 02 01",  # shut down
    "42 61 24 02 01",  # the six baud rates (E9)
    "42 61 24 02 02",
    "42 61 24 02 03",
    "42 61 24 02 04",
    "42 61 24 02 05",
    "42 61 24 02 06",
    "42 61 25 01 00",  # zero the sensor, in the shape of a query
}
REPEATABLE = {
    "42 61 01 A5 5A",
    "42 61 14 01 01",
    "42 61 15 01 00",
    "42 61 20 01 00",
    "42 61 21 01 00",
    "42 61 22 01 00",
    "42 61 23 01 00",
    "42 61 30 01 00",
    "42 61 31 01 00",
    "42 61 32 01 00",
    "42 61 33 01 00",
    "42 61 34 01 00",
    "42 61 35 01 00",
}


def every_request() -> list[Request]:
    """Each request that the catalogue can make, with every value that may be set."""
    requests = [command.query() for command in COMMANDS if command.query_data is not None]
    for command in COMMANDS:
        if command.write is not None:
            requests += [Request(command, SET, raw) for raw in sorted(command.write.allowed)]
    return requests


def without_sum(request: Request) -> str:
    return request.encode()[:-1].hex(" ").upper()


def test_e09_exactly_these_requests_are_dangerous() -> None:
    assert {without_sum(one) for one in every_request() if one.hazard is Hazard.DANGEROUS} == DANGEROUS


def test_exactly_these_requests_may_be_repeated() -> None:
    assert {without_sum(one) for one in every_request() if one.is_repeatable} == REPEATABLE


def test_the_settings_and_their_keys() -> None:
    assert [command.key for command in SETTINGS] == [
        "serial_output",
        "light_threshold_v",
        "attitude_trigger",
        "freefall_trigger",
        "attitude_threshold_deg",
        "freefall_acceleration_g",
        "freefall_time_s",
        "baud_rate",
    ]
    assert len({command.key for command in COMMANDS}) == len(COMMANDS)


@pytest.mark.parametrize("command", COMMANDS, ids=lambda command: command.name)
def test_an_entry_is_complete(command: Command) -> None:
    assert command.title
    assert command.vendor_term
    assert command.explanation.endswith(".")
    assert (command.layout is Layout.SHORT) or command.reply is None
    assert (command.write is None) or command.can_be_asked is command.reads_back
    assert command.query_data is not None or command.write is not None
    if command.reply_key is not None:
        assert command.reply is not None
        assert command.reply_key.endswith(command.reply.suffix)
    if command.write_key is not None:
        assert command.write is not None
        assert command.write_key.startswith("set")
    if isinstance(command.write, Quantity) or (command.write is not None and len(command.write.allowed) > 1):
        assert command.write_key is not None


@pytest.mark.parametrize(
    ("parts", "first", "layout"), [(STATUS_PARTS, 3, Layout.STATUS), (RECORD_PARTS, 4, Layout.RECORD)]
)
def test_the_parts_of_a_long_frame_are_every_byte_before_the_sum(
    parts: tuple[FramePart, ...], first: int, layout: Layout
) -> None:
    covered = [byte for part in parts for byte in range(part.first, part.first + part.length)]
    assert covered == list(range(first, layout.value - 1))

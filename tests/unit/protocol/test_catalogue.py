"""Exactly these requests are dangerous, and no entry of the catalogue lacks anything. The table: `tests.vendor`."""

from protocol.catalogue import COMMANDS, SET, Hazard, Request

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

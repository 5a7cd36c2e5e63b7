"""How a module speaks, fails and lies. As delivered it is honest, and answers what the table leaves open in one way."""

import dataclasses
import json
from dataclasses import dataclass, field
from typing import Any

ALWAYS = -1
"""In place of a number of times."""

Times = dict[int, int]
"""By code: how many of the next ones; `ALWAYS` for each."""


@dataclass
class Options:
    """Codes are D2. A test may change any of them while the module runs."""

    # Dialects: what the vendor's table contradicts or leaves open.
    misprinted_sum: bool = False
    """E1: the answer to query 20 carries the sum 50 of the printed table."""
    acknowledged_by_one: set[int] = field(default_factory=set)
    """E2: these codes acknowledge a set with 01 in place of the value."""
    voltage_code: int = 0x35
    """E3: the code that 34 is answered with; the table prints 35."""
    freefall_code: int = 0x17
    """E4: the code that 17 is acknowledged with; the table prints 16."""
    record_bytes: int = 16
    """E5: 14 is the row as it is printed, without its last two bytes."""
    records_at_once: int = 9
    """E6: how many records come back to one query; the next query brings the next ones."""
    records_newest_first: bool = True
    record_gap_s: float = 0.0
    empty_slot: int | None = 0x00
    """E7: the byte that never used slots are full of; None: those are not sent."""
    flags_survive: bool = True
    """E8, E15: whether 16 and 17 survive a restart."""
    activation_survives: bool = False
    """E15."""
    output_survives: bool = False
    """E15."""
    baud_answer: str = "old"
    """E9: the rate at which 24 is acknowledged: old, new or none."""
    baud_at_once: bool = True
    """E9: False: the new rate holds from the next restart on."""
    lowest_attitude_deg: int = 0
    """E10: a set of 20 below it is answered with the value that stands, and changes nothing."""
    light_closed: int = 3
    light_open: int = 30
    """E11: the reading with the bay closed and open, in 0.1 V; swap them for the other direction."""
    long_sum_short: bool = False
    """E13: the sum of 32 and 35 covers D2 to D4 only."""
    record_light_is_threshold: bool = False
    """E14: a record's D13 is the threshold, not the reading."""
    forbidding_holds_back: bool = False
    """E15: after 11 with 00 neither serial nor automatic triggers fire until a restart."""
    set_needs_pause_s: float = 0.0
    """A set is not heard so soon after the frame before it."""

    # Faults of the line and of the module.
    delay_s: float = 0.0
    """Before each answer."""
    jitter_s: float = 0.0
    """Up to so much more, seeded."""
    delays: dict[int, float] = field(default_factory=dict)
    """By code, in place of `delay_s`."""
    in_order: bool = True
    """An answer waits for the one before it."""
    lost_queries: Times = field(default_factory=dict)
    """Not heard."""
    lost_sets: Times = field(default_factory=dict)
    """Not heard: neither done nor acknowledged."""
    lost_answers: Times = field(default_factory=dict)
    """Sets that are done and not acknowledged."""
    ignored_sets: Times = field(default_factory=dict)
    """Acknowledged and not done."""
    copies: dict[int, list[float]] = field(default_factory=dict)
    """By code: the acknowledgement of a set comes again, so many seconds after the first."""
    query_copies: dict[int, list[float]] = field(default_factory=dict)
    """By code: the answer to a query comes again."""
    lose: float = 0.0
    """Share of the bytes that are lost, in both directions, seeded."""
    flip: float = 0.0
    """Share of the bytes in which one bit is turned, in both directions, seeded."""
    heartbeat_every_s: float = 0.0
    """Unasked heartbeats."""
    stream_hz: float = 50.0

    # Lies.
    instead: dict[int, str] = field(default_factory=dict)
    """By code: what stands between code and sum in each answer to a query, in hex: {0x30: "01 01"}."""
    second: dict[int, tuple[float, str]] = field(default_factory=dict)
    """By code: a second answer to each query, so many seconds after the first, as in `instead`."""
    reverts: dict[int, tuple[float, int | None]] = field(default_factory=dict)
    """By code: so long after a set the setting changes by itself, to the value, or back where it is None."""


def from_words(words: list[str]) -> Options:
    """Return options that each of `words` changes one of."""
    options = Options()
    for word in words:
        use(options, word)
    return options


def use(options: Options, word: str) -> None:
    """Take `NAME=JSON`; codes in JSON's keys and lists are hex: `copies={"16":[0.5]}`, `acknowledged_by_one=["21"]`."""
    name, _, text = word.partition("=")
    known = [one.name for one in dataclasses.fields(Options)]
    if name not in known:
        raise SystemExit(f"unknown option {name}; there are: {', '.join(known)}")
    given: Any = json.loads(text)
    before = getattr(options, name)
    if isinstance(before, dict):
        given = {int(code, 16): given[code] for code in given}
    elif isinstance(before, set):
        given = {int(code, 16) for code in given}
    setattr(options, name, given)

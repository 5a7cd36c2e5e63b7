"""How a module speaks, fails and lies. As delivered it is honest, and answers what the table leaves open in one way."""

import dataclasses
import json
from dataclasses import dataclass, field
from typing import Any

Times = dict[int, int]
"""By code: how many of the next ones; -1: each."""


@dataclass
class Options:
    """Keys are D2, the code. A test may change any of them while the module runs."""

    # Dialects: what the vendor's table contradicts or leaves open.
    misprinted_sum: bool = False  # E1: the answer to query 20 carries the printed sum 50
    acknowledged_by_one: set[int] = field(default_factory=set)  # E2: they acknowledge a set with 01, not the value
    voltage_code: int = 0x35  # E3: what 34 is answered with; the table prints 35
    freefall_code: int = 0x17  # E4: what 17 is acknowledged with; the table prints 16
    record_bytes: int = 16  # E5: 14 is the row as it is printed
    records_at_once: int = 9  # E6: so many for each query; the next query brings the next ones
    records_newest_first: bool = True
    record_gap_s: float = 0.0
    empty_slot: int | None = 0x00  # E7: what never used slots are full of; None: they are not sent
    activation_survives: bool = False  # E15: a restart, as the next two
    output_survives: bool = False
    flags_survive: bool = True  # E8: 16 and 17
    baud_answer: str = "old"  # E9: at the "old" or "new" rate, or "none"
    baud_at_once: bool = True  # E9: else with the next restart
    lowest_attitude_deg: int = 0  # E10: a set of 20 below it changes nothing, and is answered with what stands
    light_closed: int = 3  # E11: in 0.1 V; swapped with the next one, more light reads lower
    light_open: int = 30
    long_sum_short: bool = False  # E13: the sum of 32 and 35 covers D2 to D4 only
    record_light_is_threshold: bool = False  # E14: D13 is the threshold, not the reading
    forbidding_holds_back: bool = False  # E15: after 11 with 00 nothing fires until a restart
    set_needs_pause_s: float = 0.0  # a set is not heard so soon after the frame before it

    # Faults of the line and of the module.
    delay_s: float = 0.0  # before each answer
    jitter_s: float = 0.0  # up to so much more, seeded
    delays: dict[int, float] = field(default_factory=dict)  # in place of `delay_s`
    in_order: bool = True  # an answer waits for the one before it
    lost_queries: Times = field(default_factory=dict)  # not heard
    lost_sets: Times = field(default_factory=dict)  # not heard: neither done nor acknowledged
    lost_answers: Times = field(default_factory=dict)  # sets that are done and not acknowledged
    ignored_sets: Times = field(default_factory=dict)  # acknowledged and not done
    copies: dict[int, list[float]] = field(default_factory=dict)  # acknowledgements come again, so long after the first
    query_copies: dict[int, list[float]] = field(default_factory=dict)  # likewise answers to queries
    lose: float = 0.0  # share of the bytes that are lost, in both directions, seeded
    flip: float = 0.0  # share of the bytes with one bit turned, in both directions, seeded
    heartbeat_every_s: float = 0.0  # unasked; 0: none
    stream_hz: float = 50.0

    # Lies.
    instead: dict[int, str] = field(default_factory=dict)
    """What stands between code and sum in each answer to a query, in hex: {0x30: "01 01"}."""
    second: dict[int, tuple[float, str]] = field(default_factory=dict)
    """A second answer to each query, so many seconds after the first, as in `instead`."""
    reverts: dict[int, tuple[float, int | None]] = field(default_factory=dict)
    """So long after a set the setting changes by itself, to the value, or back where it is None."""


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

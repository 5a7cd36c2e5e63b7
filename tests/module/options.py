"""How a module speaks, fails and lies. As delivered it is honest, and answers what the table leaves open in one way."""

from dataclasses import dataclass, field

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
    records_at_once: int = 9  # E6: so many for each query; the next query brings the next ones
    record_gap_s: float = 0.0
    empty_slot: int | None = 0x00  # E7: what never used slots are full of; None: they are not sent
    # By the number of the query: the numbers of the records that are lost, both from 1.
    lost_records: dict[int, frozenset[int]] = field(default_factory=dict)
    activation_survives: bool = False  # E15: a restart, as the next two
    flags_survive: bool = True  # E8: 16 and 17
    baud_answer: str = "old"  # E9: at the "old" or "new" rate, or "none"
    baud_at_once: bool = True  # E9: else with the next restart
    lowest_attitude_deg: int = 0  # E10: a set of 20 below it changes nothing, and is answered with what stands
    light_closed: int = 3  # E11: in 0.1 V; swapped with the next one, more light reads lower
    light_open: int = 30

    # Faults of the line and of the module.
    delay_s: float = 0.0  # before each answer
    jitter_s: float = 0.0  # up to so much more, seeded
    lost_queries: Times = field(default_factory=dict)  # not heard
    lost_sets: Times = field(default_factory=dict)  # not heard: neither done nor acknowledged
    lost_answers: Times = field(default_factory=dict)  # sets that are done and not acknowledged
    ignored_sets: Times = field(default_factory=dict)  # acknowledged and not done
    refused_sets: set[int] = field(default_factory=set)  # answered with 00 and not done
    copies: dict[int, list[float]] = field(default_factory=dict)  # acknowledgements come again, so long after the first
    query_copies: dict[int, list[float]] = field(default_factory=dict)  # likewise answers to queries
    lose: float = 0.0  # share of the bytes that are lost, in both directions, seeded
    stream_hz: float = 50.0

    # Lies.
    instead: dict[int, str] = field(default_factory=dict)
    """What stands between code and sum in each answer to a query, in hex: {0x30: "01 01"}."""
    second: dict[int, tuple[float, str]] = field(default_factory=dict)
    """A second answer to each query, so many seconds after the first, as in `instead`."""
    reverts: dict[int, tuple[float, int | None]] = field(default_factory=dict)
    """So long after a set the setting changes by itself, to the value, or back where it is None."""

"""What was known of a module before a check."""

from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, NamedTuple

from protocol.fields import Value

if TYPE_CHECKING:  # reading loads none of it
    from app.guided.results import GuidedKind, StoredTest
    from app.modules.service import DueService


class LastTested(NamedTuple):
    """The last result of a guided test. `age_days`: at the check; None if unknown."""

    stored: "StoredTest"
    age_days: float | None


@dataclass(frozen=True, slots=True)
class LastAnswer:
    """When the module last answered the query for its trigger records, and how many it had. `at`: ISO 8601, UTC."""

    at: str
    count: int


@dataclass(frozen=True, slots=True, kw_only=True)
class Past:
    """What was known of the module before the check; empty without a store or a name."""

    module: str | None = None
    boot_count: int | None = None
    """At its last visit."""
    reviewed: Counter[bytes] = field(default_factory=Counter)
    """Raw trigger records with a person's judgement."""
    has_check: bool = False
    """There was a GO before."""
    settings: Mapping[str, Value] = field(default_factory=dict)
    """As last read, by key."""
    do_records_follow: bool = True
    """False if its trigger records do not continue those of the last visit."""
    last_answer: LastAnswer | None = None
    """None if it was always silent when it was asked for its records."""
    is_said_new: bool = False
    """A person said that it is new and has no records; it has not reported a trigger since."""
    fingerprint: str | None = None
    """Of its last GO."""
    tests: Mapping["GuidedKind", LastTested] = field(default_factory=dict)
    """The last result of each guided test; those of simulated modules only count for a simulated one."""
    due: Sequence["DueService"] = ()
    """What a person has to do to the module."""

"""What was known of a module before a check."""

from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, NamedTuple

if TYPE_CHECKING:  # reading loads none of it
    from app.guided.results import GuidedKind, StoredTest
    from app.modules.names import Remembered
    from app.modules.service import DueService
    from app.store.fact_store import Kept
    from app.store.rows import ModuleVisited


class LastTested(NamedTuple):
    """The last result of a guided test. `age_days`: at the check; None if unknown."""

    stored: "StoredTest"
    age_days: float | None


@dataclass(frozen=True, slots=True, kw_only=True)
class Past:
    """Empty without a store or a name."""

    module: str | None = None
    remembered: "Remembered | None" = None
    reviewed: Counter[bytes] = field(default_factory=Counter)  # raw trigger records with a person's judgement
    has_check: bool = False  # there was a GO before
    do_records_follow: bool = True  # False: its trigger records do not continue those of the last visit
    last_answer: "Kept[ModuleVisited] | None" = None  # None if it was always silent when it was asked for its records
    is_said_new: bool = False  # a person said that it has no records yet; it has not reported a trigger since
    fingerprint: str | None = None  # of its last GO
    # Those of simulated modules only count for a simulated one.
    tests: Mapping["GuidedKind", LastTested] = field(default_factory=dict)
    due: Sequence["DueService"] = ()  # what a person has to do to the module

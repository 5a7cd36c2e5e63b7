"""Expected values before a flight: from the profile, else the vendor's advice, and the module's history."""

from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

from app.settings.profiles import LIMITS, ActivatedBy, Profile
from protocol.fields import Value

if TYPE_CHECKING:  # reading loads none of it
    from app.guided.kept_test import StoredTest
    from app.guided.results import GuidedKind
    from app.limits.service import DueService

Fingerprint = Callable[[Mapping[str, Value]], str]
"""Computes a short code of settings, given by key."""


@dataclass(frozen=True, slots=True)
class ManualItem:
    """A manual check of the profile. `is_done` None: skipped, and printed as skipped."""

    text: str
    is_done: bool | None = None
    is_required: bool = False
    """If skipped, the verdict is NO-GO."""


@dataclass(frozen=True, slots=True, kw_only=True)
class CheckLimits:
    """Limits of the check, unless the profile has others."""

    heartbeats_lost_max: int = int(LIMITS["heartbeats_lost_max"].usual)
    """Of 20. A cable of a metre loses none."""
    round_trip_max_ms: float = LIMITS["round_trip_max_ms"].usual
    """The slowest of 20: 27 ms at 4800 baud, 16 ms for a slow adapter, and a reserve."""
    tilt_max_deg: float = LIMITS["tilt_max_deg"].usual
    tilt_spread_max_deg: float = LIMITS["tilt_spread_max_deg"].usual
    """Between the lowest and the highest value of two seconds."""
    acceleration_min_g: float = LIMITS["acceleration_min_g"].usual
    acceleration_max_g: float = LIMITS["acceleration_max_g"].usual
    acceleration_spread_max_g: float = LIMITS["acceleration_spread_max_g"].usual
    """One step (0.1 g) each way."""
    cell_voltage_min_v: float = LIMITS["cell_voltage_min_v"].usual
    """The lowest of the three examples in the vendor's table (BE)."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Expectations:
    """`settings`: required values by key. `profile`: its name, None without one."""

    profile: str | None = None
    limits: CheckLimits = field(default_factory=CheckLimits)
    settings: Mapping[str, Value] = field(default_factory=dict)
    activated_by: ActivatedBy = ActivatedBy.PERSON
    approved_fingerprint: str | None = None
    is_light_inverted: bool = False
    """A calibration found that more light reads lower (E11)."""
    manual: tuple[ManualItem, ...] = ()
    tests_within_days: Mapping["GuidedKind", int] = field(default_factory=dict)
    """Guided tests that must have passed, and their maximum age."""
    is_service_required: bool = False
    """What is overdue stands against GO."""


@dataclass(frozen=True, slots=True)
class LastTested:
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


def settings_code(settings: Mapping[str, Value]) -> str:
    """The settings code for people."""
    from app.settings.fingerprint import fingerprint

    return fingerprint(settings).code or ""


def expectations_of(profile: Profile, ticked: Mapping[int, bool] | None = None) -> Expectations:
    """Expectations of a profile; `ticked`: the person's answers for its manual items, by number from 1."""
    said = ticked or {}
    limits = {name: value for name, value in profile.limits.items() if name in CheckLimits.__slots__}
    if "heartbeats_lost_max" in limits:
        limits["heartbeats_lost_max"] = int(limits["heartbeats_lost_max"])
    return Expectations(
        profile=profile.name,
        limits=CheckLimits(**limits),  # type: ignore[arg-type]
        settings=profile.settings,
        approved_fingerprint=profile.approved_fingerprint,
        activated_by=profile.activated_by,
        is_light_inverted=profile.is_light_inverted,
        tests_within_days=profile.tests_within_days,
        is_service_required=profile.is_service_required,
        manual=tuple(
            ManualItem(line.text, said.get(number), line.is_required) for number, line in enumerate(profile.manual, 1)
        ),
    )

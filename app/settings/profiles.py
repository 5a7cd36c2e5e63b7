"""Profiles: how the modules of one airframe should be set, and what the pre-flight check expects of them."""

from collections.abc import Mapping
from enum import Enum
from types import MappingProxyType
from typing import NamedTuple

from app.guided.results import GuidedKind
from protocol.catalogue import SETTINGS, Command
from protocol.fields import Value
from protocol.translatable import marked

FORMAT = 1
MAX_NAME_LENGTH = 200
MAX_NOTES_LENGTH = 8_000
MAX_ITEMS = 40
MAX_TEST_DAYS = 3650

SETTINGS_BY_KEY: Mapping[str, Command] = MappingProxyType({command.key: command for command in SETTINGS})


class ActivatedBy(Enum):
    """Who activates the module before a flight; the value is the file's word."""

    PERSON = "person"
    AIRCRAFT = "aircraft"


class CheckLimit(NamedTuple):
    """A limit of one check of the pre-flight check: what it is without a profile, what a profile may say, ends included
    (outside the check would prove nothing), and why not more. Of a maximum a higher value is softer."""

    check: str
    usual: float
    low: float
    high: float
    why: str
    is_maximum: bool
    shown: str


# They are our choice; the vendor gives steps of the cell voltage only.
LIMITS: Mapping[str, CheckLimit] = MappingProxyType({
    # Of 20. A cable of a metre loses none.
    "heartbeats_lost_max": CheckLimit(
        "link_loss", 0, 0, 2, marked("of 20; a worse line may lose a setting"), is_maximum=True, shown="{:g}"),
    # The slowest of 20: 27 ms at 4800 baud, 16 ms for a slow adapter, and a reserve.
    "round_trip_max_ms": CheckLimit(
        "round_trip", 100.0, 1, 500, marked("after 1000 ms the module counts as offline"), is_maximum=True,
        shown="{:g} ms"),
    "tilt_max_deg": CheckLimit(
        "tilt", 5.0, 0, 15, marked("beyond it one side fires late"), is_maximum=True, shown="{:g}°"),
    # Between the lowest and the highest value of two seconds.
    "tilt_spread_max_deg": CheckLimit(
        "tilt_spread", 2.0, 0, 5, marked("a resting sensor wanders less"), is_maximum=True, shown="{:g}°"),
    "acceleration_min_g": CheckLimit(
        "acceleration", 0.9, 0.8, 1.0, marked("at rest it is 1 g"), is_maximum=False, shown="{:g} g"),
    "acceleration_max_g": CheckLimit(
        "acceleration", 1.1, 1.0, 1.2, marked("at rest it is 1 g"), is_maximum=True, shown="{:g} g"),
    # One step (0.1 g) each way.
    "acceleration_spread_max_g": CheckLimit(
        "acceleration_spread", 0.2, 0, 0.4, marked("more noise can end a fall"), is_maximum=True, shown="{:g} g"),
    # The lowest of the three examples in the vendor's table (BE).
    "cell_voltage_min_v": CheckLimit(
        "cell_voltage", 3.8, 3.5, 4.2, marked("a lithium cell has 3.5 V to 4.2 V"), is_maximum=False, shown="{:.2f} V"),
})  # fmt: skip


class ManualLine(NamedTuple):
    """A check done by a person; skipping one that `is_required` gives NO-GO. `is_done`: the person's answer, None where
    it was skipped, and in a file."""

    text: str
    is_required: bool = False
    is_done: bool | None = None


class Profile(NamedTuple):
    """`settings` by key, in the field's unit; `limits` by name. What is not said is the program's own.

    `approved_fingerprint` is that of a module that was checked with this profile. `is_light_inverted`: the calibration
    found that more light reads as a lower voltage (E11). `is_service_required`: a repack, ejector or cell that is
    overdue stands against GO; else it is a warning. `tests_within_days`: the guided tests that the pre-flight check
    requires, with the maximum age of the last one passed.
    """

    name: str = ""
    airframe: str = ""
    notes: str = ""
    settings: Mapping[str, Value] = MappingProxyType({})
    limits: Mapping[str, float] = MappingProxyType({})
    manual: tuple[ManualLine, ...] = ()
    approved_fingerprint: str | None = None
    is_light_inverted: bool = False
    is_service_required: bool = False
    activated_by: ActivatedBy = ActivatedBy.PERSON
    tests_within_days: Mapping[GuidedKind, int] = MappingProxyType({})

    def limit(self, name: str) -> float:
        """One of `LIMITS`."""
        return self.limits.get(name, LIMITS[name].usual)

    def answered(self, answers: Mapping[int, bool]) -> "Profile":
        """With a person's answers for its manual checks, by number from 1."""
        lines = enumerate(self.manual, 1)
        return self._replace(manual=tuple(line._replace(is_done=answers.get(number)) for number, line in lines))


NO_PROFILE = Profile()

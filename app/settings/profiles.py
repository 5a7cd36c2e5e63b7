"""Profiles: how the modules of one airframe should be set, and what the pre-flight check expects of them."""

from collections.abc import Mapping
from enum import Enum
from types import MappingProxyType
from typing import TYPE_CHECKING, Final, NamedTuple

from protocol.fields import Value

if TYPE_CHECKING:  # it loads what reads JSON, which takes longer than the rest of `dps-s read`
    from app.guided.results import GuidedKind


class ActivatedBy(Enum):
    """Who activates the module before a flight; the value is the file's word."""

    PERSON = "person"
    AIRCRAFT = "aircraft"


class CheckLimit(NamedTuple):
    """A limit of one check of the pre-flight check: what it is without a profile, and what a profile may say, ends
    included (outside the check would prove nothing). Of a maximum a higher value is softer."""

    check: str
    usual: float
    low: float
    high: float
    shown: str
    is_maximum: bool = True


# They are our choice; the vendor gives steps of the cell voltage only.
LIMITS: Final[Mapping[str, CheckLimit]] = {
    # Of 20. A cable of a metre loses none; a worse line than 2 may lose a setting.
    "heartbeats_lost_max": CheckLimit("link_loss", 0, 0, 2, "{:g}"),
    # The slowest of 20: 27 ms at 4800 baud, 16 ms for a slow adapter, and a reserve; after 1000 ms it is offline.
    "round_trip_max_ms": CheckLimit("round_trip", 100.0, 1, 500, "{:g} ms"),
    # Beyond 15° one side fires late.
    "tilt_max_deg": CheckLimit("tilt", 5.0, 0, 15, "{:g}°"),
    # Between the lowest and the highest value of two seconds. A resting sensor wanders less.
    "tilt_spread_max_deg": CheckLimit("tilt_spread", 2.0, 0, 5, "{:g}°"),
    "acceleration_min_g": CheckLimit("acceleration", 0.9, 0.8, 1.0, "{:g} g", is_maximum=False),
    "acceleration_max_g": CheckLimit("acceleration", 1.1, 1.0, 1.2, "{:g} g"),
    # One step (0.1 g) each way; more noise can end a fall.
    "acceleration_spread_max_g": CheckLimit("acceleration_spread", 0.2, 0, 0.4, "{:g} g"),
    # The lowest of the three examples in the vendor's table (BE); a lithium cell has 3.5 V to 4.2 V.
    "cell_voltage_min_v": CheckLimit("cell_voltage", 3.8, 3.5, 4.2, "{:.2f} V", is_maximum=False),
}


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
    tests_within_days: "Mapping[GuidedKind, int]" = MappingProxyType({})

    def limit(self, name: str) -> float:
        """Return one of `LIMITS`."""
        return self.limits.get(name, LIMITS[name].usual)

    def answered(self, answers: Mapping[int, bool]) -> "Profile":
        """Return the profile with a person's answers for its manual checks, by number from 1."""
        lines = enumerate(self.manual, 1)
        return self._replace(manual=tuple(line._replace(is_done=answers.get(number)) for number, line in lines))


NO_PROFILE = Profile()

"""Shortens the pre-flight check for tests, and allows for a busy machine."""

import pytest

from app.engine import identity
from app.limits import limits
from app.preflight import line_checks, run
from app.settings import profiles
from app.settings.profiles import LIMITS

STILL_S = 0.5
TRIAL_EVERY_S = 0.012
ROUND_TRIP_MAX_MS = 950.0  # below the timeout of a query, 1 s
IDENTIFIED_WITHIN_S = 30.0


def hurry_check(patch: pytest.MonkeyPatch, *, still_s: float = STILL_S, trials: int = 2) -> None:
    """Observe for `still_s` only, require few reports, and accept round trips that other processes delay."""
    patch.setattr(run, "STILL_S", still_s)
    patch.setattr(run, "TRIAL_EVERY_S", TRIAL_EVERY_S)
    patch.setattr(line_checks, "STILL_S", still_s / 2)
    patch.setattr(line_checks, "TRIALS_NEEDED", trials)
    patch.setattr(identity, "READ_WITHIN_S", IDENTIFIED_WITHIN_S)
    slower = LIMITS["round_trip_max_ms"]._replace(usual=ROUND_TRIP_MAX_MS)
    for module in (profiles, limits):
        patch.setattr(module, "LIMITS", {**LIMITS, "round_trip_max_ms": slower})

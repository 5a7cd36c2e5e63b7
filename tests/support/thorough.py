"""Of what takes hours a part is run each time, and all of it by `make nightly`."""

import os
from collections.abc import Iterable
from typing import Final, TypeVar

Case = TypeVar("Case")

IS_THOROUGH: Final = os.environ.get("HYPOTHESIS_PROFILE") == "thorough"


def some(cases: Iterable[Case], *, one_in: int, first: int = 0) -> list[Case]:
    """One in so many cases, counted from the number `first` on; all of them where the tests are thorough."""
    every = list(cases)
    return every if IS_THOROUGH else every[first % one_in :: one_in]

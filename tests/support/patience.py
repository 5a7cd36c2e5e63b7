"""Times on a machine that others use too: a test waits for what it names, for as long as it takes."""

import time
from collections.abc import Iterator
from contextlib import contextmanager

PATIENCE_S = 60.0
"""Longer than anything takes on a busy machine: only who waits for what never comes waits so long."""
MACHINE_S = 5.0
"""What a busy machine adds to a limit; what is tested for being late does not come at all, or much later."""


@contextmanager
def in_time(limit_s: float) -> Iterator[None]:
    start_s = time.monotonic()
    yield
    took_s = time.monotonic() - start_s
    assert took_s < limit_s + MACHINE_S, f"took {took_s:.2f} s"

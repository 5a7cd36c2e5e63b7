"""The program's clock counts while the computer sleeps."""

import sys
import time

import pytest

from app.system.clock import steady_time


def test_it_never_goes_back() -> None:
    times = [steady_time() for _ in range(1000)]
    assert times == sorted(times)


@pytest.mark.skipif(not sys.platform.startswith("linux"), reason="each system has its own clock")
def test_on_linux_it_is_the_one_that_counts_sleep() -> None:
    assert steady_time() == pytest.approx(time.clock_gettime(time.CLOCK_BOOTTIME), abs=1.0)

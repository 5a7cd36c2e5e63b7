"""Fixtures for the tests of the Pre-flight page."""

import pytest

from tests.support.check_pace import hurry_check


@pytest.fixture
def quick(monkeypatch: pytest.MonkeyPatch) -> None:
    """Measures for 0.2 s only."""
    hurry_check(monkeypatch, still_s=0.2)

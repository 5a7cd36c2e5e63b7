"""Fixtures for the tests of the pages."""

from collections.abc import Iterator
from pathlib import Path

import pytest
from PySide6.QtWidgets import QApplication

from tests.gestures.gesture_bench import GestureBench, gesture_bench


@pytest.fixture
def bench(qapp: QApplication, tmp_path: Path) -> Iterator[GestureBench]:
    """The whole window on a simulated module, with hands and clocks of its own."""
    with gesture_bench(qapp, tmp_path) as made:
        yield made

"""Fixtures for the tests of the pages."""

from collections.abc import Iterator
from pathlib import Path

import pytest
from PySide6.QtWidgets import QApplication
from pytestqt.qtbot import QtBot

from tests.support.window.hand import Hand, hand_at
from tests.support.window.preflight_window import OnBench, on_bench
from tests.support.window.settings_bench import Desk, desk


@pytest.fixture
def bench(request: pytest.FixtureRequest, qapp: QApplication, tmp_path: Path) -> Iterator[Hand]:
    """Commands and the page of the test folder, on a simulated module, with hands and clocks of its own."""
    with hand_at(Hand, qapp, tmp_path, *{"commands", request.path.parent.name}) as made:
        yield made


@pytest.fixture
def one(request: pytest.FixtureRequest, qtbot: QtBot, qapp: QApplication, tmp_path: Path) -> Iterator[Desk]:
    """Settings or Commands, as the folder of the test says."""
    with desk(qtbot, qapp, tmp_path, request.path.parent.name) as made:
        yield made


@pytest.fixture
def active(qtbot: QtBot, qapp: QApplication, tmp_path: Path) -> Iterator[Desk]:
    """Commands, of an ACTIVE module."""
    with desk(qtbot, qapp, tmp_path, "commands", active=True) as made:
        yield made


@pytest.fixture
def full_desk(qtbot: QtBot, qapp: QApplication, tmp_path: Path) -> Iterator[Desk]:
    """Commands and Settings, of an ACTIVE module."""
    with desk(qtbot, qapp, tmp_path, "commands", "settings", active=True) as made:
        yield made


@pytest.fixture
def full_rig(qtbot: QtBot, qapp: QApplication, tmp_path: Path) -> Iterator[OnBench]:
    """Triggers and Pre-flight."""
    with on_bench(qtbot, qapp, tmp_path, "rig", "triggers", "preflight") as made:
        yield made


@pytest.fixture
def rig(request: pytest.FixtureRequest, qtbot: QtBot, qapp: QApplication, tmp_path: Path) -> Iterator[OnBench]:
    """Triggers or Pre-flight, as the folder of the test says."""
    with on_bench(qtbot, qapp, tmp_path, "rig", request.path.parent.name) as made:
        yield made

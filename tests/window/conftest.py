"""The window of most tests, on a clock of its own."""

from collections.abc import Iterator
from pathlib import Path

import pytest
from PySide6.QtWidgets import QApplication
from pytestqt.qtbot import QtBot

from tests.support.window.desk import desk
from tests.support.window.hand import Hand, hand_at
from tests.support.window.rig import Rig
from ui.main import PAGES


@pytest.fixture
def bench(request: pytest.FixtureRequest, qapp: QApplication, tmp_path: Path) -> Iterator[Hand]:
    """Commands and the page of the test folder, on a simulated module, with hands and clocks of its own."""
    with hand_at(Hand, qapp, tmp_path, *{"commands", request.path.parent.name}) as made:
        yield made


@pytest.fixture
def one(request: pytest.FixtureRequest, qtbot: QtBot, qapp: QApplication, tmp_path: Path) -> Iterator[Rig]:
    """With the pages of the mark `module`, by default that of the folder if it is one's, and its options."""
    mark: pytest.Mark = request.node.get_closest_marker("module") or pytest.mark.module().mark
    own = [entry.key for entry in PAGES if entry.key == request.path.parent.name]
    with desk(qtbot, qapp, tmp_path, *(mark.args or own), **mark.kwargs) as made:
        yield made


@pytest.fixture
def active(qtbot: QtBot, qapp: QApplication, tmp_path: Path) -> Iterator[Rig]:
    """Commands, of an ACTIVE module."""
    with desk(qtbot, qapp, tmp_path, "commands", active=True) as made:
        yield made

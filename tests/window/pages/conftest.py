"""Fixtures for the tests of the pages."""

from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

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


def asked(request: pytest.FixtureRequest) -> tuple[tuple[str, ...], Mapping[str, Any]]:
    """The pages, by default that of the folder, and the options of the mark `module`."""
    mark: pytest.Mark = request.node.get_closest_marker("module") or pytest.mark.module().mark
    return tuple(map(str, mark.args)) or (request.path.parent.name,), mark.kwargs


@pytest.fixture
def one(request: pytest.FixtureRequest, qtbot: QtBot, qapp: QApplication, tmp_path: Path) -> Iterator[Desk]:
    """Settings or Commands."""
    pages, options = asked(request)
    with desk(qtbot, qapp, tmp_path, *pages, **options) as made:
        yield made


@pytest.fixture
def active(qtbot: QtBot, qapp: QApplication, tmp_path: Path) -> Iterator[Desk]:
    """Commands, of an ACTIVE module."""
    with desk(qtbot, qapp, tmp_path, "commands", active=True) as made:
        yield made


@pytest.fixture
def rig(request: pytest.FixtureRequest, qtbot: QtBot, qapp: QApplication, tmp_path: Path) -> Iterator[OnBench]:
    """Triggers or Pre-flight."""
    pages, options = asked(request)
    with on_bench(qtbot, qapp, tmp_path, "rig", *pages, **options) as made:
        yield made

import pytest
from PySide6.QtWidgets import QApplication
from pytestqt.qtbot import QtBot

from tests.support.window.contrast import style_all
from tests.window.plots.plot_bench import NOW_S, Bench
from ui.plots.lanes import Span
from ui.style.theme import LIGHT


@pytest.fixture
def bench(qapp: QApplication, qtbot: QtBot) -> Bench:
    style_all(qapp, LIGHT)
    return Bench(qtbot)


@pytest.fixture
def recorded(qapp: QApplication, qtbot: QtBot) -> Bench:
    return Bench(qtbot, seconds=300, bounds=Span(NOW_S - 300, NOW_S))

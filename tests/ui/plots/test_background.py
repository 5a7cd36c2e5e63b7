"""The cached background of the plots equals the painted one."""

import pytest
from PySide6.QtGui import QImage, QPainter
from PySide6.QtWidgets import QApplication
from pytestqt.qtbot import QtBot

from tests.ui.plots.test_time_plot import NOW_S, Bench
from ui.plots import background as plot_ground
from ui.plots.paint import Picture, paint_back
from ui.style import appearance
from ui.style.theme import DARK, LIGHT


@pytest.fixture
def bench(qapp: QApplication, qtbot: QtBot) -> Bench:
    appearance.apply(qapp, LIGHT)
    return Bench(qtbot)


@pytest.fixture
def paintings(monkeypatch: pytest.MonkeyPatch) -> list[Picture]:
    """Grows by one whenever the ground is painted by hand."""
    found: list[Picture] = []

    def painted(painter: QPainter, picture: Picture) -> None:
        found.append(picture)
        paint_back(painter, picture)

    monkeypatch.setattr(plot_ground, "paint_back", painted)
    return found


def seen(bench: Bench) -> QImage:
    return bench.plot.picture().toImage()


def test_the_cached_background_equals_the_painted_one(bench: Bench, paintings: list[Picture]) -> None:
    seen(bench)
    QApplication.processEvents()
    bench.canvas.arrange()
    before = len(paintings)
    by_hand = seen(bench)
    assert len(paintings) == before + 1
    kept = seen(bench)
    assert len(paintings) == before + 2  # into the picture
    assert seen(bench) == kept == by_hand
    assert len(paintings) == before + 2


def test_following_does_not_repaint_it(bench: Bench, paintings: list[Picture]) -> None:
    seen(bench)
    seen(bench)
    before = len(paintings)
    for step in range(1, 10):
        bench.plot.draw(NOW_S + step)
        seen(bench)
    assert len(paintings) == before


def test_another_time_line_theme_or_scale_is_painted(bench: Bench, qapp: QApplication) -> None:
    def ground() -> QImage:
        seen(bench)
        seen(bench)
        return seen(bench)

    looks = [ground()]
    bench.plot.choose_window(600)
    looks.append(ground())
    bench.tilt.append([NOW_S + 1], [170])
    bench.plot.draw(NOW_S + 2)
    looks.append(ground())
    appearance.apply(qapp, DARK)
    bench.plot.apply_theme()
    looks.append(ground())
    bench.canvas.arrange()
    assert seen(bench) == looks[-1]  # by hand
    assert all(one != other for n, one in enumerate(looks) for other in looks[:n])

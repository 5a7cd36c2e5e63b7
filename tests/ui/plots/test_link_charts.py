"""The charts of the link: texts overlap nothing, and the ground is that of the theme in use."""

from itertools import combinations

import pyqtgraph as pg
import pytest
from PySide6.QtCore import QSize
from PySide6.QtWidgets import QApplication
from pytestqt.qtbot import QtBot

from app.diagnosis.link_statistics import TripClass
from tests.ui.plots.plot_bench import labels_of
from ui.plots.link_charts import Histogram, OverTime, Stretch, percent_text
from ui.style.appearance import Appearance
from ui.style.theme import Choice

CLASSES = tuple(TripClass(bound, count) for bound, count in ((1, 0), (2, 90), (4, 10), (8, 0), (16, 0), (None, 0)))


@pytest.mark.parametrize(("width_px", "is_said"), [(150, False), (600, True)])
def test_a_share_is_not_written_across_the_higher_bar_beside_it(qtbot: QtBot, width_px: int, is_said: bool) -> None:
    chart = Histogram()
    qtbot.addWidget(chart)
    chart.show_classes(CLASSES)
    chart.resize(QSize(width_px, 130))
    chart.show()
    QApplication.processEvents()
    shares = [item.toPlainText() for item in chart.view.addedItems if isinstance(item, pg.TextItem)]
    assert shares[0] == percent_text(0.9)
    assert (percent_text(0.1) in shares) == is_said


def test_the_ground_is_not_kept_over_a_change_of_theme(qtbot: QtBot) -> None:
    """The map of flight logs stood on white in the dark theme."""
    chart = Histogram()
    qtbot.addWidget(chart)
    chart.show()
    assert chart.view.getViewWidget().cacheMode() == pg.GraphicsView.CacheModeFlag.CacheNone


@pytest.mark.parametrize("percent", [100, 200])
def test_over_time_names_each_of_its_bands_at_every_size_of_text(
    qtbot: QtBot, qapp: QApplication, percent: int
) -> None:
    """At 200 % the three labels lay on each other."""
    looks = Appearance(qapp, Choice.LIGHT)
    looks.zoom(percent)
    chart = OverTime()
    qtbot.addWidget(chart)
    chart.show_stretch(Stretch(100.0, 60.0, ()))
    chart.resize(chart.minimumSizeHint())
    chart.show()
    QApplication.processEvents()
    labels = labels_of(chart.axes["left"])
    looks.zoom(100)
    assert {text.split("\n")[0] for text, _ in labels} == {"Slowest answer", "Without reply", "Invalid bytes"}
    assert not any(one.intersects(other) for (_, one), (_, other) in combinations(labels, 2))

"""The charts of the link: texts overlap nothing, and the ground is that of the theme in use."""

import pyqtgraph as pg
import pytest
from PySide6.QtCore import QSize
from PySide6.QtWidgets import QApplication
from pytestqt.qtbot import QtBot

from app.diagnosis.link_statistics import TripClass
from ui.plots.link_charts import Histogram, percent_text

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

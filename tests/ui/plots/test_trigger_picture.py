"""The picture of a trigger record."""

import pytest
from PySide6.QtWidgets import QApplication
from pytestqt.qtbot import QtBot

from protocol.messages import TriggerRecord
from tests.support.window.contrast import style_all
from tests.support.window.painted_text import watching
from ui.plots.trigger_picture import TriggerPicture
from ui.style.theme import LIGHT, SUNLIGHT, Theme

BOTH = TriggerRecord(8, 100, ("attitude", "freefall"), 70, 0.5, 2.0, True, False, 1.2, 3.9, b"")


@pytest.mark.parametrize("theme", [LIGHT, SUNLIGHT], ids=["light", "sunlight"])
def test_what_is_said_of_one_cause_does_not_reach_into_the_other(
    qtbot: QtBot, qapp: QApplication, theme: Theme
) -> None:
    style_all(qapp, theme)
    picture = TriggerPicture("picture")
    qtbot.addWidget(picture)
    picture.resize(262, 96)
    picture.show_record(BOTH, "both")
    with watching() as drawn:
        picture.grab()
    style_all(qapp, LIGHT)
    assert ["fires" in one.text or "rearms" in one.text for one in drawn] == [True, True, False]
    tilt, fall = drawn[:2], drawn[2]
    assert min(one.place.left() for one in tilt) >= 0
    assert max(one.place.right() for one in tilt) <= fall.place.left()
    assert fall.place.right() <= picture.width()

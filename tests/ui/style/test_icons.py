"""Icons are drawn once and come from Qt's cache of pixmaps after that."""

import pytest
from pytestqt.qtbot import QtBot

from ui.style.icons import MEANING_ICONS, Icon, pixmap
from ui.style.theme import Meaning
from ui.widgets.labels import IconLabel


@pytest.mark.parametrize("ratio", [1.0, 1.5, 2.0])
def test_the_same_icon_is_the_same_pixmap(qtbot: QtBot, ratio: float) -> None:
    def key(icon: Icon = Icon.CHECK, size: int = 20, colour: str = "#112233") -> int:
        return pixmap(icon, size, colour, ratio=ratio).cacheKey()

    assert key() == key()
    assert len({key(), key(Icon.WARNING), key(size=21), key(colour="#112234")}) == 4
    assert pixmap(Icon.CHECK, 20, "#112233", ratio=ratio).devicePixelRatio() == ratio


def test_a_label_that_changes_its_icon_300_times_uses_two_pixmaps(qtbot: QtBot) -> None:
    label = IconLabel("changing_icon", 16)
    qtbot.addWidget(label)
    label.show()
    keys: set[int] = set()
    for _ in range(300):
        for meaning in (Meaning.GOOD, Meaning.DANGER):
            label.show_icon(MEANING_ICONS[meaning], meaning)
            label.repaint()
            keys.add(label.pixmap().cacheKey())
    assert len(keys) == 2

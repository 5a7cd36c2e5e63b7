"""The notice bar of a page."""

from PySide6.QtWidgets import QApplication
from pytestqt.qtbot import QtBot

from app.text.i18n import CHINESE, ENGLISH, tr
from ui.core.texts import LanguageSwitch, Texts
from ui.style.theme import Meaning
from ui.widgets.notice_bar import Choice, Notice, NoticeBar


def test_a_notice_that_nobody_shows_again_follows_the_language(qtbot: QtBot, qapp: QApplication) -> None:
    texts = Texts()
    switch = LanguageSwitch(qapp, texts)
    switch.use(ENGLISH)
    bar = NoticeBar(texts)
    qtbot.addWidget(bar)
    bar.show_notice(lambda: Notice(Meaning.ATTENTION, tr("Unsaved edits."), (Choice("keep", tr("Cancel"), bar.hide),)))
    button = bar.button("keep")
    assert button is not None
    before = (bar.accessibleName(), button.text())
    switch.use(CHINESE)
    button = bar.button("keep")
    assert button is not None
    assert bar.notice is not None
    assert bar.notice.text == tr("Unsaved edits.") != "Unsaved edits."
    assert (bar.accessibleName(), button.text()) == (tr("Message: {text}", text=bar.notice.text), tr("Cancel"))
    assert (bar.accessibleName(), button.text()) != before
    bar.show_notice(None)
    switch.use(ENGLISH)
    assert bar.notice is None

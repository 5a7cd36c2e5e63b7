"""The user guide matches the window: its words, its pictures, and both languages; the first run without a
manual, from the first start to READY by clicks and keys."""

import re
from pathlib import Path

import pytest
from PySide6.QtCore import QUrl
from PySide6.QtGui import QImage, QTextDocument
from PySide6.QtWidgets import QApplication, QPushButton, QWidget
from pytestqt.qtbot import QtBot

from app.text import i18n
from app.text.i18n import CHINESE, ENGLISH, LANGUAGES, read_translations
from tests.support.window.rig import Rig
from ui.help.windows import GUIDE, GuideViewer, anchor_of
from ui.main import PAGES

ROOT = Path(__file__).resolve().parents[3]
TS = ROOT / "app" / "locale" / "zh_CN.ts"


def text_of(language: str) -> str:
    return (GUIDE / f"{language}.md").read_text(encoding="utf-8")


def chapters(language: str) -> list[str]:
    """Each with its heading; what stands before the first one comes first."""
    return re.split(r"^(?=## )", text_of(language), flags=re.MULTILINE)


def pictures(text: str) -> list[str]:
    return re.findall(r"!\[[^\]]+\]\(([^)]+)\)", text)


def bold(text: str) -> set[str]:
    return set(re.findall(r"\*\*(.+?)\*\*", text.replace("\n", " ")))


def screen_words() -> dict[str, str]:
    """English to Chinese of what is on the screen, without the marks for a menu's key."""

    def plain(text: str) -> str:
        return re.sub(r"\(&\w\)", "", text).replace("&", "")

    return {plain(english): plain(chinese) for english, chinese in read_translations(TS).items()}


def test_bold_words_are_texts_of_the_window() -> None:
    words = screen_words()
    assert len(bold(text_of(ENGLISH))) > 50
    assert sorted(bold(text_of(ENGLISH)) - words.keys()) == []


def test_each_chapter_names_the_same_buttons_in_both_languages() -> None:
    words = screen_words()
    english, chinese = chapters(ENGLISH), chapters(CHINESE)
    assert len(english) == len(chinese)
    for one, other in zip(english, chinese, strict=True):
        assert bold(other) == {words[word] for word in bold(one) if word in words}, one.partition("\n")[0]


@pytest.mark.parametrize("language", LANGUAGES)
def test_the_viewer_shows_it_and_leads_to_every_chapter(language: str, qtbot: QtBot, qapp: QApplication) -> None:
    """With its pictures, not wider than the text."""
    around = QWidget()
    qtbot.addWidget(around)
    i18n.set_language(language)
    viewer = GuideViewer(around)
    viewer.open_at("no such chapter")
    assert viewer.text.textCursor().atStart()
    document = viewer.text.document()
    assert viewer.text.horizontalScrollBar().maximum() == 0
    plain = QTextDocument()
    plain.setMarkdown(text_of(language))
    assert document.toPlainText() == plain.toPlainText()
    for name in pictures(text_of(language)):
        image = document.resource(QTextDocument.ResourceType.ImageResource.value, document.baseUrl().resolved(name))
        assert isinstance(image, QImage), name
        assert 0 < image.width() / image.devicePixelRatio() <= viewer.text.viewport().width(), name
    english, own = (re.findall(r"^## (.+)$", text_of(one), flags=re.MULTILINE) for one in (ENGLISH, language))
    links = re.findall(r"(?<!!)\[([^\]]+)\]\(#([^)]+)\)", text_of(language))
    assert links == [(heading, anchor_of(heading)) for heading in own]
    for heading, anchor in links:
        viewer.text.anchorClicked.emit(QUrl(f"#{anchor}"))
        assert viewer.text.textCursor().block().text() == heading
    for entry in PAGES:
        viewer.open_at(entry.chapter)
        assert viewer.text.textCursor().block().text() == own[english.index(entry.chapter)]
        assert entry is PAGES[-1] or viewer.text.verticalScrollBar().value() > 0


@pytest.mark.module(*(entry.key for entry in PAGES), is_connected=False)
def test_each_page_leads_to_the_list_of_ports(one: Rig) -> None:
    """Every page, with nothing connected: one sentence on it, and a button in sight that leads on."""
    main, own = one.window, {"live": "live_choose_port", "diagnosis": "why_act"}  # the page says it itself
    main.resize(1024, 600)
    for entry in PAGES:
        main.panel.hide()
        main.go_to(entry.key)
        assert main.panel.isHidden(), entry.key  # it would lie over the page
        name = own.get(entry.key)
        one.click(main.findChild(QPushButton, name) if name else main.notice_bar.button("choose_port"))
        assert main.panel.isVisible(), entry.key

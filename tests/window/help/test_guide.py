"""The user guide matches the window: its words, its pictures, and both languages; the first run without a
manual, from the first start to READY by clicks and keys."""

import re
from pathlib import Path

import pytest
from PySide6.QtCore import Qt, QUrl
from PySide6.QtGui import QImage, QTextDocument
from PySide6.QtWidgets import QApplication, QPushButton, QWidget
from pytestqt.qtbot import QtBot

from app.diagnosis.link_state import Phase
from app.simulator import bench as benches
from app.text import i18n
from app.text.i18n import CHINESE, ENGLISH, LANGUAGES, read_translations
from tests.support.window.fakes_ui import ListedPorts, wait_online, window
from tests.support.window.preflight_window import VERDICTS
from tests.support.window.steps import find, press
from ui.help.windows import GUIDE, GuideViewer, anchor_of
from ui.main import PAGES, Assembly
from ui.pages.preflight.page import PreflightPage
from ui.session.check import Standing

ROOT = Path(__file__).resolve().parents[3]
TS = ROOT / "app" / "locale" / "zh_CN.ts"
README_IMAGES = ROOT / "docs" / "images"
MAX_BYTES, MAX_TOTAL_BYTES = 120_000, 3_000_000
BOTH = pytest.mark.parametrize("language", LANGUAGES)


def text_of(language: str) -> str:
    return (GUIDE / f"{language}.md").read_text(encoding="utf-8")


def chapters(language: str) -> list[str]:
    """Each with its heading; what stands before the first one comes first."""
    return re.split(r"^(?=## )", text_of(language), flags=re.MULTILINE)


def pictures(text: str) -> list[str]:
    return re.findall(r"!\[[^\]]+\]\(([^)]+)\)", text)


def bold(text: str) -> set[str]:
    return set(re.findall(r"\*\*(.+?)\*\*", text.replace("\n", " ")))


def rendered(language: str) -> str:
    """What a reader sees of it."""
    document = QTextDocument()
    document.setMarkdown(text_of(language))
    return document.toPlainText()


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


@BOTH
def test_the_contents_lead_to_every_chapter(language: str, qtbot: QtBot, qapp: QApplication) -> None:
    headings = re.findall(r"^## (.+)$", text_of(language), flags=re.MULTILINE)
    links = re.findall(r"(?<!!)\[([^\]]+)\]\(#([^)]+)\)", text_of(language))
    assert links == [(heading, anchor_of(heading)) for heading in headings]
    around = QWidget()
    qtbot.addWidget(around)
    i18n.set_language(language)
    viewer = GuideViewer(around)
    viewer.open_at("")
    bar = viewer.text.verticalScrollBar()
    places = []
    for _, anchor in links:
        viewer.text.anchorClicked.emit(QUrl(f"#{anchor}"))
        places.append(bar.value())
    assert places[0] > 0
    assert places == sorted(places)
    assert len(set(places)) >= len(places) - 2  # the last ones may fit into the last screenful


@BOTH
def test_each_page_has_a_chapter_that_the_guide_opens_at(language: str, qtbot: QtBot, qapp: QApplication) -> None:
    english = re.findall(r"^## (.+)$", text_of(ENGLISH), flags=re.MULTILINE)
    own = re.findall(r"^## (.+)$", text_of(language), flags=re.MULTILINE)
    around = QWidget()
    qtbot.addWidget(around)
    i18n.set_language(language)
    viewer = GuideViewer(around)
    for entry in PAGES:
        viewer.open_at(entry.chapter)
        assert viewer.text.textCursor().block().text() == own[english.index(entry.chapter)]
    viewer.open_at("no such chapter")
    assert viewer.text.textCursor().atStart()


def test_every_picture_is_there_and_used() -> None:
    used = {GUIDE / name for language in LANGUAGES for name in pictures(text_of(language))}
    pages = [*ROOT.glob("README*.md"), *(ROOT / "docs").glob("*.md")]
    used |= {
        (page.parent / name).resolve()
        for page in pages
        for name in pictures(page.read_text(encoding="utf-8"))
        if "://" not in name
    }
    there = {*(GUIDE / "images").glob("*"), *README_IMAGES.glob("*")}
    assert used == there


@BOTH
def test_the_viewer_shows_it(language: str, qtbot: QtBot, qapp: QApplication) -> None:
    """With its pictures, not wider than the text."""
    around = QWidget()
    qtbot.addWidget(around)
    i18n.set_language(language)
    viewer = GuideViewer(around)
    viewer.open_at("")
    document = viewer.text.document()
    assert document.toPlainText() == rendered(language)
    for name in pictures(text_of(language)):
        image = document.resource(QTextDocument.ResourceType.ImageResource.value, document.baseUrl().resolved(name))
        assert isinstance(image, QImage), name
        assert 0 < image.width() / image.devicePixelRatio() <= viewer.text.viewport().width(), name


MAX_CHECKS = 6
"""A busy machine answers late, which is a fault that the check rightly finds."""


def click(qtbot: QtBot, assembly: Assembly, name: str) -> None:
    widget = find(assembly.window, QWidget, name)
    assert widget.isVisible(), name
    assert widget.isEnabled(), name
    press(qtbot, widget)


def test_from_the_icon_to_go(qtbot: QtBot, qapp: QApplication, tmp_path: Path) -> None:
    benches.remove_bench("demo")
    with window(qapp, tmp_path, listed=ListedPorts(), entries=PAGES) as assembly:
        main, connector = assembly.window, assembly.ports
        with qtbot.waitSignal(main.pages_made):
            main.resize(1024, 600)
        main.activateWindow()
        qtbot.waitUntil(main.isActiveWindow)
        qtbot.waitUntil(main.panel.isVisible)
        assert not main.panel.connect_button.isEnabled()
        ports = main.panel.list
        row = ports.model().index(ports.model().rowCount() - 1, 0)
        qtbot.mouseClick(ports.viewport(), Qt.MouseButton.LeftButton, pos=ports.visualRect(row).center())
        assert ports.chosen is not None
        click(qtbot, assembly, "connect_button")
        wait_online(qtbot, assembly)
        qtbot.waitUntil(lambda: connector.current.state.phase is Phase.ONLINE)
        qtbot.waitUntil(main.panel.isHidden)
        assert "Pre-flight" in main.status_bar.passing.text()  # what comes next
        benches.module("demo").set_world(tilt_deg=20)  # as if it were not set down
        qtbot.keyClick(main, Qt.Key.Key_4, Qt.KeyboardModifier.ControlModifier)
        page = find(main, PreflightPage)
        qtbot.waitUntil(page.isVisible)
        page.tick()
        assert "Enable triggers and check" in page.banner.announcement.head
        click(qtbot, assembly, "preflight_enable")
        wait_verdict(qtbot, page)
        assert page.work.standing is Standing.NO_GO
        for _ in range(MAX_CHECKS):
            if page.work.standing is Standing.READY:
                break
            set_down = page.strip.button("set_down")
            button = set_down if set_down is not None and set_down.isVisible() else page.run
            press(qtbot, button)
            wait_verdict(qtbot, page)
        assert page.banner.announcement.word == "READY"
        assert benches.module("demo").world.tilt_deg == 0  # by the button that said so
        connector.current.disconnect_port()
        qtbot.waitUntil(lambda: not connector.current.is_open)
    benches.remove_bench("demo")


def wait_verdict(qtbot: QtBot, page: PreflightPage) -> None:
    qtbot.waitUntil(lambda: page.work.standing is not Standing.CHECKING)
    assert page.work.standing in VERDICTS


def test_each_page_leads_to_the_list_of_ports(qtbot: QtBot, qapp: QApplication, tmp_path: Path) -> None:
    """Every page, with nothing connected: one sentence on it, and a button in sight that leads on."""
    with window(qapp, tmp_path, listed=ListedPorts(), entries=PAGES) as assembly:
        main = assembly.window
        with qtbot.waitSignal(main.pages_made):
            main.resize(1024, 600)
        qtbot.waitUntil(main.panel.isVisible)
        for entry in PAGES[1:]:
            main.go_to(entry.key)
            assert main.panel.isHidden(), entry.key  # it would lie over the page
            own = {"diagnosis": "why_act"}  # pages that say so themselves
            button = (
                main.findChild(QPushButton, own[entry.key])
                if entry.key in own
                else main.notice_bar.button("choose_port")
            )
            assert button is not None, entry.key
            assert button.isVisible(), entry.key
        press(qtbot, button)
        assert main.panel.isVisible()

"""Texts of widgets: they follow the language, and no widget is kept or missed."""

import gc
import weakref
from functools import partial
from pathlib import Path

import pytest
import shiboken6
from PySide6.QtWidgets import QApplication, QDialogButtonBox, QLabel, QMenu, QTabWidget, QVBoxLayout, QWidget

from app.text.i18n import set_language
from tests.app.text.test_i18n import write_ts
from tests.support.window.steps import find
from ui.core.texts import Texts


@pytest.fixture
def pseudo(tmp_path: Path) -> str:
    messages = {"Tilt": ("倾角", ""), "{n} frames": ("{n} 帧", ""), "Light": ("光线", "")}
    return write_ts(tmp_path / "pseudo.ts", messages)


def test_texts_follow_the_language_and_come_back(qapp: QApplication, pseudo: str) -> None:
    texts, tilt, frames = Texts(), QLabel(), QLabel()
    texts.bind(tilt.setText, "Tilt")
    texts.bind(frames.setText, "{n} frames", n=3)
    assert (tilt.text(), frames.text()) == ("Tilt", "3 frames")
    set_language(pseudo)
    texts.retranslate()
    assert (tilt.text(), frames.text()) == ("倾角", "3 帧")
    set_language("en")
    texts.retranslate()
    assert (tilt.text(), frames.text()) == ("Tilt", "3 frames")


def test_binding_again_replaces_the_text(qapp: QApplication, pseudo: str) -> None:
    texts, label = Texts(), QLabel()
    texts.bind(label.setText, "Tilt")
    texts.bind(label.setText, "Light")
    texts.bind(label.setToolTip, "Tilt")
    assert len(texts) == 2
    set_language(pseudo)
    texts.retranslate()
    assert (label.text(), label.toolTip()) == ("光线", "倾角")


def test_partials_are_told_apart_by_their_arguments(qapp: QApplication, pseudo: str) -> None:
    texts, tabs = Texts(), QTabWidget()
    for number, english in enumerate(("Tilt", "Light")):
        tabs.addTab(QWidget(), "")
        texts.bind(partial(tabs.setTabText, number), english)
    texts.bind(partial(tabs.setTabText, 1), "Light")
    assert len(texts) == 2
    set_language(pseudo)
    texts.retranslate()
    assert [tabs.tabText(0), tabs.tabText(1)] == ["倾角", "光线"]


def test_a_plain_function_is_called(pseudo: str) -> None:
    texts = Texts()
    heard: list[str] = []
    shouted: list[str] = []
    texts.bind(heard.append, "Tilt")
    texts.bind(lambda text: shouted.append(text + "!"), "Tilt")
    gc.collect()
    set_language(pseudo)
    texts.retranslate()
    assert heard == ["Tilt", "倾角"]
    assert shouted == ["Tilt!", "倾角!"]


def test_widgets_that_nobody_else_names_are_reached(qapp: QApplication, pseudo: str) -> None:
    """Their Python wrappers may go while the widgets stay: made in passing, or made by Qt itself."""
    texts, window = Texts(), QWidget()
    QVBoxLayout(window).addWidget(QLabel())
    box = QDialogButtonBox(QDialogButtonBox.StandardButton.Ok, window)
    menu = QMenu(window)
    label = find(window, QLabel)
    texts.bind(label.setText, "Tilt")
    texts.bind(box.button(QDialogButtonBox.StandardButton.Ok).setText, "Tilt")
    texts.bind(menu.addAction("").setText, "Tilt")
    del label
    gc.collect()
    set_language(pseudo)
    texts.retranslate()
    again = find(window, QLabel)
    button = box.button(QDialogButtonBox.StandardButton.Ok)
    assert [again.text(), button.text(), menu.actions()[0].text()] == ["倾角"] * 3


def test_no_widget_is_kept(qapp: QApplication) -> None:
    texts, label = Texts(), QLabel()
    texts.bind(label.setText, "Tilt")
    texts.bind(partial(label.setProperty, "name"), "Tilt")
    watched = weakref.ref(label)
    del label
    gc.collect()
    assert watched() is None
    texts.retranslate()
    assert len(texts) == 0


def test_a_widget_that_qt_deleted_is_left_out(qapp: QApplication) -> None:
    texts, label, stays = Texts(), QLabel(), QLabel()
    texts.bind(label.setText, "Tilt")
    texts.bind(stays.setText, "Tilt")
    shiboken6.delete(label)
    texts.retranslate()
    assert len(texts) == 1


def test_what_is_gone_does_not_pile_up(qapp: QApplication) -> None:
    texts, stays = Texts(), QLabel()
    texts.bind(stays.setText, "Tilt")
    most = 0
    for _ in range(1000):
        texts.bind(QLabel().setText, "Light")
        most = max(most, len(texts))
    assert most < 200
    texts.retranslate()
    assert stays.text() == "Tilt"

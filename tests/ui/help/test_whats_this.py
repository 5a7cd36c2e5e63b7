"""The "What's this?" texts of all controls, the list of shortcuts, the guide and the About box."""

import re
from collections.abc import Iterator
from contextlib import contextmanager
from fnmatch import fnmatchcase
from functools import partial
from pathlib import Path

import pytest
from PySide6.QtCore import QEvent, QPoint, QSize, Qt, QUrl
from PySide6.QtGui import QAction, QHelpEvent, QImage
from PySide6.QtWidgets import (
    QAbstractButton,
    QAbstractItemView,
    QAbstractSlider,
    QAbstractSpinBox,
    QApplication,
    QComboBox,
    QHeaderView,
    QLabel,
    QLineEdit,
    QMenu,
    QMessageBox,
    QPushButton,
    QScrollBar,
    QWhatsThis,
    QWidget,
)
from pytestqt.qtbot import QtBot

from app.settings.setting_texts import advice_text, what_is
from app.text.i18n import CHINESE
from app.text.sentences import capitalised
from protocol.catalogue import BY_NAME, SETTINGS
from tests.support.window.fakes_ui import WAIT_MS, ListedPorts, window
from tests.support.window.steps import find
from ui.core.texts import Texts
from ui.help.guide_viewer import GuideViewer, anchor_of, guide_page
from ui.help.small_windows import keys_of, show_about
from ui.help.whats_this import TEXTS, WIDGETS_AT_ONCE, WhatsThis, explain, fits, text_for
from ui.main import PAGES, Assembly
from ui.pages.settings.page import SettingsPage
from ui.widgets.readout import Readout, StateChip

CONTROLS = (QAbstractButton, QAbstractItemView, QAbstractSlider, QAbstractSpinBox, QComboBox, QLineEdit, Readout,
            StateChip)  # fmt: skip
OFFSCREEN = pytest.mark.qt_log_ignore("does not support", extend=True)
"""That platform has no windows to raise and no keyboard to take."""
NOT_OURS = ("qt_*", "about_*", "*_profile_none")


@contextmanager
def whole_window(qtbot: QtBot, qapp: QApplication, folder: Path) -> Iterator[Assembly]:
    with window(qapp, folder, ports=ListedPorts(), entries=PAGES) as assembly:
        with qtbot.waitSignal(assembly.window.pages_made):
            assembly.window.resize(QSize(1024, 600))
        assembly.window.activateWindow()
        qtbot.waitUntil(assembly.window.isActiveWindow, timeout=WAIT_MS)
        yield assembly


def explained(qtbot: QtBot, assembly: Assembly) -> None:
    """Every widget that there is now has its text."""
    assembly.help.explain()
    qtbot.waitUntil(lambda: not assembly.help.is_explaining, timeout=WAIT_MS)


def controls(root: QWidget) -> list[QWidget]:
    """What a person can use or read off; parts of a control that Qt made for itself are left out."""
    return [
        one
        for one in root.findChildren(QWidget)
        if isinstance(one, CONTROLS)
        and one.objectName()
        and not isinstance(one, QScrollBar | QHeaderView)
        and not any(fnmatchcase(one.objectName(), name) for name in NOT_OURS)
    ]


def is_whole(label: QLabel) -> bool:
    return label.height() >= label.heightForWidth(label.width())


def says(widget: QWidget) -> str:
    """Its own text, or that of what it is part of: Qt asks upwards as well."""
    around: QWidget | None = widget
    while around is not None:
        if around.whatsThis():
            return around.whatsThis()
        around = around.parentWidget()
    return ""


def test_every_control_says_what_it_is(qtbot: QtBot, qapp: QApplication, tmp_path: Path) -> None:
    with whole_window(qtbot, qapp, tmp_path) as assembly:
        assembly.window.menus["simulator"].setChecked(True)
        explained(qtbot, assembly)
        found = controls(assembly.window)
        assert len(found) > 150
        silent = [f"{type(one).__name__} {one.objectName()}" for one in found if not says(one)]
        assert not silent, "\n".join(silent)
        buttons = [one for one in found if isinstance(one, QAbstractButton) and one.isEnabled() and one.toolTip()]
        assert not [one.objectName() for one in buttons if not one.whatsThis()]
        main = assembly.window  # and the table names only what there is
        names = {one.objectName() for one in (main, *main.findChildren(QWidget))}
        made_later = ("manual_*",)  # with a profile that asks for them
        dead = [
            pattern for pattern in TEXTS if pattern not in made_later and not any(fits(pattern, name) for name in names)
        ]
        assert not dead


def test_texts_follow_the_language(qtbot: QtBot, qapp: QApplication, tmp_path: Path) -> None:
    with whole_window(qtbot, qapp, tmp_path) as assembly:
        lock = assembly.window.top_bar.lock
        row = assembly.window.findChild(SettingsPage).rows["attitude_threshold_deg"]  # type: ignore[union-attr]
        english = (lock.whatsThis(), row.whatsThis())
        assembly.language_switch.use(CHINESE)
        qtbot.waitUntil(lambda: lock.whatsThis() == text_for("lock_button"), timeout=WAIT_MS)
        qtbot.waitUntil(lambda: not assembly.help.is_explaining, timeout=WAIT_MS)
        assert lock.whatsThis() == text_for("lock_button") != english[0]
        assert row.whatsThis() != english[1]


def test_texts_from_tooltips_follow_the_language(qtbot: QtBot, qapp: QApplication, tmp_path: Path) -> None:
    button = QPushButton("x")
    button.setToolTip("one")
    explain(button)
    assert button.whatsThis() == "one"
    button.setToolTip("eins")
    explain(button)
    assert button.whatsThis() == "eins"
    button.setWhatsThis("of its own")
    button.setProperty("says_tooltip", False)
    explain(button)
    assert button.whatsThis() == "of its own"


def test_each_turn_explains_only_a_few_widgets(
    qtbot: QtBot, qapp: QApplication, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The window stays quick while a thousand widgets get their texts."""
    root = QWidget()
    qtbot.addWidget(root)
    doomed = QWidget(root)
    for _ in range(30):
        group = QWidget(root)
        for _ in range(20):
            QPushButton(group).setToolTip("told")
    told: list[int] = []
    work = WhatsThis(root)
    turn = work._continue

    def counted() -> None:
        before = len(seen)
        turn()
        told.append(len(seen) - before)

    seen: list[QWidget] = []

    def seen_explain(widget: QWidget) -> None:
        seen.append(widget)
        explain(widget)

    monkeypatch.setattr("ui.help.whats_this.explain", seen_explain)
    work._timer.timeout.disconnect()
    work._timer.timeout.connect(counted)
    work.begin()
    doomed.deleteLater()
    qtbot.waitUntil(lambda: not work.is_under_way, timeout=WAIT_MS)
    assert sum(told) in (1 + 30 * 21, 2 + 30 * 21)
    assert max(told) <= WIDGETS_AT_ONCE
    assert all(one.whatsThis() == "told" for one in root.findChildren(QPushButton))


@OFFSCREEN
def test_a_clicked_control_is_explained_at_once(qtbot: QtBot, qapp: QApplication, tmp_path: Path) -> None:
    with whole_window(qtbot, qapp, tmp_path) as assembly:
        main = assembly.window
        lock = main.top_bar.lock
        qtbot.waitUntil(lambda: not assembly.help.is_explaining, timeout=WAIT_MS)
        lock.setWhatsThis("of another language")
        main.menus["what"].trigger()
        assert QWhatsThis.inWhatsThisMode()
        qtbot.mouseClick(lock, Qt.MouseButton.LeftButton)
        assert lock.whatsThis() == text_for("lock_button")
        QWhatsThis.leaveWhatsThisMode()
        QWhatsThis.hideText()
        lock.setWhatsThis("of another language")
        QApplication.sendEvent(lock, QHelpEvent(QEvent.Type.QueryWhatsThis, QPoint(), QPoint()))
        assert lock.whatsThis() == "of another language"  # nothing is looked at any more


@pytest.mark.parametrize("command", SETTINGS, ids=lambda command: command.name)
def test_a_setting_says_word_code_range_default_and_advice(command: object) -> None:
    one = next(each for each in SETTINGS if each is command)
    told = what_is(one)
    assert one.vendor_term in told
    assert f"{one.code:02X}" in told
    assert one.explanation in told
    if one.advice is not None:
        assert one.advice.text in told
    if one.default is not None:
        assert "Default" in told


def test_range_and_step_are_those_of_the_byte() -> None:
    assert "0.00 s to 2.55 s, in steps of 0.01 s." in what_is(BY_NAME["freefall_time"])
    assert "0° to 255°, in steps of 1°." in what_is(BY_NAME["attitude_threshold"])
    assert "115200" in what_is(BY_NAME["baud_rate"])


def test_advice_is_shown_beside_the_chosen_row(qtbot: QtBot, qapp: QApplication, tmp_path: Path) -> None:
    """In sight at 1024 x 600, not only in a tooltip."""
    with whole_window(qtbot, qapp, tmp_path) as assembly:
        assembly.window.go_to("settings")
        page = find(assembly.window, SettingsPage)
        qtbot.waitUntil(page.isVisible, timeout=WAIT_MS)
        page.refresh()
        for key, row in page.rows.items():
            page.choose(key)
            told, advice = capitalised(advice_text(row.command)), page.pane.advice
            assert advice.text() == told, key
            if told:
                assert advice.isVisible(), key
                assert not advice.visibleRegion().isEmpty(), key
                qtbot.waitUntil(partial(is_whole, advice), timeout=WAIT_MS)
        assert advice_text(BY_NAME["freefall_time"]).endswith("longer: fewer false triggers, more height lost")


@OFFSCREEN
def test_help_windows_are_modeless(qtbot: QtBot, qapp: QApplication, tmp_path: Path) -> None:
    with whole_window(qtbot, qapp, tmp_path) as assembly:
        main = assembly.window
        main.top_bar.port.setFocus()
        qtbot.keyClick(main.top_bar.port, Qt.Key.Key_F1,
                       Qt.KeyboardModifier.ControlModifier | Qt.KeyboardModifier.ShiftModifier)  # fmt: skip
        shown = [one for one in QApplication.topLevelWidgets() if one.inherits("QWhatsThat")]
        assert len(shown) == 1
        QWhatsThis.hideText()
        main.menus["what"].trigger()
        assert QWhatsThis.inWhatsThisMode()
        QWhatsThis.leaveWhatsThisMode()
        # The overview names every key of the window
        listed = keys_of(main)
        assert all(one.does for one in listed)
        named = {key for one in listed for key in one.keys.split(", ")}
        native = [
            (action.objectName(), key.toString(key.SequenceFormat.NativeText))
            for action in main.findChildren(QAction)
            if not isinstance(action.parent(), QMenu)
            for key in action.shortcuts()
        ]
        assert len(native) > 30
        missing = [name for name, key in native if key and key not in named]
        assert not missing
        main.menus["keys"].trigger()
        view = find(main, QWidget, "keys_view")
        assert not view.isModal()  # LOCK stays in reach
        assert "Ctrl+L" in view.findChild(QWidget, "keys_view_text").toPlainText()  # type: ignore[union-attr]
        view.close()
        # About names versions
        main.menus["about"].trigger()
        box = find(assembly.window, QMessageBox, "about_box")
        assert box.windowModality() == Qt.WindowModality.NonModal
        for part in ("MIT", "PySide6", "numpy", "pyserial"):
            assert part in box.informativeText()
        box.close()


def test_the_guide_is_read_in_the_language_in_use(qtbot: QtBot, tmp_path: Path) -> None:
    (tmp_path / "images").mkdir()
    picture = QImage(1600, 400, QImage.Format.Format_RGB32)
    picture.fill(Qt.GlobalColor.red)
    assert picture.save(str(tmp_path / "images" / "live.png"))
    assert guide_page(tmp_path) is None
    page = "# Guide\n\n[go](#what-to-do)\n\n![live](images/live.png)\n\n" + "text\n\n" * 80 + "## What to do!\n\nend\n"
    (tmp_path / "en.md").write_text(page, encoding="utf-8")
    parent = QWidget()
    qtbot.addWidget(parent)
    view = GuideViewer(Texts(), parent, tmp_path)
    view.show()
    assert view.text.toPlainText().startswith("Guide")
    shown = view.text.document().resource(2, QUrl("images/live.png"))
    assert shown.width() / shown.devicePixelRatio() <= 700
    assert view.text.verticalScrollBar().value() == 0
    view.open_link(QUrl("#what-to-do"))
    assert view.text.verticalScrollBar().value() > 0
    (tmp_path / "zh_CN.md").write_text("# 指南\n", encoding="utf-8")
    from app.text import i18n

    i18n.set_language(CHINESE)
    view.refresh()
    assert view.text.toPlainText().startswith("指南")
    view.close()


def test_anchors_are_those_of_github() -> None:
    assert anchor_of("What to do!") == "what-to-do"
    assert anchor_of("GO / NO-GO") == "go--no-go"
    assert anchor_of("飞行前检查") == "飞行前检查"


def test_every_component_is_listed_with_version_and_licence(qtbot: QtBot) -> None:
    window = QWidget()
    qtbot.addWidget(window)
    box = show_about(window)
    lines = box.informativeText().splitlines()
    parts = lines[lines.index(next(one for one in lines if one.startswith("Python"))) :]
    assert {"numpy", "mcap"} <= {one.split()[0] for one in parts}
    for one in parts:
        assert re.fullmatch(r"\S+ [\d.]+\S* \(.+\)", one), one
    assert "mcap" in parts[-1]
    assert parts[-1].endswith("(MIT)")
    box.close()

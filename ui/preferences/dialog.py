"""Preferences: applied at once and saved, in a modeless dialog; English where no font has Chinese characters."""

from collections.abc import Callable
from functools import partial

from PySide6.QtCore import QObject, Signal
from PySide6.QtGui import QAction
from PySide6.QtWidgets import (
    QAbstractButton,
    QCheckBox,
    QComboBox,
    QDialog,
    QDialogButtonBox,
    QFormLayout,
    QLabel,
    QLayout,
    QWidget,
)

from app.text.i18n import CHINESE, ENGLISH, language, tr
from protocol.translatable import marked
from ui.core.preferences import Preferences
from ui.core.texts import LanguageSwitch, Texts, has_font_for
from ui.files.file_dialogs import bring_to_front
from ui.style.appearance import Appearance
from ui.style.theme import Choice, Meaning, Space
from ui.widgets.controls import control, named
from ui.widgets.layouts import in_column
from ui.widgets.notice_bar import Notice
from ui.widgets.sliders import WheelGuard, label_for


class Choices(QObject):
    """Each choice applies at once, and at the next start."""

    changed = Signal()

    def __init__(self, appearance: Appearance, language_switch: LanguageSwitch, preferences: Preferences) -> None:
        super().__init__()
        self._appearance, self._language_switch = appearance, language_switch
        self.remembered = preferences
        self._tell: Callable[[Callable[[], Notice]], None] | None = None

    def need_fonts(self, tell: Callable[[Callable[[], Notice]], None]) -> None:
        """From now on a language whose characters no font has is not used; `tell` shows a notice."""
        self._tell = tell
        if not has_font_for(self._language_switch.language):
            self._language_switch.use(ENGLISH)
            tell(_no_font_notice)

    def use_language(self, name: str) -> None:
        if self._tell is not None and not has_font_for(name):
            self._tell(_no_font_notice)
            return
        self._language_switch.use(name)
        self.remembered.language = name
        self.changed.emit()

    def use_theme(self, key: str) -> None:
        self._appearance.choose(Choice(key))
        self.remembered.theme = key
        self.changed.emit()

    def use_zoom(self, percent: int) -> None:
        self._appearance.zoom(percent)
        self.remembered.zoom_percent = percent
        self.changed.emit()


THEMES = (
    (Choice.AUTO, marked("System")),
    (Choice.LIGHT, marked("Light mode")),
    (Choice.DARK, marked("Dark mode")),
    (Choice.SUNLIGHT, marked("Sunlight")),
)
# Each language in its own words, for those who do not read the other one.
LANGUAGES = ((ENGLISH, "English"), (CHINESE, "简体中文 (Chinese)"))
ZOOMS = (100, 125, 150, 200)


class PreferencesDialog(QDialog):
    """`wide` is the window's action for the sidebar."""

    def __init__(self, texts: Texts, choices: Choices, wide: QAction, parent: QWidget) -> None:
        super().__init__(parent)
        self.setObjectName("preferences_dialog")
        self._remembered = choices.remembered
        texts.bind(self.setWindowTitle, "Preferences")
        texts.bind(self.setAccessibleName, "Preferences")
        self.language, self.theme, self.zoom = (self._box(name) for name in ("language", "theme", "zoom"))
        for name, title in LANGUAGES:
            self.language.addItem(title, name)
        for row, (choice, title) in enumerate(THEMES):
            self.theme.addItem("", choice.value)
            texts.bind(partial(self.theme.setItemText, row), title)
        for percent in ZOOMS:
            self.zoom.addItem(f"{percent} %", percent)
        self.sidebar = control(QCheckBox(), texts, "preferences_sidebar", "Wide sidebar")
        form = QFormLayout()
        form.setHorizontalSpacing(Space.L)
        form.setVerticalSpacing(Space.M)
        # In both languages, for those who read only one.
        both = named(QLabel("Language · 语言"), "preferences_language_label")
        both.setMinimumHeight(self.language.sizeHint().height())
        form.addRow(both, self.language)
        for box, english in ((self.theme, marked("Theme")), (self.zoom, marked("Text size"))):
            texts.bind(box.setAccessibleName, english)
            form.addRow(label_for(texts, box, english), box)
        texts.bind(self.language.setAccessibleName, "Language")
        self.buttons = named(QDialogButtonBox(QDialogButtonBox.StandardButton.Close), "preferences_buttons")
        self.buttons.rejected.connect(self.reject)
        close: QAbstractButton = self.buttons.button(QDialogButtonBox.StandardButton.Close)
        control(close, texts, "preferences_close", "Close", key="Esc")
        in_column(form, self.sidebar, self.buttons, of=self, spacing=Space.L, margins=Space.XL).setSizeConstraint(
            QLayout.SizeConstraint.SetFixedSize
        )
        self.refresh()
        self.language.activated.connect(self._use_language)
        self._choices = choices
        self.theme.activated.connect(lambda row: choices.use_theme(self.theme.itemData(row)))
        self.zoom.activated.connect(lambda row: choices.use_zoom(self.zoom.itemData(row)))
        self.sidebar.toggled.connect(wide.setChecked)
        wide.toggled.connect(self.sidebar.setChecked)
        choices.changed.connect(self.refresh)

    def refresh(self) -> None:
        preferences = self._remembered
        self.language.setCurrentIndex(self.language.findData(language()))
        self.theme.setCurrentIndex(max(0, self.theme.findData(preferences.theme)))
        self.zoom.setCurrentIndex(max(0, self.zoom.findData(preferences.zoom_percent)))
        self.sidebar.setChecked(preferences.is_sidebar_wide)

    def bring_up(self) -> None:
        self.refresh()
        bring_to_front(self)

    def _box(self, name: str) -> QComboBox:
        box = named(QComboBox(), f"preferences_{name}")
        box.setMinimumWidth(180)
        WheelGuard(box)
        return box

    def _use_language(self, row: int) -> None:
        self._choices.use_language(self.language.itemData(row))
        self.refresh()


def _no_font_notice() -> Notice:
    return Notice(Meaning.ATTENTION, tr("Install a Chinese font (fonts-noto-cjk), then restart."))

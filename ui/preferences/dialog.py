"""Modeless dialog of preferences, which apply at once."""

from functools import partial

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

from app.text.i18n import CHINESE, ENGLISH, language
from protocol.translatable import marked
from ui.core.texts import Texts
from ui.preferences.choices import Choices
from ui.style.theme import Choice, Space
from ui.widgets.controls import control
from ui.widgets.document_window import bring_to_front
from ui.widgets.layouts import in_column
from ui.widgets.naming import named
from ui.widgets.sliders import WheelGuard

THEMES = (
    (Choice.AUTO, marked("System")),
    (Choice.LIGHT, marked("Light mode")),
    (Choice.DARK, marked("Dark mode")),
    (Choice.SUNLIGHT, marked("Sunlight")),
)
# Each language in its own words, for those who do not read the other one.
LANGUAGES = ((ENGLISH, "English"), (CHINESE, "简体中文 (Chinese)"))
ZOOMS = (100, 125, 150)


class PreferencesDialog(QDialog):
    """`wide` is the window's action for the sidebar."""

    def __init__(self, texts: Texts, choices: Choices, wide: QAction, parent: QWidget) -> None:
        super().__init__(parent)
        self.setObjectName("preferences_dialog")
        self.setModal(False)
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
        form.addRow(named(QLabel("Language · 语言"), "preferences_language_label"), self.language)
        for name, box, english in (("theme", self.theme, marked("Theme")), ("zoom", self.zoom, marked("Text size"))):
            label = control(QLabel(), texts, f"preferences_{name}_label", english)
            label.setBuddy(box)
            texts.bind(box.setAccessibleName, english)
            form.addRow(label, box)
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
        WheelGuard(self).guard(box)
        return box

    def _use_language(self, row: int) -> None:
        self._choices.use_language(self.language.itemData(row))
        self.refresh()

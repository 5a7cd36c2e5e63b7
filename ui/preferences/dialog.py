"""Preferences: saved at once, in a modeless dialog. The theme applies at once, too; language and text size apply at the
next start."""

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
from ui.files.file_dialogs import show_over_page
from ui.style.appearance import Appearance
from ui.style.theme import Choice, Space
from ui.widgets.controls import control, in_column, named, text_label
from ui.widgets.number_line import WheelGuard, label_for

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
    """See the module's docstring."""

    def __init__(self, preferences: Preferences, appearance: Appearance, parent: QWidget) -> None:
        super().__init__(parent)
        self.setObjectName("preferences_dialog")
        self._preferences, self._appearance = preferences, appearance
        self.setWindowTitle(tr("Preferences"))
        self.setAccessibleName(tr("Preferences"))
        self.language, self.theme, self.zoom = (self._box(name) for name in ("language", "theme", "zoom"))
        for name, title in LANGUAGES:
            self.language.addItem(title, name)
        for choice, title in THEMES:
            self.theme.addItem(tr(title), choice.value)
        for percent in ZOOMS:
            self.zoom.addItem(f"{percent} %", percent)
        form = QFormLayout()
        form.setHorizontalSpacing(Space.L)
        form.setVerticalSpacing(Space.M)
        # In both languages, for those who read only one.
        both = named(QLabel("Language · 语言"), "preferences_language_label")
        both.setMinimumHeight(self.language.sizeHint().height())
        form.addRow(both, self.language)
        for box, title in ((self.zoom, tr("Text size")), (self.theme, tr("Theme"))):
            box.setAccessibleName(title)
            form.addRow(label_for(box, title), box)
        self.language.setAccessibleName(tr("Language"))
        when = text_label("preferences_when", "small")
        when.setText(tr("Language and text size take effect at the next start."))
        self.sounds = named(QCheckBox(tr("Sound: TRIGGERED, ACTIVE, link lost while ACTIVE")), "preferences_sounds")
        self.buttons = named(QDialogButtonBox(QDialogButtonBox.StandardButton.Close), "preferences_buttons")
        self.buttons.rejected.connect(self.reject)
        close: QAbstractButton = self.buttons.button(QDialogButtonBox.StandardButton.Close)
        close.setText(tr("Close"))
        control(close, "preferences_close", key="Esc")
        column = in_column(form, when, self.sounds, self.buttons, of=self, spacing=Space.L, margins=Space.XL)
        column.setSizeConstraint(QLayout.SizeConstraint.SetFixedSize)
        self.refresh()
        self.language.activated.connect(self._keep_language)
        self.theme.activated.connect(self._use_theme)
        self.zoom.activated.connect(self._keep_zoom)
        self.sounds.toggled.connect(self._keep_sounds)

    def refresh(self) -> None:
        preferences = self._preferences
        self.language.setCurrentIndex(max(0, self.language.findData(preferences.language or language())))
        self.theme.setCurrentIndex(max(0, self.theme.findData(preferences.theme)))
        self.zoom.setCurrentIndex(max(0, self.zoom.findData(preferences.zoom_percent)))
        self.sounds.setChecked(preferences.has_sounds)

    def bring_up(self) -> None:
        self.refresh()
        show_over_page(self)

    def _box(self, name: str) -> QComboBox:
        box = named(QComboBox(), f"preferences_{name}")
        WheelGuard(box)
        return box

    def _keep_language(self, row: int) -> None:
        self._preferences.language = self.language.itemData(row)

    def _keep_zoom(self, row: int) -> None:
        self._preferences.zoom_percent = self.zoom.itemData(row)

    def _keep_sounds(self, is_on: bool) -> None:
        self._preferences.has_sounds = is_on

    def _use_theme(self, row: int) -> None:
        self._preferences.theme = self.theme.itemData(row)
        self._appearance.choose(Choice(self._preferences.theme))

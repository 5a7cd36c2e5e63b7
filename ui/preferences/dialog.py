"""Preferences: saved at once, in a modeless dialog. The theme applies at once, too; language and text size apply at the
next start."""

from collections.abc import Iterable
from typing import Final

from PySide6.QtWidgets import (
    QCheckBox,
    QComboBox,
    QDialog,
    QDialogButtonBox,
    QFormLayout,
    QLayout,
    QVBoxLayout,
    QWidget,
)

from app.text.i18n import CHINESE, ENGLISH, language, tr
from protocol.translatable import marked
from ui.core.preferences import Preferences
from ui.style.appearance import Appearance
from ui.style.theme import Choice, Space
from ui.widgets.controls import named, text_label
from ui.widgets.number_line import WheelGuard, label_for

# Each language in its own words, for those who do not read the other one.
LANGUAGES: Final = ((ENGLISH, "English"), (CHINESE, "简体中文 (Chinese)"))
THEMES: Final = (
    (Choice.AUTO.value, marked("System")),
    (Choice.LIGHT.value, marked("Light mode")),
    (Choice.DARK.value, marked("Dark mode")),
    (Choice.SUNLIGHT.value, marked("Sunlight")),
)
ZOOMS: Final = (100, 125, 150, 200)


class PreferencesDialog(QDialog):
    """See the module's docstring."""

    def __init__(self, preferences: Preferences, appearance: Appearance, parent: QWidget) -> None:
        super().__init__(parent)
        self.setObjectName("preferences_dialog")
        self._preferences = preferences
        self.setWindowTitle(tr("Preferences"))
        self.setAccessibleName(tr("Preferences"))
        self._form = form = QFormLayout()
        form.setHorizontalSpacing(Space.L)
        form.setVerticalSpacing(Space.M)
        # In both languages, for those who read only one.
        self.language = self._box("language", "Language · 语言", LANGUAGES, language())
        self.language.setAccessibleName(tr("Language"))
        sizes = [(percent, f"{percent} %") for percent in ZOOMS]
        self.zoom = self._box("zoom_percent", tr("Text size"), sizes)
        self.theme = self._box("theme", tr("Theme"), [(choice, tr(title)) for choice, title in THEMES])
        self.theme.activated.connect(lambda: appearance.choose(Choice(self.theme.currentData())))
        when = text_label("preferences_when", "small")
        when.setText(tr("Language and text size take effect at the next start."))
        self.sounds = named(QCheckBox(tr("Sound: TRIGGERED, ACTIVE, link lost while ACTIVE")), "preferences_sounds")
        self.sounds.setChecked(preferences.has_sounds)
        self.sounds.clicked.connect(lambda is_on: setattr(preferences, "has_sounds", is_on))
        buttons = named(QDialogButtonBox(QDialogButtonBox.StandardButton.Close), "preferences_buttons")
        buttons.rejected.connect(self.reject)
        column = QVBoxLayout(self)
        column.setSpacing(Space.L)
        column.setContentsMargins(Space.XL, Space.XL, Space.XL, Space.XL)
        column.addLayout(form)
        for part in (when, self.sounds, buttons):
            column.addWidget(part)
        column.setSizeConstraint(QLayout.SizeConstraint.SetFixedSize)

    def _box(self, name: str, title: str, entries: Iterable[tuple[object, str]], usual: object = None) -> QComboBox:
        """Make the box of this preference. `usual`: what is in use where none was chosen, else the first entry."""
        box = named(QComboBox(), f"preferences_{name}", says=title)
        for data, text in entries:
            box.addItem(text, data)
        box.setCurrentIndex(max(0, box.findData(getattr(self._preferences, name) or usual)))
        box.activated.connect(lambda: setattr(self._preferences, name, box.currentData()))
        WheelGuard(box)
        self._form.addRow(label_for(box, title), box)
        return box

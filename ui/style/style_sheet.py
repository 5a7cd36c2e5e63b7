"""The application's style sheet, generated from a theme.

What a widget is for is its dynamic property ``role``:

- QPushButton: ``primary`` (one on a page), ``danger``, ``quiet`` (no frame); none is an everyday button
- QFrame: ``card``, ``bar``, ``danger-corner``, ``rehearsal``, ``row``, ``marked-row``,
  ``marked-row-chosen``, ``marked-row-failed``
- QLabel: ``muted``, ``small``, ``title``, ``heading`` (28 px), ``caption``, ``strong``, ``danger``,
  ``attention``
- QToolButton: ``quiet``, ``segment``, ``choice`` (one of two, side by side)

Buttons and fields are of one height: Qt makes a tool button 3 px higher than its sheet says, so its sheet says less.
Bold is 700: a Chinese font without a bold cut of its own is made bolder by Qt from there on, and not below.
"""

import re
from functools import partial
from pathlib import Path
from string import Template
from typing import Final

from ui.style.theme import Theme, scale_in_use

# A style sheet takes pictures from files only, so the arrows and check marks of each theme are files.
_ARROWS: Final = Path(__file__).parent / "arrows"
_SCALED: Final = re.compile(r"\b(?:font-size|padding|min-height|min-width|width|height|spacing): [^;]+;")
_PX: Final = re.compile(r"(\d+)px")
_SHEET: Final = Template("""
* { outline: none; }
QToolTip { background: $text; color: $window; border: none; padding: 4px 8px; font-size: 12px; }
QToolBar#foot { border: none; padding: 0; margin: 0; spacing: 0; background: $sunken; }
QFrame[role="card"] { background: $surface; border: ${edge}px solid $divider; border-radius: 8px; }
QFrame[role="card"] QFrame[role="card"], QFrame[role="card"] QAbstractItemView { border-color: transparent; }
QFrame[role="card"] QAbstractItemView:focus { border-color: $focus; }
QToolButton#menu_button { padding: 4px; }
QPushButton#light_threshold_measure { padding: 4px 2px; min-width: 0; }
QToolButton#connect_options { padding-left: 0; }
QFrame[role="bar"] { background: $sunken; border: none; }
QFrame#top_bar { border-bottom: ${edge}px solid $divider; }
QToolBar#foot QFrame[role="bar"] { border-top: ${edge}px solid $divider; }
QFrame[role="danger-corner"] { background: $surface; border: ${edge}px solid $danger_ink; border-radius: 8px; }
QFrame[role="rehearsal"] { background: $rehearsal; border: 2px dashed $focus; border-radius: 8px; }
QFrame[role="row"] { background: transparent; border: none; border-bottom: ${edge}px solid $divider; }
QFrame[role="marked-row"] {
    background: transparent; border: none; border-left: 3px solid transparent; border-bottom: ${edge}px solid $divider;
}
QFrame[role="marked-row-chosen"] {
    background: $selection; border: none; border-left: 3px solid $focus; border-bottom: ${edge}px solid $divider;
}
QFrame[role="marked-row-failed"] {
    background: $danger_wash; border: none; border-left: 3px solid $danger_ink; border-bottom: ${edge}px solid $divider;
}
QLabel[role="strong"] { font-weight: 700; }
QLabel[role="danger"] { color: $danger_ink; font-size: 12px; font-weight: 700; }
QLabel[role="attention"] { color: $attention_ink; font-size: 12px; }
QLabel[role="muted"] { color: $muted; }
QLabel[role="small"] { color: $muted; font-size: 12px; }
QLabel[role="caption"] { color: $muted; font-size: 12px; font-weight: 700; }
QLabel[role="title"] { font-size: 18px; font-weight: 700; }
QLabel[role="heading"] { font-size: 28px; font-weight: 700; }

QPushButton, QToolButton {
    background: $surface; color: $text; border: ${edge}px solid $border; border-radius: 6px;
    padding: 4px 12px; min-height: 22px;
}
QToolButton { min-height: @tool; }
QPushButton:hover, QToolButton:hover { background: $raised; }
QPushButton:pressed, QToolButton:pressed, QToolButton:checked { background: $sunken; }
QPushButton:focus, QToolButton:focus { border: 2px solid $focus; padding: ${focus_v}px ${focus_h}px; }
QPushButton:disabled, QToolButton:disabled {
    color: $disabled; border: ${edge}px solid $disabled_edge; background: $window;
}
QPushButton[role="primary"] { background: $primary; color: $on_primary; border-color: $primary; font-weight: 700; }
QPushButton[role="primary"]:hover { background: $primary_hover; }
QPushButton[role="primary"]:focus { border-color: $focus; }
QPushButton[role="primary"]:disabled { background: $window; color: $disabled; border-color: $disabled_edge; }
QPushButton[role="danger"] { color: $danger_ink; border-color: $danger_ink; }
QPushButton[role="danger"]:hover { background: $danger_wash; }
QPushButton[role="danger"]:pressed { background: $danger_fill; color: $on_danger; }
QPushButton[role="danger"]:disabled { color: $disabled; border-color: $disabled_edge; background: $window; }
QPushButton[role="quiet"], QToolButton[role="quiet"] { background: transparent; border-color: transparent; }
QPushButton[role="quiet"]:hover, QToolButton[role="quiet"]:hover { background: $raised; }
QPushButton[role="quiet"]:disabled, QToolButton[role="quiet"]:disabled { border-color: transparent; }
QPushButton[role="quiet"]:focus, QToolButton[role="quiet"]:focus { border-color: $focus; }
QToolButton[role="segment"] { border-color: transparent; background: transparent; color: $muted; padding: 4px; }
QToolButton[role="segment"]:checked { background: $sunken; color: $text; border-color: $border; }
QToolButton[role="segment"]:focus { border-color: $focus; padding: ${focus_v}px ${focus_s}px; }
QToolButton[role="choice"] { padding: 4px; }
QToolButton[role="choice"]:focus { padding: ${focus_s}px; }
QToolButton::menu-indicator { image: none; }

QTabBar::tab {
    background: transparent; color: $muted; border: none; border-bottom: 3px solid transparent; padding: 6px 14px;
}
QTabBar::tab:selected { color: $text; border-bottom-color: $text; }
QTabBar::tab:hover { color: $text; }
QTabBar::tab:selected:focus { border-bottom-color: $focus; }

QLineEdit, QSpinBox, QDoubleSpinBox, QComboBox, QTextEdit {
    background: $surface; color: $text; border: ${edge}px solid $border; border-radius: 6px; padding: 3px 8px;
    selection-background-color: $selection; selection-color: $text; min-height: 24px;
    placeholder-text-color: $muted;
}
QLineEdit:focus, QSpinBox:focus, QDoubleSpinBox:focus, QComboBox:focus, QTextEdit:focus {
    border: 2px solid $focus; padding: ${field_v}px ${field_h}px;
}
QLineEdit:disabled, QSpinBox:disabled, QDoubleSpinBox:disabled, QComboBox:disabled {
    color: $disabled; background: $window; border: ${edge}px solid $disabled_edge;
}
QTextEdit[readOnly="true"]:focus { border: ${edge}px solid $border; padding: 3px 8px; }
QComboBox QAbstractItemView { border: ${edge}px solid $border; selection-background-color: $selection; }
QSpinBox, QDoubleSpinBox { padding-right: 26px; min-height: 22px; }
QSpinBox:focus, QDoubleSpinBox:focus { padding-right: 26px; }
QSpinBox::up-button, QDoubleSpinBox::up-button, QSpinBox::down-button, QDoubleSpinBox::down-button {
    subcontrol-origin: border; width: 24px; border: none; background: transparent;
}
QSpinBox::up-button, QDoubleSpinBox::up-button { subcontrol-position: top right; }
QSpinBox::down-button, QDoubleSpinBox::down-button { subcontrol-position: bottom right; }
QSpinBox::up-button:hover, QDoubleSpinBox::up-button:hover,
QSpinBox::down-button:hover, QDoubleSpinBox::down-button:hover { background: $sunken; border-radius: 4px; }
QSpinBox::up-arrow, QDoubleSpinBox::up-arrow { image: url("$arrow_up"); width: 14px; height: 13px; }
QSpinBox::down-arrow, QDoubleSpinBox::down-arrow, QComboBox::down-arrow {
    image: url("$arrow_down"); width: 14px; height: 13px;
}
QComboBox { padding-right: 26px; }
QLineEdit > QToolButton, QLineEdit > QToolButton:hover, QLineEdit > QToolButton:pressed {
    border: none; background: transparent; padding: 0; margin: 0; min-height: 0;
}
QComboBox QLineEdit, QComboBox QLineEdit:focus { border: none; background: transparent; padding: 0; min-height: 0; }
QComboBox:focus { padding-right: 26px; }
QComboBox::drop-down { subcontrol-origin: border; subcontrol-position: center right; width: 26px; border: none; }
QAbstractSpinBox QLineEdit { border: none; background: transparent; padding: 0 0 0 6px; min-height: 0; }
QAbstractSpinBox QLineEdit:focus { border: none; padding: 0 0 0 6px; }
QCheckBox { spacing: 8px; }
QCheckBox::indicator {
    width: 14px; height: 14px; border: ${edge}px solid $border; border-radius: 4px; background: $surface;
}
QCheckBox::indicator:checked { background: $primary; border-color: $primary; image: url("$check"); }
QCheckBox::indicator:disabled { border: ${edge}px solid $disabled; }
QCheckBox:focus { color: $focus; }
QCheckBox::indicator:focus { border-color: $focus; }

QListView, QTreeView, QTableView {
    background: $surface; border: ${edge}px solid $divider; border-radius: 8px; alternate-background-color: $window;
    gridline-color: $divider; selection-background-color: $selection; selection-color: $text;
}
QListView:focus, QTreeView:focus, QTableView:focus { border: 2px solid $focus; }
QTableView::item { padding: 0 5px; border: none; }
QHeaderView::section {
    background: $sunken; color: $muted; border: none; border-bottom: ${edge}px solid $divider; padding: 4px 8px;
    font-size: 12px; font-weight: 700;
}
QListView[role="navigation"], QListView[role="navigation"]:focus {
    background: $window; border: none; border-radius: 0; padding: 4px 0;
}

QProgressBar {
    background: $sunken; border: ${edge}px solid $border; border-radius: 4px; min-height: 8px; text-align: center;
}
QProgressBar::chunk { background: $selection; border-right: 3px solid $focus; }
QScrollArea { border: none; background: transparent; }
QScrollBar:vertical { background: transparent; width: 12px; margin: 0; }
QScrollBar:horizontal { background: transparent; height: 12px; margin: 0; }
QScrollBar::handle { background: $border; border-radius: 3px; margin: 3px; }
QScrollBar::handle:vertical { min-height: 32px; }
QScrollBar::handle:horizontal { min-width: 32px; }
QScrollBar::handle:hover { background: $muted; }
QScrollBar::add-line, QScrollBar::sub-line { width: 0; height: 0; }
QScrollBar::add-page, QScrollBar::sub-page { background: transparent; }
QMenu { background: $surface; border: ${edge}px solid $border; padding: 4px; }
QMenu::item { padding: 6px 24px 6px 12px; border-radius: 4px; }
QMenu::item:selected { background: $selection; color: $text; }
QMenu::item:disabled { color: $disabled; }
QMenu::separator { height: 1px; background: $divider; margin: 4px 8px; }
QSplitter::handle { background: $divider; }
""")


def style_sheet(theme: Theme) -> str:
    """The style sheet of a theme.  A frame that grows with the focus takes its width from the padding, so that
    nothing moves."""
    grown_px = 2 - theme.border_px
    sheet = _SHEET.substitute(
        window=theme.window,
        surface=theme.surface,
        sunken=theme.sunken,
        raised=theme.raised,
        text=theme.text,
        muted=theme.muted,
        disabled=theme.disabled,
        disabled_edge=theme.divider if theme.border_px == 1 else theme.disabled,
        border=theme.border,
        divider=theme.divider,
        selection=theme.selection,
        primary=theme.primary,
        on_primary=theme.on_primary,
        primary_hover=theme.muted if not theme.is_dark else theme.text,
        focus=theme.information.ink,
        danger_ink=theme.danger.ink,
        danger_fill=theme.danger.fill,
        on_danger=theme.danger.on_fill,
        danger_wash=theme.danger.wash,
        rehearsal=theme.information.wash,
        attention_ink=theme.attention.ink,
        edge=theme.border_px,
        check=(_ARROWS / f"{theme.name}-check.svg").as_posix(),
        arrow_up=(_ARROWS / f"{theme.name}-up.svg").as_posix(),
        arrow_down=(_ARROWS / f"{theme.name}-down.svg").as_posix(),
        focus_v=4 - grown_px,
        focus_h=12 - grown_px,
        focus_s=4 - grown_px,
        field_v=3 - grown_px,
        field_h=8 - grown_px,
    )
    scale = max(scale_in_use(), theme.scale)
    if scale != 1:
        sheet = _SCALED.sub(partial(_times, scale), sheet)
    return sheet.replace("@tool", f"{round(22 * scale) - 3}px")


def _times(scale: float, found: re.Match[str]) -> str:
    return _PX.sub(lambda px: f"{round(int(px[1]) * scale)}px", found[0])

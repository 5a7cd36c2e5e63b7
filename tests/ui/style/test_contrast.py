"""The contrast of colours; that of the texts in the window is looked at on the walk (tests/ui/shell)."""

import re
from collections.abc import Mapping

import numpy as np
import pytest
from PySide6.QtCore import QRect

from tests.support.window.contrast import DISABLED, contrast, surfaces_of, wanted
from tests.support.window.painted_text import colours_in
from ui.style.appearance import style_sheet
from ui.style.theme import THEMES, Theme


def test_pictures_are_measured_as_colours_are() -> None:
    place = QRect(0, 0, 4, 1)
    row = np.array([[0xFFFFFFFF] * 6 + [0xFF767676] * 2], np.uint32).repeat(2, axis=0)
    colours = colours_in(row, place)
    assert colours.ground == "#ffffff"
    colour, ratio = colours.strongest_ink()
    assert (colour, ratio) == ("#767676", pytest.approx(contrast("#767676", "#ffffff")))


# The states that no walk sees: under the pointer, pressed, chosen, switched off.

_PARTS = ("background", "background-color", "color", "selection-background-color", "selection-color")


def rules_of(theme: Theme) -> dict[str, dict[str, str]]:
    """What the style sheet says of each selector: colours only."""
    rules: dict[str, dict[str, str]] = {}
    for selectors, body in re.findall(r"([^{}]+)\{([^{}]*)\}", style_sheet(theme)):
        colours = {
            name.strip(): value.strip()
            for name, _, value in (line.partition(":") for line in body.split(";"))
            if name.strip() in _PARTS and re.fullmatch(r"#[0-9A-Fa-f]{6}", value.strip())
        }
        for selector in selectors.split(","):
            rules.setdefault(selector.strip(), {}).update(colours)
    return rules


def cascaded(rules: Mapping[str, dict[str, str]], selector: str, theme: Theme) -> dict[str, str]:
    """With what the selector takes over from the control without state, and without role."""
    whole = {"color": theme.text, "background": theme.surface}
    control = re.split(r"[\[:]", selector, maxsplit=1)[0]
    role = re.match(r"[^:]*\[[^]]*\]", selector)
    for one in (control, "" if role is None else role[0], selector):
        whole |= rules.get(one, {})
    return whole


@pytest.mark.parametrize("theme", THEMES, ids=lambda theme: theme.name)
def test_every_state_in_the_style_sheet_is_readable(theme: Theme) -> None:
    rules = rules_of(theme)
    assert 'QPushButton[role="danger"]:pressed' in rules
    weak = []
    for selector in rules:
        whole = cascaded(rules, selector, theme)
        least = DISABLED if ":disabled" in selector else wanted(theme)
        pairs = [(whole["color"], whole["background"])]
        if "selection-background-color" in whole:
            pairs.append((whole.get("selection-color", whole["color"]), whole["selection-background-color"]))
        if not any(part in selector for part in ("::indicator", "::chunk", "::handle", "::separator", "QProgressBar")):
            weak += [f"{selector}: {one} on {other}" for one, other in pairs if contrast(one, other) < least]
    assert not weak, "\n".join(weak)


@pytest.mark.parametrize("theme", THEMES, ids=lambda theme: theme.name)
def test_what_has_the_focus_or_is_ticked_stands_out(theme: Theme) -> None:
    """Graphics that say something: 3:1 against what is beside them (WCAG 1.4.11)."""
    for ground in surfaces_of(theme):
        for graphic in (theme.information.ink, theme.border, theme.primary):
            assert contrast(graphic, ground) >= 3, (graphic, ground)
    assert contrast(theme.on_primary, theme.primary) >= 3  # the tick in its box
    assert contrast(theme.information.ink, theme.selection) >= 3  # the end of a progress bar

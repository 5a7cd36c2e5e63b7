"""Falls back to English, and says why, where no installed font has Chinese characters."""

from collections.abc import Callable

from app.text.i18n import ENGLISH, tr
from ui.core.language_switch import LanguageSwitch, has_font_for
from ui.preferences.choices import Choices
from ui.style.theme import Meaning
from ui.widgets.notice_bar import Notice


def need_fonts(
    language_switch: LanguageSwitch,
    choices: Choices,
    *,
    tell: Callable[[Callable[[], Notice]], None],
    dismiss: Callable[[], None],
) -> None:
    """Checks the language in use, and each one chosen later; `tell` shows a notice, `dismiss` removes it."""

    def notice() -> Notice:
        text = tr("No Chinese font is installed. Install one (fonts-noto-cjk), then restart.")
        return Notice(Meaning.ATTENTION, text, dismiss=dismiss)

    choices.has_font_for = has_font_for
    choices.report_no_font = lambda: tell(notice)
    if not has_font_for(language_switch.language):
        language_switch.use(ENGLISH)
        tell(notice)

"""Binds texts of widgets so that they follow a change of language, and switches it."""

import logging
import weakref
from collections.abc import Callable, Hashable
from functools import partial
from typing import Any, NamedTuple

import shiboken6
from PySide6.QtCore import QEvent, QLibraryInfo, QLocale, QTranslator
from PySide6.QtGui import QFontDatabase
from PySide6.QtWidgets import QApplication

from app.text.i18n import CHINESE, language, set_language, tr


class _Binding(NamedTuple):
    """One text of one widget: how to reach the setter, the English text and its values."""

    find_setter: Callable[[], Callable[[str], object] | None]
    english: str
    values: dict[str, object]


class Texts:
    """Binds setters such as ``label.setText`` to English texts and applies them again at a change of language.

    Keeps no widget alive, and drops what Qt has deleted.  A plain function is held as it is, and with it what
    it closes over; bind a method, or a ``functools.partial`` of one, wherever that does.  Belongs to the
    window's thread.
    """

    def __init__(self) -> None:
        self._bindings: dict[Hashable, _Binding] = {}
        self._sweep_at = 64

    def bind(self, setter: Callable[[str], object], english: str, /, **values: object) -> None:
        """Set the text now and at each change of language; binding the same setter again replaces its text.

        A setter that wants more than the text is bound as a partial: ``partial(tabs.setTabText, 0)``.
        """
        self._bindings[_identity(setter)] = _Binding(_finder(setter), english, values)
        setter(tr(english, **values))
        if len(self._bindings) > self._sweep_at:
            self._remove_deleted()

    def retranslate(self) -> None:
        """Apply every text in the language in use, and forget the widgets that are gone."""
        for key, binding in list(self._bindings.items()):
            setter = binding.find_setter()
            if setter is None:
                self._bindings.pop(key, None)
            else:
                setter(tr(binding.english, **binding.values))

    def _remove_deleted(self) -> None:
        """Forget what is gone, seldom enough that binding stays cheap."""
        self._bindings = {key: binding for key, binding in self._bindings.items() if binding.find_setter() is not None}
        self._sweep_at = max(64, 2 * len(self._bindings))


def _identity(setter: Callable[..., object]) -> Hashable:
    """The same for two looks at one method, which Python hands out as a new object each time."""
    if isinstance(setter, partial):
        return (_identity(setter.func), setter.args, tuple(sorted(setter.keywords.items())))
    owner = getattr(setter, "__self__", None)
    return id(setter) if owner is None else (id(owner), setter.__name__)


def _finder(setter: Callable[..., object]) -> Callable[[], Callable[[str], object] | None]:
    """A function that gives the setter as long as its widget exists, without keeping the widget."""
    if isinstance(setter, partial):
        find_inner, args, keywords = _finder(setter.func), setter.args, setter.keywords

        def find_partial() -> Callable[[str], object] | None:
            inner = find_inner()
            return None if inner is None else partial(inner, *args, **keywords)

        return find_partial
    owner: Any = getattr(setter, "__self__", None)
    if owner is None or type(owner).__weakrefoffset__ == 0:  # a plain function, or the method of a list
        return lambda: setter
    name = setter.__name__
    # A wrapper that Python made lives as long as its widget.  The wrapper of what Qt made (a button of a
    # dialog's box) would die at once, and holding it keeps no widget alive: Qt deletes that with its parent.
    is_made_by_qt = isinstance(owner, shiboken6.Object) and not shiboken6.createdByPython(owner)
    find_owner = (lambda: owner) if is_made_by_qt else weakref.ref(owner)

    def find_method() -> Callable[[str], object] | None:
        alive = find_owner()
        if alive is None or not shiboken6.isValid(alive):
            return None
        method: Callable[[str], object] = getattr(alive, name)
        return method

    if not is_made_by_qt:
        del owner  # else the closure below would hold it after all
    return find_method


_log = logging.getLogger(__name__)


def has_font_for(name: str) -> bool:
    return name != CHINESE or bool(QFontDatabase.families(QFontDatabase.WritingSystem.SimplifiedChinese))


class LanguageSwitch:
    """Bound texts are applied again; what a widget words itself, it words again at `QEvent.LanguageChange`."""

    def __init__(self, app: QApplication, texts: Texts) -> None:
        self._app = app
        self._texts = texts
        self._qt_texts = QTranslator()

    @property
    def language(self) -> str:
        return language()

    def use(self, name: str) -> None:
        """Speak this language from now on; see `app.text.i18n.set_language` for the names."""
        set_language(name)
        self._app.removeTranslator(self._qt_texts)
        if name == CHINESE and self._has_qt_texts(name):
            self._app.installTranslator(self._qt_texts)
        QLocale.setDefault(QLocale(name if name == CHINESE else "en"))
        self._app.setApplicationDisplayName(tr("DPS-S Configurator"))  # some systems add it to each window's title
        self._texts.retranslate()
        for window in self._app.topLevelWidgets():
            self._app.sendEvent(window, QEvent(QEvent.Type.LanguageChange))

    def _has_qt_texts(self, name: str) -> bool:
        """Qt's own texts (OK, Cancel, the menus of text fields), loaded once; they come with its wheel."""
        folder = QLibraryInfo.path(QLibraryInfo.LibraryPath.TranslationsPath)
        if self._qt_texts.isEmpty() and not self._qt_texts.load(f"qtbase_{name}", folder):
            _log.warning("Qt's own texts for %s are not in %s", name, folder)
            return False
        return True

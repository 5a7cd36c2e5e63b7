"""The window. Widgets only: no bytes, no files, no rules of the device."""

from contextlib import suppress

with suppress(ImportError):
    from PySide6.support import feature  # type: ignore[attr-defined]

    # PySide would read the source text of every module that is imported, and the standard library keep it (20 MB), to
    # see which may ask for Qt's names in snake case: none does.
    feature._mod_uses_pyside = lambda _module: False

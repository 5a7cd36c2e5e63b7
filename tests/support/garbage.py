"""Finds widgets that Python's garbage collector would free although Qt still shows them."""

import gc

import shiboken6
from PySide6.QtCore import QObject


def living_garbage(root: QObject) -> list[str]:
    """Return the descendants of `root` (according to Qt) that are garbage according to Python.

    Freeing them removes them from the window. This happens when PySide has recorded a wrong parent for an object, as
    some calls (`nextInFocusChain`) make it do.
    """
    debug = gc.get_debug()
    gc.set_debug(gc.DEBUG_SAVEALL)
    try:
        gc.collect()
        found = [one for one in gc.garbage if isinstance(one, QObject) and shiboken6.isValid(one)]
        return sorted(f"{type(one).__name__} {one.objectName()}" for one in found if _is_in(one, root))
    finally:
        gc.set_debug(debug)
        gc.garbage.clear()


def _is_in(one: QObject, root: QObject) -> bool:
    around: QObject | None = one
    while around is not None and around is not root:
        around = around.parent()
    return around is root

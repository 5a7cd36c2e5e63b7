"""What Python's collector would free although Qt still shows it."""

import gc

import shiboken6
from PySide6.QtCore import QObject


def living_garbage(root: QObject) -> list[str]:
    """The objects around which `root` still is, as far as Qt knows, and which nothing in Python holds any more.

    Freeing them takes them out of the window. A wrong idea of who is whose parent does that: PySide notes one parent
    for each object, and some calls (`nextInFocusChain`) put a wrong one there.
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

"""Long work of the window's thread in steps, a few in each turn of the event loop."""

import sys
import time
from collections.abc import Callable, Iterable, Iterator
from functools import partial
from importlib import import_module
from types import CodeType
from typing import Final

from PySide6.QtCore import QObject, QTimer

# With 0 Qt would process no other events between two turns.
_BETWEEN_TURNS_MS: Final = 1
# After so long no further step is begun in this turn.
_TURN_S: Final = 0.005


class Turns(QTimer):
    """Takes steps one by one, so that keys, clicks and batches come between them and the window never stands still for
    all of the work. A step that raises is reported like any error of the window, and the next one is taken."""

    def __init__(self, parent: QObject) -> None:
        super().__init__(parent, interval=_BETWEEN_TURNS_MS)
        self._steps: Iterator[Callable[[], object]] = iter(())
        self.timeout.connect(self._take_steps)

    def take(self, steps: Iterable[Callable[[], object]]) -> None:
        """Take these, in place of what is left of the former ones."""
        self._steps = iter(steps)
        self.start()

    def _take_steps(self) -> None:
        ends_at = time.monotonic() + _TURN_S
        while time.monotonic() < ends_at:
            step = next(self._steps, None)
            if step is None:
                self.stop()
                return
            step()


def importing(package: str) -> Iterator[Callable[[], object]]:
    """Steps that import a package, each of them one statement of its `__init__`: for one that imports a hundred modules
    and knows Qt, so that no other thread may import it. Where one fails nothing is kept, as with any import."""
    import ast  # the first paint does not wait for these
    from importlib.abc import InspectLoader
    from importlib.util import find_spec, module_from_spec

    spec = None if package in sys.modules else find_spec(package)
    source = spec.loader.get_source(package) if spec is not None and isinstance(spec.loader, InspectLoader) else None
    if spec is None or source is None:
        yield partial(import_module, package)
        return
    module = sys.modules[package] = module_from_spec(spec)

    def run(code: CodeType) -> None:
        if sys.modules.get(package) is not module:
            return  # a statement before this one failed
        try:
            exec(code, module.__dict__)  # noqa: S102  what Python's own import does
        except BaseException:
            del sys.modules[package]
            raise

    for statement in ast.parse(source).body:
        yield partial(run, compile(ast.Module([statement], []), spec.origin or package, "exec"))

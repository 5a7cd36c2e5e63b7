"""From the choice of another theme or language until the window is painted, on the Live and the Settings page, with all
pages made and a streaming simulated module. CPU time of the window's thread is independent of other load.

    python -m tests.benchmarks.window.switching PAGE…

measures on these pages in its own process and prints JSON.
"""

import json
import statistics
import sys
import time
from collections.abc import Callable
from typing import Final

from PySide6.QtWidgets import QApplication

from app.text.i18n import CHINESE, ENGLISH
from tests.benchmarks.figures import Figure
from tests.benchmarks.runs import measured
from tests.benchmarks.window.window import LIMIT_S, turn_for, turn_until, window_with_pages
from ui.main import Assembly, WindowOptions
from ui.style.theme import Choice

AIMS_S: Final = {"theme": 0.150, "language": 0.250}
ROUNDS: Final = 6
_PAGES: Final = ("live", "settings")
_SETTLE_S: Final = 0.4


def figures() -> list[Figure]:
    """One row per kind of switch and page."""
    took = measured("tests.benchmarks.window.switching", *_PAGES)
    found = []
    for kind, aim_s in AIMS_S.items():
        for page in _PAGES:
            wall_s, cpu_s = (statistics.median(one[n] for one in took[f"{kind} {page}"]) for n in (0, 1))
            found.append(
                Figure(
                    f"another {kind}, on the page {page}",
                    f"{cpu_s * 1000:.0f} ms of CPU, {wall_s * 1000:.0f} ms until painted",
                    f"<= {aim_s * 1000:.0f} ms of CPU",
                    cpu_s <= aim_s,
                )
            )
    return found


def _took_s(app: QApplication, act: Callable[[], None]) -> tuple[float, float]:
    """Real time and CPU time until it is painted."""
    began, cpu = time.perf_counter(), time.thread_time()
    act()
    app.processEvents()  # what was posted
    app.processEvents()  # what that asked for: layouts, paints
    return time.perf_counter() - began, time.thread_time() - cpu


def measure(app: QApplication, assembly: Assembly, pages: list[str]) -> dict[str, list[tuple[float, float]]]:
    """Every switch on every page, in turn."""
    found: dict[str, list[tuple[float, float]]] = {}
    for page in pages:
        assembly.window.go_to(page)
        turn_for(_SETTLE_S)
        for number in range(ROUNDS):
            theme = (Choice.DARK, Choice.SUNLIGHT, Choice.LIGHT)[number % 3]
            language = (CHINESE, ENGLISH)[number % 2]

            def change_theme(theme: Choice = theme) -> None:
                assembly.appearance.choose(theme)

            def change_language(language: str = language) -> None:
                assembly.language_switch.use(language)

            for kind, act in (("theme", change_theme), ("language", change_language)):
                found.setdefault(f"{kind} {page}", []).append(_took_s(app, act))
                turn_for(_SETTLE_S)
    return found


def main(pages: list[str]) -> int:
    """Entry point."""
    with window_with_pages(WindowOptions(demo=True, language="en", offscreen_seconds=1)) as (app, assembly):
        if not turn_until(lambda: assembly.connector.device.is_streaming, LIMIT_S):
            raise RuntimeError("the module did not stream")
        turn_for(_SETTLE_S)
        print(json.dumps(measure(app, assembly, pages)))
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))

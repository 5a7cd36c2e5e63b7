"""Prints the program's window as seen on the desktop's accessibility bus, as by Orca.

    /usr/bin/python3 -m tests.system.screen_reader [SECONDS]

prints every role and name in sight of a window that is open, then for SECONDS what is announced and which names change.
It needs a running session with at-spi2-core, the system's Python with python3-gi and gir1.2-atspi-2.0, and the program
started with QT_LINUX_ACCESSIBILITY_ALWAYS_ON=1. Exit code 1 if the program is not on the bus, or has a button without a
name.
"""

import sys
from collections.abc import Iterator
from importlib import import_module
from typing import Any

NAME = "dps-s-configurator"
EVENTS = ("object:announcement", "object:property-change:accessible-name", "object:state-changed:focused")
MOST_CHILDREN = 300


def below(one: Any, depth: int = 0) -> Iterator[tuple[Any, int]]:
    """From the outermost to the innermost."""
    yield one, depth
    for index in range(min(one.get_child_count(), MOST_CHILDREN)):
        child = one.get_child_at_index(index)
        if child is not None:
            yield from below(child, depth + 1)


def main(words: list[str]) -> int:
    gi: Any = import_module("gi")
    gi.require_version("Atspi", "2.0")
    atspi: Any = import_module("gi.repository.Atspi")
    shown = [
        (one, depth)
        for app, _ in below(atspi.get_desktop(0))
        if app.get_name() == NAME and app.get_role_name() == "application"
        for one, depth in below(app)
        if depth < 2 or one.get_state_set().contains(atspi.StateType.SHOWING)
    ]
    for one, depth in shown:
        print(f"{'  ' * depth}{one.get_role_name()} {one.get_name()!r}")
    nameless = [one for one, _ in shown if one.get_role_name() == "push button" and not one.get_name()]
    print(f"{len(shown)} in sight, {len(nameless)} buttons without a name")
    if words:
        listener = atspi.EventListener.new(lambda event: print(event.type, event.source.get_name(), event.any_data))
        for kind in EVENTS:
            listener.register(kind)
        import_module("gi.repository.GLib").timeout_add_seconds(int(words[0]), atspi.event_quit)
        atspi.event_main()
    return 0 if shown and not nameless else 1


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))

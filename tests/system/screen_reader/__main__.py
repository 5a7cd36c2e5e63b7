"""Prints the program's window as seen on the desktop's accessibility bus, as by Orca.

    /usr/bin/python3 -m tests.system.screen_reader [SECONDS]

prints every role, name and value in sight of a window that is open, then for SECONDS what is announced and which names
change. It needs a running session with at-spi2-core, the system's Python with python3-gi and gir1.2-atspi-2.0, and the
program started with QT_LINUX_ACCESSIBILITY_ALWAYS_ON=1.
"""

import sys
from collections.abc import Iterator
from importlib import import_module
from typing import Any

NAME = "dps-s-configurator"
EVENTS = ("object:announcement", "object:property-change:accessible-name", "object:state-changed:focused")
_MOST_CHILDREN = 300


def below(one: Any, depth: int = 0) -> Iterator[tuple[Any, int]]:
    """From the outermost to the innermost."""
    yield one, depth
    for index in range(min(one.get_child_count(), _MOST_CHILDREN)):
        child = one.get_child_at_index(index)
        if child is not None:
            yield from below(child, depth + 1)


def print_tree(atspi: Any) -> bool:
    """Whether the program was found."""
    desktop = atspi.get_desktop(0)
    apps = [desktop.get_child_at_index(index) for index in range(desktop.get_child_count())]
    found = [one for one in apps if one is not None and one.get_name() == NAME]
    for app in found:
        for one, depth in below(app):
            if depth < 2 or one.get_state_set().contains(atspi.StateType.SHOWING):
                print(f"{'  ' * depth}{one.get_role_name()} {one.get_name()!r}{_range(one)}")
    return bool(found)


def _range(one: Any) -> str:
    value = one.get_value_iface()
    if value is None:
        return ""
    return f" {value.get_current_value():g} of {value.get_minimum_value():g} to {value.get_maximum_value():g}"


def print_events(atspi: Any, seconds: int) -> None:
    """Prints events as they occur."""

    def show(event: Any) -> None:
        print(f"{event.type} {event.source.get_role_name()}: {event.any_data}", flush=True)

    listener = atspi.EventListener.new(show)
    for kind in EVENTS:
        listener.register(kind)
    import_module("gi.repository.GLib").timeout_add_seconds(seconds, atspi.event_quit)
    atspi.event_main()


def main(words: list[str]) -> int:
    """Exit code 1 if the program is not on the bus."""
    gi: Any = import_module("gi")
    gi.require_version("Atspi", "2.0")
    atspi: Any = import_module("gi.repository.Atspi")
    if not print_tree(atspi):
        print(f"{NAME} is not on the accessibility bus", file=sys.stderr)
        return 1
    if words:
        print_events(atspi, int(words[0]))
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))

"""`python -m tests.bench [NAME …]` runs benchmarks and prints their results, the chief of docs/performance.md."""

import argparse
import platform
from importlib import import_module
from typing import Final

from tests.bench.kit import Figure

# By name: the module of this folder that has it as a function.
NAMES: Final = {
    "reading": "reading", "lock": "window", "startup": "window", "plots": "window", "cpu": "window", "stalls": "window",
    "logs": "logs", "archive": "archive",
}  # fmt: skip


def main() -> None:
    """It ends in order whatever the figures, which depend on the machine."""
    parser = argparse.ArgumentParser(
        prog="python -m tests.bench",
        description="Measure the program. Other work on the machine makes every figure worse: compare ratios.",
    )
    parser.add_argument("names", nargs="*", metavar="NAME", help=f"of {', '.join(NAMES)}; all of them by default")
    args = parser.parse_args()
    if unknown := set(args.names) - NAMES.keys():
        parser.error(f"no such benchmark: {', '.join(sorted(unknown))}")
    print(f"Python {platform.python_version()}, {platform.platform()}")
    figures: list[Figure] = []
    for name in (one for one in NAMES if one in args.names or not args.names):
        measure = getattr(import_module(f"tests.bench.{NAMES[name]}"), name)
        about, found = " ".join((measure.__doc__ or "").split()), list[Figure](measure())
        rows = ["| what | measured | aim | |", "| --- | --- | --- | --- |", *(figure.row for figure in found)]
        print(f"\n## {name}\n\n{about}\n", *rows, sep="\n", flush=True)
        figures += found
    missed = [figure for figure in figures if figure.is_met is False]
    print(f"{len(missed)} of {sum(figure.is_met is not None for figure in figures)} aims missed")


if __name__ == "__main__":
    main()

"""`python -m tests.benchmarks [NAME …]`: runs benchmarks and prints their results as a table.

A complete run also writes docs/performance.md.
"""

import argparse
import platform
import sys
import time
from collections.abc import Callable, Sequence
from importlib import import_module

from tests.benchmarks.figures import Figure, table
from tests.benchmarks.runs import MODULES, cores
from tests.benchmarks.window.page import PAGE, write_page

NAMES = tuple(MODULES)


def main(words: Sequence[str] | None = None) -> int:
    """Exit code 0 whatever the figures, which depend on the machine; 1 with `--strict` if an aim was missed."""
    parser = argparse.ArgumentParser(
        prog="python -m tests.benchmarks",
        description="Measure the program. Other work on the machine makes every figure worse: compare ratios.",
    )
    parser.add_argument("names", nargs="*", metavar="NAME", help=f"of {', '.join(NAMES)}; all of them by default")
    parser.add_argument("--strict", action="store_true", help="exit code 1 where an aim was missed")
    args = parser.parse_args(words)
    unknown = sorted(set(args.names) - set(NAMES))
    if unknown:
        parser.error(f"no such benchmark: {', '.join(unknown)}")
    chosen = [name for name in NAMES if name in args.names or not args.names]
    print(f"Python {platform.python_version()}, {platform.platform()}, {cores()} cores")
    by_name: dict[str, list[Figure]] = {}
    for name in chosen:
        began = time.monotonic()
        measure: Callable[[], list[Figure]] = import_module(MODULES[name]).figures
        by_name[name] = measure()
        print(f"{name}: measured in {time.monotonic() - began:.0f} s", file=sys.stderr, flush=True)
    found = [figure for figures in by_name.values() for figure in figures]
    print(table(found))
    if set(by_name) == set(NAMES):
        write_page(by_name)
        print(f"written: {PAGE}")
    missed = [one for one in found if one.is_met is False]
    print(f"{len(missed)} of {sum(one.is_met is not None for one in found)} aims missed")
    return 1 if missed and args.strict else 0


if __name__ == "__main__":
    sys.exit(main())

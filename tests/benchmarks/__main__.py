"""`python -m tests.benchmarks [NAME …]`: runs benchmarks and prints their results as docs/performance.md has them."""

import argparse
import platform
import sys
from collections.abc import Sequence
from importlib import import_module

from tests.benchmarks.figures import Figure, table
from tests.benchmarks.runs import NAMES, cores


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
    figures: list[Figure] = []
    for name in chosen:
        module = import_module(f"tests.benchmarks.{name}")
        measured: list[Figure] = module.figures()
        about = " ".join((module.__doc__ or "").partition("\n\n")[0].split())
        print(f"\n## {name}\n\n{about}\n\n{table(measured)}", flush=True)
        figures += measured
    missed = [figure for figure in figures if figure.is_met is False]
    print(f"{len(missed)} of {sum(figure.is_met is not None for figure in figures)} aims missed")
    return 1 if missed and args.strict else 0


if __name__ == "__main__":
    sys.exit(main())

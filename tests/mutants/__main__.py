"""Judges mutants; see the package's docstring."""

import argparse
import os
import sys
from collections.abc import Sequence

import tests.mutants
from tests.mutants import FOLDERS
from tests.mutants.changes import chosen
from tests.mutants.executed import recorded_map
from tests.mutants.judging import judged
from tests.mutants.processes import pool


def main(arguments: Sequence[str] | None = None) -> int:
    """Print each verdict, then the score; 1 where it is below what was asked for."""
    parser = argparse.ArgumentParser(prog="python -m tests.mutants", description=tests.mutants.__doc__)
    parser.add_argument("--count", type=int, default=200, help="mutants (default: %(default)s)")
    parser.add_argument("--seed", type=int, default=1, help="which ones (default: %(default)s)")
    parser.add_argument("--jobs", type=int, default=os.cpu_count() or 1, help="at a time (default: %(default)s)")
    parser.add_argument("--least", type=float, default=92.0, help="percent to be caught (default: %(default)s)")
    parser.add_argument("folders", nargs="*", default=FOLDERS, help="where (default: all)")
    given = parser.parse_args(arguments)
    verdicts = []
    with pool(given.jobs) as workers:
        executed = recorded_map(workers)
        mutants = chosen(given.seed, given.count, given.folders)
        for verdict in workers.map(judged, mutants, [executed.batches(mutant) for mutant in mutants]):
            verdicts.append(verdict)
            print(verdict, flush=True)
    survivors = [one.mutant for one in verdicts if one.caught_by is None]
    score = 100 * (len(verdicts) - len(survivors)) / len(verdicts)
    print(f"\n{len(verdicts)} mutants, seed {given.seed}: {score:.1f} % caught; survived:")
    print("\n".join(f"  {one}" for one in survivors) or "  none")
    return 0 if score >= given.least else 1


if __name__ == "__main__":
    sys.exit(main())

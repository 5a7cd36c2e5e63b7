"""Judges mutants; see the package's docstring."""

import argparse
import os
import sys
from collections.abc import Sequence

import tests.mutants
from tests.mutants import FOLDERS
from tests.mutants.changes import Mutant, chosen
from tests.mutants.executed import ROOMS, TestMap, other_folders, recorded_map
from tests.mutants.judging import Verdict, verdicts
from tests.mutants.processes import preload


def main(arguments: Sequence[str] | None = None) -> int:
    """Print each verdict, then the score; 1 where it is below what was asked for."""
    parser = argparse.ArgumentParser(prog="python -m tests.mutants", description=tests.mutants.__doc__)
    parser.add_argument("--count", type=int, help="mutants (default: all)")
    parser.add_argument("--seed", type=int, default=1, help="which ones (default: %(default)s)")
    parser.add_argument("--jobs", type=int, default=os.cpu_count() or 1, help="at a time (default: %(default)s)")
    parser.add_argument("--least", type=float, default=92.0, help="percent to be caught (default: %(default)s)")
    parser.add_argument("--rooms-only", action="store_true", help="leave out the tests of other rooms")
    parser.add_argument("folders", nargs="*", default=FOLDERS, help="where (default: all)")
    given = parser.parse_args(arguments)
    mutants = chosen(given.seed, given.count, given.folders)
    preload()
    found: dict[Mutant, Verdict] = {}
    try:
        for folders in (ROOMS, () if given.rooms_only else other_folders()):
            left = [mutant for mutant in mutants if mutant not in found or not found[mutant].caught_by]
            if left and folders:
                _judge(left, recorded_map(given.jobs, folders), given.jobs, folders, found)
    except KeyboardInterrupt:
        print("\nInterrupted.")
    survivors = [mutant for mutant, verdict in found.items() if not verdict.caught_by]
    score = _score(found)
    print(f"\n{len(found)} of {len(mutants)} mutants, seed {given.seed}: {score:.1f} % caught; survived:")
    print("\n".join(f"  {one}" for one in survivors) or "  none")
    return 0 if score >= given.least and len(found) == len(mutants) else 1


def _judge(
    mutants: Sequence[Mutant], executed: TestMap, jobs: int, folders: Sequence[str], found: dict[Mutant, Verdict]
) -> None:
    """Note and print each verdict as soon as there is one, so that an interrupted run still has a score."""
    for number, verdict in enumerate(verdicts(jobs, folders, executed, mutants), 1):
        found[verdict.mutant] = verdict
        print(f"{number:4}/{len(mutants)} {_score(found):3.0f} %  {verdict}", flush=True)


def _score(found: dict[Mutant, Verdict]) -> float:
    caught = sum(bool(verdict.caught_by) for verdict in found.values())
    return 100 * caught / len(found) if found else 0.0


if __name__ == "__main__":
    sys.exit(main())

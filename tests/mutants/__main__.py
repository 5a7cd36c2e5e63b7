"""Judges mutants; see the package's docstring."""

import argparse
import os
import sys
from collections.abc import Sequence
from concurrent.futures import ProcessPoolExecutor, as_completed

import tests.mutants
from tests.mutants import FOLDERS
from tests.mutants.changes import Mutant, chosen
from tests.mutants.executed import ROOMS, TestMap, other_folders, recorded_map
from tests.mutants.judging import Verdict, judged
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
    mutants = chosen(given.seed, given.count, given.folders)
    verdicts: dict[Mutant, Verdict] = {}
    with pool(given.jobs) as workers:
        try:
            for folders in (ROOMS, other_folders()):
                left = [mutant for mutant in mutants if mutant not in verdicts or not verdicts[mutant].caught_by]
                if left:
                    _judge(left, recorded_map(workers, folders), workers, verdicts)
        except KeyboardInterrupt:
            print("\nInterrupted.")
        finally:
            workers.shutdown(wait=False, cancel_futures=True)
    survivors = [mutant for mutant, verdict in verdicts.items() if not verdict.caught_by]
    score = _score(verdicts)
    print(f"\n{len(verdicts)} of {len(mutants)} mutants, seed {given.seed}: {score:.1f} % caught; survived:")
    print("\n".join(f"  {one}" for one in survivors) or "  none")
    return 0 if score >= given.least and len(verdicts) == len(mutants) else 1


def _judge(
    mutants: Sequence[Mutant], executed: TestMap, workers: ProcessPoolExecutor, verdicts: dict[Mutant, Verdict]
) -> None:
    """Note and print each verdict as soon as there is one, so that an interrupted run still has a score."""
    judging = [workers.submit(judged, one, executed.batches(one)) for one in mutants]
    for number, ended in enumerate(as_completed(judging), 1):
        verdict = ended.result()
        verdicts[verdict.mutant] = verdict
        print(f"{number:3}/{len(mutants)} {_score(verdicts):3.0f} %  {verdict}", flush=True)


def _score(verdicts: dict[Mutant, Verdict]) -> float:
    caught = sum(bool(verdict.caught_by) for verdict in verdicts.values())
    return 100 * caught / len(verdicts) if verdicts else 0.0


if __name__ == "__main__":
    sys.exit(main())

"""`python -m tests.campaigns`: exchanges at every frame of every job, and how often conversations end on bad lines.

    python -m tests.campaigns exchanges --step 3
    python -m tests.campaigns lines --seconds 3600
    python -m tests.campaigns commands --runs 1000 --first 1

The first two are in virtual time: an hour takes a minute. `commands` runs the program at random modules, eight
at once, a few seconds each. Exit code 1 for anything that must not be.
"""

import argparse
import sys
import tempfile
from pathlib import Path

from tests.campaigns import commands, exchanges, lines


def main() -> int:
    parser = argparse.ArgumentParser(prog="python -m tests.campaigns", description=__doc__.partition("\n")[0])
    parser.add_argument("what", choices=("commands", "exchanges", "lines"))
    parser.add_argument("--step", type=int, default=1, help="only every so many frames of a job")
    parser.add_argument("--job", action="append", choices=tuple(exchanges.JOBS), help="only this one")
    parser.add_argument("--seconds", type=float, default=3600.0, help="on each line (default: %(default)s)")
    parser.add_argument("--seeds", type=int, default=1, help="how often each line is tried")
    parser.add_argument("--runs", type=int, default=1000, help="of commands (default: %(default)s)")
    parser.add_argument("--first", type=int, default=1, help="seed of the first of them; the same seed, the same run")
    args = parser.parse_args()
    if args.what == "commands":
        with tempfile.TemporaryDirectory() as folder:
            seeds = range(args.first, args.first + args.runs)
            texts, broken = commands.told(commands.campaign(seeds, Path(folder)))
        print("\n".join(texts))
        return int(broken > 0)
    if args.what == "lines":
        for text in lines.table(args.seconds, args.seeds):
            print(text, flush=True)
        return 0
    results = list(exchanges.campaign(step=args.step, jobs=args.job or exchanges.JOBS))
    print("\n".join(exchanges.told(results)))
    return int(any(result.findings and result.plan.must_be_noticed for result in results))


if __name__ == "__main__":
    sys.exit(main())

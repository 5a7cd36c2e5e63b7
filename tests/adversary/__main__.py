"""`python -m tests.adversary`: every fault and lie of the simulated module against every command and the window.

Each run is compared with the module's memory. Exit code 1 for any breach; each is printed with the command that repeats
its run.
"""

import argparse
import os
import sys
import time
from collections import Counter
from itertools import islice

from PySide6.QtWidgets import QApplication

from tests.adversary.campaign import Campaign, Desk, Plan, Result, plan_of, plans, run_all
from tests.adversary.commands import NAMES
from tests.adversary.faults import DIALECTS, TROUBLES
from tests.adversary.judge import Breach
from tests.adversary.program import temporary_homes

RUNS = 5600
SHOWN_BREACHES = 60
EVERY_S = 10.0


def table_of(campaign: Campaign) -> list[str]:
    """Return the lines of the report: runs, breaches, and how often each good claim was made."""
    found = Counter(finding.breach for result in campaign.breaches for finding in result.findings)
    minutes, seconds = divmod(round(campaign.took_s), 60)
    hours = campaign.fake_s / 3600
    lines = [
        f"{campaign.runs:,} runs in {minutes} min {seconds:02} s ({hours:.1f} hours of the module's time)",
        f"{len(DIALECTS)} dialects, {len(TROUBLES)} faults and lies, {len(NAMES)} commands",
        "",
        *(f"  {breach.value:<24}{found[breach]:>6}" for breach in Breach),
        "",
        "said in all: " + ", ".join(f"{count:,} × {what}" for what, count in campaign.said.items()),
        "",
        f"  {'command':<32}{'runs':>6}   exit codes",
    ]
    for name, runs in campaign.by_command.items():
        codes = {code: count for (command, code), count in sorted(campaign.by_code.items()) if command == name}
        lines.append(f"  {name:<32}{runs:>6}   " + ", ".join(f"{code}: {count}" for code, count in codes.items()))
    return lines


def breaches_of(campaign: Campaign) -> list[str]:
    lines = []
    for result in campaign.breaches[:SHOWN_BREACHES]:
        lines += [f"  {finding.breach.value}: {finding.text}" for finding in result.findings]
        lines.append(f'    again: python3 packaging/bootstrap.py adversary --only "{result.plan}"')
    left_out = len(campaign.breaches) - SHOWN_BREACHES
    return [*lines, f"  … and {left_out} more runs"] if left_out > 0 else lines


class Progress:
    def __init__(self, total: int) -> None:
        self._total, self._done = total, 0
        self._said_at = time.perf_counter()

    def __call__(self, _result: Result) -> None:
        self._done += 1
        if time.perf_counter() - self._said_at > EVERY_S:
            self._said_at = time.perf_counter()
            print(f"{self._done:,} of {self._total:,}", file=sys.stderr, flush=True)


def _repeat(plan: Plan) -> int:
    with temporary_homes() as home, Desk(home) as desk:
        result = desk.run(plan)
    print(result.ran.out, result.ran.err, f"exit code {result.ran.code}", sep="\n")
    for finding in result.findings:
        print(f"{finding.breach.value}: {finding.text}")
    return 1 if result.findings else 0


def main(argv: list[str] | None = None) -> int:
    parser = argparse.ArgumentParser(prog="python -m tests.adversary", description=__doc__)
    parser.add_argument("--runs", type=int, default=RUNS, help=f"how many (default: {RUNS})")
    parser.add_argument("--seed", type=int, default=1, help="the same seed, the same runs")
    parser.add_argument("--only", type=plan_of, metavar="RUN", help="only this one, with all that it printed")
    args = parser.parse_args(argv)
    os.environ.setdefault("QT_QPA_PLATFORM", "offscreen")  # no display needed
    _application = QApplication.instance() or QApplication(sys.argv[:1])  # required by the window's objects
    if args.only is not None:
        return _repeat(args.only)
    with temporary_homes() as home:
        planned = islice(plans(args.runs, args.seed), args.runs)
        campaign = run_all(planned, home, Progress(args.runs))
    print("\n".join(table_of(campaign)))
    if campaign.breaches:
        print("\n".join(["", "breaches:", *breaches_of(campaign)]))
    return 1 if campaign.breaches else 0


if __name__ == "__main__":
    sys.exit(main())

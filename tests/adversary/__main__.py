"""`python -m tests.adversary`: every fault and lie of the simulated module against every command and the window.

Each run is compared with the module's memory. Exit code 1 for any breach; each is printed with the command that repeats
its run.
"""

import argparse
import os
import sys
from collections import Counter
from itertools import islice

from PySide6.QtWidgets import QApplication

from tests.adversary.campaign import Campaign, Desk, Plan, plan_of, plans, run_all
from tests.adversary.commands import NAMES
from tests.adversary.faults import DIALECTS, TROUBLES
from tests.adversary.judge import Breach
from tests.adversary.program import temporary_homes
from tests.support.confined import confined_home

RUNS = 5600


def told(campaign: Campaign) -> str:
    """What was tried, what was said, and each breach with the command that repeats it."""
    found = Counter(finding.breach for result in campaign.breaches for finding in result.findings)
    lines = [
        f"{campaign.runs:,} runs: {len(DIALECTS)} dialects, {len(TROUBLES)} faults and lies, {len(NAMES)} commands",
        "said in all: " + ", ".join(f"{count:,} × {what}" for what, count in campaign.said.items()),
        *(f"  {breach.value:<24}{found[breach]:>6}" for breach in Breach),
    ]
    for result in campaign.breaches:
        lines += [f"  {finding.breach.value}: {finding.text}" for finding in result.findings]
        lines.append(f'    again: .venv/bin/python -m tests.adversary --only "{result.plan}"')
    return "\n".join(lines)


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
        campaign = run_all(planned, home)
    print(told(campaign))
    return 1 if campaign.breaches else 0


if __name__ == "__main__":
    with confined_home():
        sys.exit(main())

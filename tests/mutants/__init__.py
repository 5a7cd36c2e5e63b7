"""Mutation test: `python -m tests.mutants` breaks the program in small ways and counts how often the tests notice.

Each mutant changes one operator, comparison, constant, statement or branch of one file. Which tests execute which line
is recorded once and kept in `build/mutants`; only the tests that execute the mutated line run on a mutant, until one
fails: first those of the mutated rooms, then on what these do not catch all others. Each verdict is printed at once
with the score so far; an interrupted run has a score, too, which is too low rather than too high. A survivor is a line
that no test holds, or a change that makes no difference: look at each.
All mutants, about 4,000, take some hours; `--count 200` is a sample. Not part of CI; needs a platform with `fork`.
"""

from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
FOLDERS = ("protocol", "app/engine", "app/safety", "app/preflight", "app/procedures")
"""What is mutated."""

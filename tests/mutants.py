"""Mutation test: `python -m tests.mutants` breaks the program in small ways and counts how often the tests notice.

Each mutant changes one operator, comparison, constant, statement or branch of one file, in a scratch copy. The tests of
its room run on it, those that name the mutated module first, until one fails. A survivor is a line that no test
holds, or a change that makes no difference: look at each. Not part of CI.
"""

import argparse
import ast
import os
import random
import re
import shutil
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor
from functools import partial
from pathlib import Path
from queue import SimpleQueue
from typing import NamedTuple

ROOT = Path(__file__).resolve().parents[1]
FOLDERS = ("protocol", "app/engine", "app/safety", "app/preflight", "app/procedures")
PROCESSOR_S = 240
"""The tests of a room take 20 to 90 s of the processor; a mutant that takes more runs in a circle, and is caught."""
HANGS_S = 300
"""A single test that takes longer waits for ever, which is noticed, too."""
_COMPARISONS: dict[type[ast.cmpop], type[ast.cmpop]] = {
    ast.Lt: ast.LtE,
    ast.LtE: ast.Lt,
    ast.Gt: ast.GtE,
    ast.GtE: ast.Gt,
    ast.Eq: ast.NotEq,
    ast.NotEq: ast.Eq,
    ast.Is: ast.IsNot,
    ast.IsNot: ast.Is,
    ast.In: ast.NotIn,
    ast.NotIn: ast.In,
}
_OPERATORS: dict[type[ast.operator], type[ast.operator]] = {
    ast.Add: ast.Sub,
    ast.Sub: ast.Add,
    ast.Mult: ast.Div,
    ast.Div: ast.Mult,
    ast.FloorDiv: ast.Mult,
    ast.Mod: ast.Mult,
    ast.BitAnd: ast.BitOr,
    ast.BitOr: ast.BitAnd,
    ast.LShift: ast.RShift,
    ast.RShift: ast.LShift,
}
_LEFT_OUT_CALLS = frozenset({"marked", "tr", "said", "isinstance", "cast"})


class Mutant(NamedTuple):
    """One change of one file; `text` is the whole file with it."""

    path: str
    line: int
    change: str
    text: str

    def __str__(self) -> str:
        return f"{self.path}:{self.line}: {self.change}"


class Verdict(NamedTuple):
    mutant: Mutant
    caught_by: str | None
    """The first test that failed; None where none did."""
    seconds: float


class Site(NamedTuple):
    """A place that can be mutated, and how."""

    node: ast.AST
    mutate: Callable[[], None]
    word: str = ""
    """What is done, where it does not show in the node itself."""


def mutant_at(path: str, source: str, number: int) -> Mutant:
    """The mutant of the site with this number in a source text."""
    tree = ast.parse(source)
    site = list(_sites_below(tree))[number]
    before = _line(site.node)
    site.mutate()
    text = ast.unparse(ast.fix_missing_locations(tree))
    change = f"{site.word}: {before}" if site.word else f"{before}  ->  {_line(site.node)}"
    return Mutant(path, getattr(site.node, "lineno", 0), change, text)


def _line(node: ast.AST) -> str:
    return ast.unparse(node).splitlines()[0][:90]


def _sites_below(node: ast.AST) -> Iterator[Site]:
    """Annotations, decorators, type unions and texts are left as they are: to change them breaks no behaviour."""
    yield from _sites_at(node)
    for name, value in ast.iter_fields(node):
        if name in ("annotation", "returns", "decorator_list", "bases"):
            continue
        for child in value if isinstance(value, list) else [value]:
            if isinstance(child, ast.AST) and not _is_left_out(child):
                yield from _sites_below(child)


def _is_left_out(node: ast.AST) -> bool:
    return isinstance(node, ast.Call) and isinstance(node.func, ast.Name) and node.func.id in _LEFT_OUT_CALLS


def _sites_at(node: ast.AST) -> Iterator[Site]:
    match node:
        case ast.Compare(ops=[comparison]):
            yield Site(node, lambda: setattr(node, "ops", [_COMPARISONS[type(comparison)]()]))
        case ast.BoolOp():
            swapped = ast.Or() if isinstance(node.op, ast.And) else ast.And()
            yield Site(node, lambda: setattr(node, "op", swapped))
        case ast.BinOp(op=operator) | ast.AugAssign(op=operator) if type(operator) in _OPERATORS:
            if not (isinstance(operator, ast.BitOr) and _is_type_union(node)):
                yield Site(node, lambda: setattr(node, "op", _OPERATORS[type(operator)]()))
        case ast.Constant(value=bool() as value):
            yield Site(node, lambda: setattr(node, "value", not value))
        case ast.Constant(value=int() | float() as value):
            yield Site(node, lambda: setattr(node, "value", value + 1))
        case ast.If() | ast.IfExp():
            yield Site(node.test, lambda: setattr(node, "test", ast.UnaryOp(ast.Not(), node.test)), "branches swapped")
    for name in ("body", "orelse", "finalbody"):
        found = getattr(node, name, None)
        statements: list[ast.stmt] = found if isinstance(found, list) else []
        for number, statement in enumerate(statements):
            if _is_droppable(statement):
                drop = partial(statements.__setitem__, number, ast.Pass())
                yield Site(statement, drop, "dropped")


def _is_type_union(node: ast.AST) -> bool:
    return any(
        isinstance(part, ast.Name) and part.id[:1].isupper() and not part.id.isupper() for part in ast.walk(node)
    )


def _is_droppable(statement: ast.stmt) -> bool:
    match statement:
        case ast.Expr(value=ast.Call() | ast.Yield() | ast.YieldFrom()) | ast.AugAssign() | ast.Raise():
            return True
        case ast.Assign(targets=[ast.Attribute() | ast.Subscript()]) | ast.Continue() | ast.Break():
            return True
    return False


def fitting_tests(path: str, root: Path = ROOT) -> list[str]:
    """The tests of the room of a file, and whatever other test of `tests/app` names its module: cheap ones first."""
    module = path.removesuffix(".py").replace("/", ".")
    room = root / "tests" / Path(path).parent
    inside = set(room.rglob("test_*.py"))
    ranked = []
    for test in {*(root / "tests/app").rglob("test_*.py"), *(root / "tests/protocol").rglob("test_*.py")}:
        source = test.read_text(encoding="utf-8")
        is_named = re.search(rf"\b{re.escape(module)}\b", source) is not None
        if test in inside or is_named:
            is_slow = "qtbot" in source or "subprocess" in source or "/cli/" in test.as_posix()
            is_own = Path(path).stem in test.stem
            ranked.append((is_slow, not (is_own and test in inside), not is_named, test not in inside, test.as_posix()))
    return [Path(one[-1]).relative_to(root).as_posix() for one in sorted(ranked)]


def judged(mutant: Mutant, copy: Path) -> Verdict:
    """Run the fitting tests on the mutant in a scratch copy, which is left as it was."""
    target, began = copy / mutant.path, time.monotonic()
    original = target.read_text(encoding="utf-8")
    left_out: list[str] = []
    while True:
        target.write_text(mutant.text, encoding="utf-8")
        try:
            caught_by = _first_failure(copy, fitting_tests(mutant.path, copy), left_out)
        finally:
            target.write_text(original, encoding="utf-8")
        if caught_by is None or "::" not in caught_by or _first_failure(copy, [caught_by], []) is None:
            return Verdict(mutant, caught_by, time.monotonic() - began)
        left_out.append(caught_by)  # it fails without the mutant, too


def _first_failure(copy: Path, tests: Sequence[str], left_out: Sequence[str]) -> str | None:
    options = ["-x", "-q", "-n", "0", "-p", "no:randomly", "-p", "no:cacheprovider", "--tb", "no"]
    options += ["-o", f"faulthandler_timeout={HANGS_S}", *(f"--deselect={test}" for test in left_out)]
    environment = {**os.environ, "PYTHONPATH": str(copy), "QT_QPA_PLATFORM": "offscreen"}
    command = [sys.executable, "-m", "pytest", *options, *tests]
    limited = ["/bin/sh", "-c", f'ulimit -t {PROCESSOR_S}; exec "$@"', "sh", *command]
    process = subprocess.run(limited, cwd=copy, env=environment, capture_output=True, text=True, check=False)
    printed = process.stdout
    if process.returncode == 0:
        return None
    failed = re.search(r"^(?:FAILED|ERROR) (.+?)(?: - .*)?$", printed, re.MULTILINE)
    return failed[1] if failed else f"ended with {process.returncode}"


def chosen(seed: int, count: int, folders: Sequence[str]) -> list[Mutant]:
    """So many mutants of all that there are, the same ones for the same seed and source."""
    found = []
    for folder in folders:
        for path in sorted((ROOT / folder).rglob("*.py")) or [ROOT / folder]:
            source = path.read_text(encoding="utf-8")
            found += [(path, source, number) for number, _ in enumerate(_sites_below(ast.parse(source)))]
    some = random.Random(seed).sample(found, min(count, len(found)))
    return [mutant_at(path.relative_to(ROOT).as_posix(), source, number) for path, source, number in some]


def scratch_copy(folder: Path) -> Path:
    """What git knows of the checkout, as it is now, and with it whatever tests need."""
    listed = subprocess.run(["git", "ls-files", "-z"], cwd=ROOT, capture_output=True, text=True, check=True).stdout
    for name in filter(None, listed.split("\0")):
        target = folder / name
        target.parent.mkdir(parents=True, exist_ok=True)
        if (ROOT / name).exists():
            shutil.copy2(ROOT / name, target)
    return folder


def main(arguments: Sequence[str] | None = None) -> int:
    """Print each verdict, then the score; 1 where it is below what was asked for."""
    parser = argparse.ArgumentParser(prog="python -m tests.mutants", description=__doc__)
    parser.add_argument("--count", type=int, default=200, help="mutants (default: %(default)s)")
    parser.add_argument("--seed", type=int, default=1, help="which ones (default: %(default)s)")
    parser.add_argument("--jobs", type=int, default=os.cpu_count() or 1, help="at a time (default: %(default)s)")
    parser.add_argument("--least", type=float, default=92.0, help="percent to be caught (default: %(default)s)")
    parser.add_argument("folders", nargs="*", default=FOLDERS, help="where (default: all)")
    given = parser.parse_args(arguments)
    verdicts: list[Verdict] = []
    with tempfile.TemporaryDirectory() as place, ThreadPoolExecutor(given.jobs) as pool:
        copies: SimpleQueue[Path] = SimpleQueue()
        for number in range(given.jobs):
            copies.put(scratch_copy(Path(place) / str(number)))

        def judge(mutant: Mutant) -> Verdict:
            copy = copies.get()
            try:
                return judged(mutant, copy)
            finally:
                copies.put(copy)

        for verdict in pool.map(judge, chosen(given.seed, given.count, given.folders)):
            verdicts.append(verdict)
            word = "SURVIVED" if verdict.caught_by is None else "caught"
            print(f"{word:8} {verdict.seconds:5.0f} s  {verdict.mutant}  [{verdict.caught_by}]", flush=True)
    survivors = [one.mutant for one in verdicts if one.caught_by is None]
    score = 100 * (len(verdicts) - len(survivors)) / len(verdicts)
    print(f"\n{len(verdicts)} mutants, seed {given.seed}: {score:.1f} % caught; survived:")
    print("\n".join(f"  {one}" for one in survivors) or "  none")
    return 0 if score >= given.least else 1


if __name__ == "__main__":
    sys.exit(main())

"""Mutation test: `python -m tests.mutants` breaks the program in small ways and counts how often the tests notice.

Each mutant changes one comparison, operator, constant, branch or statement of one file, in a copy of the checkout. The
tests of its room run on it, then those that import the file, until one fails. A survivor is a line that no test holds,
or a change that makes no difference: look at each. Not part of CI; 400 mutants take hours.
"""

import argparse
import ast
import os
import random
import shutil
import subprocess
import sys
import tempfile
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor
from functools import partial
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[1]
FOLDERS = ("protocol", "app", "ui")
HANGS_S, TIMEOUT_S = 40, 400
"""One test, and all tests of a mutant: what hangs is caught."""
_SWAPPED = {
    ast.Lt: ast.LtE, ast.LtE: ast.Lt, ast.Gt: ast.GtE, ast.GtE: ast.Gt, ast.Eq: ast.NotEq, ast.NotEq: ast.Eq,
    ast.Is: ast.IsNot, ast.IsNot: ast.Is, ast.In: ast.NotIn, ast.NotIn: ast.In, ast.And: ast.Or, ast.Or: ast.And,
    ast.Add: ast.Sub, ast.Sub: ast.Add, ast.Mult: ast.Div, ast.Div: ast.Mult, ast.FloorDiv: ast.Mult,
    ast.Mod: ast.Mult, ast.BitAnd: ast.BitOr, ast.LShift: ast.RShift, ast.RShift: ast.LShift,
}  # fmt: skip
_TEXTS = frozenset({"marked", "tr", "message", "isinstance", "cast"})
_ANNOTATIONS = frozenset({"annotation", "returns", "decorator_list", "bases"})
_DROPPABLE = (ast.Expr, ast.AugAssign, ast.Raise, ast.Continue, ast.Break)


def mutants_in(source: str) -> int:
    """How many changes there are."""
    return sum(1 for _ in _changes(ast.parse(source)))


def mutant_of(source: str, number: int) -> tuple[int, str, str]:
    """The line, what stood there, and the changed source text."""
    tree = ast.parse(source)
    node, change = list(_changes(tree))[number]
    before = ast.unparse(node).splitlines()[0]
    change()
    return getattr(node, "lineno", 0), before, ast.unparse(ast.fix_missing_locations(tree))


def _changes(node: ast.AST) -> Iterator[tuple[ast.AST, Callable[[], None]]]:
    """Annotations, decorators and texts are left as they are: to change them breaks no behaviour."""
    match node:
        case ast.Compare(ops=[comparison]):
            yield node, partial(setattr, node, "ops", [_SWAPPED[type(comparison)]()])
        case ast.BoolOp() | ast.BinOp() | ast.AugAssign() if type(node.op) in _SWAPPED:
            yield node, partial(setattr, node, "op", _SWAPPED[type(node.op)]())
        case ast.Constant(value=bool() as value):
            yield node, partial(setattr, node, "value", not value)
        case ast.Constant(value=int() | float() as value):
            yield node, partial(setattr, node, "value", value + 1)
        case ast.If() | ast.IfExp():
            yield node.test, partial(setattr, node, "test", ast.UnaryOp(ast.Not(), node.test))
        case ast.Call(func=ast.Name(id=name)) if name in _TEXTS:
            return
    for name, value in ast.iter_fields(node):
        children = value if isinstance(value, list) else [value]
        for place, child in enumerate(children if name not in _ANNOTATIONS else ()):
            if isinstance(child, _DROPPABLE) and not isinstance(getattr(child, "value", None), ast.Constant):
                yield child, partial(children.__setitem__, place, ast.Pass())
            if isinstance(child, ast.AST):
                yield from _changes(child)


def _tests_of(path: Path) -> list[str]:
    """The tests of its room, then those that import it."""
    room = ROOT / "tests" / path.parent
    module = ".".join(path.with_suffix("").parts)
    importing = [test for test in ROOT.glob("tests/**/test_*.py") if module in test.read_text(encoding="utf-8")]
    tests = [room, *(test for test in importing if room not in test.parents)]
    return [test.relative_to(ROOT).as_posix() for test in tests if test.exists()]


def _is_caught(path: Path, text: str) -> bool:
    """In a copy of the checkout, with what is compiled: a mutant costs its tests alone."""
    options = ["-x", "-q", "-p", "no:randomly", "-p", "no:cacheprovider", "-o", f"faulthandler_timeout={HANGS_S}"]
    left_out = shutil.ignore_patterns(".venv", ".git", "build", "dist")
    with tempfile.TemporaryDirectory() as folder:
        checkout = shutil.copytree(ROOT, Path(folder) / "checkout", ignore=left_out)
        (checkout / path).write_text(text, encoding="utf-8")
        try:
            ended = subprocess.run(
                [sys.executable, "-m", "pytest", *options, *_tests_of(path)],
                cwd=checkout,
                env={**os.environ, "QT_QPA_PLATFORM": "offscreen"},
                timeout=TIMEOUT_S,
                capture_output=True,
                check=False,
            )
        except subprocess.TimeoutExpired:
            return True
    return ended.returncode != pytest.ExitCode.OK


def main(arguments: Sequence[str] | None = None) -> int:
    """Print each verdict, then the score; 1 where it is below what was asked for."""
    parser = argparse.ArgumentParser(prog="python -m tests.mutants", description=__doc__)
    parser.add_argument("--count", type=int, default=400, help="mutants (default: %(default)s)")
    parser.add_argument("--seed", type=int, default=random.randrange(1000), help="which ones")
    parser.add_argument("--jobs", type=int, default=os.cpu_count() or 1, help="at a time (default: %(default)s)")
    parser.add_argument("--least", type=float, default=92.0, help="percent to be caught (default: %(default)s)")
    parser.add_argument("paths", nargs="*", default=FOLDERS, help="files and folders (default: the program)")
    given = parser.parse_args(arguments)
    files = [file for path in given.paths for file in sorted((ROOT / path).rglob("*.py")) or [ROOT / path]]
    sources = {file.relative_to(ROOT): file.read_text(encoding="utf-8") for file in files}
    everything = [(path, number) for path, source in sources.items() for number in range(mutants_in(source))]
    chosen = random.Random(given.seed).sample(everything, min(given.count, len(everything)))

    def judge(mutant: tuple[Path, int]) -> bool:
        path, number = mutant
        line, change, text = mutant_of(sources[path], number)
        is_caught = _is_caught(path, text)
        print(f"{'caught  ' if is_caught else 'SURVIVED'} {path}:{line}: {change}", flush=True)
        return is_caught

    with ThreadPoolExecutor(given.jobs) as pool:
        score = 100 * sum(pool.map(judge, chosen)) / len(chosen)
    print(f"{len(chosen)} of {len(everything)} mutants, seed {given.seed}: {score:.1f} % caught")
    return 0 if score >= given.least else 1


if __name__ == "__main__":
    sys.exit(main())

"""The mutants of a source text, and the choice among those of the program."""

import ast
import random
from collections.abc import Callable, Iterator, Sequence
from functools import cache, partial
from types import CodeType
from typing import NamedTuple

from tests.mutants import ROOT

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
_LEFT_OUT_CALLS = frozenset({"marked", "tr", "message", "isinstance", "cast"})


class Mutant(NamedTuple):
    """One change of one file."""

    path: str
    source: str
    number: int
    """Which of the places in the source is changed."""
    lines: range
    """The lines of the statement that is changed; empty outside functions, where importing the file executes it."""
    line: int
    change: str

    def __str__(self) -> str:
        return f"{self.path}:{self.line}: {self.change}"

    def code(self) -> CodeType:
        """The whole file with the change; every line keeps its number."""
        tree = ast.parse(self.source)
        list(_sites_below(tree))[self.number].mutate()
        return compile(ast.fix_missing_locations(tree), str(ROOT / self.path), "exec", dont_inherit=True)

    def changes_functions_only(self) -> bool:
        """Whether the change can be made in the functions of the imported file, without importing it again."""
        before, after = _functions_of(self.source), functions_in(self.code())
        return bool(self.lines) and all(
            before[key].co_freevars == code.co_freevars for key, code in after.items() if key in before
        )


def functions_in(code: CodeType) -> dict[tuple[str, int], CodeType]:
    """What is compiled in a file, by its qualified name and first line."""
    found = {(code.co_qualname, code.co_firstlineno): code}
    for inner in code.co_consts:
        if isinstance(inner, CodeType):
            found |= functions_in(inner)
    return found


@cache
def _functions_of(source: str) -> dict[tuple[str, int], CodeType]:
    return functions_in(compile(source, "", "exec", dont_inherit=True))


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
    before, lines = _line(site.node), _statement_lines(tree, site.node)
    site.mutate()
    change = f"{site.word}: {before}" if site.word else f"{before}  ->  {_line(site.node)}"
    return Mutant(path, source, number, lines, getattr(site.node, "lineno", 0), change)


def _line(node: ast.AST) -> str:
    return ast.unparse(node).splitlines()[0][:90]


def _statement_lines(tree: ast.Module, node: ast.AST) -> range:
    """The lines of the innermost statement around a node, without its block; empty where no function is around it."""
    first, last = getattr(node, "lineno", 0), getattr(node, "end_lineno", 0)
    lines, is_in_function = range(first, last + 1), False
    for around in ast.walk(tree):  # outer ones first
        if isinstance(around, ast.stmt) and around.lineno <= first and last <= (around.end_lineno or 0):
            body: list[ast.stmt] = getattr(around, "body", [])
            is_in_block = bool(body) and first >= body[0].lineno
            is_in_function |= is_in_block and isinstance(around, ast.FunctionDef)
            if not is_in_block:
                lines = range(around.lineno, (body[0].lineno if body else (around.end_lineno or 0) + 1))
    return lines if is_in_function else range(0)


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
            yield Site(
                node.test,
                lambda: setattr(node, "test", ast.UnaryOp(ast.Not(), node.test)),
                "branches swapped",
            )
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


def chosen(seed: int, count: int | None, folders: Sequence[str]) -> list[Mutant]:
    """So many mutants of all that there are, the same ones for the same seed and source; or all."""
    found = []
    for folder in folders:
        for path in sorted((ROOT / folder).rglob("*.py")) or [ROOT / folder]:
            source = path.read_text(encoding="utf-8")
            found += [(path, source, number) for number, _ in enumerate(_sites_below(ast.parse(source)))]
    some = random.Random(seed).sample(found, len(found) if count is None else min(count, len(found)))
    return [mutant_at(path.relative_to(ROOT).as_posix(), source, number) for path, source, number in some]

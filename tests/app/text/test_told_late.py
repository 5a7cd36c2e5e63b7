"""What is said later is translated later, so that it follows a change of language."""

import ast
from collections.abc import Iterator
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[3]
ONE_LANGUAGE = ("app/cli/", "app/terminal/", "app/__main__.py")
"""A command ends in the language in which it began."""
OVERWRITTEN = {"ui/plots/header.py": "self.chip", "ui/widgets/readout.py": "self.word"}
"""Replaced before it is shown."""


def calls_now(node: ast.AST) -> Iterator[ast.AST]:
    """What is called when this is, without what functions in it would call."""
    if not isinstance(node, ast.Lambda):
        yield node
        for child in ast.iter_child_nodes(node):
            yield from calls_now(child)


def is_translated(node: ast.AST) -> bool:
    for one in calls_now(node):
        match one:
            case ast.Call(func=ast.Name(id="tr" | "join_sentences") | ast.Attribute(attr="translated" | "tr")):
                return True
            case ast.Attribute(attr="sentence", ctx=ast.Load()):
                return True
    return False


def kept_in(tree: ast.AST) -> Iterator[tuple[int, str]]:
    """Line and target of each translated text that an attribute keeps, or an exception takes along."""
    for node in ast.walk(tree):
        match node:
            case ast.Assign(targets=[target], value=value) | ast.AnnAssign(target=target, value=ast.expr() as value):
                place = target.value if isinstance(target, ast.Subscript) else target
                if isinstance(place, ast.Attribute) and is_translated(value):
                    yield node.lineno, ast.unparse(target)
            case ast.Raise(exc=ast.Call() as error) if is_translated(error):
                yield node.lineno, ast.unparse(error.func)


@pytest.mark.parametrize("path", ["app", "ui"])
def test_no_translated_text_is_kept(path: str) -> None:
    found = []
    for file in sorted((ROOT / path).rglob("*.py")):
        name = file.relative_to(ROOT).as_posix()
        if not name.startswith(ONE_LANGUAGE):
            tree = ast.parse(file.read_text(encoding="utf-8"))
            found += [f"{name}:{line}: {what}" for line, what in kept_in(tree) if OVERWRITTEN.get(name) != what]
    assert found == []


@pytest.mark.parametrize(
    ("code", "is_kept"),
    [
        ("self.why = tr('Lost.')", True),
        ("self.why: str = error.sentence", True),
        ("raise Refused(message('{why}', why=tr('Lost.')))", True),
        ("self.why = lambda: tr('Lost.')", False),
        ("self.why = message(marked('Lost.'))", False),
        ("why = tr('Lost.')", False),
    ],
)
def test_what_counts_as_kept(code: str, is_kept: bool) -> None:
    assert bool(list(kept_in(ast.parse(code)))) is is_kept

"""Keeps app/locale/zh_CN.ts up to date with the texts of the source.

    python3 docs/generate/translations.py update       rewrite the file: new texts unfinished, old ones removed
    python3 docs/generate/translations.py check        exit 1 with a list if it is out of date or unfinished

A capital letter, a full stop or an ellipsis needs no message of its own: see `app.text.i18n.variants`.

Texts are the literals in calls of ``tr(...)`` and ``marked(...)``.  Any other argument of ``tr`` has to be the name of
a marked text.
"""

import argparse
import ast
import string
import sys
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Final, NamedTuple
from xml.etree import ElementTree
from xml.sax.saxutils import escape

from jinja2 import Environment, nodes

ROOT: Final = Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT))

from app.text.i18n import variants  # noqa: E402  the package lies beside this folder

TS: Final = ROOT / "app" / "locale" / "zh_CN.ts"
PACKAGES: Final = ("protocol", "app", "ui")
TEMPLATES: Final = "app/templates"
CONTEXT: Final = "dps-s"
_CALLED: Final = ("tr", "marked")


@dataclass(slots=True)
class Extract:
    """The texts of the sources with their first place, and faulty calls."""

    texts: dict[str, str] = field(default_factory=dict)
    faults: list[str] = field(default_factory=list)


class Translation(NamedTuple):
    """The Chinese for one text ("" if missing) and whether it is finished."""

    chinese: str
    is_finished: bool


def extract_all(root: Path = ROOT) -> Extract:
    """The texts of every Python file of the packages, and of the templates of what is printed."""
    found = Extract()
    for path in sorted((root / TEMPLATES).glob("*.html")):
        extract_template(path.read_text(encoding="utf-8"), path.relative_to(root).as_posix(), found)
    for package in PACKAGES:
        for path in sorted((root / package).rglob("*.py")):
            extract(path.read_text(encoding="utf-8"), path.relative_to(root).as_posix(), found)
    return found


def extract_template(source: str, path: str, found: Extract) -> None:
    """Add the literals in calls of ``tr(...)`` in a Jinja2 template."""
    for call in Environment(autoescape=True).parse(source).find_all(nodes.Call):
        if not isinstance(call.node, nodes.Name) or call.node.name != "tr":
            continue
        text = call.args[0] if call.args else None
        if isinstance(text, nodes.Const) and isinstance(text.value, str):
            found.texts.setdefault(text.value, f"{path}:{call.lineno}")
        else:
            found.faults.append(f"{path}:{call.lineno}: tr() wants a literal")


def extract(source: str, path: str, found: Extract) -> None:
    """Add the texts and faults of one source text."""
    is_any = any(f"{name}(" in source for name in _CALLED)
    for node in ast.walk(ast.parse(source)) if is_any else ():
        if isinstance(node, ast.Call) and node.args and (name := _called_name(node.func)) in _CALLED:
            _extract_call(node, name, node.args[0], f"{path}:{node.lineno}", found)


def _called_name(function: ast.expr) -> str:
    match function:
        case ast.Name(id=name) | ast.Attribute(attr=name):
            return name
    return ""


def _extract_call(call: ast.Call, name: str, text: ast.expr, place: str, found: Extract) -> None:
    match text:
        case ast.Constant(value=str(literal)):
            found.texts.setdefault(literal, place)
            if name != "marked":
                _check_values(call, literal, place, found)
        case ast.IfExp(body=one, orelse=other):
            _extract_call(call, name, one, place, found)
            _extract_call(call, name, other, place, found)
        case ast.Name() | ast.Attribute() if name != "marked":
            pass
        case ast.Subscript(value=ast.Name() | ast.Attribute()) if name != "marked":
            pass  # a table of marked texts
        case ast.JoinedStr():
            found.faults.append(f"{place}: {name}() is given an f-string; use {{name}} and name=value")
        case _:
            wanted = "a literal" if name == "marked" else "a literal or the name of a marked text"
            found.faults.append(f"{place}: {name}() wants {wanted}, not {ast.unparse(text)}")


def _check_values(call: ast.Call, literal: str, place: str, found: Extract) -> None:
    """The placeholders of a text have to match the arguments of the call."""
    given = {keyword.arg for keyword in call.keywords}
    if None in given:  # **values: only known at run time
        return
    wanted = {name.partition(".")[0].partition("[")[0] for name in placeholders(literal)}
    if wanted != given:
        found.faults.append(f"{place}: placeholders {_listed(wanted)}, values {_listed(given)}: {literal!r}")


def _listed(names: set[str | None] | set[str]) -> str:
    return ", ".join(sorted(str(name) for name in names)) or "none"


def placeholders(text: str) -> set[str]:
    """The names in braces; empty if the text is not a valid format."""
    try:
        return {name for _, name, _, _ in string.Formatter().parse(text) if name is not None}
    except ValueError:
        return set()


def formats(text: str) -> set[tuple[str | None, str | None]]:
    """The names in braces, each with its format; empty if the text is not a valid format."""
    try:
        return {(name, spec) for _, name, spec, _ in string.Formatter().parse(text) if name is not None}
    except ValueError:
        return set()


def read_ts(path: Path = TS) -> dict[str, Translation]:
    """All messages of a .ts file, including unfinished ones."""
    messages = {}
    for message in ElementTree.parse(path).getroot().iterfind("context/message"):
        translation = message.find("translation")
        if translation is not None:
            is_finished = translation.get("type") is None and bool(translation.text)
            messages[message.findtext("source", "")] = Translation(translation.text or "", is_finished)
    return messages


def write_ts(messages: Mapping[str, Translation], path: Path = TS) -> None:
    """Write a .ts file, sorted by the English text and without line numbers, for small diffs."""
    lines = [
        '<?xml version="1.0" encoding="utf-8"?>',
        "<!DOCTYPE TS>",
        '<TS version="2.1" language="zh_CN" sourcelanguage="en">',
        "<context>",
        f"    <name>{CONTEXT}</name>",
    ]
    for english, translation in sorted(messages.items()):
        kind = "" if translation.is_finished else ' type="unfinished"'
        lines += [
            "    <message>",
            f"        <source>{escape(english)}</source>",
            f"        <translation{kind}>{escape(translation.chinese)}</translation>",
            "    </message>",
        ]
    lines += ["</context>", "</TS>", ""]
    path.write_text("\n".join(lines), encoding="utf-8", newline="\n")


def followed(texts: Mapping[str, str], messages: Mapping[str, Translation]) -> dict[str, str]:
    """The Chinese of the texts that are another message with a capital letter, a full stop or an ellipsis."""
    return {
        variant: chinese
        for english in sorted(messages.keys() & texts.keys(), key=lambda text: text[:1].isupper())
        for variant, chinese in variants(english, messages[english].chinese)
        if variant in texts and variant != english and messages[english].is_finished
    }


def updated(texts: Mapping[str, str], old: Mapping[str, Translation]) -> dict[str, Translation]:
    """The messages for exactly these texts, with existing translations; none for what follows from another."""
    follows, new = followed(texts, old), Translation("", is_finished=False)
    return {
        english: old.get(english, new)
        for english in texts
        if english not in follows or (english in old and old[english].chinese != follows[english])
    }


def problems(found: Extract, messages: Mapping[str, Translation]) -> Iterator[str]:
    """The problems found by ``check``, one line each."""
    yield from found.faults
    follows = followed(found.texts, messages)
    for english, place in sorted(found.texts.items()):
        translation = messages.get(english)
        if translation is None and english in follows:
            continue
        if translation is not None and translation.chinese == follows.get(english):
            yield f"{TS.name}: follows from another: {english!r}"
        if translation is None:
            yield f"{place}: missing: {english!r}"
        elif not translation.is_finished:
            yield f"{place}: unfinished: {english!r}"
        elif formats(english) != formats(translation.chinese):
            yield f"{place}: other placeholders: {english!r}, {translation.chinese!r}"
    for english in sorted(messages.keys() - found.texts.keys()):
        yield f"{TS.name}: gone from the source: {english!r}"


def main(arguments: list[str]) -> int:
    parser = argparse.ArgumentParser(description="Keep app/locale/zh_CN.ts in step with the texts of the source.")
    commands = parser.add_subparsers(dest="command", required=True)
    commands.add_parser("update", help="write the file again")
    commands.add_parser("check", help="exit 1 when it is not in step or not finished")
    chosen = parser.parse_args(arguments)

    found, messages = extract_all(), read_ts()
    if chosen.command == "check":
        listed = list(problems(found, messages))
        print("\n".join([*listed, f"{len(listed)} problems in {len(found.texts)} texts"]))
        return 1 if listed else 0
    messages = updated(found.texts, messages)
    write_ts(messages)
    unfinished = sum(not one.is_finished for one in messages.values())
    print(f"{len(messages)} texts, {unfinished} of them unfinished")
    print(*found.faults, sep="\n")
    return 1 if found.faults else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))

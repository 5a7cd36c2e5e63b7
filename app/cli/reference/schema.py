"""`dps-s schema NAME`: prints the JSON Schema of what a command prints with --json, or of a pre-flight record."""

import argparse
from pathlib import Path

from app.terminal import console

FOLDER = Path(__file__).with_name("schemas")


def add_parser(subparsers: "argparse._SubParsersAction[argparse.ArgumentParser]") -> None:
    parser = subparsers.add_parser("schema")
    parser.add_argument("name", choices=sorted(path.stem for path in FOLDER.glob("*.json")))
    parser.set_defaults(run=run)


def run(args: argparse.Namespace) -> int:
    console.write((FOLDER / f"{args.name}.json").read_text(encoding="utf-8"))
    return console.SUCCESS

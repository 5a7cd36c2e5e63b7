"""`dps-s schema NAME`: prints the JSON Schema of what a command prints with --json, or of a pre-flight record."""

import argparse

from app.cli.commands import SCHEMAS
from app.terminal import console


def run(args: argparse.Namespace) -> int:
    console.write((SCHEMAS / f"{args.name}.json").read_text(encoding="utf-8"))
    return console.SUCCESS

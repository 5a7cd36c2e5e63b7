"""Pictures of the real program on the simulated module:  .venv/bin/python docs/generate/screenshots.py

Without arguments it takes those of the user guide (ui/help/guide/images) and of the README (docs/images), in two
minutes; see docs/generate/picture_scenes.py. With `--all FOLDER` it takes one of each page in each theme, language and
scale, for review, at 1024x600, the smallest supported screen.
"""

import argparse
import os
import subprocess
import sys
import tempfile
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
LANGUAGES = ("en", "zh_CN")


def main(arguments: list[str]) -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--all", type=Path, metavar="FOLDER", help="every page, theme, language and scale")
    parser.add_argument("--page", action="append", metavar="KEY", help="with --all: only this page (repeatable)")
    parser.add_argument("--language", choices=LANGUAGES, help="only this language")
    chosen = parser.parse_args(arguments)
    wanted = () if chosen.all is None else (chosen.all.resolve(), *(chosen.page or ("live", "diagnosis")))
    for language in (chosen.language,) if chosen.language else LANGUAGES:
        for scale in (1, 2) if wanted else (1,):  # each in another process, because Qt reads it only at start
            variables = {"QT_QPA_PLATFORM": "offscreen", "QT_SCALE_FACTOR": str(scale), "PYTHONPATH": str(ROOT)}
            scenes = Path(__file__).with_name("picture_scenes.py")
            with tempfile.TemporaryDirectory() as home:
                subprocess.run(
                    [sys.executable, scenes, language, home, *wanted], env=os.environ | variables, check=True
                )
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))

"""Pictures of the real program on the simulated module:  .venv/bin/python docs/generate/screenshots.py [LANGUAGE]

It takes those of the user guide (ui/help/guide/images) and of the README (docs/images), in two minutes, each language
in a process and a home of its own; see docs/generate/picture_scenes.py. The drawings of the guide (*.svg) are edited by
hand; its viewer replaces their ink (#1a1c1e) and paper (#ffffff) by the colours of the theme.
"""

import os
import subprocess
import sys
import tempfile
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]

if __name__ == "__main__":
    for language in sys.argv[1:] or ("en", "zh_CN"):
        variables = {"QT_QPA_PLATFORM": "offscreen", "PYTHONPATH": str(ROOT)}
        scenes = Path(__file__).with_name("picture_scenes.py")
        with tempfile.TemporaryDirectory() as home:
            subprocess.run([sys.executable, scenes, language, home], env=os.environ | variables, check=True)

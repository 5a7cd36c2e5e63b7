"""What the README shows can be done with what a fresh clone has."""

import re
import shlex
import sys
from pathlib import Path

from tests.support.processes import ran

ROOT = Path(__file__).parents[2]


def test_every_command_of_the_readme_does_what_it_says(tmp_path: Path) -> None:
    """One after the other, as some use what one before has left; the simulated module's check is NO-GO, code 1."""
    text = (ROOT / "README.md").read_text(encoding="utf-8")
    lines = re.findall(r"(?m)^\.venv/bin/dps-s (\S.*?)\s+#", text)
    assert len(lines) > 5
    for line in (line for line in lines if not line.startswith("#")):
        words = [str(tmp_path / word) if word.endswith((".toml", ".pdf")) else word for word in shlex.split(line)]
        done = ran(sys.executable, "-m", "app", *words, HOME=str(tmp_path), LC_ALL="C.UTF-8")
        assert done.returncode == (1 if words[0] == "preflight" else 0), f"{line}: {done.stderr}"


def test_it_fits_on_two_screens() -> None:
    for name in ("README.md", "README.zh_CN.md"):
        assert len((ROOT / name).read_text(encoding="utf-8").splitlines()) <= 90

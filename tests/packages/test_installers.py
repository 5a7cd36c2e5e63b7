"""The wheel installed, used and removed with pipx and uv. Run by `package --installers`.

Not part of every run, because it downloads pipx, uv and the dependencies.
"""

import os
import subprocess
import sys
from pathlib import Path

import pytest

from tests.packages.programs import LONGEST_S, ROOT, Program, check_reading

LOCK = ROOT / "packaging" / "lock.txt"


@pytest.mark.parametrize("name", ["pipx", "uv"])
def test_the_wheel_is_installed_used_and_removed(name: str, dist: Path, version: str, tmp_path: Path) -> None:
    tools, programs = tmp_path / "tools", tmp_path / "programs"
    variables = {
        **os.environ,
        "PATH": f"{programs}{os.pathsep}{os.environ['PATH']}",
        "PIPX_HOME": str(tmp_path / "pipx"),
        "PIPX_BIN_DIR": str(programs),
        "PIPX_DEFAULT_PYTHON": sys.executable,
        "UV_TOOL_DIR": str(tmp_path / "uv"),
        "UV_TOOL_BIN_DIR": str(programs),
        "UV_PYTHON": sys.executable,
        "UV_SYSTEM_CERTS": "true",
    }

    def run(*command: str) -> None:
        done = subprocess.run(
            command, env=variables, capture_output=True, text=True, timeout=5 * LONGEST_S, check=False
        )
        assert done.returncode == 0, done.stdout + done.stderr

    run(sys.executable, "-m", "venv", str(tools))
    python = tools / ("Scripts/python.exe" if os.name == "nt" else "bin/python")
    run(str(python), "-m", "pip", "install", "--quiet", name)
    wheel = str(next(dist.glob("*.whl")))
    command = [str(python), "-m", "pipx"] if name == "pipx" else [str(python), "-m", "uv", "tool"]
    limits = [f"--pip-args=--constraint={LOCK}"] if name == "pipx" else ["--constraints", str(LOCK)]
    run(*command, "install", *limits, wheel)
    program = Program((str(programs / ("dps-s.exe" if os.name == "nt" else "dps-s")),), tmp_path / "home")
    done = program.run("--version")
    assert (done.returncode, done.stdout) == (0, f"DPS-S Configurator {version}\n")
    check_reading(program)
    run(*command, "uninstall", "dps-s-configurator")
    assert list(programs.iterdir()) == []

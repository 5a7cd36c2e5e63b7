"""Names, checksums and completeness of dist/."""

import hashlib
import re
import sys
from pathlib import Path


def test_every_file_has_its_sum(dist: Path) -> None:
    lines = (dist / "SHA256SUMS").read_text(encoding="utf-8").splitlines()
    stated = {name: digest for digest, _, name in (line.partition("  ") for line in lines)}
    files = {path.name: path for path in dist.iterdir() if path.is_file() and path.name != "SHA256SUMS"}
    assert stated == {name: hashlib.sha256(path.read_bytes()).hexdigest() for name, path in files.items()}


def test_every_package_is_there_with_the_version(dist: Path, version: str) -> None:
    wanted = [rf"dps_s_configurator-{version}-py3-none-any\.whl", rf"dps_s_configurator-{version}\.tar\.gz"]
    bundle = rf"dps-s-configurator-{version}-\w+-\w+"
    wanted += {
        "linux": [bundle, rf"{bundle}\.tar\.gz", rf"dps-s-configurator_{version}-1_\w+\.deb"],
        "win32": [bundle, rf"{bundle}\.zip"],
        "darwin": [r"DPS-S Configurator\.app", rf"{bundle}\.dmg"],
    }[sys.platform]
    wanted += [rf"{bundle}\.cdx\.json", "SHA256SUMS"]
    names = sorted(path.name for path in dist.iterdir() if not path.name.endswith("-setup.exe"))
    assert len(names) == len(wanted)
    for pattern in wanted:
        assert any(re.fullmatch(pattern, name) for name in names), pattern

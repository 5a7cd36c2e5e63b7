"""Builds the bundle: a folder with the program, Python and Qt, and what is made from it on macOS and Windows."""

import json
import re
import shutil
import sys
import sysconfig
import tempfile
import zipfile
from pathlib import Path

from environment import PROGRAM, ROOT, locked, run, say
from icon_files import write_icons
from release import DIST, NAME, TITLE, VERSION, WORK, bundle_name, epoch, filled, numbers

SBOM = "sbom.cdx.json"
_HEAD = """DPS-S Configurator is under the MIT licence (LICENSE.txt). It brings works of others:

Python {python}, under the licence at the end of this file.
Qt and PySide6, under the LGPL, version 3 (licences/). They lie here as files of their own: whoever wants to may put
others in their place. What Qt itself is made of is listed at https://doc.qt.io/qt-6/licenses-used-in-qt.html, and its
sources are at https://download.qt.io.
Libraries of the system that this was built on, under its licences: {libraries}.
The Python packages below. {sbom} lists them for programs.

"""


def make_bundle(wheel: Path) -> Path:
    """Build it from the wheel; returns the folder, on macOS the .app, in dist/. Raises SetupError."""
    site, icons = WORK / "site", WORK / "icons"
    with zipfile.ZipFile(wheel) as archive:
        archive.extractall(site)
    write_icons(icons)
    command = [sys.executable, "-m", "PyInstaller", "--noconfirm", "--log-level", "ERROR"]
    command += ["--distpath", str(WORK / "frozen"), "--workpath", str(WORK / "pyinstaller")]
    variables = {"DPS_S_SITE": str(site), "DPS_S_ICONS": str(icons), "SOURCE_DATE_EPOCH": str(epoch())}
    # Outside of the checkout, whose metadata it would include.
    run([*command, str(ROOT / "packaging" / "dps-s.spec")], "PyInstaller failed", variables=variables, folder=WORK)
    is_mac = sys.platform == "darwin"
    folder = DIST / (f"{TITLE}.app" if is_mac else bundle_name())
    shutil.move(WORK / "frozen" / (folder.name if is_mac else NAME), folder)
    papers = folder / "Contents" / "Resources" if is_mac else folder
    _write_papers(papers, folder / "Contents" / "Frameworks" if is_mac else folder / "_internal")
    shutil.copyfile(papers / SBOM, DIST / f"{bundle_name()}.cdx.json")
    if sys.platform == "linux":
        (folder / "README.txt").write_text(filled(ROOT / "packaging/linux/README.txt"), encoding="utf-8")
    elif is_mac:
        # Not run here: written for macOS, never executed. PyInstaller's signature does not cover what was added.
        run(["codesign", "--force", "--deep", "--sign", "-", str(folder)], "codesign failed")
    return folder


def _write_papers(folder: Path, internal: Path) -> None:
    """Write the licences and the lists of parts: for people by pip-licenses, for programs by cyclonedx-bom."""
    shutil.copyfile(ROOT / "LICENSE", folder / "LICENSE.txt")
    shutil.copytree(ROOT / "packaging" / "licences", folder / "licences")
    names = [re.split("[=;]", line)[0].strip() for line in locked(PROGRAM)]
    names.remove("setuptools")  # installs it from a checkout
    command = [sys.executable, "-m", "piplicenses", "--format=plain-vertical", "--with-urls", "--with-license-file"]
    command += ["--no-license-path", "--packages", *names]
    listed = run(command, "pip-licenses failed").replace("\nUNKNOWN\n", "\n")  # where a package brings no text
    python = Path(sysconfig.get_path("stdlib")) / "LICENSE.txt"
    ending = python.read_text(encoding="utf-8") if python.is_file() else "https://docs.python.org/3/license.html"
    libraries = ", ".join(sorted(path.name for path in internal.glob("lib*.so*") if not path.is_symlink())) or "none"
    head = _HEAD.format(python=sys.version.split()[0], libraries=libraries, sbom=SBOM)
    (folder / "NOTICES.txt").write_text(f"{head}{listed}\n\n{ending}\n", encoding="utf-8")
    known = {_plain(name) for name in names}
    command = [sys.executable, "-m", "cyclonedx_py", "environment", "--output-reproducible", sys.executable]
    bom = json.loads(run([*command, "--pyproject", "pyproject.toml", "-o", "-"], "cyclonedx-bom failed"))
    bom["components"] = [part for part in bom["components"] if _plain(part["name"]) in known]
    references = {part["bom-ref"] for part in bom["components"]}
    bom["dependencies"] = [one for one in bom["dependencies"] if one["ref"] in references]
    for one in bom["dependencies"]:
        one["dependsOn"] = [other for other in one.get("dependsOn", []) if other in references]
    (folder / SBOM).write_text(json.dumps(bom, indent=1), encoding="utf-8")


def _plain(name: str) -> str:
    return re.sub(r"[-_.]+", "-", name).lower()


def make_disk_image(app: Path) -> None:
    """Not run here: written for macOS, never executed. A compressed image with the .app and a link to Applications.

    The program is signed ad hoc. Without a warning Gatekeeper opens only programs that are signed with a Developer ID
    (`codesign --deep --options runtime --sign ID`) and notarised (`xcrun notarytool submit`), which needs an account.
    """
    with tempfile.TemporaryDirectory() as content:
        run(["ditto", str(app), f"{content}/{app.name}"], "ditto failed")  # keeps links and signatures
        (Path(content) / "Applications").symlink_to("/Applications")
        target = str(DIST / f"{bundle_name()}.dmg")
        run(
            ["hdiutil", "create", "-volname", TITLE, "-srcfolder", content, "-format", "UDZO", target], "hdiutil failed"
        )


def make_installer(bundle: Path) -> None:
    """Build the installer for Windows if NSIS is there. Raises SetupError if it fails."""
    compiler = shutil.which("makensis")
    if compiler is None:
        say("NSIS is not installed here, so there is no installer; the bundle and its .zip are complete.")
    else:
        run([compiler, *installer_words(bundle, WORK / "icons")], "NSIS failed")


def installer_words(bundle: Path, icons: Path) -> list[str]:
    """What NSIS is called with, which runs on Windows and on Linux."""
    defined = {
        "VERSION": VERSION,
        "NUMBERS": numbers(),
        "BUNDLE": bundle,
        "OUTPUT": f"{bundle}-setup.exe",
        "ICON": icons / f"{NAME}.ico",
        "SIZE_KB": sum(path.stat().st_size for path in bundle.rglob("*") if path.is_file()) // 1024,
    }
    options = ["-V2", "-WX", "-INPUTCHARSET", "UTF8", *(f"-D{name}={value}" for name, value in defined.items())]
    return [*options, str(ROOT / "packaging" / "windows" / "installer.nsi")]

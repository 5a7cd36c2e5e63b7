"""Writes the notices of the third-party code in Qt:  .venv/bin/python docs/generate/qt_notices.py FOLDER

Qt's documentation has one page for each third-party part (`qtgui-attribution-libpng.html`). FOLDER is where Debian's
packages qt6-base-doc-html, qt6-svg-doc-html and qt6-wayland-doc-html of the same Qt series are unpacked
(`dpkg-deb --extract`). Writes packaging/licences/qt/: a text for each part, and parts.json, which
packaging/enclosed_parts.py reads.
"""

import html
import json
import re
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import Final

ROOT: Final = Path(__file__).resolve().parents[2]
TARGET: Final = ROOT / "packaging" / "licences" / "qt"
SYSTEMS: Final = ("linux", "win32", "darwin")
_NOT_LINUX: Final = ("win32", "darwin")
NOT_SHIPPED: Final = frozenset(
    {
        "android-gradle-wrapper",
        "android-native-style",
        "dejayvu",  # for WebAssembly
        "extra-cmake-modules",  # builds Qt
        "kwin",  # builds Qt
        "libjpeg",  # the plugin qjpeg is not in the bundle
        "pixman",  # for ARM
    }
)
ONLY_ON: Final = {
    "cocoa-platform-plugin": ("darwin",),
    "d3d12memoryallocator": ("win32",),
    "forkfd": ("linux", "darwin"),
    # On Linux, Qt of the PySide6 wheels takes FreeType and zlib from the system.
    "freetype": _NOT_LINUX,
    "freetype-bdf": _NOT_LINUX,
    "freetype-pcf": _NOT_LINUX,
    "freetype-zlib": _NOT_LINUX,
    "libdbus-1-headers": ("linux",),
    "opengl-es2-headers": ("linux", "win32"),
    "opengl-headers": ("linux", "win32"),
    "qeventdispatcher-cf": ("darwin",),
    "rhi-miniengine-d3d12-mipmap": ("win32",),
    "wayland-ivi-extension-protocol": ("linux",),
    "xcb-xinput": ("linux",),
    "zlib": _NOT_LINUX,
}
MODULES: Final = {
    "qtcore": "Core",
    "qtdbus": "DBus",
    "qtgui": "Gui",
    "qtsvg": "Svg",
    "qtwaylandcompositor": "WaylandClient",  # the page describes a protocol
}
"""The folders with relevant pages, and the Qt library of their parts."""
SPDX: Final = {
    "Academic Free License v2.1, or GNU General Public License v2.0 or later": "AFL-2.1 OR GPL-2.0-or-later",
    "Apache License 2.0 or MIT License": "Apache-2.0 OR MIT",
    'BSD 2-clause "Simplified" License and Imlib2 License': "BSD-2-Clause AND Imlib2",
    'BSD 3-clause "New" or "Revised" License with PCRE2 binary-like Packages Exception': (
        "LicenseRef-BSD-3-Clause-with-PCRE2-Binary-Like-Packages-Exception"
    ),
    "Creative Commons Zero v1.0 Universal or Apache License 2.0": "CC0-1.0 OR Apache-2.0",
    "Freetype Project License or GNU General Public License v2.0 only": "FTL OR GPL-2.0-only",
    "International Color Consortium License": "LicenseRef-ICC-License",
    "MIT License and MIT Open Group variant": "MIT AND MIT-open-group",
    "Public Domain": "LicenseRef-Public-Domain",
    "X11 License and Historical Permission Notice and Disclaimer": "X11 AND HPND",
    "libpng License and PNG Reference Library version 2": "Libpng AND libpng-2.0",
}
"""SPDX ids of licences that the pages do not link."""


def _part(
    name: str, title: str, version: str | None, licence: str, library: str, systems: Sequence[str]
) -> dict[str, object]:
    return {
        "file": f"{name}.txt", "name": title, "version": version, "licence": licence, "library": library,
        "systems": list(systems),
    }  # fmt: skip


WAYLAND: Final = (
    _part("wayland", "Wayland core protocol", None, "MIT", "WaylandClient", ("linux",)),
    _part("wayland-protocols", "Wayland protocols", None, "MIT AND HPND-sell-variant", "WaylandClient", ("linux",)),
)
"""Not in Qt's documentation: texts of Debian's packages wayland and wayland-protocols."""


class Page:
    """One page of Qt's documentation."""

    def __init__(self, path: Path) -> None:
        self.name = _name(path)
        self.library = MODULES[path.parent.name]
        content = path.read_text(encoding="utf-8")
        title = _plain(_found(r'<h1 class="title">(.*?)</h1>', content))
        self.title, _, version = title.partition(", version ")
        self.version = version.removeprefix("Revision ").removeprefix("v") or None
        content = content[content.index('<div class="descr"') : content.index("<!-- @@@")]
        self.licence_name = _plain(re.findall(r"<p>((?:(?!<p>).)*?)\.</p>\s*<pre", content, re.DOTALL)[-1])
        linked = re.search(r'<p><a href="https://spdx\.org/licenses/([\w.-]+)\.html">', content)
        self.spdx = SPDX[self.licence_name] if self.licence_name in SPDX else _required(linked, path)[1]
        pieces = re.findall(r"<(p|pre)\b[^>]*>(.*?)</\1>", content, re.DOTALL)
        self.text = "\n\n".join(
            _plain(piece).strip("\n") if tag == "pre" else " ".join(_plain(piece).split())
            for tag, piece in pieces
            if "The sources can be found in" not in piece
        )


def _name(path: Path) -> str:
    return path.stem.partition("-attribution-")[2]


def _found(pattern: str, text: str) -> str:
    return _required(re.search(pattern, text, re.DOTALL), pattern)[1]


def _required(match: re.Match[str] | None, what: object) -> re.Match[str]:
    if match is None:
        raise SystemExit(f"{what}: not as Qt's documentation was when this was written.")
    return match


def _plain(text: str) -> str:
    return html.unescape(re.sub(r"<[^>]*>", "", text))


def main(folder: Path) -> int:
    paths = [
        path
        for path in sorted(folder.rglob("*-attribution-*.html"))
        if path.parent.name in MODULES and _name(path) not in NOT_SHIPPED
    ]
    pages = [Page(path) for path in paths]
    version = _found(r"qt6-base-(\d+\.\d+\.\d+)", next(p for p in paths if p.parent.name == "qtgui").read_text("utf-8"))
    kept = {part["file"] for part in WAYLAND}
    for old in TARGET.glob("*.txt") if TARGET.exists() else ():
        if old.name not in kept:
            old.unlink()
    TARGET.mkdir(parents=True, exist_ok=True)
    for page in pages:
        text = f"{page.title}\n{'=' * len(page.title)}\n\n{page.text}\n"
        lines = (line.rstrip() for line in text.splitlines())
        (TARGET / f"{page.name}.txt").write_text("\n".join(lines).rstrip() + "\n", encoding="utf-8", newline="\n")
    parts = [
        _part(page.name, page.title, page.version, page.spdx, page.library, ONLY_ON.get(page.name, SYSTEMS))
        for page in pages
    ]
    parts += WAYLAND
    listed = {"documentation": version, "parts": parts}
    text = json.dumps(listed, indent=2, ensure_ascii=False)
    (TARGET / "parts.json").write_text(text + "\n", encoding="utf-8", newline="\n")
    print(f"{len(parts)} parts of Qt {version} in {TARGET.relative_to(ROOT)}")
    return 0


if __name__ == "__main__":
    if len(sys.argv) != 2 or not Path(sys.argv[1]).is_dir():
        sys.exit(__doc__)
    sys.exit(main(Path(sys.argv[1])))

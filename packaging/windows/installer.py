"""Builds the installer for Windows with NSIS, which runs on Windows and Linux, from installer.nsi."""

import shutil
from collections.abc import Iterator
from pathlib import Path

from environment import run, say
from file_types import FILE_TYPES, FileType
from release import Release

SCRIPT = Path(__file__).with_name("installer.nsi")
FILE_TYPES_NAME = "file-types.nsh"


def make_installer(release: Release, bundle: Path, dist: Path, icons: Path) -> Path | None:
    """Build it; None if NSIS is not installed. Raises SetupError if it fails."""
    compiler = shutil.which("makensis")
    if compiler is None:
        say("NSIS is not installed here, so there is no installer; the bundle and its .zip are complete.")
        return None
    target, file_types = dist / f"{bundle.name}-setup.exe", icons / FILE_TYPES_NAME
    write_file_types(file_types)
    words = arguments(release, bundle, target, icons / "dps-s-configurator.ico", file_types)
    run([compiler, *words], "NSIS failed")
    return target


def arguments(release: Release, bundle: Path, target: Path, icon: Path, file_types: Path) -> list[str]:
    """Arguments of makensis."""
    numbers = [int("".join(filter(str.isdigit, part)) or 0) for part in release.version.split("+")[0].split(".")]
    size = sum(path.stat().st_size for path in bundle.rglob("*") if path.is_file())
    defined = {
        "VERSION": release.version,
        "NUMBERS": ".".join(map(str, [*numbers, 0, 0, 0, 0][:4])),
        "BUNDLE": str(bundle),
        "OUTPUT": str(target),
        "ICON": str(icon),
        "FILE_TYPES": str(file_types),
        "SIZE_KB": str(size // 1024),
    }
    return ["-V2", "-WX", *(f"-D{name}={value}" for name, value in defined.items()), str(SCRIPT)]


def write_file_types(target: Path) -> None:
    """Write the part of the script that registers and removes the file types."""
    text = "\n".join([
        *(line for file_type in FILE_TYPES for line in _names(file_type)),
        "!macro REGISTER_FILE_TYPES",
        *(f"  {line}" for file_type in FILE_TYPES for line in _registration(file_type)),
        "!macroend",
        "!macro REMOVE_FILE_TYPES",
        *(f"  {line}" for file_type in FILE_TYPES for line in _removal(file_type)),
        "!macroend",
        "",
    ])  # fmt: skip
    target.write_text(text, encoding="utf-8-sig")  # without a BOM NSIS on Windows assumes the ANSI code page


def _class_of(file_type: FileType) -> str:
    """Its ProgID."""
    return f"DPS-S.{file_type.key}"


def _names(file_type: FileType) -> Iterator[str]:
    yield f'LangString TYPE_{file_type.key} ${{LANG_ENGLISH}} "{file_type.english}"'
    yield f'LangString TYPE_{file_type.key} ${{LANG_SIMPCHINESE}} "{file_type.chinese}"'


def _registration(file_type: FileType) -> Iterator[str]:
    own, program = f'HKCU "${{CLASSES}}\\{_class_of(file_type)}', "$INSTDIR\\dps-s-window.exe"
    yield f'WriteRegStr {own}" "" "$(TYPE_{file_type.key})"'
    yield f'WriteRegStr {own}\\DefaultIcon" "" "{program},0"'
    yield f'WriteRegStr {own}\\shell\\open\\command" "" \'"{program}" "%1"\''
    for ending in file_type.mime_types:
        yield f'WriteRegStr HKCU "${{CLASSES}}\\{ending}\\OpenWithProgids" "{_class_of(file_type)}" ""'
        if file_type.is_own:
            yield f'WriteRegStr HKCU "${{CLASSES}}\\{ending}" "" "{_class_of(file_type)}"'


def _removal(file_type: FileType) -> Iterator[str]:
    """Keeps the entries of other programs."""
    yield f'DeleteRegKey HKCU "${{CLASSES}}\\{_class_of(file_type)}"'
    for ending in file_type.mime_types:
        key = f'HKCU "${{CLASSES}}\\{ending}'
        yield f'DeleteRegValue {key}\\OpenWithProgids" "{_class_of(file_type)}"'
        yield f'DeleteRegKey /ifnosubkeys /ifnovalues {key}\\OpenWithProgids"'
        if file_type.is_own:
            yield f'ReadRegStr $0 {key}" ""'
            yield f'StrCmp $0 "{_class_of(file_type)}" 0 +2'
            yield f'DeleteRegValue {key}" ""'
        yield f'DeleteRegKey /ifnosubkeys /ifnovalues {key}"'

"""Opens profiles by dialog, recent list or drop; saves the current settings as one."""

from collections.abc import Sequence
from functools import partial
from pathlib import Path

from PySide6.QtCore import QObject, Signal
from PySide6.QtWidgets import QMenu, QWidget

from app.settings.profile_file import ProfileRefused, read_profile, refusal_text, save_profile
from app.settings.profiles import Profile, profile_of
from app.text.i18n import tr
from protocol.catalogue import SERIAL_OUTPUT, SETTINGS
from protocol.translatable import marked
from ui.files.file_dialogs import AskOpen, AskPath, ask_path, ask_profile
from ui.files.file_opener import add_recent
from ui.services.context import Services
from ui.services.job_notice import JobNotice
from ui.services.page_header import PageHeader
from ui.style.theme import Meaning
from ui.widgets.naming import named

SUFFIX = ".toml"


class ProfileFiles(QObject):
    """Entries of the page's menu."""

    opened = Signal(object, object)
    """`Profile` and path."""
    refused = Signal(object, object)
    """Path and `ProfileRefused`."""

    def __init__(self, services: Services, page: QWidget, header: PageHeader, result: JobNotice) -> None:
        super().__init__(page)
        self.ask_open: AskOpen = ask_profile
        self.ask_save: AskPath = ask_path
        self._page, self._result = page, result
        self._connector, self._remembered = services.connector, services.preferences
        self.open = header.add_rare("profile_open", marked("Open profile…"), self.choose)
        self.recent = header.add_rare("profile_recent", marked("Recent profiles"), self._fill_menu)
        self.menu = named(QMenu(page), "profile_recent_menu")
        self.recent.setMenu(self.menu)
        self.save = header.add_rare("profile_save", marked("Save as profile…"), self.choose_and_save)
        self.menu.aboutToShow.connect(self._fill_menu)

    def refresh(self) -> None:
        self.recent.setEnabled(bool(self._remembered.recent_profiles))

    def choose(self) -> None:
        """The profile is for the module that is shown when it is asked for."""
        asked = self._connector.current, self._connector.adapter_key

        def open_file(path: Path) -> None:
            if asked == (self._connector.current, self._connector.adapter_key):
                self.open_file(path)
            else:
                self._result.notify(Meaning.ATTENTION, lambda: tr("Another module is shown now: nothing was opened."))

        self.ask_open(self._page, self._remembered.profile_folder, open_file)

    def open_file(self, path: Path) -> None:
        """Emits `opened` or `refused`."""
        try:
            profile = read_profile(path)
        except ProfileRefused as refusal:
            if not path.exists():
                self._remove_recent(path)
            self.refused.emit(path, refusal)
            return
        self._remember(path)
        self.opened.emit(profile, path)

    def choose_and_save(self) -> None:
        """Saves the module's current settings where any are known."""
        now = self._connector.clock()
        profile = profile_of(self._connector.device, now, name=tr("Profile"))
        if not profile.settings:
            self._result.notify(Meaning.ATTENTION, lambda: tr("No settings known: read them first."))
            return
        suggested = self._remembered.profile_folder / f"profile{SUFFIX}"
        save = partial(self._save, profile)
        self.ask_save(self._page, tr("Save as profile…"), suggested, tr("Profile (*.toml)"), save)

    def _save(self, profile: Profile, path: Path) -> None:
        try:
            save_profile(path, Profile(name=path.stem or tr("Profile"), settings=profile.settings))
        except (OSError, ProfileRefused) as error:
            fault = error  # the name of an except clause ends with it
            self._result.notify(
                Meaning.DANGER, lambda: tr("{path} was not saved: {why}.", path=path, why=refusal_text(fault))
            )
            return
        self._remember(path)
        missing = [one.title for one in SETTINGS if one.key not in profile.settings and one is not SERIAL_OUTPUT]
        self._result.notify(Meaning.GOOD, lambda: _saved_text(path, [tr(title) for title in missing]))

    def _remember(self, path: Path) -> None:
        self._remembered.add_profile(path)
        self.refresh()

    def _remove_recent(self, path: Path) -> None:
        name = str(path.absolute())
        self._remembered.recent_profiles = tuple(one for one in self._remembered.recent_profiles if one != name)
        self.refresh()

    def _fill_menu(self) -> None:
        self.menu.clear()
        add_recent(self.menu, "profile_recent", self._remembered.recent_profiles, self.open_file)


def _saved_text(path: Path, missing: Sequence[str]) -> str:
    if not missing:
        return tr("Saved as {path}.", path=path)
    return tr("Saved as {path}. Unknown, left out: {names}.", path=path, names=", ".join(missing))

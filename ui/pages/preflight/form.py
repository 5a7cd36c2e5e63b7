"""Form of the Pre-flight page: person, module, aircraft, profile."""

from collections.abc import Callable
from contextlib import suppress
from pathlib import Path
from typing import Final

from PySide6.QtCore import Qt, Signal
from PySide6.QtGui import QShowEvent
from PySide6.QtWidgets import QLineEdit, QMenu, QSizePolicy, QToolButton, QWidget

from app.records.filing import aircraft_of
from app.settings.profiles import Profile
from app.store.fact_store import Store
from app.store.opening import StoreTrouble
from app.text.i18n import tr
from app.text.messages import MAX_TEXT_LENGTH, clean, labelled
from ui.files.file_dialogs import AskOpen, add_recent, ask_profile
from ui.services.context import Services
from ui.services.job_notice import JobNotice
from ui.session.name_question import ModuleField
from ui.style.icons import Icon, icon
from ui.widgets.controls import captioned_row, named, without_key

MAX_NAME_LENGTH: Final = 80


class PreflightForm(QWidget):
    """`changed`: an entry changed. `edit_wanted`: the profile, or a new one, is to be edited."""

    changed = Signal()
    edit_wanted = Signal()

    def __init__(self, services: Services, result: JobNotice) -> None:
        super().__init__()
        self.setObjectName("preflight_form")
        self._services, self._result = services, result
        self.ask_open: AskOpen = ask_profile
        self.profile: Profile | None = None
        # The profile's file.
        self.path: Path | None = None
        self.who = named(QLineEdit(services.preferences.who), "preflight_who")
        self.who.setAccessibleName(tr("Checked by"))
        self.who.setMaxLength(MAX_NAME_LENGTH)
        self.name_field = ModuleField("preflight_module", services.ports)
        self.aircraft = named(QLineEdit(), "preflight_aircraft")
        self.aircraft.setMaxLength(MAX_TEXT_LENGTH)
        self.aircraft.setAccessibleName(tr("Aircraft"))
        self.choose = named(QToolButton(), "preflight_profile")
        self.choose.setIcon(icon(Icon.CHEVRON_DOWN))
        self.choose.setPopupMode(QToolButton.ToolButtonPopupMode.InstantPopup)
        self.choose.setToolButtonStyle(Qt.ToolButtonStyle.ToolButtonTextBesideIcon)
        self.choose.setLayoutDirection(Qt.LayoutDirection.RightToLeft)  # the arrow behind the name
        self.choose.setSizePolicy(QSizePolicy.Policy.Ignored, QSizePolicy.Policy.Fixed)
        self.menu = named(QMenu(self.choose), "preflight_profile_menu")
        self.menu.aboutToShow.connect(self._fill_menu)
        self.choose.setMenu(self.menu)
        # Person and aircraft, as they were entered last.
        self.committed = self._entered()
        self.enter_aircraft()
        self.who.editingFinished.connect(self.commit)
        self.aircraft.editingFinished.connect(self.commit)
        fields = (
            (tr("Checked by"), self.who),
            (tr("Module"), self.name_field),
            (tr("Aircraft"), self.aircraft),
            (tr("Profile"), self.choose),
        )
        self.setLayout(captioned_row(*fields))
        self.show_profile()

    def commit(self) -> None:
        entered = self._entered()
        if entered != self.committed:
            self.committed = entered
            self._services.preferences.who = entered[0]
            self.changed.emit()

    def commit_edits(self) -> None:
        """Commit what is typed in a field that still has the focus, as when a key starts the check."""
        self.name_field.apply()
        self.commit()

    def _entered(self) -> tuple[str, str]:
        return clean(self.who.text().strip()), clean(self.aircraft.text().strip())

    # The aircraft

    def clear_aircraft(self) -> None:
        """Another module is shown."""
        self.aircraft.clear()
        self.commit()

    def enter_aircraft(self) -> None:
        """That of the module's last check."""
        store, module = self._services.storage.store, self._services.ports.module.name
        if not module or self.aircraft.text():
            return
        if isinstance(store, Store):
            with suppress(StoreTrouble):
                self.aircraft.setText(store.read(lambda facts: aircraft_of(facts, module)))
                self.commit()

    # The profile

    def use_profile(self, path: Path) -> None:
        profile = self._result.read_profile(path)
        if profile is not None:
            self._services.preferences.add_profile(path)
            self._use(profile, path)

    def read_again(self) -> bool:
        """What another page or program wrote into the file since; False where it is no profile any more, which is
        said."""
        profile = None if self.path is None else self._result.read_profile(self.path)
        if profile is not None and profile != self.profile:
            self._use(profile, self.path)
        return self.path is None or profile is not None

    def _use(self, profile: Profile | None, path: Path | None) -> None:
        self.profile, self.path = profile, path
        self.show_profile()
        self.changed.emit()

    def show_profile(self) -> None:
        self._services.in_use.use(self.profile)
        self._services.exchange.limits_used.emit()
        name = tr("Vendor's advice") if self.profile is None else clean(self.profile.name, longest=40)
        self.choose.setText(without_key(name))
        whole = labelled(tr("Profile"), name)
        self.choose.setToolTip(whole)
        self.choose.setAccessibleName(whole)

    def choose_file(self) -> None:
        self.ask_open(self, self._services.preferences.profile_folder, self.use_profile)

    def _fill_menu(self) -> None:
        self.menu.clear()
        self._add("preflight_profile_none", tr("Vendor's advice"), lambda: self._use(None, None))
        add_recent(self.menu, "preflight_profile", self._services.preferences.recent_profiles, self.use_profile)
        self.menu.addSeparator()
        self._add("preflight_profile_open", tr("Open profile…"), self.choose_file)
        words = tr("New profile…") if self.profile is None else tr("Edit profile…")
        self._add("preflight_profile_edit", words, self.edit_wanted.emit)

    def _add(self, name: str, text: str, act: Callable[[], object]) -> None:
        action = named(self.menu.addAction(text), name)
        action.setToolTip(text)
        action.triggered.connect(lambda _is_checked=False: act())

    # Qt

    def showEvent(self, event: QShowEvent) -> None:
        """Who was named on another page meanwhile checks here, too."""
        super().showEvent(event)
        if not self.who.text():
            self.who.setText(self._services.preferences.who)
            self.commit()

; Not run here: written for Windows, never executed by us. Needs Inno Setup 6.3 or later.
; packaging/windows/installer.py calls it; by hand:
;   ISCC /DAppVersion=0.1.0 /DBundle=dist\NAME /DOutput=dist /DOutputName=setup /DIcons=build\package\icons windows.iss

#ifndef AppVersion
  #error AppVersion is not given: pyproject.toml states it, and packaging/windows/installer.py passes it on
#endif
#ifndef Bundle
  #error Bundle is not given: the folder that PyInstaller made
#endif

#define AppName "DPS-S Configurator"

[Setup]
; The same for every version, so that a new one replaces the old.
AppId={{6E1C2B4A-7C0F-4B35-9C53-9D6A1F0E8D21}
AppName={#AppName}
AppVersion={#AppVersion}
AppVerName={#AppName} {#AppVersion}
AppPublisher=The DPS-S Configurator authors
VersionInfoVersion={#AppVersion}
LicenseFile={#Bundle}\licences\dps-s-configurator\LICENSE.txt
DefaultDirName={autopf}\{#AppName}
DefaultGroupName={#AppName}
DisableProgramGroupPage=yes
UninstallDisplayIcon={app}\dps-s-window.exe
UninstallDisplayName={#AppName}
; For this user alone, without an administrator, unless chosen otherwise.
PrivilegesRequired=lowest
PrivilegesRequiredOverridesAllowed=dialog
ArchitecturesAllowed=x64compatible
ArchitecturesInstallIn64BitMode=x64compatible
MinVersion=10.0.17763
; An upgrade asks to close a running window instead of failing on its files.
CloseApplications=yes
RestartApplications=no
SetupIconFile={#Icons}\dps-s-configurator.ico
OutputDir={#Output}
OutputBaseFilename={#OutputName}
Compression=lzma2/max
SolidCompression=yes
WizardStyle=modern

[Languages]
Name: "english"; MessagesFile: "compiler:Default.isl"

[Tasks]
Name: "desktopicon"; Description: "{cm:CreateDesktopIcon}"; GroupDescription: "{cm:AdditionalIcons}"; Flags: unchecked

[InstallDelete]
; Files of an older version that the new one no longer has would be loaded in place of nothing.
Type: filesandordirs; Name: "{app}\_internal"
Type: filesandordirs; Name: "{app}\licences"

[Files]
Source: "{#Bundle}\*"; DestDir: "{app}"; Flags: ignoreversion recursesubdirs createallsubdirs

[Icons]
Name: "{group}\{#AppName}"; Filename: "{app}\dps-s-window.exe"
Name: "{autodesktop}\{#AppName}"; Filename: "{app}\dps-s-window.exe"; Tasks: desktopicon

[Registry]
; "dps-s" in the Run box and "start dps-s" in a console find the program; PATH stays as it is.
Root: HKA; Subkey: "Software\Microsoft\Windows\CurrentVersion\App Paths\dps-s.exe"; ValueType: string; ValueName: ""; ValueData: "{app}\dps-s.exe"; Flags: uninsdeletekey

[Run]
Filename: "{app}\dps-s-window.exe"; Description: "{cm:LaunchProgram,{#AppName}}"; Flags: nowait postinstall skipifsilent

; The installer of DPS-S Configurator for Windows, for the user alone and without administrator rights.
; packaging/bundle.py calls makensis with VERSION, NUMBERS (four of them), BUNDLE, OUTPUT, ICON and SIZE_KB.
!ifdef TARGET ; a 64-bit setup, where NSIS has that: Debian's has, that of its makers has not
  Target ${TARGET}
!endif
Unicode true
!include "MUI2.nsh"

!define TITLE "DPS-S Configurator"
!define NAME "dps-s-configurator"
!define UNINSTALL "Software\Microsoft\Windows\CurrentVersion\Uninstall\${NAME}"
!define CLASSES "Software\Classes"

Name "${TITLE}"
OutFile "${OUTPUT}"
RequestExecutionLevel user
InstallDir "$LOCALAPPDATA\Programs\${TITLE}"
InstallDirRegKey HKCU "${UNINSTALL}" "InstallLocation"
SetCompressor /SOLID lzma
ManifestDPIAware true
BrandingText "${TITLE} ${VERSION}"
VIProductVersion "${NUMBERS}"
VIAddVersionKey "ProductName" "${TITLE}"
VIAddVersionKey "FileDescription" "${TITLE} setup"
VIAddVersionKey "FileVersion" "${VERSION}"
VIAddVersionKey "ProductVersion" "${VERSION}"
VIAddVersionKey "LegalCopyright" "MIT licence"

!define MUI_ICON "${ICON}"
!define MUI_UNICON "${ICON}"
!define MUI_ABORTWARNING
!define MUI_FINISHPAGE_RUN "$INSTDIR\dps-s-window.exe"
!insertmacro MUI_PAGE_LICENSE "${BUNDLE}/LICENSE.txt"
!insertmacro MUI_PAGE_DIRECTORY
!insertmacro MUI_PAGE_INSTFILES
!insertmacro MUI_PAGE_FINISH
!insertmacro MUI_UNPAGE_CONFIRM
!insertmacro MUI_UNPAGE_INSTFILES
!insertmacro MUI_LANGUAGE "English"
!insertmacro MUI_LANGUAGE "SimpChinese"

LangString IN_USE ${LANG_ENGLISH} "${TITLE} is running. Close it, then try again."
LangString IN_USE ${LANG_SIMPCHINESE} "DPS-S 上位机正在运行。请先关闭，然后重试。"
LangString TYPE_Profile ${LANG_ENGLISH} "Profile"
LangString TYPE_Profile ${LANG_SIMPCHINESE} "配置文件"
LangString TYPE_Flight ${LANG_ENGLISH} "Session or flight log"
LangString TYPE_Flight ${LANG_SIMPCHINESE} "数据记录或飞行日志"
LangString TYPE_Record ${LANG_ENGLISH} "Pre-flight record"
LangString TYPE_Record ${LANG_SIMPCHINESE} "飞行前检查记录"

; The types of files that the program opens, and what is done with each.
!macro FILE_TYPES DO
  !insertmacro ${DO} Profile .toml
  !insertmacro ${DO} Flight .ulg
  !insertmacro ${DO} Flight .bin
  !insertmacro ${DO} Flight .csv
  !insertmacro ${DO} Flight .tsv
  !insertmacro ${DO} Flight .tlog
  !insertmacro ${DO} Flight .log
  !insertmacro ${DO} Flight .txt
  !insertmacro ${DO} Flight .mcap
  !insertmacro ${DO} Record .json
  !insertmacro ${DO} Record .pdf
!macroend

!macro REGISTER CLASS ENDING
  WriteRegStr HKCU "${CLASSES}\DPS-S.${CLASS}" "" "$(TYPE_${CLASS})"
  WriteRegStr HKCU "${CLASSES}\DPS-S.${CLASS}\DefaultIcon" "" "$INSTDIR\dps-s-window.exe,0"
  WriteRegStr HKCU "${CLASSES}\DPS-S.${CLASS}\shell\open\command" "" '"$INSTDIR\dps-s-window.exe" "%1"'
  WriteRegStr HKCU "${CLASSES}\${ENDING}\OpenWithProgids" "DPS-S.${CLASS}" ""
!macroend

!macro REMOVE CLASS ENDING ; keeps the entries of other programs
  DeleteRegKey HKCU "${CLASSES}\DPS-S.${CLASS}"
  DeleteRegValue HKCU "${CLASSES}\${ENDING}\OpenWithProgids" "DPS-S.${CLASS}"
  DeleteRegKey /ifnosubkeys /ifnovalues HKCU "${CLASSES}\${ENDING}\OpenWithProgids"
  DeleteRegKey /ifnosubkeys /ifnovalues HKCU "${CLASSES}\${ENDING}"
!macroend

!macro FILE_TYPES_HAVE_CHANGED
  System::Call 'shell32::SHChangeNotify(i 0x08000000, i 0, p 0, p 0)' ; SHCNE_ASSOCCHANGED
!macroend

Section
  SetOutPath "$INSTDIR"
  ; Files of an older version that the new one no longer has would be loaded in place of nothing.
  ClearErrors
  IfFileExists "$INSTDIR\dps-s-window.exe" 0 free
    Delete "$INSTDIR\dps-s-window.exe"
    IfErrors 0 free
    MessageBox MB_OK|MB_ICONSTOP "$(IN_USE)" /SD IDOK
    Abort "$(IN_USE)"
  free:
  RMDir /r "$INSTDIR\_internal"
  RMDir /r "$INSTDIR\licences"
  File /r "${BUNDLE}/*"
  WriteUninstaller "$INSTDIR\uninstall.exe"

  CreateShortcut "$SMPROGRAMS\${TITLE}.lnk" "$INSTDIR\dps-s-window.exe"

  ; "dps-s" in the Run box and "start dps-s" in a console find the program; PATH stays as it is.
  WriteRegStr HKCU "Software\Microsoft\Windows\CurrentVersion\App Paths\dps-s.exe" "" "$INSTDIR\dps-s.exe"

  !insertmacro FILE_TYPES REGISTER
  !insertmacro FILE_TYPES_HAVE_CHANGED

  WriteRegStr HKCU "${UNINSTALL}" "DisplayName" "${TITLE}"
  WriteRegStr HKCU "${UNINSTALL}" "DisplayVersion" "${VERSION}"
  WriteRegStr HKCU "${UNINSTALL}" "DisplayIcon" "$INSTDIR\dps-s-window.exe"
  WriteRegStr HKCU "${UNINSTALL}" "InstallLocation" "$INSTDIR"
  WriteRegStr HKCU "${UNINSTALL}" "UninstallString" '"$INSTDIR\uninstall.exe"'
  WriteRegStr HKCU "${UNINSTALL}" "QuietUninstallString" '"$INSTDIR\uninstall.exe" /S'
  WriteRegDWORD HKCU "${UNINSTALL}" "EstimatedSize" ${SIZE_KB}
  WriteRegDWORD HKCU "${UNINSTALL}" "NoModify" 1
  WriteRegDWORD HKCU "${UNINSTALL}" "NoRepair" 1
SectionEnd

Section "Uninstall"
  ClearErrors
  Delete "$INSTDIR\dps-s-window.exe"
  IfErrors 0 free
    MessageBox MB_OK|MB_ICONSTOP "$(IN_USE)" /SD IDOK
    Abort "$(IN_USE)"
  free:
  ; Only what the installer brought: the user's data lies elsewhere, and what a user put here stays.
  RMDir /r "$INSTDIR\_internal"
  RMDir /r "$INSTDIR\licences"
  Delete "$INSTDIR\dps-s.exe"
  Delete "$INSTDIR\sbom.cdx.json"
  Delete "$INSTDIR\LICENSE.txt"
  Delete "$INSTDIR\NOTICES.txt"
  Delete "$INSTDIR\uninstall.exe"
  RMDir "$INSTDIR"
  Delete "$SMPROGRAMS\${TITLE}.lnk"
  DeleteRegKey HKCU "Software\Microsoft\Windows\CurrentVersion\App Paths\dps-s.exe"
  !insertmacro FILE_TYPES REMOVE
  !insertmacro FILE_TYPES_HAVE_CHANGED
  DeleteRegKey HKCU "${UNINSTALL}"
SectionEnd

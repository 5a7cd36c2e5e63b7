"""The commands of dps-s archive: status, sync, export, import, conflicts, settle, report."""

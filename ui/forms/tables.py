"""Common behaviour of all tables: whole rows are selected, nothing is edited in place."""

from PySide6.QtWidgets import QAbstractItemView, QHeaderView, QTableView


def list_rows(table: QTableView, *, row_px: int) -> None:
    """Rows of one height without numbers; Tab leaves the table, so that the keyboard is never caught in it."""
    table.setSelectionBehavior(QAbstractItemView.SelectionBehavior.SelectRows)
    table.setSelectionMode(QAbstractItemView.SelectionMode.ExtendedSelection)
    table.setVerticalScrollMode(QAbstractItemView.ScrollMode.ScrollPerPixel)
    table.setHorizontalScrollMode(QAbstractItemView.ScrollMode.ScrollPerPixel)
    table.setEditTriggers(QAbstractItemView.EditTrigger.NoEditTriggers)
    table.setShowGrid(False)
    table.setWordWrap(False)
    table.setTabKeyNavigation(False)
    rows = table.verticalHeader()
    rows.hide()
    rows.setSectionResizeMode(QHeaderView.ResizeMode.Fixed)
    rows.setDefaultSectionSize(row_px)
    table.horizontalHeader().setHighlightSections(False)

"""Printing a report in a background thread."""

from threading import Thread

from PySide6.QtCore import QMessageLogContext, QtMsgType, qInstallMessageHandler

from ui.files.report_printer import print_report

_PAGE = (
    "<table width='100%' border='1'>"
    + "<tr><td>CHUTE_A</td><td>NO-GO: the cell voltage is low</td></tr>" * 70
    + "</table>"
)


def test_a_report_printed_in_a_background_thread_causes_no_warning_of_qt(qapp: object) -> None:
    said: list[str] = []
    printed: list[bytes] = []

    def hear(_kind: QtMsgType, _context: QMessageLogContext, text: str) -> None:
        said.append(text)

    before = qInstallMessageHandler(hear)
    try:
        thread = Thread(target=lambda: printed.append(print_report(_PAGE, b"{}")))
        thread.start()
        thread.join()
    finally:
        qInstallMessageHandler(before)
    assert [one[:5] for one in printed] == [b"%PDF-"]
    assert said == []

"""Statistics of the link since the connection began."""

from typing import Final

from PySide6.QtWidgets import QFormLayout, QFrame, QLabel, QWidget

from app.text.i18n import tr
from app.text.sentences import in_brackets, labelled
from protocol.translatable import marked
from ui.services.context import Services
from ui.style.theme import Space
from ui.widgets.controls import named, set_role
from ui.widgets.labels import SELECTABLE, TickingLabel
from ui.widgets.layouts import in_column
from ui.widgets.visibility_timer import VisibilityTimer

REFRESH_EVERY_MS: Final = 500
# The share of requests without reply from which a warning is shown.
LOSS_ATTENTION: Final = 0.01
_FIGURES: Final = (
    ("sent", marked("Requests")),
    ("lost", marked("Without reply")),
    ("trip", marked("Round trip")),
    ("late", marked("95th percentile")),
    ("slowest", marked("Slowest answer")),
    ("lag", marked("Lag")),
    ("restarts", marked("Restarts")),
    ("losses", marked("Port lost")),
    ("rejected", marked("Invalid bytes")),
    ("reasons", marked("Why")),
)


def percent_text(share: float) -> str:
    """ "0 %", "0.03 %", "12 %"."""
    percent = share * 100
    return f"{percent:.0f} %" if percent >= 10 or not percent else f"{percent:.2g} %"


class StatisticsView(QWidget):
    def __init__(self, services: Services) -> None:
        super().__init__()
        self.setObjectName("link_figures_view")
        self._ports = services.ports
        self.figures: dict[str, QLabel] = {}
        card = named(QFrame(), "figures_card", "card")
        form = QFormLayout(card)
        form.setHorizontalSpacing(Space.XL)
        for key, english in _FIGURES:
            figure = self.figures[key] = named(TickingLabel(), f"figures_{key}")
            figure.setTextInteractionFlags(SELECTABLE)
            figure.setAccessibleName(tr(english))
            form.addRow(named(QLabel(tr(english)), f"figures_{key}_name", "muted"), figure)
        in_column(card, 1, of=self, spacing=Space.S, margins=(Space.M, Space.S))
        VisibilityTimer(self, self.refresh, every_ms=REFRESH_EVERY_MS)

    def refresh(self) -> None:
        statistics, lag_s = self._ports.module.statistics, self._ports.module.view.lag_s
        totals = statistics.totals
        share = min(1.0, totals.time_outs / totals.sent) if totals.sent else 0.0
        texts = {
            "sent": f"{totals.sent:,}",
            "lost": f"{totals.time_outs:,}{in_brackets(percent_text(share))}" if totals.sent else "—",
            "lag": "—" if lag_s is None else f"{lag_s:.2f} s",
            "restarts": f"{totals.restarts:,}",
            "losses": f"{statistics.losses:,}",
            "rejected": f"{totals.rejected:,}",
            "reasons": "\n".join(
                labelled(tr(why.value), f"{n:,}") for why, n in totals.rejected_bytes.most_common() if n
            ),
        }
        for key, quantile in (("trip", 0.5), ("late", 0.95), ("slowest", 1.0)):
            trip_s = statistics.quantile_s(quantile)
            texts[key] = "—" if trip_s is None else f"{trip_s * 1000:.1f} ms"
        for key, text in texts.items():
            self.figures[key].setText(text)
        warned = {"lost": share > LOSS_ATTENTION, "rejected": totals.rejected > 0, "losses": statistics.losses > 0}
        for key, is_warned in warned.items():
            set_role(self.figures[key], "attention" if is_warned else "")

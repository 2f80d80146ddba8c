"""What the participant's page says of itself once a second: kept with the press, and told when it is news."""

from __future__ import annotations

from emg2vsa.session.views import ScreenReport

TOLD_S, NEWS_S = 10.0, 1.0
"A screen without news is told to the journal so often; one with news no more often."
HIDDEN = "The participant's page is hidden. Bring it to the front, full screen."


class Screens:
    """The reports since the last START, and which of all are to be told."""

    def __init__(self) -> None:
        self._last: ScreenReport | None = None
        self._of_press: list[ScreenReport] = []
        self._told_s = -TOLD_S
        self._news = False

    def begin(self) -> None:
        """A press begins; a page that is hidden then is hidden in it."""
        self._of_press = [self._last] if self._last is not None and self._last.hidden else []

    def take(self, report: ScreenReport, now_s: float) -> tuple[bool, bool]:
        """Whether the page has just been hidden, and whether the report is to be told."""
        before, self._last = self._last, report
        self._of_press.append(report)
        news = before is None or before.hidden != report.hidden
        self._news |= news
        told = now_s - self._told_s >= (NEWS_S if self._news else TOLD_S)
        if told:
            self._told_s, self._news = now_s, False
        return news and report.hidden, told

    @property
    def age_ms(self) -> float | None:
        """Of the force on the page since the press began (95 %); None without a page."""
        return max((report.age_p95_ms for report in self._of_press), default=None)

    @property
    def hidden(self) -> bool:
        """Whether the page was, since the press began."""
        return any(report.hidden for report in self._of_press)

"""What the participant's page says of itself once a second: kept with the press, and told when it is news."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from emg2vsa.session.views import ScreenReport

TOLD_S, NEWS_S = 10.0, 1.0
"A screen without news is told to the journal so often; one with news no more often."
COMMAND_MS = 50.0
"Time from command to frame in 95 % of all cases. Later frames are told with a remedy."
HIDDEN = "The participant's page is hidden. Bring it to the front, full screen."


class Screens:
    """The reports since the last START, and which of all are to be told."""

    def __init__(self) -> None:
        self._last: ScreenReport | None = None
        self._of_press: list[ScreenReport] = []
        self._told_s = -TOLD_S
        self._news = False
        self._command_ms: list[float] = []
        self._told_commands = 0

    def begin(self) -> None:
        """A press begins; a page that is hidden then is hidden in it."""
        self._of_press = [self._last] if self._last is not None and self._last.hidden else []

    def take(self, report: ScreenReport, now_s: float) -> tuple[bool, ScreenReport | None]:
        """Whether the page has just been hidden, and the report as it is to be told at ``now_s``, s, with all commands
        since the last one; None where it is not."""
        before, self._last = self._last, report
        self._of_press.append(report)
        news = before is None or before.hidden != report.hidden
        self._command_ms += report.command_ms
        self._news |= news or bool(report.command_ms)
        told = now_s - self._told_s >= (NEWS_S if self._news else TOLD_S)
        if not told:
            return news and report.hidden, None
        self._told_s, self._news = now_s, False
        new = tuple(self._command_ms[self._told_commands :])
        self._told_commands = len(self._command_ms)
        return news and report.hidden, replace(report, command_ms=new)

    @property
    def commands(self) -> str:
        """How soon all commands were on the page, in a sentence; "" without any."""
        if not self._command_ms:
            return ""
        p95_ms = float(np.percentile(self._command_ms, 95))
        late = f" {COMMAND_MS:g} ms are wanted: close other programs." if p95_ms > COMMAND_MS else ""
        return f"From command to frame: 95 % of {len(self._command_ms)} within {p95_ms:.0f} ms.{late}"

    @property
    def age_ms(self) -> float | None:
        """Age, ms, of the force on the page since the press began (95 %); None without a page."""
        return max((report.age_p95_ms for report in self._of_press), default=None)

    @property
    def hidden(self) -> bool:
        """Whether the page was, since the press began."""
        return any(report.hidden for report in self._of_press)

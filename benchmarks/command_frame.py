"""From a command to the frame that shows it, by the page's own frame times, in a real browser and in real time.

Run as ``python -m benchmarks.command_frame``; it prints Markdown. ``emg2vsa session --virtual`` is a process of its
own; Chromium without a window shows both pages, the participant's at 1920 x 1080 px, and draws them with the processor.
The operator's part is a presenter's forward key. ``chrt -r 1 python -m ...`` keeps other programs away.
"""

from __future__ import annotations

import os
import re
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator
from pathlib import Path

import numpy as np

from benchmarks.bench.record import print_page
from benchmarks.browser import Window, running
from benchmarks.small_study import SIMULATED_SESSION, small_study
from emg2vsa.session.journal import JOURNAL_FILE, read_journal
from emg2vsa.session.views import ScreenReport

PARTICIPANT, TASK, MOST_S, BOUNCE_S = "P03", "press", 300.0, 0.5
STUDY = small_study(
    participants=[PARTICIPANT], specimens=["S1", "S5"], task=TASK, simulation="seed = 5\n",
    tables=f"[session]\n{SIMULATED_SESSION}repetitions = 6\npause_s = 1.0\nrest_s = 1.0\n",
)  # fmt: skip
BUTTON = """(() => { const button = document.querySelector("#primary");
  return [button.querySelector("b").textContent, !button.matches(":disabled, .early")]; })()"""


def press_all(operator: Window) -> None:
    """Do what the large button says until the session is over."""
    end_s = time.monotonic() + MOST_S
    while time.monotonic() < end_s:
        label, ready = operator.value(BUTTON)
        if label == "Session is over":
            return
        if ready:
            operator.key("PageDown")
            time.sleep(BOUNCE_S)
            if label == "End session":
                return
        time.sleep(0.05)
    raise SystemExit(operator.text())


def played(folder: Path) -> list[ScreenReport]:
    """What the participant's page told of itself in a session of twelve presses."""
    (folder / "study.toml").write_text(STUDY)
    command = [sys.executable, "-m", "emg2vsa.cli", "session", "study.toml", "--participant", PARTICIPANT, "--virtual"]
    with subprocess.Popen(
        [*command, "--port", "0"], cwd=folder, text=True, stdout=subprocess.PIPE, stderr=subprocess.STDOUT,
        env=os.environ | {"PYTHONUNBUFFERED": "1"},
    ) as session, running(folder / "browser") as browser:  # fmt: skip
        assert session.stdout is not None
        at = dict(re.findall(r"(\w+): +(http://\S+)", session.stdout.readline() + session.stdout.readline()))
        operator = browser.open(at["operator"])
        browser.open(at["participant"], 1920, 1080).until("document.body.dataset.look !== 'lost'")
        press_all(operator)
        session.communicate(timeout=120)
    raw = folder / "data" / "sourcedata" / f"sub-{PARTICIPANT}" / TASK
    return [line.event for line in read_journal(raw / JOURNAL_FILE)[0] if isinstance(line.event, ScreenReport)]


def page() -> Iterator[str]:
    busy = os.getloadavg()[0]
    with tempfile.TemporaryDirectory(prefix="command_frame_", ignore_cleanup_errors=True) as folder:
        reports = played(Path(folder))
    yield "# From a command to its frame\n"
    yield __doc__.partition("\n\n")[2].replace("``", "`")
    policy = {os.SCHED_RR: "real-time priority", os.SCHED_OTHER: "ordinary priority"}[os.sched_getscheduler(0)]
    yield f"Load of the two cores {busy:.1f} before, {os.getloadavg()[0]:.1f} after; {policy}; no graphics card.\n"
    yield "| | number | p50 | p95 | largest |"
    yield "|---|---:|---:|---:|---:|"
    commands = [ms for report in reports for ms in report.command_ms]
    for name, values in (
        ("from command to frame, ms", commands),
        ("longest frame of a second, ms", [report.longest_frame_ms for report in reports]),
        ("age of the force shown, p95 of a second, ms", [report.age_p95_ms for report in reports]),
    ):
        p50, p95 = np.percentile(values, (50, 95))
        yield f"| {name} | {len(values)} | {p50:.1f} | {p95:.1f} | {max(values):.1f} |"


if __name__ == "__main__":
    print_page(__doc__, page)

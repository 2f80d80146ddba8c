"""A short session with an emulated participant, from the first page to the last press, and its pictures.

EMG2VSA_PICTURES=docs/images renews those of the documentation.
"""

from __future__ import annotations

import os
import re
import subprocess
import sys
import time
from pathlib import Path

import pytest

from benchmarks.browser import CHROMIUM, running
from benchmarks.small_study import SIMULATED_SESSION, small_study

pytestmark = [
    pytest.mark.realtime,
    pytest.mark.slow,
    pytest.mark.skipif(CHROMIUM is None, reason="Chromium is not installed"),
]
STUDY = small_study(
    name="palpation",
    title="Softness study",
    participants=["P03"],
    simulation="seed = 1\n",
    tables=f"""
[window]
force_n = [0.5, 7.0]
expected_trials = 2
[hypotheses]
kept_specimens = ["S1", "S5"]
[profile]
participant = "P03"
specimens = ["S1", "S3", "S5"]
[session]
{SIMULATED_SESSION}
training_specimens = ["T1"]
training_repetitions = 1
repetitions = 2
pause_s = 2
""",
)
LABEL = "document.querySelector('#primary b').textContent"
READY = "!document.querySelector('#primary').matches(':disabled, .early')"
WORD = "document.querySelector('#word').textContent"
METER = "+document.querySelector('#bar').getAttribute('aria-valuenow')"
LOOK = "document.body.dataset.look"


class Operator:
    """Does with the forward key of a presenter what the large button says, until it says something else."""

    def __init__(self, window):
        self.window = window

    def forward(self, *until, within_s=20.0):
        """What the button says then."""
        end_s = time.monotonic() + within_s
        while True:
            label, ready = self.window.value(f"[{LABEL}, {READY}]")
            if label in until:
                return label
            assert time.monotonic() < end_s, self.window.text()
            if ready:
                self.window.key("PageDown")
                time.sleep(0.45)  # sooner it would be taken for a key that bounces
            time.sleep(0.05)


def test_a_session_from_its_first_page_to_its_last_press(tmp_path):
    pictures = Path(os.environ.get("EMG2VSA_PICTURES", tmp_path))
    study = tmp_path / "study.toml"
    study.write_text(STUDY, encoding="utf-8")
    mistakes = ["--mistake", "aborted@2", "--mistake", "too-fast@3"]
    words = ["session", str(study), "--participant", "P03", "--virtual", "--port", "0", *mistakes]
    command = [sys.executable, "-m", "emg2vsa.cli", *words]
    with (
        subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as session,
        running(tmp_path / "browser") as browser,
    ):
        try:
            addresses = [re.search(r"http://\S+", session.stdout.readline())[0] for _ in range(2)]
            window, participant = browser.open(addresses[0]), browser.open(addresses[1], 1920, 1080)
            operator = Operator(window)
            operator.forward("Specimen is placed")
            assert window.value("document.querySelector('#specimen').textContent") == "T1"
            operator.forward("START", within_s=30)

            window.key("PageDown")
            participant.until(f"{LOOK} === 'start'", 3)
            participant.picture(pictures / "session-start.png", 0.5)
            participant.until(f"{METER} > 3.2 && {LOOK} === 'rise'")
            participant.picture(pictures / "session-press.png", 0.5)
            participant.until(f"{LOOK} === 'stop' && {WORD} === 'STOP'")
            participant.picture(pictures / "session-stop.png", 0.5)
            assert "T1" not in participant.value("document.documentElement.outerHTML")

            operator.forward("Specimen is placed")
            first = window.value("document.querySelector('#specimen').textContent")
            assert first in ("S1", "S3", "S5")
            assert first not in participant.value("document.documentElement.outerHTML")
            window.size(1280, 800, "dark")
            operator.forward("Tick: electrodes and cables in place")
            window.picture(pictures / "session-checklist-dark.png", 0.8)
            window.size(1280, 800)
            operator.forward("Repeat press", within_s=60)  # the press that ended at 4 N
            assert window.value("document.querySelector('#judged').textContent").startswith("✕ Not usable")
            window.size(420, 880)
            time.sleep(0.3)
            window.picture(pictures / "session-verdict-420.png")
            window.size(1280, 800)
            for _ in range(2):  # the repeated press, and one that is too fast
                operator.forward("Pressing", within_s=60)
                window.until(f"{LABEL} !== 'Pressing'")
            operator.forward("Pressing", within_s=60)
            participant.until(f"{METER} > 4.5")
            window.picture(pictures / "session-operator.png", 0.8)
            participant.size(420, 800)
            participant.until(f"{METER} < 0.1")
            operator.forward("Pressing", within_s=60)
            participant.until(f"{METER} > 3")
            participant.picture(pictures / "session-press-420.png")
            operator.forward("End session", within_s=90)
            assert "6 of 6 presses" in window.text()
            window.key("PageDown")
            window.until("document.querySelector('#message').textContent.startsWith('The session is over: completed')")
            participant.until(f"{WORD} === 'Finished. Thank you!'")
            told, _ = session.communicate(timeout=60)
        finally:
            session.kill()
    assert "recordings: 4" in told
    assert session.returncode in (0, 1)
    for picture in pictures.glob("session-*.png"):
        assert picture.stat().st_size < 200_000

"""Real EMG as the carrier of presses: nothing is said of a good one, and a channel that is none is refused."""

from __future__ import annotations

import numpy as np
import pytest

from benchmarks.public_recordings import CARRIERS, FILES, WITH_FORCE, channels, judged, pressed


@pytest.mark.parametrize("name", ["knee, grid channel 1", "bursts of one muscle", "no EMG: slow sensor"])
def test_a_public_recording_as_carrier(name: str) -> None:
    case = CARRIERS[name]
    if not (FILES / case.file).is_file():
        pytest.skip(f"{case.file} is not here")
    (channel,), _ = channels(case)
    emg, force = pressed(channel, 0.0, 1.0, 1)
    _, session, ratio = judged([emg], force, "P", "S")
    if name.startswith("no EMG"):
        assert session.verdict == "unreadable"
    else:
        assert (session.verdict, session.advice) == ("good", ())
        assert np.mean(ratio) == pytest.approx(1.0, abs=0.1)


def test_a_file_with_its_own_force_that_begins_in_a_grip_says_so() -> None:
    case = WITH_FORCE["grip, 5 s"]
    if not (FILES / case.file).is_file():
        pytest.skip(f"{case.file} is not here")
    emg, force = channels(case)
    assert force is not None
    _, session, _ = judged(emg, force, "P", "S")
    assert session.verdict == "repeat"
    assert "record begins at" in session.advice[1].text

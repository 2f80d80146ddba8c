"""Sources that send half of their samples, zeros or one value are named on the operator's page within 2 s."""

from __future__ import annotations

import numpy as np
import pytest

from emg2vsa.devices.streams import StreamInfo
from emg2vsa.errors import SettingError
from emg2vsa.session.liveness import Liveness
from emg2vsa.worlds.people.mistakes import parse_mistakes
from tests.session.conftest import play_in

INFO = StreamInfo("emg", ("EDC", "FDS"), "V", 1000.0)


@pytest.mark.parametrize(
    ("mistake", "told"),
    [
        ("zeros:FDS@0", "EMG: FDS sends one value only, 0 V: check its sensor and its cable."),
        ("half-rate@0", "samples a second come, 1000 are stated"),
    ],
)
def test_a_source_that_is_wrong_from_the_start_is_named_before_the_first_press(tmp_path, mistake, told) -> None:
    seen: list[tuple[float, str]] = []

    def beside(desk, now_s: float) -> None:
        texts = [device.text for device in desk.operator()[1].devices if told in device.text]
        if texts and not seen:
            seen.append((now_s, texts[0]))
        if now_s > 2.0:
            desk.session.end()

    play_in(tmp_path, mistake, beside=beside, operator=False)
    assert seen
    assert seen[0][0] < 2.0


def test_radio_frames_that_are_lost_reject_their_press(tmp_path) -> None:
    played = play_in(tmp_path, "radio-loss@1", most_presses=4)
    rejected = [problems for verdict, problems in played.verdicts.values() if verdict == "rejected"]
    assert len(rejected) == 1
    assert any("of the samples are lost" in problem for problem in rejected[0])


def test_what_a_stream_sends_in_the_last_second_is_told() -> None:
    rng = np.random.default_rng(1)
    liveness = Liveness(INFO, 0.0)
    for turn in range(400):
        samples = rng.normal(size=(5, 2))
        samples[:, 1] = np.nan if turn > 205 else samples[:, 1]
        liveness.take(samples, 0.005 * turn)
        if turn == 200:
            assert list(liveness.problems(1.0)) == []
    told = "FDS sends no values: check that its sensor is paired, charged and switched on."
    assert list(liveness.problems(1.995)) == [told]
    assert list(liveness.problems(9.0)) == []


def test_mistakes_before_the_first_press_are_of_sensors() -> None:
    muscles = {"EDC": 1.0, "FDS": 1.0}
    assert [mistake.press for mistake in parse_mistakes(["zeros:FDS@0"], muscles)] == [0]
    for wrong in ("dips@0", "zeros@0-3", "mains:FDS@1"):
        with pytest.raises(SettingError, match="--mistake"):
            parse_mistakes([wrong], muscles)

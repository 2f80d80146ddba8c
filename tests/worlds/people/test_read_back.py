"""Every format through the project's own readers: one study reads what it simulated, in volts and newtons."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from emg2vsa.readers.roles import read_roles
from emg2vsa.settings import ChannelSettings, EmgChannelSettings, ForceChannelSettings
from emg2vsa.study import Study
from emg2vsa.worlds.people.plan import plan_study
from emg2vsa.worlds.people.study import Format, simulate_study

Make = Callable[..., Study]
RELATIVE_ERROR = {"bids": 2e-7, "csv": 6e-9, "emgworks": 6e-7, "c3d": 7e-8}
"""Largest error of a sample over the largest sample of its channel."""
PLAIN = ChannelSettings(
    emg={"EDC": EmgChannelSettings(name="EDC", unit="V"), "FDS": EmgChannelSettings(name="FDS", unit="V")},
    force=ForceChannelSettings(name="Fz", unit="N", sign=-1),
)
AMPLIFIED = ChannelSettings(
    emg={
        "EDC": EmgChannelSettings(name="Bagnoli sensor 1: EDC", unit="mV", gain=1000.0),
        "FDS": EmgChannelSettings(name="Bagnoli sensor 2: FDS", unit="V", gain=100.0),
    },
    force=ForceChannelSettings(name="Load Cell: Fz", unit="%MVC", newtons_per_unit=0.8),
)


@pytest.mark.parametrize(
    ("format", "channels"),
    [*((format, PLAIN) for format in RELATIVE_ERROR), *((format, AMPLIFIED) for format in ("csv", "emgworks", "c3d"))],
)
def test_the_readers_return_what_was_simulated(
    study_with: Make, tmp_path: Path, format: Format, channels: ChannelSettings
) -> None:
    study = study_with(channels=channels, repetitions=1)
    path = simulate_study(study, tmp_path, format=format).recordings[-1]
    settings, plan = plan_study(study)
    recording = plan[-1].make(settings)
    read = read_roles(path, None, channels)
    for true, channel in [(recording.emg_v["EDC"], read.emg["EDC"]), (recording.emg_v["FDS"], read.emg["FDS"])]:
        assert channel.unit == "V"
        assert channel.fs_hz == pytest.approx(1000.0, rel=1e-9)
        assert channel.samples == pytest.approx(true, abs=RELATIVE_ERROR[format] * np.max(np.abs(true)))
    limit = RELATIVE_ERROR[format] * np.max(np.abs(recording.force_n))
    assert read.force.unit == "N"
    assert read.force.samples == pytest.approx(recording.force_n, abs=limit)

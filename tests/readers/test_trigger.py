"""A trigger that both files recorded puts them on one clock, or says why it cannot."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from emg2vsa.errors import RecordingError
from emg2vsa.readers.roles import read_roles
from emg2vsa.settings import ChannelSettings, EmgChannelSettings, ForceChannelSettings

EDGES_S = np.array([0.5, 2.0, 4.5])


def write(path: Path, fs_hz: float, late_s: float, edges_s=EDGES_S, name="e1 (mV)", trigger="TTL") -> Path:
    """Six seconds of a clock that shows ``late_s`` less; the trigger stays up for 0.1 s from each edge."""
    time_s = np.arange(0, 6, 1 / fs_hz)
    up = np.any((time_s + late_s >= edges_s[:, None]) & (time_s + late_s < edges_s[:, None] + 0.1), axis=0)
    rows = [f"{t:.6f},{np.sin(t):.6f},{5.0 * u:g}" for t, u in zip(time_s, up, strict=True)]
    path.write_text("\n".join([f"time (s),{name},{trigger}", *rows]) + "\n")
    return path


def channels(trigger=("TTL", "TTL")) -> ChannelSettings:
    force = ForceChannelSettings(name="Fz", trigger=trigger)
    return ChannelSettings(emg={"EDC": EmgChannelSettings(name="e1")}, force=force)


@pytest.mark.parametrize("late_s", [0.25, -0.4])
def test_force_is_moved_to_the_clock_of_the_emg(tmp_path: Path, late_s: float) -> None:
    emg = write(tmp_path / "emg.csv", 1000.0, 0.0)
    force = write(tmp_path / "force.csv", 200.0, late_s, name="Fz (N)")
    roles = read_roles(emg, force, channels())
    assert roles.force.start_s == pytest.approx(late_s, abs=0.005)
    assert "3 edges" in roles.notes[-1]
    assert "of the trigger in both files" in roles.notes[-1]


def test_clocks_without_time_in_common_meet_by_the_trigger(tmp_path: Path) -> None:
    emg = write(tmp_path / "emg.csv", 1000.0, 0.0)
    force = tmp_path / "force.csv"
    rows = write(force, 200.0, 0.0, name="Fz (N)").read_text().splitlines()
    moved = [f"{float(row.split(',')[0]) + 3600:.6f},{row.split(',', 1)[1]}" for row in rows[1:]]
    force.write_text("\n".join([rows[0], *moved]) + "\n")
    assert read_roles(emg, force, channels()).force.start_s == pytest.approx(0, abs=0.005)


@pytest.mark.parametrize(
    ("edges_s", "wanted", "found"),
    [
        (np.array([0.5, 2.0]), "3 rising edges", "found 2"),
        (np.array([0.5, 2.1, 4.5]), "as far apart", "difference of 100 ms"),
        (np.array([20.0]), "rising edge", "0 to 0 without one"),
    ],
)
def test_triggers_that_differ_are_refused(tmp_path: Path, edges_s, wanted: str, found: str) -> None:
    emg = write(tmp_path / "emg.csv", 1000.0, 0.0)
    force = write(tmp_path / "force.csv", 200.0, 0.0, edges_s, name="Fz (N)")
    with pytest.raises(RecordingError) as refused:
        read_roles(emg, force, channels())
    assert wanted in str(refused.value)
    assert found in str(refused.value)
    assert "force.csv, channel 'TTL'" in str(refused.value)


def test_one_file_needs_no_trigger_and_an_unknown_channel_is_named(tmp_path: Path) -> None:
    emg = write(tmp_path / "emg.csv", 1000.0, 0.0, trigger="Fz (N)")
    with pytest.raises(RecordingError, match="Remove trigger"):
        read_roles(emg, None, channels())
    force = write(tmp_path / "force.csv", 200.0, 0.0, name="Fz (N)")
    emg = write(tmp_path / "emg.csv", 1000.0, 0.0)
    with pytest.raises(RecordingError, match="'Sync'"):
        read_roles(emg, force, channels(("TTL", "Sync")))


@pytest.mark.parametrize("edges_s", [EDGES_S, EDGES_S[:1]])
def test_a_trigger_of_the_other_polarity_is_turned(tmp_path: Path, edges_s) -> None:
    emg = write(tmp_path / "emg.csv", 1000.0, 0.0, edges_s)
    force = write(tmp_path / "force.csv", 200.0, 0.25, edges_s, name="Fz (N)")
    rows = force.read_text().splitlines()
    turned = [f"{row.rsplit(',', 1)[0]},{5 - float(row.rsplit(',', 1)[1]):g}" for row in rows[1:]]
    force.write_text("\n".join([rows[0], *turned]) + "\n")
    roles = read_roles(emg, force, channels())
    assert roles.force.start_s == pytest.approx(0.25, abs=0.005)
    assert "it falls in the file of the force" in roles.notes[-1]


def test_pulses_of_another_length_are_refused(tmp_path: Path) -> None:
    emg = write(tmp_path / "emg.csv", 1000.0, 0.0)
    force = write(tmp_path / "force.csv", 200.0, 0.0, name="Fz (N)")
    head, *rows = force.read_text().splitlines()
    longer = [
        f"{row.rsplit(',', 1)[0]},{5 * any(0 <= i / 200 - e < 0.15 for e in EDGES_S)}" for i, row in enumerate(rows)
    ]
    force.write_text("\n".join([head, *longer]) + "\n")
    with pytest.raises(RecordingError, match=r"pulses as long as those of channel 'TTL'.* a difference of 5\d ms"):
        read_roles(emg, force, channels())

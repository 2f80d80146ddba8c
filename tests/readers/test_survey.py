"""What a file's channels probably are."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from emg2vsa.errors import RecordingError
from emg2vsa.readers.survey import survey
from emg2vsa.settings import SimulationSettings
from emg2vsa.worlds.people.recording import RecordingStream

MADE = RecordingStream(
    np.random.SeedSequence(1), SimulationSettings(repetitions=3), a_v=40e-6, b_v=20e-6, window_n=(0.5, 7)
).whole()
N = MADE.force_n.size
TIME = np.arange(N) / 1000
RNG = np.random.default_rng(1)


def write(tmp_path: Path, columns: dict[str, np.ndarray]) -> Path:
    path = tmp_path / "a.csv"
    np.savetxt(path, np.column_stack(list(columns.values())), "%.9g", ",", header=",".join(columns), comments="")
    return path


def test_names_and_units_are_not_needed(tmp_path: Path) -> None:
    path = write(
        tmp_path,
        {
            "time": TIME, "a": MADE.emg_v["EDC"], "b": MADE.emg_v["FDS"], "c": -30 * MADE.force_n + 5,
            "d": np.zeros(N), "e": np.arange(N), "f": (TIME % 4 > 2) * 5.0, "g": np.sin(TIME / 3),
        },
    )  # fmt: skip
    facts = survey(path)
    assert [c.role for c in facts.channels] == ["EMG", "EMG", "force", "other", "other", "other", "other"]
    assert facts.force is not None
    assert (facts.force.name, facts.force.sign) == ("c", -1)
    assert "it changes with the EMG, r = -" in facts.force.guess
    said = [c.guess.partition(":")[0] for c in facts.channels[3:]]
    assert said == ["flat", "a count or a time", "a trigger", "slow"]


@pytest.mark.parametrize(("grams", "role"), [(100.0, "force"), (0.1, "other")])
def test_large_values_in_g_are_a_weight_and_small_ones_an_acceleration(tmp_path: Path, grams: float, role: str) -> None:
    columns = {"time": TIME, "EDC (mV)": 1e3 * MADE.emg_v["EDC"], "hx (g)": grams * MADE.force_n}
    assert survey(write(tmp_path, columns)).channels[1].role == role


def test_figures_of_a_channel(tmp_path: Path) -> None:
    emg = MADE.emg_v["EDC"] + 30e-6 * np.sin(2 * np.pi * 50 * TIME)
    clipped = np.clip(MADE.emg_v["FDS"], -5e-5, 5e-5)
    facts = survey(write(tmp_path, {"time (s)": TIME, "e (V)": emg, "h (V)": clipped, "Fz (N)": MADE.force_n}))
    hum, clip, force = facts.channels
    assert hum.mains_share > 0.2
    assert clip.clip_share == pytest.approx(np.mean(np.abs(clipped) == 5e-5), rel=0.3)
    assert clip.mains_share < 0.05
    assert (force.low, force.high) == (pytest.approx(MADE.force_n.min()), pytest.approx(MADE.force_n.max()))
    assert force.noise == pytest.approx(0.02, rel=0.15)  # the simulation's force noise
    assert force.guess.startswith("looks like the force: ")
    assert (force.sign, force.duration_s) == (1, N / 1000)


def test_hum_is_no_muscle(tmp_path: Path) -> None:
    hum = 1e-4 * np.sin(2 * np.pi * 50 * TIME) + RNG.normal(0, 1e-5, N)
    plain, named = survey(write(tmp_path, {"time (s)": TIME, "ch 2 (V)": hum, "EMG 2 (V)": hum})).channels
    assert (plain.role, plain.guess) == ("other", "mains hum: was anything connected?")
    assert (named.role, named.guess) == ("EMG", "EMG, by its name, but 98 % of its power is mains")


def test_the_upright_force_of_several_is_taken(tmp_path: Path) -> None:
    noise = {f"F{axis} (N)": RNG.normal(0, 1, N) for axis in "xy"}
    facts = survey(write(tmp_path, {"time (s)": TIME, **noise, "Fz (N)": MADE.force_n, "EMG (V)": MADE.emg_v["EDC"]}))
    assert facts.force is not None
    assert facts.force.name == "Fz"


def test_a_rate_that_is_stated(tmp_path: Path) -> None:
    path = write(tmp_path, {"EMG (V)": MADE.emg_v["EDC"], "Fz (N)": MADE.force_n})
    assert "state it with --fs" in survey(path).channels[0].guess
    assert [c.role for c in survey(path, fs_hz=1000.0).channels] == ["EMG", "force"]


def test_a_channel_that_cannot_be_read_costs_itself_only(tmp_path: Path) -> None:
    path = tmp_path / "a.csv"
    rows = "".join(f"{i / 1000},{i % 3},{'x' if i == 50 else i % 5}\n" for i in range(100))
    path.write_text("time (s),EDC (mV),bad\n" + rows)
    good, bad = survey(path).channels
    assert (good.fault, good.n_samples) == ("", 100)
    assert "found 'x'" in bad.fault


def test_a_file_that_is_none(tmp_path: Path) -> None:
    (tmp_path / "a.csv").write_bytes(b"\x00\x01\x02")
    with pytest.raises(RecordingError):
        survey(tmp_path / "a.csv")


@pytest.mark.parametrize(
    ("name", "emg", "force"),
    [
        ("c3d/btk_PiG_Motion-FlatFoot-Full.c3d", 10, "Fz2"),
        ("delsys_csv/emgio_emgworks_verbose_truncated.csv", 2, None),
        ("emg_force/openhdemg_otb_testfile_VL64_force.mat", 64, "acquired data"),
    ],
)
def test_real_files(shared_data, name: str, emg: int, force: str | None) -> None:
    facts = survey(shared_data(f"emg/{name}"))
    assert len(facts.emg) == emg
    assert (facts.force.name if facts.force else None) == force


def test_a_clock_that_counts_from_1970_costs_no_memory(tmp_path: Path) -> None:
    guesses = []
    for begin_s in (0.0, 1.7e9):
        path = tmp_path / "a.csv"
        columns = np.column_stack([begin_s + TIME, next(iter(MADE.emg_v.values())), MADE.force_n])
        np.savetxt(path, columns, ("%.3f", "%.9g", "%.9g"), ",", header="time (s),EDC (V),Fz (N)", comments="")
        guesses.append([facts.guess for facts in survey(path).channels])
    assert guesses[0] == guesses[1]

"""What is wrong with a muscle's signal is told before the first press."""

from __future__ import annotations

import numpy as np
import pytest

from emg2vsa.recordings import Channel
from emg2vsa.session.quality import measured
from emg2vsa.settings import FilterSettings
from emg2vsa.worlds.people.signals import emg_carrier

FS_HZ = 1000.0


def muscle(name, level_v, seconds, seed, change=lambda x, t: x):
    rng = np.random.default_rng(seed)
    n = round(seconds * FS_HZ)
    x = level_v * emg_carrier(rng, n, FS_HZ) + 1.2e-6 * rng.standard_normal(n)
    return Channel(name, change(x, np.arange(n) / FS_HZ), "V", FS_HZ, 0.0, "")


def rest(**changes):
    return {m: muscle(m, 1.5e-6, 10, i, changes.get(m, lambda x, t: x)) for i, m in enumerate(("EDC", "FDS"))}


def contraction(**changes):
    return {m: muscle(m, 200e-6, 3, 9 + i, changes.get(m, lambda x, t: x)) for i, m in enumerate(("EDC", "FDS"))}


def test_two_good_muscles_have_levels_and_no_problem():
    for view in measured(rest(), contraction(), FilterSettings(), 5e-3):
        assert view.problems == ()
        assert view.contraction_v == pytest.approx(200e-6, rel=0.3)
        assert view.snr_db == pytest.approx(40, abs=3)


def test_before_the_contraction_only_the_rest_is_known():
    (view, _) = measured(rest(), None, FilterSettings(), None)
    assert view.rest_v is not None
    assert view.contraction_v is None
    assert view.snr_db is None


MAINS = {"EDC": lambda x, t: x + 20e-6 * np.sin(2 * np.pi * 50 * t)}
OFF = {"EDC": lambda x, t: 4e-3 * np.sin(2 * np.pi * 50 * t)}


@pytest.mark.parametrize(
    ("resting", "contracting", "said"),
    [
        (MAINS, {}, "mains is"),
        (OFF, {}, "mV of hum"),
        ({"EDC": lambda x, t: 0 * x + 3e-6}, {}, "EDC is flat"),
        ({"EDC": lambda x, t: x + 8e-6 * np.random.default_rng(5).standard_normal(x.size)}, {}, "loud at rest"),
        ({"EDC": lambda x, t: x + 30e-6 * np.random.default_rng(5).standard_normal(x.size)}, {}, "far too loud"),
        ({}, {"EDC": lambda x, t: np.clip(30 * x, -5e-3, 5e-3)}, "EDC clips"),
        ({}, {"EDC": lambda x, t: x * 0.015}, "over rest at maximum contraction"),
    ],
)
def test_each_fault_is_told_of_its_muscle_alone_with_what_to_do(resting, contracting, said):
    bad, good = measured(rest(**resting), contraction(**contracting), FilterSettings(), 5e-3)
    assert any(said in problem for problem, _ in bad.problems), bad.problems
    assert all(do for _, do in bad.problems)
    assert good.problems == ()


def test_channels_joined_by_gel_are_told():
    channels = contraction()
    joined = channels["EDC"].samples + 0.05 * channels["FDS"].samples
    channels["FDS"] = Channel("FDS", joined, "V", FS_HZ, 0.0, "")
    bad, _ = measured(rest(), channels, FilterSettings(), None)
    assert any("EDC and FDS are one signal" in problem for problem, _ in bad.problems)


def test_too_short_a_rest_is_a_problem_and_no_crash():
    short = {m: Channel(m, np.zeros(5), "V", FS_HZ, 0.0, "") for m in ("EDC", "FDS")}
    assert all(view.problems for view in measured(short, None, FilterSettings(), None))

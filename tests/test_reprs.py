"""What a notebook shows of a product is one short line, its answer first."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np

import casr
from casr.contact_area import initial_area
from casr.flow.region import Region
from casr.pins import detect_pins
from emg2vsa.extraction.extract import extract_trials
from emg2vsa.fits import fit_trials
from emg2vsa.profiles import Profile, Profiles
from emg2vsa.recordings import Channel
from emg2vsa.run_scores import RunScores
from emg2vsa.schedules.build import build_schedules
from emg2vsa.settings import (
    CocontractionSettings,
    FilterSettings,
    FitSettings,
    ForceChannelSettings,
    ScheduleSettings,
    SimulationSettings,
    WindowSettings,
)
from emg2vsa.study_file import load_study
from emg2vsa.worlds.people.recording import RecordingStream

ROOT = Path(__file__).resolve().parent.parent


def are_short(shown: list[object]) -> None:
    for one in shown:
        assert len(repr(one)) < 200
        assert "array(" not in repr(one)
        assert repr(one).startswith(f"{type(one).__name__}(")


def test_reprs_of_a_press() -> None:
    press = casr.simulate_press()
    sequence = press.sequence()
    score = casr.score(sequence)
    pins = detect_pins(sequence[0])
    area = initial_area(pins, pins.centroids_px * 1.05, rule="circle")
    region = Region.circle(150, 150, 40)
    are_short([press, sequence, score, score.rate, score.initial, pins, area, region])
    assert score.rate is not None
    assert f"{score.rate.value:.4g} mm2/N" in repr(score.rate)
    assert f"{len(sequence)} frames" in repr(sequence)
    assert f"{area.area_px2:.4g} px2 by rule circle" in repr(area)
    assert "about (150.0, 150.0) px" in repr(region)


def test_reprs_of_people(run_of: Callable[..., RunScores]) -> None:
    made = RecordingStream(
        np.random.SeedSequence(4), SimulationSettings(repetitions=2), a_v=2e-5, b_v=8e-6, window_n=(0.5, 7.0)
    ).whole()
    emg = {name: Channel(name, samples, "V", made.fs_hz, 0.0, "V") for name, samples in made.emg_v.items()}
    trials = extract_trials(
        emg, Channel("Fz", made.force_n, "N", made.fs_hz, 0.0, "N"), participant="P01", specimen="S1",
        filters=FilterSettings(), cocontraction=CocontractionSettings(), window=WindowSettings(),
        force_channel=ForceChannelSettings(name="Fz"), notes=(),
    )  # fmt: skip
    fits = fit_trials(trials, FitSettings(), WindowSettings())
    force_n = np.linspace(0.5, 7, 50)
    profile = Profile("S1", 7.63, 4e-5, 2e-5, force_n, 4e-5 + 2e-5 * np.log(force_n), "measured", 9, force_n)
    profiles = Profiles((profile,), None, np.nan, None, None, None, (), "P01", "V", ())
    schedules = build_schedules(profiles, ScheduleSettings(), {})
    study, run = load_study(ROOT / "studies" / "palpation" / "study.toml"), run_of("S1", 0.0, "modular")
    are_short([trials, fits, profiles, *schedules, study, run])
    assert repr(trials).startswith("Trials(P01 S1: 2 presses")
    assert f"median b {np.median(fits.b_v):.4g} V" in repr(fits)
    assert "'palpation', default mode: 14 participants" in repr(study)
    assert f"median CASR {np.median(run.casr[run.algorithm]):.4g} mm2/N" in repr(run)

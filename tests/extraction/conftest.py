"""Continuous records of presses, trials out of them, and trials by hand."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from emg2vsa.extraction import Trials
from emg2vsa.extraction.extract import extract_trials
from emg2vsa.recordings import Channel
from emg2vsa.settings import CocontractionSettings, FilterSettings, ForceChannelSettings, WindowSettings
from emg2vsa.signals.bias import BiasBudget
from emg2vsa.signals.delays import DelayBudget
from tests.made_traits import unknown

FS_HZ = 1000.0
RISE = [(0, 0), (2.6, 7.6), (2.9, 7.6), (3.6, 0)]


def force_of(*presses, rest_s=2.0, fs_hz=FS_HZ, start_s=0.0):
    """Newtons at ``fs_hz`` from ``start_s`` on: rest, then each press as (seconds, newtons) knots, then rest."""
    knots, at = [(0.0, 0.0)], rest_s
    for press in presses:
        knots += [(at + t, f) for t, f in press]
        at += press[-1][0] + rest_s
    times, values = zip(*knots, strict=True)
    return np.interp(np.arange(start_s, at, 1 / fs_hz), times, values)


def emg_of(force_n, share, seed, fs_hz=FS_HZ):
    """Volts: Gaussian noise that follows force, on a rest tone of 1.5 uV."""
    rng = np.random.default_rng(seed)
    level_v = share * (3e-6 + 30e-6 * np.log1p(np.maximum(force_n, 0)))
    return level_v * rng.standard_normal(force_n.size)


def channel(samples, unit="V", fs_hz=FS_HZ, start_s=0.0):
    return Channel(unit, np.asarray(samples, dtype=float), unit, fs_hz, start_s, "as stored")


def recorded(force_n, *, emg=None, fs_hz=FS_HZ):
    emg = emg or {"EDC": emg_of(force_n, 0.4, 1, fs_hz), "FDS": emg_of(force_n, 0.6, 2, fs_hz)}
    return {name: channel(samples, "V", fs_hz) for name, samples in emg.items()}, channel(force_n + 0.3, "N", fs_hz)


def extract(emg, force, **settings):
    chosen = {
        "filters": FilterSettings(),
        "cocontraction": CocontractionSettings(),
        "window": WindowSettings(),
        "force_channel": ForceChannelSettings(name="Fz"),
        **settings,
    }
    return extract_trials(emg, force, participant="P01", specimen="S1", **chosen)


def one_press(change_emg=None, change_force=None, press=RISE, **settings):
    force_n = force_of(press)
    emg, force = recorded(force_n)
    if change_emg:
        emg["EDC"] = replace(emg["EDC"], samples=change_emg(emg["EDC"].samples.copy()))
    if change_force:
        force = replace(force, samples=change_force(force.samples.copy()))
    return extract(emg, force, **settings)


@pytest.fixture(name="force_of")
def give_force_of():
    return force_of


@pytest.fixture(name="emg_of")
def give_emg_of():
    return emg_of


@pytest.fixture(name="channel")
def give_channel():
    return channel


@pytest.fixture(name="recorded")
def give_recorded():
    return recorded


@pytest.fixture(name="extract")
def give_extract():
    return extract


@pytest.fixture(name="one_press")
def give_one_press():
    return one_press


@pytest.fixture
def by_hand() -> Trials:
    nothing = np.zeros(3)
    envelopes_v = 1e-6 * np.array([[1.0, 2.0, 90.0, 99.0, 3.0, 4.0], [10.0, 20.0, 90.0, 99.0, 15.0, 5.0]])
    return Trials(
        participant="P01", specimen="S1", muscles=("EDC", "FDS"), repetition=np.arange(1, 4), start_s=nothing,
        stop_s=nothing, duration_s=nothing, peak_force_n=nothing, falling_share=nothing, snr_db=nothing,
        verdict=np.array(["ok", "rejected", "doubtful"]), reasons=("", "EDC is flat", "FDS is 3.0 dB over rest"),
        fs_hz=100.0, offsets=np.array([0, 2, 4, 6]), force_n=np.array([0.5, 7.0] * 3),
        activity=envelopes_v.sum(axis=0), envelopes_v=envelopes_v, activity_unit="V", rest_force_n=0.0,
        rest_envelope_v=np.zeros(2), mains_ratio=np.zeros(2), clip_share=np.zeros(2), overview_time_s=np.empty(0),
        overview_force_n=np.empty(0), delay=DelayBudget((), 0.0, 0.0, 0.0), bias=BiasBudget.of((), 3),
        traits=unknown(("EDC", "FDS"), 3),
        notes=("a note",),
    )  # fmt: skip

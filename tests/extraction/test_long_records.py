"""A long record is worked on in parts; so is a short one here, and gives what it gives as a whole."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import fields, is_dataclass

import numpy as np
import pytest
from numpy.typing import NDArray

from emg2vsa import arrays
from emg2vsa.extraction.cleaning import _force_at
from emg2vsa.settings import FilterSettings
from emg2vsa.signals import envelope, plausibility, windowed
from emg2vsa.signals.pairing import Clock
from tests.extraction.conftest import FS_HZ, RISE

Spoil = Callable[[NDArray[np.float64], NDArray[np.float64]], NDArray[np.float64]]


def hum(emg_v, time_s):
    return emg_v + 10e-6 * np.sin(2 * np.pi * 50 * time_s)


def coarse_and_sent_twice(emg_v, time_s):
    stored = np.round(emg_v / 1e-7) * 1e-7
    for begin in range(0, stored.size - 54, 270):
        stored[begin + 27 : begin + 54] = stored[begin : begin + 27]
    return stored


def wandering_and_sent_twice(emg_v, time_s):
    return coarse_and_sent_twice(emg_v + 3e-3 * np.sin(2 * np.pi * 0.2 * time_s), time_s)


def gaps(emg_v, time_s):
    return np.where((time_s % 7 > 3) & (time_s % 7 < 3.01), np.nan, emg_v)


SPOILT: dict[str, tuple[Spoil, str]] = {
    "nothing": (lambda emg_v, time_s: emg_v, ""),
    "hum": (hum, ""),
    "sent twice": (coarse_and_sent_twice, "twice"),
    "wanders, sent twice": (wandering_and_sent_twice, "twice"),
    "gaps": (gaps, ""),
}


def differences(one: object, other: object, where: str) -> list[str]:
    """Numbers that differ by more than a billionth of the largest beside them; all else that is not equal."""
    if is_dataclass(one):
        return [
            said for field in fields(one)
            for said in differences(getattr(one, field.name), getattr(other, field.name), f"{where}.{field.name}")
        ]  # fmt: skip
    if isinstance(one, tuple) and one and is_dataclass(one[0]):
        return [said for pair in zip(one, other, strict=True) for said in differences(*pair, where)]
    if isinstance(one, np.ndarray) and one.dtype.kind == "f":
        scale = np.max(np.abs(one), initial=0.0, where=np.isfinite(one))
        return [] if np.allclose(one, other, rtol=0, atol=1e-9 * scale, equal_nan=True) else [where]
    if isinstance(one, float):
        return [] if other == pytest.approx(one, rel=1e-9, nan_ok=True) else [where]
    return [] if np.array_equal(one, other) else [where]


@pytest.mark.parametrize("filters", [FilterSettings(), FilterSettings(phase="causal", envelope="rms")])
@pytest.mark.parametrize("spoilt", SPOILT)
def test_parts_give_what_the_whole_gives(spoilt, filters, force_of, recorded, extract, monkeypatch):
    spoil, told = SPOILT[spoilt]
    force_n = force_of(*[RISE] * 8)
    force_n += 0.01 * np.random.default_rng(0).standard_normal(force_n.size)
    emg, force = recorded(force_n)
    for channel in emg.values():
        channel.samples[:] = spoil(channel.samples, np.arange(force_n.size) / FS_HZ)
    before = {name: channel.samples.copy() for name, channel in emg.items()}, force.samples.copy()
    whole = extract(emg, force, filters=filters)
    for module, name, value in (
        (arrays, "AT_ONCE", 700), (plausibility, "AT_ONCE", 3000), (windowed, "LONG", 5000), (envelope, "LONG", 12_000),
    ):  # fmt: skip
        assert getattr(module, name) > force_n.size
        monkeypatch.setattr(module, name, value)
    assert differences(extract(emg, force, filters=filters), whole, "trials") == []
    assert told in " ".join(whole.remarks)
    assert whole.repetition.size == 8
    for name, samples in before[0].items():
        np.testing.assert_array_equal(emg[name].samples, samples)
    np.testing.assert_array_equal(force.samples, before[1])


@pytest.mark.parametrize("force_start_s", [-3.0, 0.0, 0.4, 30.0])
@pytest.mark.parametrize("force_hz", [100.0, 1000.0, 2148.15])
def test_force_at_samples_of_the_emg(force_start_s: float, force_hz: float) -> None:
    force_n = np.random.default_rng(0).standard_normal(round(8 * force_hz))
    emg, force = Clock(0.1, 1000.0, 10_000), Clock(force_start_s, force_hz, force_n.size)
    at_s = 0.1 + np.arange(10_000) / 1000.0
    expected = np.interp(at_s, force_start_s + np.arange(force_n.size) / force_hz, force_n)
    parts = [np.arange(begin, min(begin + 700, 10_000)) for begin in range(0, 10_000, 700)]
    found = np.concatenate([_force_at(part, force_n, emg, force) for part in parts])
    np.testing.assert_allclose(found, expected, atol=1e-9)

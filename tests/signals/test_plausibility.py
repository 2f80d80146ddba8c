"""How channels correlate and where their power lies, with the presses taken some at a time; packets sent twice."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from emg2vsa.signals import plausibility
from emg2vsa.signals.plausibility import _in_bands, _saturated
from emg2vsa.signals.press_signals import Signals, pieces_of
from emg2vsa.signals.spikes import repeated_of

FS_HZ = 1000.0
PRESSES = np.arange(0, 20_000, 2000)[:, None] + np.array([300, 1800])


def signals_of(*samples: np.ndarray) -> Signals:
    none = np.empty(0)
    return Signals(
        tuple("abc"[: len(samples)]),
        samples,
        FS_HZ,
        PRESSES,
        PRESSES[:0],
        none,
        none,
        none,
        100.0,
        np.zeros(1, np.int64),
    )


@pytest.mark.parametrize("at_once", [1, 4000, 2**17])
def test_correlations_and_shares_of_power(monkeypatch: pytest.MonkeyPatch, at_once: int) -> None:
    monkeypatch.setattr(plausibility, "AT_ONCE", at_once)
    one, other = np.random.default_rng(0).standard_normal((2, 20_000))
    time_s = np.arange(20_000) / FS_HZ
    # 12 Hz in the second half alone, which only its own presses show
    slow = np.where(time_s > 10, 3 * np.sin(2 * np.pi * 12 * time_s), 0.0)
    signals = signals_of(one, 0.6 * one + 0.8 * other, slow + other)
    pairs, shares = _in_bands(signals, [pieces_of(x, PRESSES, 8) for x in signals.samples])
    found = {(first, second): r for first, second, r in pairs}
    assert found == {("a", "b"): pytest.approx(0.6, abs=0.03), ("a", "c"): pytest.approx(0, abs=0.03),
                     ("b", "c"): pytest.approx(0.8, abs=0.03)}  # fmt: skip
    white = 1 - 20 / 500
    assert shares == pytest.approx([white, white, white / (1 + 4.5 / 2)], abs=0.03)


@pytest.mark.parametrize("step_v", [0.0, 1e-3])
def test_packets_sent_twice_are_counted_whatever_the_steps_of_the_converter(step_v: float) -> None:
    samples = np.random.default_rng(1).standard_normal(20_000)
    if step_v:
        samples = np.round(samples / step_v) * step_v
    for first in range(0, 20_000, 2000):
        samples[first + 1000 : first + 1027] = samples[first + 400 : first + 427]
    pieces = [pieces_of(samples, PRESSES, 8)]
    ordered = np.sort(np.concatenate(pieces[0]))
    alike = int(np.count_nonzero(np.diff(ordered) == 0))
    # of 1500 samples of a press, 27 - 11 begin 12 that occur twice
    said = "a has 1.1 % of its samples twice; did the link send packets again?"
    assert list(repeated_of(signals_of(samples), pieces, [alike])) == [("a", said)]


def test_mains_in_some_presses_is_no_rail_of_the_others() -> None:
    rng = np.random.default_rng(3)
    clean = rng.standard_normal(20_000)
    off = clean.copy()
    off[4000:10_000] = 40 * np.sin(2 * np.pi * 50 * np.arange(6000) / FS_HZ)  # an electrode that fell off
    signals = replace(
        signals_of(off, np.clip(2 * clean, -2.5, 2.5)), envelopes_v=np.ones((2, 10)), rest_v=np.full(2, 0.1)
    )
    rails, said = _saturated(signals, [pieces_of(x, PRESSES, 8) for x in signals.samples])
    assert list(rails) == ["b"]
    assert len(said) == 1

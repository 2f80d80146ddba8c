"""What the chain says of b, lag, law and interval of people whose EMG and force both come from motor units.

``python -m benchmarks.motor_units [PEOPLE] [RECORDINGS]``, kept by ``benchmarks.bench.record``: some minutes. No law
of activity against force is put into these people (``benchmarks.motor_unit_pool``); the truth of b is the line that the
fit's own weights give for the mean rectified EMG of many presses without noise, at the mean force of the same instants.
``twitches``: force is the sum of the flexor's twitches, so that it follows the EMG; ``commanded``: force is what the
excitation asks for, so that its lag is 0 and the motor units make the EMG alone.
"""

from __future__ import annotations

import math
import sys
from collections.abc import Sequence
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass
from functools import cached_property
from typing import Literal, NamedTuple, get_args

import numpy as np
from scipy import signal

from benchmarks.motor_unit_pool import Electrode, Muscle
from emg2vsa.arrays import Floats
from emg2vsa.companions.force_laws import LAWS, ForceLaws, force_laws
from emg2vsa.extraction.extract import extract_trials
from emg2vsa.fits import Fits, concatenate, fit_trials, usable
from emg2vsa.recordings import Channel
from emg2vsa.settings import (
    CocontractionSettings,
    FilterSettings,
    FitSettings,
    ForceChannelSettings,
    HypothesisSettings,
    WindowSettings,
)
from emg2vsa.signals.lag import Lag

FS_HZ = 2000.0
TOP_N, RAMP_S, HOLD_S, RELEASE_S = 8.0, 3.0, 0.5, 0.4
REST_S = 2.0
PRESSES = 10
SENSOR_N, ELECTRODE_V = 0.005, 1.5e-6
"Noise of the force sensor and of each electrode."
ENSEMBLE = 150
"Presses without noise of which the truth is the mean."
WINDOW, FILTERS, FORCE = WindowSettings(), FilterSettings(), ForceChannelSettings(name="Fz")
SMOOTH_S = 0.05
CLOSE_S = 0.02
"A lag that is told is right within this."

Origin = Literal["twitches", "commanded"]


@dataclass(frozen=True)
class Person:
    """Two muscles over which the excitation of a press is spread; ``seed`` decides anatomy and electrodes."""

    seed: int
    origin: Origin

    @cached_property
    def _drawn(self) -> tuple[tuple[Muscle, Muscle], float, float]:
        rng = np.random.default_rng([self.seed, 1993])
        flexor, extensor = (
            Muscle(
                int(rng.integers(2**31)),
                electrode=Electrode(
                    spacing_mm=float(rng.choice([10.0, 20.0])), depth_mm=rng.uniform(*depth_mm),
                    from_end_plate_mm=rng.uniform(15, 25),
                ),
                fs_hz=FS_HZ,
            )
            for depth_mm in ((4, 9), (2, 5))
        )  # fmt: skip
        return (flexor, extensor), float(rng.uniform(0.2, 0.3)), float(rng.uniform(0.4, 0.8))

    @property
    def muscles(self) -> tuple[Muscle, Muscle]:
        """Flexor (FDS), which makes the force, and extensor (EDC)."""
        return self._drawn[0]

    @property
    def share_of_most(self) -> float:
        """Of the flexor's greatest force, at the top of a press."""
        return self._drawn[1]

    @property
    def coactivation(self) -> float:
        """The extensor's excitation over the flexor's."""
        return self._drawn[2]

    def press(self, rng: np.random.Generator, wanted_n: Floats) -> tuple[Floats, Floats]:
        """EMG (2, n) in volts of FDS and EDC, and force (n,), where the hand wants the force (n,); without noise.

        The excitation is the one that holds the wanted force at rest: the hand corrects nothing.
        """
        flexor, extensor = self.muscles
        grid = np.linspace(0, flexor.pool.most, 2000)
        static = flexor.pool.static_force(grid)
        newtons = TOP_N / (self.share_of_most * float(static[-1]))
        # below its threshold the first unit gives no force: there is no excitation in between
        excitation = np.interp(wanted_n, newtons * static[static > 0], grid[static > 0]) * (wanted_n > 0)
        trains = [muscle.pool.discharges(rng, share * excitation, FS_HZ)
                  for muscle, share in ((flexor, 1.0), (extensor, self.coactivation))]  # fmt: skip
        n = wanted_n.size
        emg_v = np.stack([muscle.emg_v(train, n) for muscle, train in zip(self.muscles, trains, strict=True)])
        return emg_v, newtons * flexor.pool.force(trains[0], n, FS_HZ) if self.origin == "twitches" else wanted_n


def wanted(presses: int) -> Floats:
    """Force (n,) that the hand asks for: rest, rise, hold, release, and again; a rest at the end."""
    rise = np.linspace(0, TOP_N, round(RAMP_S * FS_HZ))
    one = np.concatenate((
        np.zeros(round(REST_S * FS_HZ)), rise, np.full(round(HOLD_S * FS_HZ), TOP_N),
        np.linspace(TOP_N, 0, round(RELEASE_S * FS_HZ)),
    ))  # fmt: skip
    return np.concatenate((np.tile(one, presses), np.zeros(round(REST_S * FS_HZ))))


def record(person: Person, number: int) -> tuple[dict[str, Channel], Channel]:
    """EMG by muscle and force of one recording, with noise."""
    rng = np.random.default_rng([person.seed, number])
    emg_v, force_n = person.press(rng, wanted(PRESSES))
    emg_v = emg_v + ELECTRODE_V * rng.standard_normal(emg_v.shape)
    force_n = force_n + SENSOR_N * rng.standard_normal(force_n.size)
    emg = {
        name: Channel("V", row, "V", FS_HZ, 0.0, "simulated") for name, row in zip(("FDS", "EDC"), emg_v, strict=True)
    }
    return emg, Channel("N", force_n, "N", FS_HZ, 0.0, "simulated")


class Truth(NamedTuple):
    """b_v : (2,) of the line, weighted by 1 / v^2 and not weighted, at the force that was made; held_b_v : at the force
    that the excitation would hold. r2 : (3,) of the laws of ``LAWS``. lag_s : of force behind the envelope, by the
    largest correlation over the press; rise_s : of force behind what is asked for, the median over the rise."""

    b_v: Floats
    held_b_v: Floats
    r2: Floats
    lag_s: float
    rise_s: float


def truth(person: Person) -> Truth:
    """From the mean of many presses of the person, without the chain: nothing of it is used but the band's edges."""
    rng = np.random.default_rng([person.seed, 10**6])
    asked_n = wanted(1)
    sections = signal.butter(2, FILTERS.band_hz, "bandpass", fs=FS_HZ, output="sos")
    envelope_v, force_n = np.zeros(asked_n.size), np.zeros(asked_n.size)
    for _ in range(ENSEMBLE):
        emg_v, own_n = person.press(rng, asked_n)
        envelope_v += np.abs(signal.sosfiltfilt(sections, emg_v)).sum(axis=0) / ENSEMBLE
        force_n += own_n / ENSEMBLE
    size = round(SMOOTH_S * FS_HZ) | 1
    envelope_v = np.convolve(envelope_v, np.full(size, 1 / size), mode="same")
    levels_n = np.linspace(*WINDOW.force_n, 50)
    reached = [np.array([int(np.argmax(each >= level)) for level in levels_n]) for each in (force_n, asked_n)]
    b_v, r2 = line_of(force_n, envelope_v)
    held_b_v, _ = line_of(asked_n, envelope_v)
    rise_s = float(np.median(reached[0] - reached[1])) / FS_HZ
    return Truth(b_v, held_b_v, r2, mean_lag(envelope_v, force_n) / FS_HZ, rise_s)


def mean_lag(envelope_v: Floats, force_n: Floats) -> int:
    """Samples by which the force (n,) comes after the envelope (n,), where the two correlate most; both rest at zero
    before and after, and their means stay, for else what a shift cuts off would count."""
    across = signal.correlate(force_n, envelope_v, mode="full")
    lags = signal.correlation_lags(force_n.size, envelope_v.size, mode="full")
    return int(lags[np.argmax(across)])


def line_of(force_n: Floats, v: Floats) -> tuple[Floats, Floats]:
    """b (2,) of v = a + b ln F on bins of force in the window, weighted by the samples over v^2 and not weighted; and
    R squared (3,) of logarithm, power and straight line, not weighted."""
    lower, upper = WINDOW.force_n
    begin = int(np.argmax(force_n >= lower))
    end = int(np.argmax(force_n >= upper))
    force_n, v = force_n[begin:end], v[begin:end]
    edges = np.linspace(lower, upper, round((upper - lower) / FitSettings().bin_n) + 1)
    bins = np.clip(np.digitize(force_n, edges) - 1, 0, edges.size - 2)
    counts = np.bincount(bins)
    x = np.bincount(bins, np.log(force_n)) / counts
    y = np.bincount(bins, v) / counts
    plain = np.polyfit(x, y, 1)
    weighted = plain
    for _ in range(20):
        weighted = np.polyfit(x, y, 1, w=np.sqrt(counts) / np.polyval(weighted, x))
    power = np.exp(np.polyval(np.polyfit(x, np.log(y), 1), x))
    line = np.polyval(np.polyfit(np.exp(x), y, 1), np.exp(x))
    left = [y - np.polyval(plain, x), y - power, y - line]
    return np.array([weighted[0], plain[0]]), np.array([1 - np.sum(r**2) / np.sum((y - y.mean()) ** 2) for r in left])


class Said(NamedTuple):
    """Of all presses of a person: fits with and without weights by level; lag_s (r,) of the recordings, NaN where it is
    not known; told_s : likewise, NaN where no press is told it; error_s : (r,) standard errors; differs : presses told
    that they share no lag. laws : on all fitted presses."""

    fits: Fits
    plain: Fits
    lag_s: Floats
    told_s: Floats
    error_s: Floats
    differs: int
    laws: ForceLaws


def said(person: Person, recordings: int) -> Said:
    """The chain on so many recordings."""
    fits, plain, lags, told, errors, differs = [], [], [], [], [], 0
    for number in range(recordings):
        emg, force = record(person, number)
        trials = extract_trials(
            emg, force, participant=f"P{person.seed}", specimen=f"S{number + 1}", filters=FILTERS,
            cocontraction=CocontractionSettings(), window=WINDOW, force_channel=FORCE,
        )  # fmt: skip
        fits.append(fit_trials(trials, FitSettings(), WINDOW))
        plain.append(fit_trials(trials, FitSettings(weights="none"), WINDOW))
        lags.append(trials.lag_s)
        told.append(trials.lag_s if any("force follows EMG" in each for each in trials.reasons) else math.nan)
        errors.append(Lag(trials.lag_s, trials.lag_se_s, PRESSES).error_s)
        differs += sum("lag of force d" in each for each in trials.reasons)
    joined = concatenate(fits)
    laws = force_laws(joined, "ok+doubtful")
    return Said(joined, concatenate(plain), np.array(lags), np.array(told), np.array(errors), differs, laws)


def of_person(person: Person, recordings: int) -> tuple[Truth, Said]:
    return truth(person), said(person, recordings)


def covers(fits: Fits, b_v: float) -> float:
    """Share in percent of the intervals of usable presses that hold b; NaN without any."""
    used = usable(fits, HypothesisSettings().use)
    held = (fits.b_lo_v <= b_v) & (fits.b_hi_v >= b_v)
    return 100 * float(held[used].mean()) if used.any() else math.nan


def row(person: Person, true: Truth, found: Said) -> Sequence[str]:
    fits = found.fits
    fitted = np.isfinite(fits.b_v)
    used = usable(fits, HypothesisSettings().use)
    b_v, sd = fits.b_v[fitted], float(np.std(fits.b_v[fitted], ddof=1))
    half = float(np.median((fits.b_hi_v - fits.b_lo_v)[fitted] / 2))
    best = [LAWS[int(np.argmin(errors))] for errors in found.laws.error[1].T.tolist()]
    off_s = np.maximum(true.lag_s - found.told_s, found.told_s - true.rise_s)
    false, beyond = off_s > CLOSE_S, off_s > 2 * found.error_s
    known = found.lag_s[np.isfinite(found.lag_s)]
    return (
        f"{person.seed}", person.origin, f"{1e6 * true.b_v[0]:.1f} / {1e6 * true.b_v[1]:.1f}",
        f"{1e6 * true.held_b_v[0]:.1f}", f"{1e6 * b_v.mean():.1f} ± {1e6 * sd:.1f}",
        f"{half / sd:.1f}", f"{covers(fits, float(true.b_v[0])):.0f}", f"{covers(fits, float(true.held_b_v[0])):.0f}",
        f"{1e6 * np.nanmean(found.plain.b_v):.1f}", f"{int(used.sum())} of {fits.b_v.size}",
        f"{1e3 * true.lag_s:.0f} / {1e3 * true.rise_s:.0f}",
        f"{1e3 * known.mean():.0f} ± {1e3 * np.std(known):.0f} ({known.size})" if known.size else "none",
        f"{int(np.isfinite(found.told_s).sum())} of {found.told_s.size}", f"{int(false.sum())}", f"{int(beyond.sum())}",
        f"{found.differs}",
        f"{100 * (true.b_v[0] / true.held_b_v[0] - 1):+.0f}", f"{100 * float(np.mean(fits.b_bias)):+.0f}",
        " / ".join(f"{value:.3f}" for value in true.r2), " / ".join(str(best.count(law)) for law in LAWS),
    )  # fmt: skip


HEAD = (
    "person", "force", "b true", "b held", "b found ± SD", "half width / SD", "cover", "cover held", "b not weighted",
    "used", "true lag", "lag found", "lag told", "false", "beyond", "differs", "b changed", "expected", "R2",
    "best law",
)  # fmt: skip
ABOUT = f"""`b true`: weighted by 1 / v^2, and not weighted; `held`: at the force that the excitation would hold.
Cover in percent of the presses that enter the tests by default. Lags in ms: by correlation over the press /
of force behind what is asked for, on the rise. `false`: recordings told a lag that is not between the two,
{1e3 * CLOSE_S:.0f} ms aside; `beyond`: two of their standard errors aside. `differs`: presses told that their lags do.
`b changed`: by the delay of force, percent, and what the presses expect of it. R2 of the ensemble and best law of each
recording, by bins left out: logarithm / power / line.
"""


def main() -> None:
    people = int(sys.argv[1]) if len(sys.argv) > 1 else 6
    recordings = int(sys.argv[2]) if len(sys.argv) > 2 else 8
    everyone = [Person(seed, origin) for origin in get_args(Origin) for seed in range(1, people + 1)]
    with ProcessPoolExecutor(2) as pool:
        outcomes = list(pool.map(of_person, everyone, [recordings] * len(everyone)))
    print("# People made of motor units\n")
    print(f"`python -m benchmarks.motor_units`: {people} people, each with their own force and with commanded force,")
    print(f"{recordings} recordings of {PRESSES} presses; no law of activity against force is put in. b in uV.")
    print(ABOUT)
    print(f"| {' | '.join(HEAD)} |\n|{'---|' * len(HEAD)}")
    for person, outcome in zip(everyone, outcomes, strict=True):
        print(f"| {' | '.join(row(person, *outcome))} |")
    for origin in get_args(Origin):
        fits = concatenate(
            [found.fits for who, (_, found) in zip(everyone, outcomes, strict=True) if who.origin == origin]
        )
        used, laws = usable(fits, HypothesisSettings().use), force_laws(fits, "ok+doubtful")
        ratios = "; ".join(
            f"{law} {laws.ratio[1, i]:.2f} ({laws.ratio_low[1, i]:.2f} to {laws.ratio_high[1, i]:.2f})"
            for i, law in enumerate(LAWS) if i
        )  # fmt: skip
        print(f"\n{origin}: {int(used.sum())} of {used.size} presses enter the tests; error of bins left out over that")
        print(f"of the logarithm: {ratios}.")


if __name__ == "__main__":
    main()

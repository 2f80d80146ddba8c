"""One study of 10 clean people, and as many others as there are mishaps, each with one; and studies that are clean.

Three specimens of five presses each, in memory: smooth ramps, carrier 40 to 80 Hz, noise 1.5 uV, a hum of 0.5 uV.
``b`` is the mean slope of a spoilt recording, rejected presses left out, over that of the same recording unspoilt.

    python -m benchmarks.study_mishaps            # writes benchmarks/results/study_mishaps.json
"""

from __future__ import annotations

import argparse
import contextlib
import re
from collections import Counter
from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Literal

import numpy as np
from numpy.typing import NDArray
from scipy import signal

from benchmarks.bench.record import keep
from emg2vsa.errors import SignalError
from emg2vsa.extraction import Trials
from emg2vsa.extraction.extract import extract_trials
from emg2vsa.fits import Fits, fit_trials
from emg2vsa.recordings import Channel
from emg2vsa.screening import Screening, screened, screened_trials
from emg2vsa.screening.screen import screen
from emg2vsa.session_verdict import doubts_between, judge_session
from emg2vsa.settings import (
    CocontractionSettings,
    FilterSettings,
    FitSettings,
    ForceChannelSettings,
    SimulationSettings,
    WindowSettings,
)
from emg2vsa.worlds.people.recording import RecordingStream

Floats = NDArray[np.float64]
RESULTS = Path(__file__).parent / "results" / "study_mishaps.json"
PRESSES = 5
CURVES_V = {"S1": (34e-6, 18e-6), "S2": (28e-6, 12e-6), "S3": (24e-6, 8e-6)}
WINDOW = WindowSettings(expected_trials=PRESSES)
CLEAN_PEOPLE = 10
OFF = 0.08


@dataclass
class Raw:
    """One recording; volts by muscle and newtons (n,) at ``fs_hz``; force_start_s : later than the EMG."""

    emg_v: dict[str, Floats]
    force_n: Floats
    fs_hz: float = 1000.0
    force_start_s: float = 0.0
    seed: int = 0

    @property
    def time_s(self) -> Floats:
        return np.arange(self.force_n.size) / self.fs_hz


def made(person: int, specimen: str, study: int = 0) -> Raw:
    """A clean recording; people differ in level (sd 25 %), share of muscles, band (4 %) and speed (15 %)."""
    who = np.random.default_rng([study, person, 1])
    level, shares = np.exp(0.25 * who.standard_normal()), 0.6 + 0.05 * who.standard_normal()
    stretch, pace = np.exp(0.04 * who.standard_normal()), np.exp(0.15 * who.standard_normal())
    rng = np.random.default_rng([study, person, *specimen.encode()])
    fs, pieces = 1000.0, [np.zeros(3000)]
    for _ in range(PRESSES):
        x = np.linspace(0, 1, int(2500 * pace * np.exp(0.1 * rng.standard_normal())))
        ramp = x + rng.uniform(-0.1, 0.1) * np.sin(2 * np.pi * x) + 0.05 * rng.uniform(-1, 1) * np.sin(4 * np.pi * x)
        peak = rng.uniform(7.35, 8.3)
        down = peak * (1 + np.cos(np.linspace(0, np.pi, 600))) / 2
        pieces += [peak * ramp, np.full(300, peak), down, np.zeros(int(rng.uniform(1200, 1800)))]
    force_n = np.concatenate(pieces)
    a_v, b_v = CURVES_V[specimen]
    curve_v = level * np.where(force_n > 0.3, a_v + b_v * np.log(np.maximum(force_n, 0.3)), 0.0)
    low = np.maximum(force_n, 0) / 0.3
    curve_v = np.where(force_n > 0.3, curve_v, low * level * (a_v + b_v * np.log(0.3)))
    band = signal.butter(4, np.array([40, 80]) * stretch, "bandpass", fs=fs, output="sos")
    emg_v = {}
    for muscle, share in (("EDC", shares), ("FDS", 1 - shares)):
        carrier = signal.sosfilt(band, rng.standard_normal(force_n.size + 500))[500:]
        carrier /= carrier.std() * np.sqrt(2 / np.pi)
        hum = 0.5e-6 * np.sqrt(2) * np.sin(2 * np.pi * 50 * np.arange(force_n.size) / fs + rng.uniform(0, 6))
        emg_v[muscle] = share * np.maximum(curve_v, 0) * carrier + 1.5e-6 * rng.standard_normal(force_n.size) + hum
    return Raw(emg_v, force_n + 0.2 + 0.01 * rng.standard_normal(force_n.size), fs, 0.0, person)


def simulated(person: int, specimen: str, study: int) -> Raw:
    """A clean recording of the project's simulator; people differ in level (sd 35 %), noise (2 uV, sd 30 %) and hum."""
    who = np.random.default_rng([study, person, 2])
    level, noise_v = np.exp(0.35 * who.standard_normal()), 2e-6 * np.exp(0.3 * who.standard_normal())
    settings = SimulationSettings(
        repetitions=PRESSES, muscle_share={"EDC": 0.6, "FDS": 0.4}, emg_noise_v=noise_v, mains_v=who.uniform(0, 4e-6)
    )
    a_v, b_v = (level * each for each in CURVES_V[specimen])
    seed = np.random.SeedSequence([study, person, *specimen.encode()])
    stream = RecordingStream(seed, settings, a_v=a_v, b_v=b_v, window_n=WINDOW.force_n).whole()
    return Raw(dict(stream.emg_v), stream.force_n, stream.fs_hz, 0.0, person)


CLEAN_WORLDS = {
    "as above": made,
    "of the project's simulator: level ± 35 %, noise ± 30 %, hum 0 to 4 uV": simulated,
}
Change = Callable[[Raw], Raw]


def emg(change: Callable[[Floats], Floats], *muscles: str) -> Change:
    return lambda raw: replace(
        raw, emg_v={m: change(x) if m in muscles or not muscles else x for m, x in raw.emg_v.items()}
    )


def gain(factor: float, *muscles: str) -> Change:
    return emg(lambda x: factor * x, *muscles)


def filtered(hz: float | tuple[float, float], kind: Literal["low", "high", "bandstop"]) -> Change:
    return emg(lambda x: signal.sosfiltfilt(signal.butter(4, np.array(hz), kind, fs=1000, output="sos"), x))


def rate(factor: float) -> Change:
    return lambda raw: replace(raw, fs_hz=raw.fs_hz / factor)


def force(change: Callable[[Floats, Floats], Floats]) -> Change:
    return lambda raw: replace(raw, force_n=change(raw.force_n, raw.time_s))


def resampled(hz: int) -> Change:
    every = 1000 // hz

    def change(x: Floats) -> Floats:
        t = np.arange(x.size)
        return np.interp(t, t[::every], x[::every])

    return emg(change)


def envelope(hz: float) -> Change:
    low = signal.butter(2, hz, fs=1000, output="sos")
    return emg(lambda x: signal.sosfiltfilt(low, np.abs(x)))


def envelope_ac(hz: float) -> Change:
    low, high = signal.butter(2, hz, fs=1000, output="sos"), signal.butter(1, 10, "high", fs=1000, output="sos")
    return emg(lambda x: signal.sosfiltfilt(high, signal.sosfiltfilt(low, np.abs(x))))


def digits(step_v: float) -> Change:
    return lambda raw: replace(raw, emg_v={m: np.round(x / step_v) * step_v for m, x in raw.emg_v.items()})


def cut(seconds: float) -> Change:
    def change(raw: Raw) -> Raw:
        n = round(seconds * raw.fs_hz)
        return replace(raw, emg_v={m: x[n:] for m, x in raw.emg_v.items()}, force_n=raw.force_n[n:])

    return change


def added(level_v: float) -> Change:
    def change(raw: Raw) -> Raw:
        rng = np.random.default_rng([raw.seed, 7])
        return replace(raw, emg_v={m: x + level_v * rng.standard_normal(x.size) for m, x in raw.emg_v.items()})

    return change


def hum(level_v: float, touched: bool = False) -> Change:
    def change(raw: Raw) -> Raw:
        wave = level_v * np.sqrt(2) * np.sin(2 * np.pi * 50 * raw.time_s)
        wave = wave * (raw.force_n > 0.4) if touched else wave
        return replace(raw, emg_v={m: x + wave for m, x in raw.emg_v.items()})

    return change


def lost(share: float) -> Change:
    """Packets of 20 samples that never came; what follows moves up."""

    def change(raw: Raw) -> Raw:
        rng = np.random.default_rng([raw.seed, 8])
        n = raw.force_n.size
        kept = np.repeat(rng.random(-(-n // 20)) > share, 20)[:n]
        return replace(raw, emg_v={m: x[kept] for m, x in raw.emg_v.items()})

    return change


def fading(to: float, *muscles: str) -> Change:
    return emg(lambda x: x * np.linspace(1, to, x.size), *muscles)


def exchanged(raw: Raw) -> Raw:
    return replace(raw, emg_v={"EDC": raw.emg_v["FDS"], "FDS": raw.emg_v["EDC"]})


def late(by_s: float) -> Change:
    return lambda raw: replace(raw, force_start_s=by_s)


def clipped(level_v: float) -> Change:
    return emg(lambda x: np.clip(x, -level_v, level_v))


ONE, ALL = ("S2",), tuple(CURVES_V)
MISHAPS: dict[str, tuple[Change, tuple[str, ...]]] = {
    **{f"one recording × {f:g}": (gain(f), ONE) for f in (1.3, 1.5, 2, 3, 10, 100, 0.67, 0.5, 0.3, 0.1)},
    **{f"EDC of one recording × {f:g}": (gain(f, "EDC"), ONE) for f in (1.5, 2, 10, 0.5, 0.1)},
    **{f"EDC of all recordings × {f:g}": (gain(f, "EDC"), ALL) for f in (1.5, 2, 3, 10, 0.3, 0.1)},
    **{f"all recordings × {f:g}": (gain(f), ALL) for f in (1.5, 2, 3, 10, 0.3, 0.1)},
    **{f"low-passed at {f} Hz, one": (filtered(f, "low"), ONE) for f in (30, 60, 80, 100, 200)},
    **{f"low-passed at {f} Hz, all": (filtered(f, "low"), ALL) for f in (60, 100)},
    **{f"high-passed at {f} Hz, one": (filtered(f, "high"), ONE) for f in (30, 60, 100)},
    "high-passed at 100 Hz, all": (filtered(100, "high"), ALL),
    "notch 45 to 55 Hz, one": (filtered((45.0, 55.0), "bandstop"), ONE),
    **{f"{f} Hz interpolated to 1000 Hz, one": (resampled(f), ONE) for f in (125, 250, 500)},
    "250 Hz interpolated to 1000 Hz, all": (resampled(250), ALL),
    **{f"envelope to {f} Hz, one": (envelope(f), ONE) for f in (6, 20, 50)},
    **{f"envelope to {f} Hz, high-passed at 10 Hz, {n}": (envelope_ac(f), w) for f in (50, 100) for n, w in
       (("one", ONE), ("all", ALL))},
    "rectified, one": (emg(np.abs), ONE),
    "rectified, its mean off, one": (emg(lambda x: np.abs(x) - np.abs(x).mean()), ONE),
    **{f"time × {f:g}, one": (rate(f), ONE) for f in (2, 0.5, 1.1, 0.9, 1.2)},
    **{f"time × {f:g}, all": (rate(f), ALL) for f in (2, 0.5, 1.1)},
    "ounces as N, one": (force(lambda f, t: f * 3.597), ONE),
    "ounces as N, all": (force(lambda f, t: f * 3.597), ALL),
    "pounds as N, one": (force(lambda f, t: f * 0.2248), ONE),
    "kilogram-force as N, one": (force(lambda f, t: f * 0.10197), ONE),
    "sign of force, one": (force(lambda f, t: -f), ONE),
    "force drifts 3 N a minute, one": (force(lambda f, t: f + 0.05 * t), ONE),
    **{f"noise {1e6 * v:g} uV, one": (added(v), ONE) for v in (5e-6, 15e-6, 40e-6)},
    **{f"hum {1e6 * v:g} uV, one": (hum(v), ONE) for v in (10e-6, 40e-6)},
    **{f"hum {1e6 * v:g} uV at the touch, one": (hum(v, True), ONE) for v in (10e-6, 40e-6)},
    **{f"packets lost {100 * s:g} %, one": (lost(s), ONE) for s in (0.01, 0.02)},
    **{f"EDC fades to {f:g}, one": (fading(f, "EDC"), ONE) for f in (0.7, 0.2)},
    **{f"force {1e3 * s:g} ms late, one": (late(s), ONE)
       for s in (0.06, 0.4, -0.4)},
    **{f"clipped at {1e6 * v:g} uV, one": (clipped(v), ONE) for v in (20e-6, 60e-6)},
    "muscles exchanged, one": (exchanged, ONE),
}  # fmt: skip
COPIES: dict[str, Change] = {
    "byte copy of S1 as S2": lambda raw: raw,
    "S1 re-exported to 1 uV as S2": digits(1e-6),
    "S1 cut by 1 s as S2": cut(1.0),
    "S1 shifted by 0.4003 s as S2": cut(0.4003),
    "S1 re-exported at half the gain as S2": gain(0.5),
}
OTHERS_FILE = "file of another person, as if own"


def trials_of(raw: Raw, participant: str, specimen: str) -> Trials:
    channels = {m: Channel(m, x, "V", raw.fs_hz, 0.0, "made") for m, x in raw.emg_v.items()}
    return extract_trials(
        channels, Channel("force", raw.force_n, "N", raw.fs_hz, raw.force_start_s, "made"),
        participant=participant, specimen=specimen, filters=FilterSettings(), cocontraction=CocontractionSettings(),
        window=WINDOW, force_channel=ForceChannelSettings(name="force"),
    )  # fmt: skip


Fitted = dict[tuple[str, str], tuple[Trials, Fits]]


def fitted(raw: Raw, participant: str, specimen: str, into: Fitted) -> None:
    """One recording, unless it cannot be used at all."""
    with contextlib.suppress(SignalError):
        trials = trials_of(raw, participant, specimen)
        into[participant, specimen] = trials, fit_trials(trials, FitSettings(), WINDOW)


def judged(study: Fitted, person: str, screening: Screening) -> tuple[str, str]:
    """Verdict on a session, and what was said first."""
    doubts = doubts_between([t for t, _ in study.values()], {k: f for k, (_, f) in study.items()}, ())
    own = {what: both for (who, what), both in study.items() if who == person}
    session = judge_session(
        person, [screened_trials(t, screening) for t, _ in own.values()],
        {what: screened(f, screening) for what, (_, f) in own.items()}, dict.fromkeys(CURVES_V, PRESSES), {},
        {what: doubts.get((person, what), ()) for what in own},
    )  # fmt: skip
    told = [advice.text for advice in session.advice if "record again" not in advice.text]
    return session.verdict, told[0] if told else ""


def mishaps(number: int) -> tuple[Fitted, dict[str, tuple[str, tuple[str, ...]]]]:
    """The study of all mishaps on the people ``number``, and of each what went wrong with which specimens."""
    study: Fitted = {}
    for n in range(CLEAN_PEOPLE):
        for specimen in CURVES_V:
            fitted(made(n, specimen, number), f"C{n:02d}", specimen, study)
    who: dict[str, tuple[str, tuple[str, ...]]] = {}
    names = [*MISHAPS, *COPIES, OTHERS_FILE]
    for n, name in enumerate(names, CLEAN_PEOPLE):
        person = f"M{n:03d}"
        change, spoilt = MISHAPS.get(name, (lambda raw: raw, ONE))
        who[person] = name, spoilt
        for specimen in CURVES_V:
            raw = made(n, specimen, number)
            if specimen in spoilt:
                if name in COPIES:
                    raw = COPIES[name](made(n, "S1", number))
                elif name == OTHERS_FILE:
                    raw = made(9999, specimen, number)
                else:
                    raw = change(raw)
            fitted(raw, person, specimen, study)
    return study, who


def slope_v(fits: Fits) -> float:
    """Mean slope of the presses that are not rejected; NaN without any."""
    b_v = fits.b_v[(fits.verdict != "rejected") & np.isfinite(fits.b_v)]
    return float(b_v.mean()) if b_v.size else np.nan


def clean_b_v(n: int, specimen: str, number: int) -> float:
    """Slope of the same recording as it was before its mishap."""
    clean: Fitted = {}
    fitted(made(n, specimen, number), "", specimen, clean)
    return slope_v(clean["", specimen][1])


@dataclass(frozen=True)
class Outcome:
    """A study of mishaps, judged. rows : of the table. silent : names of those GOOD with b off by more than ``OFF``."""

    rows: list[str]
    silent: list[str]
    good_clean: int


def outcome(number: int) -> Outcome:
    study, who = mishaps(number)
    screening = screen({key: trials.traits for key, (trials, _) in study.items()})
    rows, silent = [], []
    for person, (name, spoilt) in who.items():
        verdict, said = judged(study, person, screening)
        ratios = []
        for specimen in spoilt:
            if (person, specimen) in study:
                ratio = slope_v(study[person, specimen][1]) / clean_b_v(int(person[1:]), specimen, number)
                ratios += [ratio] if np.isfinite(ratio) else []
        if verdict == "good" and any(abs(ratio - 1) > OFF for ratio in ratios):
            silent.append(name)
        found = [screening.of(person, specimen) for specimen in CURVES_V]
        cause = next((each.cause for each in found if each), "")
        shown = f"{min(ratios):.2f} to {max(ratios):.2f}" if len(ratios) > 1 else f"{ratios[0]:.2f}" if ratios else "–"
        rows.append(f"| {name} | {verdict.upper()} | {shown} | {cause} | {said.replace('|', '/')} |")
    good = sum(judged(study, f"C{n:02d}", screening)[0] == "good" for n in range(CLEAN_PEOPLE))
    return Outcome(rows, silent, good)


def page(studies: int, people: int) -> str:
    first, *others = [outcome(number) for number in range(3)]
    about = (__doc__ or "").partition("\n")[2].strip().partition("    python")[0].strip()
    lines = [
        "# Mishaps of one recording or session in a study", "", about, "",
        f"GOOD though b is off by more than {100 * OFF:.0f} %, of {len(first.rows)} mishaps: {len(first.silent)} "
        f"({'; '.join(first.silent)}). "
        f"With other people: {' and '.join(str(len(each.silent)) for each in others)} "
        f"({'; '.join(sorted({name for each in others for name in each.silent}))}). "
        f"Clean sessions of the studies that are GOOD, of {CLEAN_PEOPLE} each: "
        f"{', '.join(str(each.good_clean) for each in (first, *others))}.", "",
        "| mishap | verdict | b × | cause by the study | said first |\n|---|---|---:|---|---|", *first.rows, "",
        f"Clean studies of {people} people: sessions that are not GOOD, and presses that are not used.", "",
        "| people | studies | sessions | not GOOD | by the comparison alone | presses | doubtful | rejected |",
        "|---|---:|---:|---:|---:|---:|---:|---:|",
    ]  # fmt: skip
    told: Counter[str] = Counter()
    for world, make in CLEAN_WORLDS.items():
        off = alarms = 0
        presses: Counter[str] = Counter()
        for number in range(201, 201 + studies):
            study: Fitted = {}
            for n in range(people):
                for specimen in CURVES_V:
                    fitted(make(n, specimen, number), f"P{n:02d}", specimen, study)
            screening = screen({key: trials.traits for key, (trials, _) in study.items()})
            alarms += len({each.participant for each in screening.found})
            presses.update(verdict for _, fits in study.values() for verdict in fits.verdict.tolist())
            for n in range(people):
                verdict, said = judged(study, f"P{n:02d}", screening)
                off += verdict != "good"
                told.update([re.sub(r"-?[0-9.]+", "N", said)] if verdict != "good" else [])
        sessions = studies * people
        share, unused = f"{off} ({100 * off / sessions:.2f} %)", f"{presses['doubtful']} | {presses['rejected']}"
        lines.append(f"| {world} | {studies} | {sessions} | {share} | {alarms} | {presses.total()} | {unused} |")
    said_of = "; ".join(f"{text} ({count})" for text, count in told.most_common())
    return "\n".join([*lines, "", f"What was said first of those that are not GOOD: {said_of or 'nothing'}."]) + "\n"


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--studies", type=int, default=50)
    parser.add_argument("--people", type=int, default=12)
    parser.add_argument("--no-write", action="store_true")
    arguments = parser.parse_args()
    text = page(arguments.studies, arguments.people)
    print(text)
    if not arguments.no_write:
        keep(RESULTS, text)


if __name__ == "__main__":
    main()

"""False alarms on clean sessions: which limits may be set so that of 1000 good presses at most 10 are doubted.

Sessions of ten presses over every carrier, ramp and pair of rates that the method claims to hold for
(``benchmarks.laboratory``), with 1 uV of noise and nothing wrong. And sessions drawn from all of them at once: other
people, rates, numbers of presses, noise and hum in each, judged as ``emg2vsa check`` judges a recording.

    python -m benchmarks.verdict_thresholds     # writes benchmarks/results/verdict_thresholds.json
"""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass, replace
from pathlib import Path
from typing import get_args

import numpy as np

from benchmarks.bench.record import keep
from benchmarks.laboratory import Carrier, Laboratory, Ramp, simulate_session
from emg2vsa.extraction import Trials
from emg2vsa.extraction.extract import extract_trials
from emg2vsa.fits import Fits, fit_trials
from emg2vsa.recordings import Channel
from emg2vsa.session_verdict import judge_session
from emg2vsa.settings import (
    CocontractionSettings,
    FilterSettings,
    FitSettings,
    ForceChannelSettings,
    WindowSettings,
)

RESULTS = Path(__file__).parent / "results" / "verdict_thresholds.json"
BASE = Laboratory()
CLEAN: dict[str, Laboratory] = {
    **{f"carrier {name}": replace(BASE, carrier=name)
       for name in ("60/120", "40/80", "90/180", "20/45", "laplacian", "units-60", "units-15", "units-6")},
    "ramp 0.7 s": replace(BASE, ramp_s=0.7),
    "ramp 8 s": replace(BASE, ramp_s=8.0),
    **{f"ramp {name}": replace(BASE, ramp=name)
       for name in ("exponential", "saturating", "plateaus", "stairs", "tremor")},
    "EMG 2000 Hz": replace(BASE, fs_hz=2000.0),
    "EMG 1259.26 Hz, force 148.15 Hz": replace(BASE, fs_hz=1259.2593, force_fs_hz=148.1481),
    "EMG 1000 Hz, force 50 Hz": replace(BASE, force_fs_hz=50.0),
    "force noise 0.1 N": replace(BASE, force_noise_n=0.1),
    "shares 90/10": replace(BASE, shares=(0.9, 0.1)),
}  # fmt: skip
FREE = FitSettings(min_adj_r2=-1.0, max_b_error=0.0, max_b_error_ratio=0.0)


@dataclass(frozen=True)
class Found:
    """Of one session: the fits without limits and with the defaults, and the remarks on it."""

    trials: Trials
    free: Fits
    fits: Fits


def analysed(laboratory: Laboratory, seed: int) -> Found:
    made = simulate_session(laboratory, seed)
    muscles = ("EDC", "FDS")
    emg = {m: Channel(m, x, "V", laboratory.fs_hz, 0.0, "V as stored")
           for m, x in zip(muscles, made.emg_v, strict=True)}  # fmt: skip
    window = WindowSettings(expected_trials=laboratory.presses)
    trials = extract_trials(
        emg, Channel("Fz", made.force_n, "N", laboratory.force_fs_hz, 0.0, "N as stored"), participant="P",
        specimen="S", filters=FilterSettings(), cocontraction=CocontractionSettings(), window=window,
        force_channel=ForceChannelSettings(name="Fz"),
    )  # fmt: skip
    return Found(trials, fit_trials(trials, FREE, window), fit_trials(trials, FitSettings(), window))


def drawn(seed: int) -> Laboratory:
    """A clean session: b within 5 % of the law's where nothing is said of it; EMG ahead of force by up to 10 ms."""
    rng = np.random.default_rng([34, seed])
    carriers = [each for each in get_args(Carrier) if each != "units-6"]  # so few units are no surface EMG
    fs_hz, level = float(rng.choice([1000.0, 1259.26, 2000.0, 4000.0])), float(np.exp(0.35 * rng.standard_normal()))
    share = float(rng.uniform(0.5, 0.7))
    return Laboratory(
        a_v=30e-6 * level, b_v=float(rng.uniform(10e-6, 18e-6)) * level, shares=(share, 1 - share),
        tone_share=float(rng.uniform(0.05, 0.15)), presses=int(rng.integers(3, 13)), fs_hz=fs_hz,
        force_fs_hz=float(rng.choice([fs_hz, fs_hz / 2, 148.15, 100.0])), carrier=rng.choice(carriers),
        ramp=rng.choice(get_args(Ramp)), ramp_s=float(rng.uniform(1.5, 6.0)), noise_v=float(rng.uniform(0.5e-6, 3e-6)),
        hum_v=float(rng.uniform(0.0, 3e-6)), hum_hz=float(rng.choice([50.0, 60.0])),
        delay_s=float(rng.uniform(0.0, 0.01)), force_noise_n=float(rng.uniform(0.005, 0.03)),
        drift_n_per_min=float(rng.uniform(-0.5, 0.5)),
    )  # fmt: skip


def sessions_table(sessions: int, presses: int | None = None) -> list[str]:
    """Verdicts on sessions drawn at random, of so many presses each if given, and what was said of those not GOOD."""
    words: Counter[str] = Counter()
    verdicts: Counter[str] = Counter()
    lines = []
    for seed in range(sessions):
        laboratory = drawn(seed) if presses is None else replace(drawn(seed), presses=presses)
        found = analysed(laboratory, seed)
        session = judge_session("P", [found.trials], {"S": found.fits}, {"S": laboratory.presses}, {})
        words[session.verdict] += 1
        verdicts.update(found.fits.verdict.tolist())
        if session.verdict != "good":
            world = f"{laboratory.carrier}, {laboratory.ramp}, {laboratory.ramp_s:.1f} s, {laboratory.fs_hz:g} Hz"
            said = "; ".join(each.text for each in session.advice).replace("|", "/")
            lines.append(f"| {seed} | {world} | {session.verdict} | {said} |")
    total, off, size = verdicts.total(), sessions - words["good"], "3 to 12 presses" if presses is None else "one press"
    return [
        "", f"## Sessions of {size}, drawn from all of these", "",
        f"{sessions} sessions: {off} not GOOD ({100 * off / sessions:.2f} %). {total} presses: "
        f"{verdicts['doubtful']} doubtful, {verdicts['rejected']} rejected "
        f"({100 * (total - verdicts['ok']) / total:.2f} %).", "",
        "| session | carrier, ramp, rate | verdict | said |", "|---|---|---|---|", *lines,
    ]  # fmt: skip


def table(sessions: int) -> list[str]:
    lines = ["| clean sessions | presses | doubted % | rejected by the fit % | remarks on sessions | adj R2 1 % | "
             "half width of b over b 99 % | over its median 99 % |", "|---|---|---|---|---|---|---|---|"]  # fmt: skip
    totals: Counter[str] = Counter()
    said: Counter[str] = Counter()
    for name, laboratory in CLEAN.items():
        found = [analysed(laboratory, seed) for seed in range(sessions)]
        r2 = np.concatenate([one.free.adj_r2_bins for one in found])
        half = [(one.free.b_hi_v - one.free.b_lo_v) / 2 for one in found]
        relative = np.concatenate([h / np.abs(one.free.b_v) for h, one in zip(half, found, strict=True)])
        ratio = np.concatenate([h / np.median(h) for h in half])
        verdicts = np.concatenate([one.fits.verdict for one in found])
        by_fit = sum(int(np.sum((one.fits.verdict == "rejected") & (one.trials.verdict != "rejected")))
                     for one in found)  # fmt: skip
        remarks = [remark for one in found for remark in (*one.trials.remarks, *filter(None, [one.trials.fault]))]
        doubted = int(np.sum(verdicts != "ok"))
        totals.update(presses=verdicts.size, doubted=doubted, fit=by_fit, remarks=len(remarks))
        for one in found:
            said.update(part for reason in one.fits.reason.tolist() for part in reason.split("; ") if part)
        said.update(remarks)
        n = verdicts.size
        lines.append(f"| {name} | {n} | {100 * doubted / n:.1f} | {100 * by_fit / n:.1f} | {len(remarks)} | "
                     f"{np.nanquantile(r2, 0.01):.2f} | {np.nanquantile(relative, 0.99):.2f} | "
                     f"{np.nanquantile(ratio, 0.99):.1f} |")  # fmt: skip
    n = totals["presses"]
    lines.append(f"| all | {n} | {100 * totals['doubted'] / n:.2f} | {100 * totals['fit'] / n:.2f} | "
                 f"{totals['remarks']} | | | |")  # fmt: skip
    return [*lines, "", "What was said:", *(f"- {text} ({k})" for text, k in said.most_common(25))]


if __name__ == "__main__":
    text = "\n".join([*table(5), *sessions_table(600), *sessions_table(400, presses=1)])
    head = "# False alarms on clean sessions\n\nMade by `python -m benchmarks.verdict_thresholds`.\n\n"
    keep(RESULTS, head + text)
    print(text)

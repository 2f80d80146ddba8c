"""What spoils a moment or a level of EMG, by kind and size: b, its coverage, presses used, and what is said of it.

``python -m benchmarks.artefacts [SESSIONS]``, kept by ``benchmarks.bench.record``: two processes, some minutes. All
conditions use the seeds of the clean one, and its carriers.
"""

from __future__ import annotations

import re
import sys
from collections import Counter
from concurrent.futures import ProcessPoolExecutor
from dataclasses import replace

import numpy as np

from benchmarks.laboratory import Carrier, Laboratory, Ramp, simulate_session
from emg2vsa.extraction.extract import extract_trials
from emg2vsa.fits import fit_trials, usable
from emg2vsa.recordings import Channel
from emg2vsa.settings import (
    CocontractionSettings,
    FilterSettings,
    FitSettings,
    ForceChannelSettings,
    HypothesisSettings,
    WindowSettings,
)

CLEAN = Laboratory()
KINDS: dict[str, Laboratory] = {
    "clean": CLEAN,
    "artefact 50 uV": replace(CLEAN, artefact_v=50e-6),
    "artefact 150 uV": replace(CLEAN, artefact_v=150e-6),
    **{f"touch hum {v} uV": replace(CLEAN, touch_hum_v=v * 1e-6) for v in (10, 20, 40)},
    **{f"touch hum {v} uV, grows": replace(CLEAN, touch_hum_v=v * 1e-6, touch_hum_grows=True) for v in (10, 20, 40)},
    "spikes of 5 mV, 0.2 a second": replace(CLEAN, spike_hz=0.2),
    "spikes of 5 mV, 1 a second": replace(CLEAN, spike_hz=1.0),
    "burst 100 uV": replace(CLEAN, burst_v=100e-6),
    "burst 300 uV": replace(CLEAN, burst_v=300e-6),
    "held for 60 ms": replace(CLEAN, held_s=0.06),
    "held for 150 ms": replace(CLEAN, held_s=0.15),
    "missing for 5 ms": replace(CLEAN, missing_s=0.005),
    "missing for 60 ms": replace(CLEAN, missing_s=0.06),
    **{f"clips at {100 * s:.0f} % of its peak": replace(CLEAN, clip_at=s) for s in (0.99, 0.95, 0.8, 0.6, 0.4)},
    **{f"clips at {100 * s:.0f} %, noise of 1 uV behind": replace(CLEAN, clip_at=s, clip_noise_v=1e-6)
       for s in (0.8, 0.6, 0.4)},
    "packets lost 0.5 %": replace(CLEAN, lost_share=0.005),
}  # fmt: skip
WAYS: dict[str, tuple[Carrier, Ramp]] = {
    "60/120, linear": ("60/120", "linear"),
    "20/45, linear": ("20/45", "linear"),
    "Laplacian, exponential": ("laplacian", "exponential"),
    "15 units, plateaus": ("units-15", "plateaus"),
}
WINDOW = WindowSettings()


def row(kind: str, way: str, sessions: int) -> str:
    """One row of the table."""
    carrier, ramp = WAYS[way]
    laboratory = replace(KINDS[kind], carrier=carrier, ramp=ramp)
    ratios, covers, used = [], [], []
    causes: Counter[str] = Counter()
    said: Counter[str] = Counter()
    for seed in range(sessions):
        made = simulate_session(laboratory, seed)
        emg = {f"M{i}": Channel("E", x, "V", laboratory.fs_hz, 0.0, "") for i, x in enumerate(made.emg_v)}
        trials = extract_trials(
            emg, Channel("F", made.force_n, "N", laboratory.force_fs_hz, 0.0, ""), participant="P", specimen="S",
            filters=FilterSettings(), cocontraction=CocontractionSettings(), window=WINDOW,
            force_channel=ForceChannelSettings(name="F"),
        )  # fmt: skip
        fits = fit_trials(trials, FitSettings(), WINDOW)
        own = usable(fits, HypothesisSettings().use)
        used.append(own)
        ratios.append(fits.b_v[own] / laboratory.b_v)
        covers.append(((fits.b_lo_v <= laboratory.b_v) & (fits.b_hi_v >= laboratory.b_v))[own])
        causes.update(fits.cause[fits.cause != ""].tolist())
        for reason in filter(None, (*trials.reasons, *trials.remarks)):
            said.update({re.sub(r"M\d( and M\d)?|[\d.+-]*\d", "..", part)[:36] for part in reason.split("; ")})
    ratio, cover, share = np.concatenate(ratios), np.concatenate(covers), np.concatenate(used)
    bias = f"{100 * (ratio.mean() - 1):+.1f} ({100 * ratio.std() / np.sqrt(ratio.size):.1f})" if ratio.size else "none"
    cause = causes.most_common(1)[0][0] if causes else ""
    told = said.most_common(1)[0] if said else ("", 0)
    cells = (
        kind, way, bias, f"{100 * cover.mean():.1f}" if cover.size else "none", f"{100 * share.mean():.0f}", cause,
        f"{told[0]} ({told[1]})" if told[1] else "",
    )  # fmt: skip
    return f"| {' | '.join(cells)} |"


def main() -> None:
    sessions = int(sys.argv[1]) if len(sys.argv) > 1 else 12
    print("# Artefacts of a moment, hum at the touch, clipping, lost samples\n")
    print("`python -m benchmarks.artefacts`: v = 30 + 15 ln F uV, shares 60/40, 10 presses of 2.5 s a session,")
    print(f"{sessions} sessions a row. `b bias` with its standard error and `coverage` are those of the presses that")
    print("enter the tests by default; `cause` is the largest in the budget of most presses, `said` what most say.\n")
    print("| kind | carrier, ramp | b bias % (se) | coverage 95 % | used % | cause | said (presses, recordings) |")
    print("|---|---|---|---|---|---|---|")
    cells = [(kind, way) for kind in KINDS for way in WAYS]
    with ProcessPoolExecutor(2) as pool:
        for line in pool.map(row, *zip(*cells, strict=True), [sessions] * len(cells)):
            print(line, flush=True)


if __name__ == "__main__":
    main()

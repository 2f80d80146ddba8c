"""The truth of a synthetic study: matched to the trials that were found, and how well their fits recover it."""

from __future__ import annotations

import csv
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from emg2vsa.errors import DataError
from emg2vsa.fits import Fits, usable
from emg2vsa.shown import shown

Truth = dict[tuple[str, str, int], tuple[float, float]]

ONSET_TOLERANCE_S = 0.5
"""A trial and a simulated press are the same when their loading phases start this close; presses are seconds apart."""


def read_truth(path: Path, fits: Fits) -> Truth:
    """(participant, specimen, repetition) of every trial whose press is known, to its true (a, b) in volts.

    Trials are matched by the time of their onset, not by number: a press that was missed must not shift the others.

    Raises DataError where the file is not a table of presses.
    """
    presses: dict[tuple[str, str], list[tuple[float, float, float]]] = {}
    try:
        with path.open(newline="", encoding="utf-8") as file:
            for row in csv.DictReader(file, delimiter="\t"):
                cell = presses.setdefault((row["participant"], row["specimen"]), [])
                cell.append((float(row["onset_s"]), float(row["a_v"]), float(row["b_v"])))
    except (OSError, KeyError, ValueError, TypeError) as error:
        raise DataError(
            path, wanted="a table of simulated presses", found=f"{type(error).__name__} {error}",
            do="Simulate the study again, or remove the file.",
        ) from error  # fmt: skip
    truth: Truth = {}
    rows = zip(fits.participant.tolist(), fits.specimen.tolist(), fits.repetition.tolist(), fits.start_s, strict=True)
    for participant, specimen, repetition, start_s in rows:
        known = np.array(presses.get((participant, specimen), np.empty((0, 3))))
        if known.size and np.abs(known[:, 0] - start_s).min() <= ONSET_TOLERANCE_S:
            _, a_v, b_v = known[np.abs(known[:, 0] - start_s).argmin()].tolist()
            truth[participant, specimen, repetition] = (a_v, b_v)
    return truth


@dataclass(frozen=True)
class Recovery:
    """Recovery of the truth over the usable trials whose truth is known; errors of b are relative to the true b of
    the trial.

    ``..._mcse`` are Monte-Carlo standard errors: what another seed would change.
    """

    n: int = field(metadata=shown("Trials"))
    mean_b_error: float = field(metadata=shown("Mean error of b (%)", 100.0))
    mean_b_error_mcse: float = field(metadata=shown("Monte-Carlo SE (%)", 100.0, 2))
    sd_b_error: float = field(metadata=shown("SD of the error of b (%)", 100.0))
    coverage: float = field(metadata=shown("Intervals that hold the true b (%)", 100.0))
    coverage_mcse: float = field(metadata=shown("Monte-Carlo SE (%)", 100.0, 2))
    confidence: float


def recover(fits: Fits, truth: Truth, use: str, specimen: str | None = None) -> Recovery:
    """Recovery over all specimens, or over one."""
    keys = zip(fits.participant.tolist(), fits.specimen.tolist(), fits.repetition.tolist(), strict=True)
    true_b = np.array([truth.get(key, (np.nan, np.nan))[1] for key in keys], dtype=np.float64)
    entering = usable(fits, use) & np.isfinite(true_b)
    if specimen is not None:
        entering &= fits.specimen == specimen
    n = int(np.count_nonzero(entering))
    if n == 0:
        nan = float("nan")
        return Recovery(0, nan, nan, nan, nan, nan, fits.confidence)
    true_b = true_b[entering]
    error = fits.b_v[entering] / true_b - 1
    coverage = float(np.mean((fits.b_lo_v[entering] <= true_b) & (true_b <= fits.b_hi_v[entering])))
    spread = float(np.std(error, ddof=1)) if n > 1 else float("nan")
    return Recovery(
        n=n,
        mean_b_error=float(np.mean(error)),
        mean_b_error_mcse=spread / n**0.5,
        sd_b_error=spread,
        coverage=coverage,
        coverage_mcse=(coverage * (1 - coverage) / n) ** 0.5,
        confidence=fits.confidence,
    )

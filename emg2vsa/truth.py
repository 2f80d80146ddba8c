"""The truth of a synthetic study, matched to the trials that were found."""

from __future__ import annotations

import csv
from pathlib import Path

import numpy as np

from emg2vsa.errors import DataError
from emg2vsa.fits import Fits

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
        with path.open(newline="") as file:
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

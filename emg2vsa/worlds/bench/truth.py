"""What is true of the presses of an emulated run, kept with it in truth.json, to hold their scores against."""

from __future__ import annotations

import json
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import ArrayLike

from casr.spread import WINDOW_N
from emg2vsa.arrays import Floats
from emg2vsa.errors import DataError
from emg2vsa.worlds import VERSION

TRUTH_FILE = "truth.json"
_DO = "Emulate the run again."


@dataclass(frozen=True, eq=False)
class TrueLoading:
    """One press: (N,) force down the probe's axis, N, rising, and contact area, mm2, on its own loading.

    Bodies that creep have no common area over force: it depends on how fast a press was.
    """

    force_n: Floats
    area_mm2: Floats

    def area_at(self, force_n: ArrayLike) -> Floats:
        """Area, mm2, at forces of any shape, straight between the logarithms; NaN beyond the loading and for NaN."""
        asked = np.asarray(force_n, dtype=np.float64)
        pressed = (self.force_n > 0) & (self.area_mm2 > 0)
        if not pressed.any():
            return np.full(asked.shape, np.nan)
        asked = np.where(asked > 0, asked, np.nan)
        log_force, log_area = np.log(self.force_n[pressed]), np.log(self.area_mm2[pressed])
        log_area = np.interp(np.log(asked), log_force, log_area, left=np.nan, right=np.nan)
        return np.asarray(np.exp(log_area), dtype=np.float64)

    @property
    def a_c0_mm2(self) -> float:
        """Area, mm2, at the force at which CASR begins."""
        return float(self.area_at(WINDOW_N[0]))

    @property
    def casr_mm2_per_n(self) -> float:
        """Mean rate, mm2/N, from the lower to the higher force over which CASR is defined, as scores have it."""
        first, last = self.area_at(WINDOW_N).tolist()
        return float(last - first) / (WINDOW_N[1] - WINDOW_N[0])


_NONE = TrueLoading(np.empty(0), np.empty(0))


def truth_text(loadings: Sequence[TrueLoading]) -> str:
    """truth.json of a run: for each press its loading, A_c0 and CASR; null where the press did not come so far."""
    presses = [
        {
            "a_c0_mm2": _number(each.a_c0_mm2),
            "casr_mm2_per_n": _number(each.casr_mm2_per_n),
            "force_n": np.round(each.force_n, 5).tolist(),
            "area_mm2": np.round(each.area_mm2, 4).tolist(),
        }
        for each in loadings
    ]
    return json.dumps({"world": VERSION, "presses": presses}) + "\n"


def read_truth(folder: Path) -> list[TrueLoading]:
    """What truth.json of a run says of each press. DataError where it is missing or broken."""
    path = folder / TRUTH_FILE
    try:
        presses = json.loads(path.read_text(encoding="utf-8"))["presses"]
        pairs = [(np.array(each["force_n"], float), np.array(each["area_mm2"], float)) for each in presses]
    except OSError as error:
        raise DataError(
            path, wanted="the truth of an emulated run", found=error.strerror or "no file", do=_DO
        ) from error
    except (ValueError, KeyError, TypeError) as error:
        raise DataError(path, wanted="forces and areas of each press", found=repr(error), do=_DO) from error
    for force_n, area_mm2 in pairs:
        if force_n.ndim != 1 or force_n.shape != area_mm2.shape or not np.all(np.diff(force_n) > 0):
            raise DataError(path, wanted="rising forces, each with its area", found="other numbers", do=_DO)
    return [TrueLoading(*pair) for pair in pairs]


def true_areas_mm2(folders: Sequence[Path], force_n: ArrayLike) -> Floats:
    """(R,) true area, mm2, of the presses of these folders at ``force_n``[r], N along the probe's axis.

    NaN for NaN, and where the press was not loaded so far. DataError as `read_truth`.
    """
    loadings: list[TrueLoading] = []
    for folder in folders:
        numbers = [int(press.name.rpartition("-")[2]) for press in sorted(folder.glob("press-*"))]
        of_run = dict(enumerate(read_truth(folder), start=1))
        loadings += [of_run.get(number, _NONE) for number in numbers]
    forces = np.asarray(force_n, dtype=np.float64).tolist()
    return np.array([float(loading.area_at(at)) for loading, at in zip(loadings, forces, strict=True)])


def _number(value: float) -> float | None:
    return round(value, 6) if np.isfinite(value) else None

"""The stiffness of the new specimen in a world, as the stage of calibration would hand it on; without bootstrap."""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence

import numpy as np

from benchmarks.claims.worlds import ALGORITHMS, KAPPA
from emg2vsa.calibration.calibrate import calibrate
from emg2vsa.calibration.forms import casr_angle_share, casr_exponent, specimen_share
from emg2vsa.calibration.mountings import MountingScatter, mounting_scatter, pooled
from emg2vsa.calibration.one_condition import law_result
from emg2vsa.calibration.results import AlgorithmResult, CalibrationResults, ConditionResult, LawResult
from emg2vsa.calibration.unknown import estimate
from emg2vsa.discrimination.run_table import RunTable
from emg2vsa.settings import CalibrationSettings

CASR_UNIT, HERTZ = "mm2/N", 2 / 3
_OF_OTHERS = {("high-stiffness", "circle"), ("high-stiffness", "paper"), ("modular", "paper")}
"Conditions and algorithms that claims ask for, besides those of the front."
_FIELDS = dataclasses.fields(MountingScatter)
_Laws = dict[tuple[int, int, str], LawResult]
"Of study, design and algorithm."


def calibrations_of(tables: Sequence[RunTable], settings: CalibrationSettings) -> list[CalibrationResults]:
    """Of studies that were mounted alike, by the law of the settings; the paper's law, which no claim asks for, is left
    out, and that of the settings stands in its place."""
    laws = _all_laws(tables, settings)
    return [_results(number, table, laws) for number, table in enumerate(tables)]


def _all_laws(tables: Sequence[RunTable], settings: CalibrationSettings) -> _Laws:
    angles = tables[0].angles_deg.tolist()
    asked = {(condition, "front") for condition in tables[0].conditions} | _OF_OTHERS
    found: _Laws = {}
    for name in ALGORITHMS:
        scatters = [_scatter(table, name, settings) for table in tables]
        for angle in dict.fromkeys(angles):
            designs = [d for d, other in enumerate(angles) if other == angle]
            own = [d for d in designs if (tables[0].conditions[d], name) in asked]
            if not own:
                continue
            casr = np.concatenate([table.casr[name][own] for table in tables])
            scatter = MountingScatter(
                *(np.concatenate([getattr(each, field.name)[own] for each in scatters]) for field in _FIELDS)
            )
            places = [(number, design, name) for number in range(len(tables)) for design in own]
            found |= dict(zip(places, _laws(tables[0], casr, scatter, name, angle, settings), strict=True))
    return found


def _scatter(table: RunTable, algorithm: str, settings: CalibrationSettings) -> MountingScatter:
    """Of the mountings of every design (D,), as all of them together show."""
    return pooled(mounting_scatter(table.casr[algorithm], table.mounting[0], settings.mounting_sd_percent / 100))


def _laws(
    table: RunTable,
    casr: np.ndarray,
    scatter: MountingScatter,
    algorithm: str,
    angle: float,
    settings: CalibrationSettings,
) -> list[LawResult]:
    """Of scores (d, S, R) of one algorithm at one angle."""
    known, labels = table.known, table.mounting[0]
    calibration = calibrate(
        KAPPA[known], casr[:, known], settings, casr_unit=CASR_UNIT,
        specimens=tuple(table.specimens[i] for i in known), specimen_share=specimen_share(algorithm),
        angle_share=casr_angle_share(algorithm, angle, settings.angle_sd_deg),
        scatter=scatter, mountings=labels[known], other_exponent=casr_exponent(HERTZ),
    )  # fmt: skip
    truth = float(KAPPA[table.new])
    found = estimate(calibration, casr[:, table.new], np.asarray(labels[table.new]), known=truth, bootstrap=False)
    return [law_result(found, truth, i) for i in range(len(casr))]


def _results(number: int, table: RunTable, laws: _Laws) -> CalibrationResults:
    known, new = table.known, table.new
    conditions = tuple(
        ConditionResult(
            angle_deg=angle, condition=condition, simulated=True,
            specimens=tuple(table.specimens[i] for i in known), known_kappa=KAPPA[known], exponent=1 / HERTZ,
            algorithms={
                name: AlgorithmResult(
                    casr=table.casr[name][d, known], new_casr=table.casr[name][d, new], casr_unit=CASR_UNIT,
                    chosen=laws[number, d, name], paper=laws[number, d, name], left_out_rms={}, best_law="", fused=None,
                )
                for name in ALGORITHMS
                if (number, d, name) in laws
            },
            indentation=None,
        )
        for d, (condition, angle) in enumerate(zip(table.conditions, table.angles_deg.tolist(), strict=True))
    )  # fmt: skip
    return CalibrationResults(table.specimens[new], float(KAPPA[new]), conditions, ())

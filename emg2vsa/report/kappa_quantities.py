"""Every number of the calibration under one flat name: ``runs.<condition>.<angle>.<algorithm>.kappa...``."""

from __future__ import annotations

from emg2vsa.calibration.results import AlgorithmResult, CalibrationResults
from emg2vsa.report.quantity import Items, Quantity


def kappa_quantities(found: CalibrationResults) -> dict[str, Quantity]:
    """Name to value; NaN where a number is not defined."""
    return dict(_items(found))


def _items(found: CalibrationResults) -> Items:
    yield "runs.kappa.new_specimen", found.new_specimen
    yield "runs.kappa.known_n_per_mm", found.known_kappa_new
    for each in found.conditions:
        for name, of in each.algorithms.items():
            yield from _algorithm(f"runs.{each.condition}.{each.angle_deg:g}.{name}.kappa", of)


def _algorithm(name: str, of: AlgorithmResult) -> Items:
    for prefix, law in (("", of.chosen), ("paper_law.", of.paper)):
        yield f"{name}.{prefix}n_per_mm", law.kappa
        yield f"{name}.{prefix}n_per_mm.low", law.low
        yield f"{name}.{prefix}n_per_mm.high", law.high
        yield f"{name}.{prefix}error", law.error
        yield f"{name}.{prefix}adj_r2", law.adj_r2
        yield f"{name}.{prefix}law", law.law
        for key, value in zip(("first", "second"), law.parameters, strict=True):
            yield f"{name}.{prefix}parameter.{key}", value
    for law_name, rms in of.left_out_rms.items():
        yield f"{name}.left_out_rms.{law_name}", rms
    if of.fused is not None:
        yield f"{name}.fused.n_per_mm", of.fused.kappa
        yield f"{name}.fused.error", of.fused.error
        yield f"{name}.fused.weight", of.fused.weight

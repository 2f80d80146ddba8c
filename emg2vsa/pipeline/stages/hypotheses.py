"""Hypotheses: the tests on b."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from emg2vsa.pipeline.stage import Given, Keyed, Stage
from emg2vsa.readers.acquisition_order import order_files, places

if TYPE_CHECKING:
    from collections.abc import Iterator, Sequence
    from pathlib import Path

    from emg2vsa.fits import Fits
    from emg2vsa.hypotheses import Hypotheses
    from emg2vsa.pipeline.campaign import Campaign


def settings(campaign: Campaign, item: str) -> dict[str, Any]:
    study = campaign.study
    recordings = {(entry.participant, entry.specimen): entry.emg_file for entry in study.recordings}
    return {
        "hypotheses": study.hypotheses,
        "participants": study.participants,
        "palpated": study.palpated,
        "recordings": Keyed(recordings, [(*cell, path.name) for cell, path in recordings.items()]),
    }


def files(campaign: Campaign, item: str) -> dict[str, Sequence[Path]]:
    """What tells the order of the recordings."""
    study = campaign.study
    return {"order": order_files((entry.emg_file for entry in study.recordings), study.data)}


def run(given: Given) -> Hypotheses:
    """One recording at a time: of its force bins only their mean and what the laws say of them is kept."""
    from emg2vsa.companions.force_laws import CellErrors, cell_errors, compare_laws
    from emg2vsa.companions.law_misfit import CellMisfit, cell_misfits, compare_misfits
    from emg2vsa.companions.whole_curve import CellCurve, cell_curves, compare_curves
    from emg2vsa.fits import concatenate
    from emg2vsa.hypotheses import test_hypotheses
    from emg2vsa.screening import screened

    of, screening = given.settings["hypotheses"], given.one("screening")
    errors: list[CellErrors] = []
    shapes: list[CellMisfit] = []
    means: list[CellCurve] = []

    def recordings() -> Iterator[Fits]:
        for each in given.each("fits"):
            fits = screened(each, screening)
            errors.extend(cell_errors(fits, of.use))
            shapes.extend(cell_misfits(fits, of.use, spline=True))
            means.extend(cell_curves(fits, of.use))
            yield fits

    fits = concatenate(recordings(), bins=False)
    laws, misfits = compare_laws(errors, 1 - of.alpha), compare_misfits(shapes, 1 - of.alpha)
    curves = compare_curves(means, of.alpha)
    began = {(trials.participant, trials.specimen): trials.began for trials in given.each("trials")}
    order = places(given.settings["recordings"], given.files["order"], began)
    asked = given.settings["participants"], given.settings["palpated"]
    return test_hypotheses(fits, of, *asked, laws, misfits, curves, order)


STAGE = Stage(
    per="study",
    of="people",
    needs=("fits", "trials", "screening"),
    run=run,
    settings=settings,
    files=files,
    gives="The tests on people are",
)

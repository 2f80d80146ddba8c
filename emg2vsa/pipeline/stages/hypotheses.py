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
    from emg2vsa.study import RecordingEntry


def settings(campaign: Campaign, item: str) -> dict[str, Any]:
    study = campaign.study
    recordings = {(entry.participant, entry.specimen): _first_files(entry) for entry in study.recordings}
    return {
        "hypotheses": study.hypotheses,
        "participants": study.participants,
        "palpated": study.palpated,
        "recordings": Keyed(recordings, [(*cell, *(path.name for path in own)) for cell, own in recordings.items()]),
    }


def _first_files(entry: RecordingEntry) -> tuple[Path, ...]:
    """Files of the first recording of each visit."""
    found: dict[str, Path] = {}
    for part in entry.parts:
        found.setdefault(part.visit, part.emg_file)
    return tuple(found.values())


def files(campaign: Campaign, item: str) -> dict[str, Sequence[Path]]:
    """What tells the order of the recordings."""
    study = campaign.study
    return {"order": order_files((part.emg_file for entry in study.recordings for part in entry.parts), study.data)}


def run(given: Given) -> Hypotheses:
    """One recording at a time: of its force bins only their mean and what the laws say of them is kept."""
    from statistics import fmean

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

    def each_fit() -> Iterator[Fits]:
        for each in given.each("fits"):
            fits = screened(each, screening)
            errors.extend(cell_errors(fits, of.use))
            shapes.extend(cell_misfits(fits, of.use, spline=True))
            means.extend(cell_curves(fits, of.use))
            yield fits

    fits = concatenate(each_fit(), bins=False)
    laws, misfits = compare_laws(errors, 1 - of.alpha), compare_misfits(shapes, 1 - of.alpha)
    curves = compare_curves(means, of.alpha)
    began = {(trials.participant, trials.specimen): trials.began for trials in given.each("trials")}
    recordings = given.settings["recordings"]
    at = [
        places({cell: own[n] for cell, own in recordings.items() if n < len(own)}, given.files["order"], began)
        for n in range(max(map(len, recordings.values()), default=0))
    ]
    order = {cell: fmean(place[cell] for place in at if cell in place) for cell in recordings}
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

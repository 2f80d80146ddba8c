"""Hypotheses: the tests on b."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from emg2vsa.pipeline.stage import Given, Stage

if TYPE_CHECKING:
    from collections.abc import Iterator

    from emg2vsa.fits import Fits
    from emg2vsa.hypotheses import Hypotheses
    from emg2vsa.pipeline.campaign import Campaign


def settings(campaign: Campaign, item: str) -> dict[str, Any]:
    study = campaign.study
    return {"hypotheses": study.hypotheses, "participants": study.participants, "palpated": study.palpated}


def run(given: Given) -> Hypotheses:
    """One recording at a time: of its force bins only what the laws say of them is kept."""
    from emg2vsa.companions.force_laws import CellErrors, cell_errors, compare_laws
    from emg2vsa.fits import concatenate
    from emg2vsa.hypotheses import test_hypotheses

    of = given.settings["hypotheses"]
    errors: list[CellErrors] = []

    def recordings() -> Iterator[Fits]:
        for fits in given.each("fits"):
            errors.extend(cell_errors(fits, of.use))
            yield fits

    fits = concatenate(recordings(), bins=False)
    laws = compare_laws(errors, 1 - of.alpha)
    return test_hypotheses(fits, of, given.settings["participants"], given.settings["palpated"], laws)


STAGE = Stage(per="study", of="people", needs=("fits",), run=run, settings=settings, gives="The tests on people are")

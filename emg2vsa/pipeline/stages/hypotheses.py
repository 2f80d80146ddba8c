"""Hypotheses: the tests on b."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from emg2vsa.pipeline.stage import Given, Stage

if TYPE_CHECKING:
    from emg2vsa.hypotheses import Hypotheses
    from emg2vsa.pipeline.campaign import Campaign


def settings(campaign: Campaign, item: str) -> dict[str, Any]:
    study = campaign.study
    return {"hypotheses": study.hypotheses, "participants": study.participants, "palpated": study.palpated}


def run(given: Given) -> Hypotheses:
    from emg2vsa.fits import concatenate
    from emg2vsa.hypotheses import test_hypotheses

    of = given.settings
    return test_hypotheses(concatenate(given.each("fits")), of["hypotheses"], of["participants"], of["palpated"])


STAGE = Stage(per="study", of="people", needs=("fits",), run=run, settings=settings, gives="The tests on people are")

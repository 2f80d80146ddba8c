"""Studies of a world, from their draws to the verdicts of all claims together, as the report judges them."""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence
from functools import cache
from itertools import product
from pathlib import Path

import numpy as np

from benchmarks.claims.kappa import calibrations_of
from benchmarks.claims.laws import laws_of
from benchmarks.claims.people import drawn, fits_of
from benchmarks.claims.rig import Draw, even, table_of
from benchmarks.claims.worlds import SPECIMENS, World
from emg2vsa.claims.claim import OF_A_STUDY, Claim, Judged, judge
from emg2vsa.claims.kappa import kappa_claims
from emg2vsa.claims.people import claims_of_study
from emg2vsa.claims.rig import rig_claims
from emg2vsa.study import Study
from emg2vsa.study_file import load_study

STUDY = Path(__file__).resolve().parents[2] / "studies" / "palpation" / "study.toml"
MANY_PEOPLE, MANY_MOUNTINGS, MANY_PRESSES = 500, 60, 9
"People, and mountings and presses, of the study from which a world's true values are read."


@cache
def study_of(people: int) -> Study:
    """The demo's study with so many participants, whose profiles are means over people."""
    study = load_study(STUDY)
    return dataclasses.replace(
        study, participants=tuple(f"P{i + 1:02d}" for i in range(people)),
        profile=dataclasses.replace(study.profile, participant=None),
    )  # fmt: skip


def claims_of(world: World, seeds: Sequence[int], draw: Draw = drawn) -> list[list[Claim]]:
    """All claims on data of the study of each seed. draw : of the rig's scatter."""
    study = study_of(world.people.people)
    rngs = [np.random.default_rng([seed, *world.name.encode()]) for seed in seeds]
    tables = [table_of(world.rig, rng, draw) for rng in rngs]
    calibrations = calibrations_of(tables, study.calibration)
    found = []
    for rng, table, calibration in zip(rngs, tables, calibrations, strict=True):
        fits, places = fits_of(world.people, rng)
        place = dict(zip(product(study.participants, SPECIMENS), places.ravel().tolist(), strict=True))
        found.append(
            [
                *claims_of_study(study, fits, place, laws_of(fits, world.people.presses)),
                *rig_claims(table, study.calibration.mounting_sd_percent / 100, study.claims),
                *kappa_claims(calibration, study.scoring.algorithm, study.claims),
            ]
        )
    return found


def judged(world: World, seeds: Sequence[int]) -> list[tuple[Judged, ...]]:
    """The verdicts of the study of each seed."""
    alpha = study_of(world.people.people).claims.false_verdict_percent / 100
    return [judge(claims, alpha, OF_A_STUDY) for claims in claims_of(world, seeds)]


def truth_of(world: World) -> dict[str, tuple[float, float, str]]:
    """Claim to its estimand in this world, its margin and what it asserts: of a study of very many people, and of
    mountings and presses whose scatter cancels in every cell; without drift."""
    large = dataclasses.replace(
        world,
        people=dataclasses.replace(world.people, people=MANY_PEOPLE, drift=0.0, order="random"),
        rig=dataclasses.replace(
            world.rig, mountings=MANY_MOUNTINGS, presses=MANY_PRESSES, drift=0.0, serial=0.0, order="random"
        ),
    )  # fmt: skip
    (claims,) = claims_of(large, [0], even)
    found = {claim.key: (claim.found.estimate, claim.margin, claim.asserts) for claim in claims}
    if world.people.b[0] == world.people.b[2]:  # of the neighbours' difference, which is none, no error is a share
        found["interpolation_rmse"] = (np.nan, *found["interpolation_rmse"][1:])
    return found

"""The stage that computes what stiffness can do, from the settings of a rig file."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from emg2vsa.pipeline.campaign import campaign
from emg2vsa.pipeline.stage import Given
from emg2vsa.pipeline.stages.stiffness import STAGE
from emg2vsa.study_file import load_study

STUDY = Path(__file__).parents[2] / "studies" / "palpation" / "study.toml"


def given(**changed: object) -> Given:
    settings = STAGE.settings(campaign(load_study(STUDY)), "study")
    return Given("study", settings | changed)


def test_without_schedules_there_are_constants_alone() -> None:
    effect = STAGE.run(given())
    assert effect.specimens == ("S1", "S_new", "S3", "S5")
    assert effect.conditions == ("high-stiffness", "all-20", "all-80")
    assert np.ptp(effect.contrast(effect.rate)[0]) < 1e-4
    assert STAGE.says(effect) == ""


@pytest.mark.parametrize("skin", ["finite-elements", "sticking"])
def test_the_area_is_that_of_the_skin(skin: str) -> None:
    effect = STAGE.run(given(skin=skin))
    rigid = float(effect.contrast(effect.rate)[0, 0])
    assert rigid == pytest.approx(0.5527 if skin == "sticking" else 0.3427, abs=2e-3)


def test_one_specimen_has_no_contrast() -> None:
    found = STAGE.run(given(stiffness={"S1": 7.63}))
    assert found is None
    assert "two specimens or more" in STAGE.says(found)


def test_of_the_bench_only_what_moves_and_creeps_counts() -> None:
    """Its scatter and its seed leave the step fresh; its relaxation does not."""
    found = campaign(load_study(STUDY))
    assert found.rig is not None
    assert found.rig.emulated is not None

    def key(**changed: object) -> dict[str, object]:
        emulated = replace(found.rig.emulated, **changed)
        return STAGE.settings(replace(found, rig=replace(found.rig, emulated=emulated)), "study")

    assert key(seed=5, landing_sd_mm=0.5) == key()
    assert key(sensor_relaxation=0.3) != key()
    elastic = key(world="elastic")
    assert (elastic["sensor_relaxation"], elastic["preset_latency_s"], set(elastic["relaxation"].values())) == (
        0,
        0,
        {0},
    )


@pytest.mark.parametrize(
    "changed",
    [
        {"ramp_mm_per_s": 1.0},
        {
            "sensor_relaxation": 0.0,
            "relaxation": dict.fromkeys(("S1", "S_new", "S3", "S5"), 0.0),
            "camera": (0.0, 0.0, 0.01),
            "preset_latency_s": 0.0,
        },
    ],
)
def test_a_slow_ramp_and_the_elastic_world_have_an_effect_too(changed: dict[str, object]) -> None:
    assert STAGE.run(given(**changed)) is not None

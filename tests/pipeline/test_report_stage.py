"""What the report takes beside the results of other steps: the order of the runs."""

from __future__ import annotations

import json
from types import SimpleNamespace

import pytest

from emg2vsa.errors import DataError
from emg2vsa.pipeline.stage import Given
from emg2vsa.pipeline.stages.report import _run_order, files
from emg2vsa.study import RunsSource


def given(*paths, drawn=None):
    return Given("study", {"run_order": drawn}, {"order": paths})


def test_the_order_of_an_emulated_rig_is_that_of_its_file(tmp_path):
    assert _run_order(given(drawn=("random", 3))) == "random, seed 3"
    assert _run_order(given(drawn=("listed", 3))) == "listed"
    assert _run_order(given()) == ""


def test_the_order_of_measured_runs_is_the_one_that_the_rig_kept(tmp_path):
    study = SimpleNamespace(
        data=tmp_path, recordings=(), runs_source=RunsSource(tmp_path, None, None, tmp_path / "plates")
    )
    campaign = SimpleNamespace(study=study, rig=None)
    assert files(campaign, "study")["order"] == []
    path = tmp_path / "order.json"
    path.write_text(json.dumps({"order": "random", "seed": 5, "runs": []}))
    assert files(campaign, "study")["order"] == [path]
    assert _run_order(given(path)) == "random, seed 5"


@pytest.mark.parametrize("text", ["{", "[]", '{"order": "random"}'])
def test_a_damaged_order_is_one_error(tmp_path, text):
    path = tmp_path / "order.json"
    path.write_text(text)
    with pytest.raises(
        DataError, match=r"order.json: expected the order .* found a file that tells no order and seed.*Put back"
    ):
        _run_order(given(path))

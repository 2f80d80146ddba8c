"""What a study is made of: who is recorded on what and when, its truth, and bytes that its seed alone fixes."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Callable
from dataclasses import replace
from itertools import pairwise
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from emg2vsa.errors import SettingError
from emg2vsa.study import Study
from emg2vsa.worlds import VERSION
from emg2vsa.worlds.people.plan import plan_study
from emg2vsa.worlds.people.study import WRITERS, Format, simulate_study

Make = Callable[..., Study]


def digests(folder: Path) -> dict[str, str]:
    files = (path for path in folder.rglob("*") if path.is_file())
    return {path.relative_to(folder).as_posix(): hashlib.sha256(path.read_bytes()).hexdigest() for path in files}


@pytest.mark.parametrize("format", list(WRITERS))
def test_a_recording_depends_on_the_seed_and_on_no_other_recording(
    study_with: Make, tmp_path: Path, format: Format
) -> None:
    def made(name: str, participants: int = 1, seed: int = 1) -> list[bytes]:
        study = study_with(participants=participants, seed=seed)
        return [path.read_bytes() for path in simulate_study(study, tmp_path / name, format=format).recordings]

    first = made("first")
    assert made("again") == first == made("more", participants=2)[:2]
    assert digests(tmp_path / "again") == digests(tmp_path / "first")
    assert len(set(first + made("other", seed=2))) == 4
    assert {path.name for path in tmp_path.rglob(".*")} <= {".bidsignore"}


def test_truth_is_what_the_recordings_were_made_from(study: Study, tmp_path: Path) -> None:
    made = simulate_study(study, tmp_path, format="csv")
    truth = pd.read_csv(made.truth, sep="\t")
    assert json.loads(made.truth.with_suffix(".json").read_text())["World"] == VERSION
    settings, plan = plan_study(study)
    assert len(truth) == 8
    for planned in plan:
        rows = truth[(truth.participant == planned.participant) & (truth.specimen == planned.specimen)]
        expected = planned.make(settings).truth
        assert rows.repetition.tolist() == [1, 2]
        for column, values in {
            "a_v": expected.a_v,
            "b_v": expected.b_v,
            "onset_s": expected.presses.onset_s,
            "stop_s": expected.presses.stop_s,
            "peak_force_n": expected.presses.peak_force_n,
            "largest_fall_n": expected.presses.largest_fall_n,
        }.items():
            np.testing.assert_array_equal(rows[column], values)


def test_order_of_the_specimens_is_recorded_in_time(study_with: Make, tmp_path: Path) -> None:
    simulate_study(study_with(participants=3, specimens=3), tmp_path, format="csv")
    order = pd.read_csv(tmp_path / "order.tsv", sep="\t", parse_dates=["acq_time"])
    assert order.acq_time.is_monotonic_increasing
    assert order.order.tolist() == [1, 2, 3] * 3
    assert order.groupby("participant").specimen.nunique().tolist() == [3, 3, 3]


def test_progress_counts_every_recording(study: Study, tmp_path: Path) -> None:
    seen: list[tuple[int, int, str]] = []
    simulate_study(study, tmp_path, format="csv", progress=lambda *step: seen.append(step))
    assert [step[:2] for step in seen] == [(0, 4), (1, 4), (2, 4), (3, 4), (4, 4)]
    assert seen[0][2] == "P01/S1"


def test_every_cell_once_and_each_participant_in_an_order_of_its_own(study_with: Make) -> None:
    _, plan = plan_study(study_with(participants=6, specimens=5))
    assert [(r.participant, r.specimen) for r in plan[:6]] == [*(("P01", f"S{i}") for i in range(1, 6)), ("P02", "S1")]
    orders = [tuple(r.position for r in plan[i : i + 5]) for i in range(0, 30, 5)]
    assert all(sorted(order) == [1, 2, 3, 4, 5] for order in orders)
    assert len(set(orders)) > 1


def test_acquisition_times_follow_the_order(study_with: Make) -> None:
    _, plan = plan_study(study_with(participants=3, specimens=4))
    for i in range(0, 12, 4):
        in_time = sorted(plan[i : i + 4], key=lambda r: r.acquired)
        assert [r.position for r in in_time] == [1, 2, 3, 4]
        assert len({r.acquired.date() for r in in_time}) == 1
    assert len({r.acquired for r in plan}) == 12


def test_long_recordings_do_not_overlap(study_with: Make) -> None:
    settings, plan = plan_study(study_with(participants=1, specimens=3, repetitions=50))
    begun = sorted(plan, key=lambda r: r.acquired)
    for first, second in pairwise(begun):
        assert first.make(settings).duration_s < (second.acquired - first.acquired).total_seconds()


def test_coefficients_are_the_specimens_own_unless_participants_differ(study_with: Make) -> None:
    _, plan = plan_study(study_with(participants=3))
    assert [r.b_v for r in plan] == pytest.approx([15e-6, 14e-6] * 3)
    _, plan = plan_study(study_with(participants=200, specimens=1, participant_sd=0.1))
    b_v = np.array([r.b_v for r in plan])
    assert np.std(b_v) / 15e-6 == pytest.approx(0.1, rel=0.2)
    assert np.mean(b_v) / 15e-6 == pytest.approx(1.0, abs=0.03)


def test_a_participant_differs_alike_on_all_specimens(study_with: Make) -> None:
    _, plan = plan_study(study_with(participants=4, participant_sd=0.1))
    for first, second in zip(plan[::2], plan[1::2], strict=True):
        assert first.b_v / 15e-6 == pytest.approx(second.b_v / 14e-6)
        assert first.a_v / first.b_v == pytest.approx(2.0)


def test_a_study_without_simulation_is_refused(study: Study) -> None:
    with pytest.raises(SettingError, match=r"\[simulation\]"):
        plan_study(replace(study, simulation=None))

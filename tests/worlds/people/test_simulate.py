from __future__ import annotations

import hashlib
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from emg2vsa.errors import SettingError
from emg2vsa.study import Study
from emg2vsa.worlds.people.plan import plan_study
from emg2vsa.worlds.people.study import WRITERS, Format, simulate_study

Make = Callable[..., Study]


def digests(folder: Path) -> dict[str, str]:
    files = (path for path in folder.rglob("*") if path.is_file())
    return {path.relative_to(folder).as_posix(): hashlib.sha256(path.read_bytes()).hexdigest() for path in files}


@pytest.mark.parametrize("format", list(WRITERS))
def test_same_seed_same_bytes(study: Study, tmp_path: Path, format: Format) -> None:
    simulate_study(study, tmp_path / "first", format=format)
    simulate_study(study, tmp_path / "second", format=format)
    assert digests(tmp_path / "first") == digests(tmp_path / "second")
    assert len(digests(tmp_path / "first")) >= 4 + 4


@pytest.mark.parametrize("format", list(WRITERS))
def test_another_seed_gives_other_recordings(study_with: Make, tmp_path: Path, format: Format) -> None:
    first = simulate_study(study_with(seed=1), tmp_path / "first", format=format)
    second = simulate_study(study_with(seed=2), tmp_path / "second", format=format)
    for one, other in zip(first.recordings, second.recordings, strict=True):
        assert one.read_bytes() != other.read_bytes()


@pytest.mark.parametrize("format", list(WRITERS))
def test_a_recording_does_not_depend_on_the_others(study_with: Make, tmp_path: Path, format: Format) -> None:
    more = simulate_study(study_with(participants=3), tmp_path / "more", format=format)
    fewer = simulate_study(study_with(participants=1), tmp_path / "fewer", format=format)
    for one, other in zip(fewer.recordings, more.recordings[:2], strict=True):
        assert one.read_bytes() == other.read_bytes()


def test_recordings_of_one_study_differ(study: Study, tmp_path: Path) -> None:
    made = simulate_study(study, tmp_path, format="csv")
    assert len({path.read_bytes() for path in made.recordings}) == 4


def test_truth_is_what_the_recordings_were_made_from(study: Study, tmp_path: Path) -> None:
    made = simulate_study(study, tmp_path, format="csv")
    truth = pd.read_csv(made.truth, sep="\t")
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


def test_unknown_format_is_refused(study: Study, tmp_path: Path) -> None:
    with pytest.raises(SettingError, match="bids or csv or emgworks or c3d"):
        simulate_study(study, tmp_path, format="xls")  # type: ignore[arg-type]


def test_no_part_file_is_left(study: Study, tmp_path: Path) -> None:
    for format in WRITERS:
        simulate_study(study, tmp_path / format, format=format)  # type: ignore[arg-type]
    names = {path.name for path in tmp_path.rglob(".*")}
    assert names <= {".bidsignore"}

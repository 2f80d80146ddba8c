from __future__ import annotations

from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

from emg2vsa.errors import DataError
from emg2vsa.truth import ONSET_TOLERANCE_S, read_truth

HEAD = "participant\tspecimen\trepetition\ta_v\tb_v\tonset_s"


def fits_of(*trials: tuple[str, str, int, float]) -> SimpleNamespace:
    """The columns of Fits that are matched: participant, specimen, repetition, start_s."""
    columns = list(zip(*trials, strict=True)) or [(), (), (), ()]
    names = ("participant", "specimen", "repetition", "start_s")
    return SimpleNamespace(**{name: np.array(column) for name, column in zip(names, columns, strict=True)})


@pytest.fixture
def table(tmp_path: Path):
    def write(*rows: str, head: str = HEAD) -> Path:
        path = tmp_path / "truth.tsv"
        path.write_text("\n".join([head, *rows, ""]))
        return path

    return write


THREE = ("P01\tS1\t1\t4e-05\t2e-05\t3.0", "P01\tS1\t2\t4e-05\t2.1e-05\t9.0", "P01\tS1\t3\t4e-05\t2.2e-05\t15.0")


def test_every_trial_gets_its_press(table):
    found = read_truth(table(*THREE), fits_of(("P01", "S1", 1, 3.02), ("P01", "S1", 2, 8.9), ("P01", "S1", 3, 15.0)))
    assert found == {("P01", "S1", i): (4e-5, b) for i, b in ((1, 2e-5), (2, 2.1e-5), (3, 2.2e-5))}


def test_a_missed_press_does_not_shift_the_others(table):
    found = read_truth(table(*THREE), fits_of(("P01", "S1", 1, 9.05), ("P01", "S1", 2, 15.1)))
    assert found == {("P01", "S1", 1): (4e-5, 2.1e-5), ("P01", "S1", 2): (4e-5, 2.2e-5)}


@pytest.mark.parametrize(("off_s", "known"), [(0.9 * ONSET_TOLERANCE_S, True), (1.1 * ONSET_TOLERANCE_S, False)])
def test_a_trial_far_from_any_press_has_no_truth(table, off_s, known):
    for sign in (1, -1):
        found = read_truth(table(*THREE), fits_of(("P01", "S1", 1, 9.0 + sign * off_s)))
        assert (("P01", "S1", 1) in found) is known


def test_recordings_are_not_mixed_up(table):
    path = table(THREE[0], "P02\tS1\t1\t1e-05\t1e-06\t3.0", "P01\tS2\t1\t2e-05\t3e-06\t3.0")
    found = read_truth(path, fits_of(("P01", "S2", 1, 3.0), ("P02", "S1", 1, 3.0), ("P09", "S1", 1, 3.0)))
    assert found == {("P01", "S2", 1): (2e-5, 3e-6), ("P02", "S1", 1): (1e-5, 1e-6)}


def test_no_trials_no_truth(table):
    assert read_truth(table(*THREE), fits_of()) == {}


@pytest.mark.parametrize(
    ("rows", "head"),
    [
        (THREE, HEAD.replace("b_v", "slope")),
        (("P01\tS1\t1\tmuch\t2e-05\t3.0",), HEAD),
        (("P01\tS1\t1",), HEAD),
    ],
)
def test_what_is_not_such_a_table_is_refused(table, rows, head):
    with pytest.raises(DataError, match=r"truth\.tsv"):
        read_truth(table(*rows, head=head), fits_of(("P01", "S1", 1, 3.0)))


def test_a_file_that_is_not_there_or_not_text_is_refused(tmp_path):
    with pytest.raises(DataError):
        read_truth(tmp_path / "none.tsv", fits_of())
    (tmp_path / "noise.tsv").write_bytes(b"\xff\xfe\x00\x81" * 20)
    with pytest.raises(DataError):
        read_truth(tmp_path / "noise.tsv", fits_of())

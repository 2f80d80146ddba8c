"""What presses tell of their specimen is read from the files of their run, and nothing is made up."""

from __future__ import annotations

import json
import math
from pathlib import Path
from typing import Any

import pytest

from emg2vsa.rig.record.press_counts import HEADER, PressCounts, line_of
from emg2vsa.run_folders.weighed import weighed_presses

LIKE = "this presses like S3 (3.4 N/mm, 95 %: 3 to 4), not S1, 7.63 N/mm"


def run(folder: Path, *presses: PressCounts, plan: object = None, **ended: Any) -> Path:
    """The files of a run on S1."""
    folder.mkdir()
    stated = {"specimen": "S1", "stiffness_n_per_mm": 7.63}
    (folder / "plan.json").write_text(json.dumps({"plan": stated if plan is None else plan}))
    (folder / "presses.csv").write_text("\n".join([HEADER, *map(line_of, presses)]).replace("\n\n", "\n"))
    if ended:
        (folder / "ended.json").write_text(json.dumps(ended))
    return folder


def press(number: int, *kappa: float, **more: Any) -> PressCounts:
    low = dict(zip(("kappa_n_per_mm", "kappa_low_n_per_mm", "kappa_high_n_per_mm"), kappa, strict=False))
    return PressCounts(number, **low, **more)


def test_every_press_says_in_words_what_it_is(tmp_path: Path) -> None:
    presses = press(1, 7.5, 6.5, math.inf), press(2, 3.4, 3.0, 4.0, verdict="doubtful", why=LIKE), press(3), press(4)
    ended = {"how": "guard", "cause": "specimen", "why": "the contact is 2 times as stiff", "repetitions_done": 3}
    found = [*weighed_presses([run(tmp_path / "S1_0_modular", *presses, **ended)])]
    assert [(each.verdict, each.said) for each in found] == [
        ("ok", "presses like S1"), ("doubtful", LIKE), ("ok", "too short to tell the specimen"),
        ("ended", "specimen: the contact is 2 times as stiff"),
    ]  # fmt: skip
    first = found[0]
    assert (first.folder, first.press, first.specimen, first.stated_n_per_mm) == ("S1_0_modular", 1, "S1", 7.63)
    assert (first.kappa_n_per_mm, first.low_n_per_mm, first.high_n_per_mm) == (7.5, 6.5, math.inf)
    assert math.isnan(found[2].kappa_n_per_mm)


def test_a_press_that_a_run_ended_in_is_told_where_none_has_kappa(tmp_path: Path) -> None:
    ended = {"how": "guard", "cause": "specimen", "why": "another", "repetitions_done": 0}
    (found,) = weighed_presses([run(tmp_path / "run", press(1), **ended)])
    assert (found.verdict, found.why) == ("ended", "specimen: another")


def test_an_unknown_specimen_is_compared_with_nothing(tmp_path: Path) -> None:
    plan = {"specimen": "pear", "stiffness_n_per_mm": None}
    (found,) = weighed_presses([run(tmp_path / "run", press(1, 5, 4, 6), plan=plan)])
    assert (found.verdict, found.said) == ("ok", "nothing stated to compare with")


@pytest.mark.parametrize("plan", [[], "S1", 3])
def test_other_files_tell_nothing(plan: object, tmp_path: Path) -> None:
    before = run(tmp_path / "before", press(1), how="completed", repetitions_done=1)
    other = run(tmp_path / "other", press(1, 5, 4, 6), plan=plan)
    assert [*weighed_presses([before, other, tmp_path / "none"])] == []

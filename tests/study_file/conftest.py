"""A small study file, and a way to change it and see what is said of it."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import pytest

from emg2vsa.errors import StudyError
from emg2vsa.study import Study
from emg2vsa.study_file import load_study

SMALL = """\
[study]
name = "small"

[participants]
ids = ["P01", "P02"]

[[specimens]]
name = "S1"
stiffness_n_per_mm = 7.63

[[specimens]]
name = "S3"
stiffness_n_per_mm = 3.35

[recordings]
layout = "pattern"
pattern = "data/{participant}_{specimen}.csv"

[channels.emg.EDC]
name = "EMG 1"

[channels.emg.FDS]
name = "EMG 2"

[channels.force]
name = "Fz"

[simulation]
a_v = { S1 = 40e-6, S3 = 30e-6 }
b_v = { S1 = 20e-6, S3 = 15e-6 }
"""


@pytest.fixture
def small() -> str:
    return SMALL


@pytest.fixture
def load(tmp_path: Path) -> Callable[[str], Study]:
    """The study of a text, loaded from ``<tmp>/studies/small/study.toml``."""

    def load_text(text: str) -> Study:
        path = tmp_path / "studies" / "small" / "study.toml"
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text, encoding="utf-8")
        return load_study(path)

    return load_text


@pytest.fixture
def problems(load: Callable[[str], Study]) -> Callable[[str], list[str]]:
    """What is said of a text, each line without the path before its line number."""

    def problems_of(text: str) -> list[str]:
        with pytest.raises(StudyError) as caught:
            load(text)
        return [line.partition("study.toml:")[2] for line in caught.value.problems]

    return problems_of

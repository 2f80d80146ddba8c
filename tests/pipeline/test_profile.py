"""``run --profile``: what ran, what was skipped and why, and numbers that were counted where the work was done."""

from __future__ import annotations

import contextlib
import json
import sys
from pathlib import Path
from types import SimpleNamespace

import pytest

from benchmarks.small_study import small_study
from casr.counts import COUNTED, count, counting
from emg2vsa.cli import main
from emg2vsa.pipeline.profile import Spent, StageProfile, kind_of, measured
from tests.small import simulated


@pytest.fixture
def people(tmp_path: Path) -> Path:
    """A study of two people whose recordings are there."""
    return simulated(tmp_path, small_study(specimens=("S1", "S3")))


def profile(study: Path, capsys: pytest.CaptureFixture[str], *more: str) -> dict[str, dict]:
    capsys.readouterr()
    assert main(["run", str(study), "--profile", "--json", *more]) == 0
    return {one["stage"]: one for one in json.loads(capsys.readouterr().out)["profile"]}


def test_the_first_run_and_the_one_after_it(people: Path, capsys: pytest.CaptureFixture[str]) -> None:
    first = profile(people, capsys, "--only", "fits", "--jobs", "1")
    again = profile(people, capsys, "--only", "fits", "--jobs", "1")
    assert list(first) == list(again) == ["trials", "fits"]
    trials = first["trials"]
    assert (trials["computed"], trials["fresh"], trials["left"]) == (4, 0, 0)
    assert trials["reasons"] == {"never ran": 4}
    assert trials["cpu_s"] > 0
    assert 0 < trials["slowest_s"] <= trials["wall_s"]
    assert trials["counts"]["files read"] == 4
    sizes = [path.stat().st_size for path in people.parent.glob("data/sub-*/emg/*.bdf")]
    assert trials["counts"]["bytes read"] == sum(sizes)
    assert set(trials["counts"]) <= set(COUNTED)
    for stage in again.values():
        assert (stage["computed"], stage["fresh"], stage["counts"]) == (0, 4, {})


def test_workers_bring_the_same_counts_home(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    text = small_study(participants=("P01", "P02", "P03"), simulation="seed = 3\nrepetitions = 1\n")
    path = simulated(tmp_path, text)
    one = profile(path, capsys, "--only", "trials", "--jobs", "1", "--work", str(tmp_path / "one"))
    two = profile(path, capsys, "--only", "trials", "--jobs", "2", "--work", str(tmp_path / "two"))
    assert one["trials"]["counts"]["files read"] == 9  # more than run in the calling process
    assert two["trials"]["counts"] == one["trials"]["counts"]


def test_a_step_says_why_it_ran_and_one_that_cannot_run_is_left(
    people: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    profile(people, capsys, "--only", "fits", "--jobs", "1")
    people.write_text(people.read_text() + "[filters]\noutput_fs_hz = 50\n")
    next(people.parent.glob("data/sub-P01/emg/*S1*.bdf")).write_bytes(b"no recording")
    found = profile(people, capsys, "--only", "fits", "--jobs", "1")
    assert found["trials"]["reasons"]["changed file"] == 1
    assert found["trials"]["reasons"]["setting filters.output_fs_hz: 100.0 -> 50.0"] == 4
    assert [found["trials"][name] for name in ("computed", "failed", "left")] == [3, 1, 0]
    assert [found["fits"][name] for name in ("computed", "failed", "left")] == [3, 0, 1]


def test_the_table_is_for_people(people: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["run", str(people), "--only", "fits", "--profile", "--jobs", "1"]) == 0
    out = capsys.readouterr().out
    assert "trials: 4 ran because: never ran" in out
    assert "samples conditioned" in out


def test_a_stage_has_the_largest_peak_and_the_slowest_step() -> None:
    own = StageProfile()
    for item, wall_s, peak_mb in (("a", 2.0, 5.0), ("b", 1.0, 3.0)):
        own.add(SimpleNamespace(item=item, status="done", reasons=()), Spent(wall_s=wall_s, peak_mb=peak_mb))
    assert (own.peak_mb, own.slowest, own.slowest_s, own.wall_s, own.computed) == (5.0, "a", 2.0, 3.0, 2)


def test_reasons_of_one_kind_are_one() -> None:
    assert kind_of("changed file data/sub-P01/emg/a.bdf") == "changed file"
    assert kind_of("new input trials/P01/S1") == "new input trials"
    same = (
        "setting a.b: 1 -> 2",
        "library numpy 1 -> 2",
        "never ran",
        "changed code emg2vsa.fits",
        "its result is missing",
    )
    assert [kind_of(reason) for reason in same] == list(same)


def test_the_peak_is_of_the_step_and_not_of_one_before_it() -> None:
    with measured() as large:
        held = bytearray(80_000_000)
        held[::4096] = b"x" * len(held[::4096])
        del held
    with measured() as small:
        count("fits", 2)
    assert small.counts == {"fits": 2}
    if sys.platform == "linux":
        assert large.peak_mb is not None
        assert small.peak_mb is not None
        assert large.peak_mb - small.peak_mb > 50


def test_counts_are_of_what_is_inside_and_end_with_an_error() -> None:
    count("fits")
    with counting() as outer:
        count("fits", 3)
        with contextlib.suppress(ValueError), counting() as inner:
            count("fits", 4)
            raise ValueError
        count("files read")
    count("fits")
    assert inner == {"fits": 4}
    assert outer == {"fits": 7, "files read": 1}

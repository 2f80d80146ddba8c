"""The matrix of versions: what counts as another number, what as missing; no address of the network is told."""

from __future__ import annotations

import sys
import time
from pathlib import Path

import pytest

from benchmarks import versions
from benchmarks.versions import LATE, Failed, Missing, Tried, Tries, inputs_digest, page, python_of
from benchmarks.versions_of import EXTRAS, Environment, environments

NUMBERS = {"fit.S1.b_v": 2e-5, "runs.modular.0.kappa.cue.force.sd": 0.4, "study.name": "small", "fit.S1.low": None}


@pytest.fixture
def tries(tmp_path: Path) -> Tries:
    return Tries(tmp_path, time.monotonic() + 60)


@pytest.mark.parametrize(
    ("other", "apart"),
    [
        ({}, []),
        ({"fit.S1.b_v": 2e-5 * (1 + 5e-10)}, []),
        ({"fit.S1.b_v": 2e-5 * (1 + 5e-9)}, ["fit.S1.b_v"]),
        ({"runs.modular.0.kappa.cue.force.sd": 0.4 * (1 + 5e-8)}, []),
        ({"runs.modular.0.kappa.cue.force.sd": 0.4 * (1 + 5e-7)}, ["runs.modular.0.kappa.cue.force.sd"]),
        ({"study.name": "large", "new.number": 1.0}, ["new.number", "study.name"]),
        ({"fit.S1.low": 0.0}, ["fit.S1.low"]),
    ],
)
def test_numbers_are_compared_with_the_first_of_their_kind(
    tries: Tries, other: dict[str, object], apart: list[str]
) -> None:
    tries._compare(Tried(Environment("locked", "locked"), "good"), dict(NUMBERS))
    told = Tried(Environment("lowest", "lowest"), "good")
    tries._compare(told, {**NUMBERS, **other})
    assert [each.partition(":")[0] for each in told.apart] == apart
    assert told.good == (not apart)


def test_a_command_that_fails_is_told_without_addresses_and_one_that_is_late_is_not_tried(tries: Tries) -> None:
    with pytest.raises(Failed, match=r"no wheel at \(address\) for you"):
        tries._do(sys.executable, "-c", "raise SystemExit('no wheel at https://host.example/simple/x for you')")
    tries._end_s = time.monotonic() - 1
    with pytest.raises(Missing, match="the time was over"):
        tries._do(sys.executable, "-c", "import time; time.sleep(30)")
    assert tries.tried(Environment("locked", "locked")).said == "not tried: the time was over"


def test_a_python_that_is_not_here_is_named(tries: Tries) -> None:
    here = f"{sys.version_info.major}.{sys.version_info.minor}"
    assert python_of("3.999") is None
    told = tries.tried(Environment("locked", "locked", "3.999"))
    assert (told.good, told.said) == (True, "not tried: no Python 3.999 here")
    assert "| locked | – |" in told.row()
    assert python_of(here) is not None


def test_every_extra_of_a_run_is_tried() -> None:
    text = (versions.ROOT / "pyproject.toml").read_text(encoding="utf-8")
    assert all(f"\n{extra} = [" in text for extra in EXTRAS)
    tried = {extra for one in environments() for extra in one.extras}
    assert tried == {"study", *EXTRAS}
    assert next(environments()).name == "locked"


def test_the_matrix_is_skipped_where_bounds_and_locks_are_those_of_the_page(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    for name in ("pyproject.toml", "requirements.lock", "requirements-dev.lock"):
        (tmp_path / name).write_bytes((versions.ROOT / name).read_bytes())
    monkeypatch.setattr(versions, "ROOT", tmp_path)
    monkeypatch.setattr(versions, "PAGE", tmp_path / "versions.md")
    (tmp_path / "versions.md").write_text(page([Tried(Environment("locked", "locked"), "good")]), encoding="utf-8")
    monkeypatch.setattr(sys, "argv", ["matrix", "--if-changed"])
    assert versions.main() == 0
    assert capsys.readouterr().out == "matrix: skipped; versions.md is of these bounds and locks\n"
    assert inputs_digest() not in page([Tried(Environment("locked", "locked"), f"not tried: {LATE}")])
    before = inputs_digest()
    (tmp_path / "pyproject.toml").write_text((tmp_path / "pyproject.toml").read_text().replace("numpy>=2", "numpy>=3"))
    assert inputs_digest() != before

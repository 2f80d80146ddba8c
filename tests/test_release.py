"""What a release needs: a licence, one version number, typed markers, and an installation of the tactile side alone."""

from __future__ import annotations

import re
import subprocess
import sys
import tomllib
from pathlib import Path

import pytest

import casr
import emg2vsa

ROOT = Path(__file__).resolve().parent.parent
PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]
TACTILE = "numpy", "cv2", "tifffile", "shtab"
"""Libraries of an installation without extras."""


def test_there_is_one_version_number() -> None:
    assert casr.__version__ is emg2vsa.__version__
    assert PROJECT["dynamic"] == ["version"]
    cited = re.search(r"^version: (\S+)$", (ROOT / "CITATION.cff").read_text(), flags=re.M)
    assert cited is not None
    assert cited[1] == casr.__version__
    assert f"## {casr.__version__}" in (ROOT / "CHANGELOG.md").read_text(encoding="utf-8")


def test_the_licence_is_there_and_is_the_one_that_is_named() -> None:
    assert PROJECT["license"] == "BSD-3-Clause"
    assert "Redistribution and use in source and binary forms" in (ROOT / "LICENSE").read_text()
    assert "license: BSD-3-Clause" in (ROOT / "CITATION.cff").read_text()


@pytest.mark.parametrize("package", ["emg2vsa", "casr"])
def test_types_are_for_users_too(package: str) -> None:
    assert (ROOT / package / "py.typed").exists()


def without(libraries: tuple[str, ...], code: str) -> str:
    """Code that finds none of the libraries installed."""
    return f"""
import sys
class Absent:
    def find_spec(self, name, path=None, target=None):
        if name.partition(".")[0] in {libraries!r}:
            raise ModuleNotFoundError(f"No module named {{name!r}}", name=name)
sys.meta_path.insert(0, Absent())
{code}
"""


HUMAN = ("scipy", "pandas", "matplotlib", "edfio", "ezc3d", "jinja2", "serial", "numba", "statsmodels", "pydantic")


def test_the_tactile_side_runs_without_the_libraries_of_the_human_side(tmp_path: Path) -> None:
    code = f"""
import os
os.chdir({str(tmp_path)!r})
from casr.cli import main
assert main(["simulate", "presses", "--repetitions", "1", "--specimens", "S1"]) == 0
assert main(["score", "presses", "--page", "scores.html", "-q"]) == 0
"""
    done = subprocess.run([sys.executable, "-c", without(HUMAN, code)], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    assert (tmp_path / "scores.html").exists()


@pytest.mark.parametrize("words", [["fit", "{file}"], ["stats", "{file}", "--value", "b", "--group", "g"]])
def test_what_is_not_installed_is_named_with_its_extra(words: list[str], tmp_path: Path) -> None:
    (tmp_path / "x.csv").write_text("t,b,g\n0,1,2\n1,2,2\n2,2,1\n")
    words = [word.format(file=tmp_path / "x.csv") for word in words]
    code = f"from emg2vsa.cli import main; sys.exit(main({words!r}))"
    done = subprocess.run([sys.executable, "-c", without(HUMAN, code)], capture_output=True, text=True, check=False)
    assert done.returncode == 2, done.stderr
    assert re.search(
        r'expected the library \w+, but found none. Install it: pip install "\.\[study\]" in the folder', done.stderr
    )


@pytest.mark.parametrize("name", ["emg2vsa.read", "emg2vsa.plot_fits", "emg2vsa.load"])
def test_a_function_names_the_extra_that_it_lacks(name: str) -> None:
    code = without(HUMAN, f"import emg2vsa; {name}")
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=False)
    last = done.stderr.strip().splitlines()[-1]
    do = 'Install it: pip install ".[study]" in the folder of the sources.'
    assert re.fullmatch(rf"\w+: {name}: expected the library \w+, but found none. {re.escape(do)}", last)


def test_the_container_copies_what_is_there_and_what_its_ignore_file_admits() -> None:
    recipe = (ROOT / "scripts" / "container" / "Dockerfile").read_text()
    copied = [name for line in re.findall(r"^COPY (.+) \S+$", recipe, flags=re.M) for name in line.split()]
    admitted = re.findall(r"^!(.+)$", (ROOT / ".dockerignore").read_text(), flags=re.M)
    assert copied
    assert [name for name in copied if not (ROOT / name).exists()] == []
    assert sorted(copied) == sorted(admitted)
    assert "CMD" in recipe
    assert (ROOT / re.findall(r'CMD \["(.+)"\]', recipe)[0]).exists()

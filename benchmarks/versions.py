"""Under which versions the program gives its numbers: a small study in fresh environments, compared with the locks'.

``scripts/matrix`` runs it: the lowest versions that pyproject.toml allows, those of the locks, the newest there are,
the tactile side alone, every extra, other kernels of BLAS, and every Python from 3.11 that is here. Each installs the
wheel and the libraries, by uv, and runs a study of two people with an emulated rig from recordings to report.
``--write`` keeps the table as docs/reference/versions.md; ``--if-changed`` runs only where bounds or locks are not
those of that page. Exit status 1: an environment gave other numbers, or failed; what cannot be had here is no failure.
"""

from __future__ import annotations

import argparse
import json
import os
import re
import shutil
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field
from fnmatch import fnmatchcase
from functools import partial
from hashlib import sha256
from pathlib import Path
from typing import Any

from benchmarks.processors import ROOT, results
from benchmarks.versions_of import EXTRAS, PYTHONS, TOOLS, Environment, environments
from casr.atomic import write_text_atomic
from emg2vsa.deposit.agreement import relative_difference

PAGE = ROOT / "docs" / "reference" / "versions.md"
TOLERANCES = (
    ("runs.*.law_p", 1e-7),
    ("runs.*.kappa.cue.*", 1e-7),
    ("stiffness.*.contrast_gain.*", 1e-7),
    ("*", 1e-9),
)
"""Pattern of keys to the largest relative difference from the locks; the first that fits counts. A p of
1e-30 has an error seventy times that of its logarithm, one cue alone leaves kappa almost free, and the gain of contrast
is a difference of numbers that agree in their first six digits."""
MINUTES, LATE = 15.0, "the time was over"
_SHOWN = ("numpy", "scipy", "pandas", "opencv-contrib-python-headless", "numba")
_HEAD = f"| environment | Python | {' | '.join(_SHOWN)} | BLAS kernel | numbers | apart | largest | result |"
_RULE = "|---" * 8 + "|---:" * 3 + "|---|"
_VERSIONS = f"""
import importlib.metadata as of
from casr.blas_kernel import blas_kernel
def version(name):
    try:
        return of.version(name)
    except of.PackageNotFoundError:
        return "–"
print(*map(version, {_SHOWN}), blas_kernel())
"""
_FREEZE = """
from importlib.metadata import distributions
print(*sorted({f"{one.name}=={one.version}" for one in distributions()}), sep=chr(10))
"""
_ADDRESS = re.compile(r"\w+://\S+")


class Failed(Exception):
    """A command that did not end well; what it said last."""


class Missing(Exception):
    """What this computer lacks for an environment."""


@dataclass
class Tried:
    """What came of an environment. numbers : of its study; apart : keys beyond their tolerance, the worst first."""

    environment: Environment
    said: str
    good: bool = True
    python: str = "–"
    versions: list[str] = field(default_factory=lambda: ["–"] * (len(_SHOWN) + 1))
    numbers: int = 0
    apart: list[str] = field(default_factory=list)
    largest: float = 0.0

    def row(self) -> str:
        largest = f"{self.largest:.0e}" if self.numbers else "–"
        cells = [self.environment.name, self.python, *self.versions, str(self.numbers or "–"),
                 str(len(self.apart)) if self.numbers else "–", largest, self.said]  # fmt: skip
        return f"| {' | '.join(cells)} |"


class Tries:
    """Environments in a folder, until the time is over. A number is compared with that of the first environment."""

    def __init__(self, folder: Path, end_s: float) -> None:
        self._folder, self._end_s = folder, end_s
        self._references: dict[bool, dict[str, Any]] = {}
        self._uv = shutil.which("uv") or ""
        self._wheel = ""

    def prepare(self) -> None:
        """uv, and the wheel. Missing : the registry gives no uv."""
        if not self._uv:
            own = self._folder / "uv"
            try:
                self._do(sys.executable, "-m", "venv", str(own))
                self._do(str(_bin(own) / "python"), "-m", "pip", "install", "--quiet", "uv")
            except Failed as error:
                raise Missing(f"uv cannot be installed: {error}") from error
            self._uv = str(_bin(own) / "uv")
        self._do(self._uv, "build", "--quiet", "--wheel", "--out-dir", str(self._folder / "dist"), str(ROOT))
        self._wheel = str(next((self._folder / "dist").glob("*.whl")))

    def tried(self, one: Environment) -> Tried:
        """Install and run one environment."""
        if time.monotonic() > self._end_s:
            return Tried(one, f"not tried: {LATE}")
        python = python_of(one.python)
        if python is None:
            return Tried(one, f"not tried: no Python {one.python} here")
        told = Tried(one, "good")
        try:
            told.python, run = self._installed(one, python)
            told.versions = run("python", "-c", _VERSIONS).split()
            found = self._numbers(one, run)
            self._compare(told, found)
            for extra in one.tests:
                run("python", "-m", "pytest", "-q", "-p", "no:cacheprovider", "-W", "ignore", "-o",
                    "addopts=--import-mode=importlib", *EXTRAS[extra], at=ROOT)  # fmt: skip
        except Missing as error:
            told.said = f"not tried: {error}"
        except Failed as error:
            told.good, told.said = False, f"failed: {error}"
        return told

    def _installed(self, one: Environment, python: str) -> tuple[str, Callable[..., str]]:
        """The Python's version, and how a program of the environment is run there; what is there already stays."""
        place = self._folder / re.sub(r"\W+", "-", f"{one.libraries} {one.extras} {one.python}")
        run = partial(self._run, place, dict(one.variables))
        if not place.exists():
            self._do(self._uv, "venv", "--quiet", "--python", python, str(place))
            install = partial(self._do, self._uv, "pip", "install", "--quiet", "--python", str(_bin(place) / "python"))
            try:
                for words in one.installs(self._wheel, str(ROOT)):
                    install(*words)
                if one.tests:  # whose tools must move nothing of it
                    there = place / "there.txt"
                    there.write_text(run("python", "-c", _FREEZE))
                    install("--constraint", str(there), *TOOLS)
            except Failed as error:
                shutil.rmtree(place)
                raise (Missing if _DOWNLOAD.search(str(error)) else Failed)(f"not installed: {error}") from error
        return run("python", "-c", "import platform; print(platform.python_version())").strip(), run

    def _numbers(self, one: Environment, run: Callable[..., str]) -> dict[str, Any]:
        if one.extras:
            return results(partial(run, "emg2vsa"))
        with tempfile.TemporaryDirectory(dir=self._folder) as folder:
            run("casr", "simulate", folder, "--repetitions", "1", "--specimens", "S1", "-q")
            every = _flat(json.loads(run("casr", "score", folder, "--json")))
            return {key: value for key, value in every if ".provenance." not in key}  # which names the versions

    def _compare(self, told: Tried, found: dict[str, Any]) -> None:
        reference = self._references.setdefault(bool(told.environment.extras), found)
        told.numbers = len(found)
        for key in sorted(reference.keys() | found.keys()):
            ours, theirs = found.get(key, "absent"), reference.get(key, "absent")
            relative = 0.0 if ours == theirs else relative_difference(ours, theirs)
            relative = float("inf") if relative is None else relative
            told.largest = max(told.largest, relative)
            if relative > next(most for pattern, most in TOLERANCES if fnmatchcase(key, pattern)):
                told.apart.append(f"{key}: {ours}, with the locks {theirs}")
        if told.apart:
            told.good, told.said = False, f"other numbers, such as {told.apart[0]}"

    def _run(self, place: Path, variables: Mapping[str, str], name: str, *words: str, at: Path | None = None) -> str:
        """A program of an environment; at : working folder."""
        return self._do(str(_bin(place) / name), *words, variables=variables, at=at)

    def _do(self, *words: str, variables: Mapping[str, str] | None = None, at: Path | None = None) -> str:
        """What a command prints. Failed : with the last of what it said, without addresses of the network."""
        clean = {key: value for key, value in os.environ.items() if key not in ("PYTHONPATH", "VIRTUAL_ENV")}
        left_s = max(self._end_s - time.monotonic(), 1.0)
        try:
            done = subprocess.run(
                words, env={**clean, **(variables or {})}, capture_output=True, text=True,
                cwd=at or self._folder, timeout=left_s,
            )  # fmt: skip
        except subprocess.TimeoutExpired:
            raise Missing(LATE) from None
        if done.returncode:
            said = " ".join(_ADDRESS.sub("(address)", done.stderr or done.stdout).split())
            raise Failed(f"{Path(words[0]).name} {' '.join(words[1:4])}: {said[-400:]}".replace("|", "/"))
        return done.stdout


_DOWNLOAD = re.compile(
    r"(?i)failed to (fetch|download)|error sending request|connection|timed out|could not connect|dns error|network"
)


def _bin(place: Path) -> Path:
    return place / ("Scripts" if os.name == "nt" else "bin")


def _flat(tree: object, name: str = "") -> Iterator[tuple[str, Any]]:
    """Every leaf with its dotted name."""
    if isinstance(tree, (dict, list)):
        pairs = tree.items() if isinstance(tree, dict) else enumerate(tree)
        for key, value in pairs:
            yield from _flat(value, f"{name}.{key}" if name else str(key))
    else:
        yield name, tree


def python_of(version: str) -> str | None:
    """The interpreter of a version such as 3.12: on the path, or one of pyenv's."""
    root = Path(os.environ.get("PYENV_ROOT", Path.home() / ".pyenv")) / "versions"
    candidates = [shutil.which(f"python{version}"), *sorted(map(str, root.glob(f"{version}.*/bin/python")))]
    ask = "import sys; print('%d.%d' % sys.version_info[:2])"
    for each in [one for one in candidates if one]:
        done = subprocess.run([each, "-c", ask], capture_output=True, text=True)
        if done.stdout.strip() == version:
            return each
    return None


def inputs_digest() -> str:
    """Of what says which versions are allowed and locked."""
    text = (ROOT / "pyproject.toml").read_text(encoding="utf-8")
    project = text[text.index("[build-system]") : text.index("[project.scripts]")]
    locks = [(ROOT / name).read_text(encoding="utf-8") for name in ("requirements.lock", "requirements-dev.lock")]
    return sha256("".join([project, *locks]).encode()).hexdigest()[:16]


def page(rows: list[Tried]) -> str:
    """The page of the documentation; where the time was over it does not say that these bounds and locks were tried."""
    late = any(LATE in one.said for one in rows)
    commit = subprocess.run(
        ["git", "describe", "--always", "--dirty"], cwd=ROOT, capture_output=True, text=True
    ).stdout.strip()
    exceptions = "; ".join(f"`{pattern}` {most:.0e}" for pattern, most in TOLERANCES[:-1])
    return "\n".join([
        "# Versions", "",
        f"`scripts/matrix` made this table at commit {commit} on {time.strftime('%Y-%m-%d', time.gmtime())}. Each row "
        "is a fresh environment with the wheel. It runs a study of two people with an emulated rig, from recordings to "
        "report; the tactile side alone scores simulated presses. Numbers are compared with those of the first row of "
        f"the same kind. A number is apart where it differs by more than 1e-9 ({exceptions}). *Largest* is the "
        "largest relative difference of all.", "",
        _HEAD, _RULE, *(one.row() for one in rows), "",
        f"With every extra, the tests of {', '.join(EXTRAS)} run too. Pythons tried where they are installed: "
        f"{', '.join(PYTHONS)}. Bounds of the extras `test`, `lint`, `docs` and `bench` are not tried.", "",
        "" if late else f"<!-- of bounds and locks {inputs_digest()} -->", "",
    ])  # fmt: skip


def main() -> int:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--write", action="store_true", help="keep the table in docs/reference/versions.md")
    parser.add_argument("--if-changed", action="store_true", help="not where the page is of these bounds and locks")
    parser.add_argument("--minutes", type=float, default=MINUTES, help=f"at most (default {MINUTES:g})")
    given = parser.parse_args()
    if given.if_changed and PAGE.is_file() and inputs_digest() in PAGE.read_text(encoding="utf-8"):
        print(f"matrix: skipped; {PAGE.relative_to(ROOT)} is of these bounds and locks")
        return 0
    rows: list[Tried] = []
    with tempfile.TemporaryDirectory() as folder:
        tries = Tries(Path(folder), time.monotonic() + 60 * given.minutes)
        try:
            tries.prepare()
        except Missing as error:
            print(f"matrix: skipped; {error}")
            return 0
        print(_HEAD, _RULE, sep="\n", flush=True)
        for one in environments():
            rows.append(tries.tried(one))
            print(rows[-1].row(), flush=True)
            for each in rows[-1].apart[:20]:
                print(f"  {each}", file=sys.stderr)
    if given.write:
        write_text_atomic(PAGE, page(rows))
    return int(not all(one.good for one in rows))


if __name__ == "__main__":
    raise SystemExit(main())

"""What a stranger checks before relying on the project: licences, citation, parts list, a wheel that can be rebuilt."""

from __future__ import annotations

import hashlib
import importlib.util
import json
import re
import shutil
import subprocess
import sys
import tomllib
import zipfile
from pathlib import Path
from types import ModuleType

import numpy as np
import pytest
import yaml

import casr
from casr.dome.library import DEFAULT_WORLD, SHIPPED

ROOT = Path(__file__).resolve().parent.parent


@pytest.fixture(scope="module")
def sbom() -> ModuleType:
    spec = importlib.util.spec_from_file_location("sbom", ROOT / "scripts" / "sbom.py")
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def test_the_parts_list_holds_every_locked_version_with_its_hashes(sbom: ModuleType) -> None:
    lock = (ROOT / "requirements.lock").read_text(encoding="utf-8")
    made = sbom.bom(lock, "1.0", "BSD-3-Clause", None)
    pins = re.findall(r"^([a-z0-9._-]+)==(\S+)", lock, flags=re.M)
    assert [(one["name"], one["version"]) for one in made["components"]] == pins
    hashes = {one["content"] for part in made["components"] for one in part["hashes"]}
    assert hashes == set(re.findall(r"sha256:([0-9a-f]{64})", lock))
    assert made["dependencies"][0]["dependsOn"] == [f"pkg:pypi/{name}@{version}" for name, version in pins]
    assert "://" not in json.dumps(made)


def test_the_parts_list_follows_lock_version_and_stated_time_alone(sbom: ModuleType) -> None:
    lock = "numpy==2.4.6 ; python_full_version >= '3.12' \\\n    --hash=sha256:" + 64 * "a" + "\n"
    one = sbom.bom(lock, "1.0", "BSD-3-Clause", "0")
    assert one == sbom.bom(lock, "1.0", "BSD-3-Clause", "0")
    assert one["metadata"]["timestamp"] == "1970-01-01T00:00:00+00:00"
    assert one["components"][0]["properties"] == [{"name": "python:marker", "value": "python_full_version >= '3.12'"}]
    assert one["serialNumber"] != sbom.bom(lock.replace("aa", "ab"), "1.0", "BSD-3-Clause", "0")["serialNumber"]
    with pytest.raises(ValueError, match="expected NAME==VERSION with hashes, but found 'numpy>=2'"):
        sbom.bom("numpy>=2\n", "1.0", "BSD-3-Clause", None)


def test_licences_cover_every_file_and_those_of_others_are_named() -> None:
    rules = tomllib.loads((ROOT / "REUSE.toml").read_text(encoding="utf-8"))["annotations"]
    assert rules[0]["path"] == "**"
    others = {Path(path) for rule in rules[1:] for path in rule["path"]}
    assert {path for path in others if not (ROOT / path).is_file()} == set()
    used = {one for rule in rules for one in rule["SPDX-License-Identifier"].split(" AND ")}
    assert {path.stem for path in (ROOT / "LICENSES").iterdir()} == used
    assert (ROOT / "LICENSES" / "BSD-3-Clause.txt").read_bytes() == (ROOT / "LICENSE").read_bytes()
    # moduli of the data set stand where its name stands beside numbers
    assert {Path("emg2vsa/rig_file/silicone_kit.py"), Path("studies/silicone/specimens.toml")} <= others


@pytest.mark.parametrize("name", [SHIPPED, DEFAULT_WORLD])
def test_the_origin_of_a_domes_tables_stands_beside_them(name: str) -> None:
    beside = (ROOT / "casr" / "dome" / f"{name}.license").read_text(encoding="utf-8")
    assert "-Identifier: BSD-3-Clause\n" in beside
    named = set(re.findall(r"\b[A-Z]\b", beside.partition("Origin:")[2]))
    with np.load(ROOT / "casr" / "dome" / name) as arrays:
        assert named == set(arrays["dome"].tolist())
    assert {sensor for sensor in named if not (ROOT / "scripts" / "domes" / f"{sensor}.toml").is_file()} == set()


def test_reuse_agrees() -> None:
    if importlib.util.find_spec("reuse") is None:
        pytest.skip("reuse is not installed; the workflow Lint runs it")
    done = subprocess.run(
        [sys.executable, "-m", "reuse", "lint"], cwd=ROOT, capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, done.stdout


def test_the_citation_names_paper_and_data_and_invents_nobody() -> None:
    cited = yaml.safe_load((ROOT / "CITATION.cff").read_text(encoding="utf-8"))
    kinds = {one["type"]: one for one in cited["references"]}
    assert set(kinds) == {"article", "data"}
    assert kinds["article"]["authors"] == [{"name": "anonymous"}]
    assert "doi" not in kinds["article"]
    assert "missing here" in kinds["article"]["notes"]
    assert kinds["data"]["license"] == "CC-BY-4.0"
    assert cited["authors"] == [{"name": "The emg2vsa authors"}]


def test_the_manuscript_is_as_long_as_the_journal_allows_and_cites_what_it_lists() -> None:
    text = (ROOT / "docs" / "paper" / "paper.md").read_text(encoding="utf-8")
    head, body = text.split("---\n", 2)[1:]
    assert 250 <= len(body.split()) <= 1000
    assert yaml.safe_load(head)["bibliography"] == "paper.bib"
    listed = set(
        re.findall(r"^@\w+\{(\w+),", (ROOT / "docs" / "paper" / "paper.bib").read_text(encoding="utf-8"), re.M)
    )
    assert set(re.findall(r"@(\w+)", body)) == listed
    for title in ("# Summary", "# Statement of need", "# State of the field", "# References"):
        assert f"\n{title}\n" in body


def rows_of(area: str, case: str) -> dict[str, dict[str, float]]:
    """Rows of a case of a committed benchmark, by the name of the way."""
    cases = json.loads((ROOT / "docs" / "benchmarks" / f"{area}.json").read_text(encoding="utf-8"))["cases"]
    return {f"{row['library']} {row['name']}": row for one in cases if one["name"] == case for row in one["rows"]}


def test_the_manuscript_prints_the_committed_benchmarks() -> None:
    text = " ".join((ROOT / "docs" / "paper" / "paper.md").read_text(encoding="utf-8").split())
    fits = rows_of("fits", "logarithmic fits of 131 points, each on its own forces, 700 fits")
    ours, statsmodels, scipy = (
        fits[name] for name in ("emg2vsa fit_log", "statsmodels OLS, loop", "scipy linregress, loop")
    )
    mixed = rows_of("tests", "mixed model in volts, no variance between participants (boundary)")
    large = rows_of("tests", "Mann-Whitney of two large samples, 30000 values each")
    tukey = rows_of("tests", "ANOVA of 5 x 10 with Tukey's pairs and intervals, 4 designs")
    for said in (
        f"take {ours['least_ms']:.1f} ms with {ours['digits']:.1f} correct digits",
        f"statsmodels {statsmodels['least_ms']:.0f} ms with {statsmodels['digits']:.1f}",
        f"SciPy {scipy['least_ms']:.0f} ms with {scipy['digits']:.1f}",
        f"NumPy takes {fits['numpy expert: closed form']['least_ms']:.2f} ms with "
        f"{fits['numpy expert: closed form']['digits']:.1f}",
        f"{mixed['emg2vsa balanced_mixed']['digits']:.1f} digits against "
        f"{mixed['statsmodels MixedLM, specimens within']['digits']:.1f} of statsmodels",
        f"takes SciPy {large['scipy mannwhitneyu']['least_ms']:.1f} ms, and ours "
        f"{large['emg2vsa mann_whitney']['least_ms']:.0f} ms",
        f"{tukey['emg2vsa all designs in one call']['digits']:.1f} correct digits against "
        f"{tukey['scipy f_oneway and tukey_hsd, loop']['digits']:.1f} of peers",
    ):
        assert said in text, said


@pytest.mark.slow
def test_two_builds_of_one_commit_are_the_same_bytes(tmp_path: Path) -> None:
    if importlib.util.find_spec("build") is None or importlib.util.find_spec("hatchling") is None:
        pytest.skip("build and hatchling are not installed; the workflow Release runs scripts/build")
    if shutil.which("git") is None or not (ROOT / ".git").exists():
        pytest.skip("scripts/build copies what git has, and this is no clone")
    wheels = []
    for name in ("first", "second"):
        done = subprocess.run(
            ["scripts/build", str(tmp_path / name)], cwd=ROOT, capture_output=True, text=True, check=False,
            env={"PYTHON": sys.executable, "PATH": "/usr/bin:/bin", "SOURCE_DATE_EPOCH": "1700000000"},
        )  # fmt: skip
        assert done.returncode == 0, done.stderr
        wheels.append(next((tmp_path / name).glob(f"emg2vsa-{casr.__version__}-*.whl")))
    assert len({hashlib.sha256(wheel.read_bytes()).hexdigest() for wheel in wheels}) == 1
    with zipfile.ZipFile(wheels[0]) as wheel:
        names = wheel.namelist()
    assert f"casr/dome/{SHIPPED}.license" in names
    assert any(name.endswith("licenses/LICENSES/CC-BY-4.0.txt") for name in names)

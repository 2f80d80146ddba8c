"""A step hangs on the libraries and plugins that it used: what is installed besides changes nothing."""

from __future__ import annotations

import json
import shutil
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from benchmarks.areas import readers
from casr.by_name import module_named, noting, used
from casr.plugins import found_plugins, plugin_named, plugins
from emg2vsa.cli import main
from emg2vsa.pipeline.code import Code
from emg2vsa.pipeline.fingerprint import Fingerprints
from emg2vsa.pipeline.plan import Step, survey
from emg2vsa.pipeline.stage_order import ORDER, module_of
from emg2vsa.pipeline.tasks import Task
from emg2vsa.study_file import load_study
from tests.small import study_of_files

Install = Callable[..., None]
OTHERS = ("c3d", "h5py", "numba", "npTDMS", "pymatreader", "pyxdf", "scikit-fem", "pylsl", "bottleneck")
"""Libraries that the small study, of BDF files scored by pins, does not use."""


@pytest.fixture
def install(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Install:
    """Install a library of that name and version, with entry points, in place of any other of its name."""
    site = tmp_path / "site"
    site.mkdir()
    monkeypatch.syspath_prepend(str(site))

    def build(name: str, version: str = "9.9", **groups: str) -> None:
        module = name.lower().replace("-", "_")
        info = site / f"{name.replace('-', '_')}-{version}.dist-info"
        for old in site.glob(f"{info.name.partition('-')[0]}-*.dist-info"):
            shutil.rmtree(old)
        info.mkdir()
        (info / "METADATA").write_text(f"Metadata-Version: 2.1\nName: {name}\nVersion: {version}\n")
        (info / "top_level.txt").write_text(f"{module}\n")
        lines = (f"[{group.replace('__', '.')}]\n{entry} = {module}:x\n" for group, entry in groups.items())
        (info / "entry_points.txt").write_text("".join(lines))
        found_plugins.cache_clear()

    return build


def stale(study: Path) -> dict[str, Step]:
    steps = survey(load_study(study), ORDER, lambda text: pytest.fail(text)).steps
    return {name: step for name, step in steps.items() if step.status != "fresh"}


def test_what_a_study_does_not_use_can_be_installed(study: Path, install: Install) -> None:
    for name in OTHERS:
        install(name)
    install("lab-engines", casr__flow_engines="other-engine")
    install("lab-kinds", emg2vsa__devices="other-kind")
    install("lab-readers", emg2vsa__readers="other-reader")
    install("lab-tests", emg2vsa__statistics="other-test")
    assert stale(study) == {}


@pytest.mark.parametrize(
    ("library", "used_by"),
    [("edfio", {"trials"}), ("tifffile", {"stiffness", "emulation", "runs"}), ("jinja2", {"report"})],
)
def test_a_new_version_of_a_library_makes_stale_what_used_it(
    study: Path, install: Install, library: str, used_by: set[str]
) -> None:
    install(library)
    steps = [step for step in stale(study).values() if step.status == "stale"]
    assert {step.stage for step in steps} == used_by
    for step in steps:
        (reason,) = step.reasons
        assert reason.startswith(f"library {library} ")
        assert reason.endswith(" -> 9.9")


def test_of_two_formats_a_new_decoder_makes_its_own_files_stale(tmp_path: Path, install: Install) -> None:
    """The files are read by one process, one after the other, which imports both decoders."""
    truth = readers.made_samples(4000) | {"Fz": 1 - np.cos(np.arange(4000) / 300)}
    for number, write in enumerate((readers.write_c3d, readers.write_csv, readers.write_bdf, readers.write_c3d), 1):
        path = write(tmp_path, truth)
        path.rename(tmp_path / f"P01_S{number}{path.suffix}")
    text = study_of_files("{participant}_{specimen}.*", specimens=("S1", "S2", "S3", "S4"))
    (study := tmp_path / "study.toml").write_text(text)
    main(["run", str(study), "--jobs", "1", "--json"])
    before = set(stale(study))
    assert before.isdisjoint(f"trials/P01/S{n}" for n in range(1, 5))
    for name in ("c3d", "h5py", "nptdms"):
        install(name)
    assert set(stale(study)) == before
    install("ezc3d")
    assert {name for name in stale(study) if name.startswith("trials/")} == {"trials/P01/S1", "trials/P01/S4"}


def test_a_plugin_counts_where_its_name_or_its_whole_group_is_looked_up(tmp_path: Path, install: Install) -> None:
    install("lab-engines", casr__flow_engines="mine")
    install("lab-readers", emg2vsa__readers="theirs")
    with noting() as told:
        assert plugin_named("casr.flow_engines", "other") is None
        assert [each.distribution for each in plugins("emg2vsa.readers")] == ["lab-readers"]
    code = Code(Fingerprints(tmp_path / "memory.json"))
    root = module_of("screening")

    def libraries(*loaded: str) -> dict[str, str]:
        return {name: version for name, version in code.used(root, loaded).libraries.value.items() if "lab" in name}

    assert libraries() == {}
    assert libraries(*told) == {"lab-readers": "9.9"}
    assert libraries("plugins casr.flow_engines mine") == {"lab-engines": "9.9"}


def test_a_library_that_was_looked_for_in_vain_counts(tmp_path: Path) -> None:
    with noting() as told, pytest.raises(ImportError):
        module_named("no_such_library.inner")
    libraries = Code(Fingerprints(tmp_path / "memory.json")).used(module_of("screening"), tuple(told)).libraries.value
    assert libraries["no-such-library"] == "absent"


def test_a_library_has_one_name_however_it_is_spelt(tmp_path: Path, install: Install) -> None:
    def named(library: str) -> set[str]:
        code = Code(Fingerprints(tmp_path / f"{library}.json"))
        return {name for name in code.used("emg2vsa.readers.tdms").libraries.value if "tdms" in name.lower()}

    installed = named("as it is")
    install("npTDMS")
    assert named("npTDMS") == installed == {"nptdms"}


def test_what_a_child_imports_by_name_is_told_by_its_parent(tmp_path: Path) -> None:
    """MATLAB 7.3 asks for pymatreader and h5py inside the child; their absence, or their failure, counts as well."""
    path = tmp_path / "a.mat"
    path.write_bytes(b"MATLAB 7.3 MAT-file".ljust(512, b" "))
    study = tmp_path / "study.toml"
    study.write_text(study_of_files("a.mat"))
    main(["run", str(study), "--jobs", "1", "--json"])
    (ledger,) = tmp_path.glob(".emg2vsa/*/ledger.jsonl")
    entries = [json.loads(line) for line in ledger.read_text().splitlines()]
    (loaded,) = (entry["loaded"] for entry in entries if entry.get("step") == "trials/P01/S1")
    assert {"emg2vsa.readers.matlab", "pymatreader", "h5py"} <= set(loaded)


def test_use_is_noted_from_the_step_alone_and_after_a_failure_too(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def fail(task: Task) -> str:
        used(["emg2vsa.readers.tdms"])
        raise ValueError("no")

    monkeypatch.setattr(Task, "_make", fail)
    used(["emg2vsa.readers.xdf"])
    ended = Task("trials/P01/S1", None, tmp_path / "x", tmp_path / "claim")()  # type: ignore[arg-type]
    assert (ended.status, ended.loaded) == ("failed", ("emg2vsa.readers.tdms",))


def test_a_record_without_use_makes_its_step_stale(study: Path) -> None:
    """As an older version wrote them, or where the lines of a step are lost."""
    (ledger,) = study.parent.glob(".emg2vsa/*/ledger.jsonl")
    lines = [line for line in ledger.read_text().splitlines() if '"step": "trials/P01/S1"' not in line]
    ledger.write_text("\n".join(lines) + "\n")
    found = stale(study)
    assert found["trials/P01/S1"].reasons == ("never ran",)
    assert {step.stage for step in found.values() if step.status == "stale"} == {"trials"}

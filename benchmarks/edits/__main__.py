"""Prints the tables."""

from __future__ import annotations

import argparse
import contextlib
import io
import os
import random
import subprocess
import sys
import tempfile
from collections.abc import Iterator
from datetime import date
from pathlib import Path

import benchmarks.edits
from benchmarks.edits.edit import PRODUCT, copy_of_product, edited, file_of, in_prose, stale_after, trace
from benchmarks.small_study import WITH_A_RIG, small_rig, small_study
from emg2vsa.cli import main as emg2vsa
from emg2vsa.pipeline.code import Code
from emg2vsa.pipeline.fingerprint import Fingerprints
from emg2vsa.pipeline.plan import survey
from emg2vsa.pipeline.stage_order import ORDER, module_of
from emg2vsa.study_file import load_study

LIBRARIES = ("numba", "c3d", "h5py", "nptdms", "pymatreader", "pyxdf", "scikit-fem", "pylsl", "bottleneck")
GROUPS = ("casr.flow_engines", "emg2vsa.readers", "emg2vsa.devices", "emg2vsa.statistics")
Sets = dict[str, set[str]]
_MEANT = "number or operator, in a module that ran"
_STALE_STEPS = """
import sys
from emg2vsa.pipeline.plan import survey
from emg2vsa.pipeline.stage_order import ORDER
from emg2vsa.study_file import load_study
steps = survey(load_study(sys.argv[1]), ORDER, print, asked=ORDER).steps
print(sum(step.status != "fresh" for step in steps.values()), len(steps))
"""


def main() -> None:
    """Print the tables."""
    parser = argparse.ArgumentParser(description=str(benchmarks.edits.__doc__).splitlines()[0])
    parser.add_argument("--edits", type=int, default=200)
    n = parser.parse_args().edits
    with tempfile.TemporaryDirectory() as name:
        study = finished_study(Path(name) / "studies" / "small")
        steps = survey(load_study(study), ORDER, print, asked=ORDER).steps
        trace(study, {step.stage: step.item for step in reversed(steps.values())}, Path(name) / "trace")
        print(f"# Which edits and installations make stages stale\n\n`python -m benchmarks.edits`, {date.today()}. "
              f"{benchmarks.edits.__doc__.partition('Markdown. ')[2].strip()}\n")  # fmt: skip
        print("\n".join(edits_table(Path(name), study, n)), "\n", flush=True)
        print("\n".join(libraries_table(Path(name), study)))


def finished_study(folder: Path) -> Path:
    """The file of a small study with every stage, run to its report."""
    folder.mkdir(parents=True)
    (folder / "study.toml").write_text(small_study(tables=WITH_A_RIG))
    (folder / "rig.toml").write_text(small_rig("high-stiffness = [0]\nmodular = [0]\n"))
    for command in (["tools", "simulate"], ["run", "--jobs", "1", "--paths"]):
        with contextlib.redirect_stdout(io.StringIO()), contextlib.redirect_stderr(io.StringIO()):
            assert emg2vsa([*command, str(folder / "study.toml"), "--json"]) == 0
    return folder / "study.toml"


def traced(folder: Path, what: str) -> Sets:
    """Module to the stages that did so with it."""
    found: Sets = {}
    for stage in ORDER:
        for module in (folder / "trace" / stage / f"{what}.txt").read_text().split():
            found.setdefault(module, set()).add(stage)
    return found


def by_reach(folder: Path) -> Sets:
    """Module to the stages that reach it, by which keys went before."""
    code = Code(Fingerprints(folder / "reach.json"))
    found: Sets = {}
    for stage in ORDER:
        for module in code.reached(module_of(stage)).modules.value:
            found.setdefault(module, set()).add(stage)
    return found


def edits_table(folder: Path, study: Path, n: int) -> Iterator[str]:
    draw, copy = random.Random(20261129), copy_of_product(folder / "product")
    executed, called, reached = traced(folder, "executed"), traced(folder, "called"), by_reach(folder)
    paths = [path for package in ("emg2vsa", "casr") for path in sorted((copy / package).rglob("*.py"))]
    names = [".".join(path.relative_to(copy).with_suffix("").parts).removesuffix(".__init__") for path in paths]
    ran, others = sorted(called), sorted(set(names) - executed.keys())
    edits = {
        _MEANT: _drawn(copy, ran, n * 7 // 10, draw),
        "prose, in a module that ran": [
            (module, in_prose(file_of(copy, module), draw)) for module in draw.choices(ran, k=n * 2 // 10)
        ],
        "number or operator, in a module that no stage ran": _drawn(copy, others, n - n * 7 // 10 - n * 2 // 10, draw),
    }
    yield "| edit | tries | hits wanted | missed | hits | imported only | needless | needless by reach, as before |"
    yield "|---|---:|---:|---:|---:|---:|---:|---:|"
    said = ""
    for kind, of in edits.items():
        prose, n_wanted, n_missed, n_hits, n_imported, n_needless, n_before = "prose" in kind, 0, 0, 0, 0, 0, 0
        for (module, _), stale in zip(of, stale_after(copy, study, of), strict=True):
            wanted = set() if prose else executed.get(module, set())
            before = set() if prose else reached.get(module, set()) | wanted
            n_wanted, n_missed, n_hits = n_wanted + len(wanted), n_missed + len(wanted - stale), n_hits + len(stale)
            n_imported += len(stale & wanted - called.get(module, set()))
            n_needless, n_before = n_needless + len(stale - wanted), n_before + len(before - wanted)
        counts = f"{n_wanted} | **{n_missed}** | {n_hits} | {n_imported} | {n_needless} | {n_before}"
        yield f"| {kind} | {len(of)} | {counts} |"
        if of is edits[_MEANT]:
            share, old = 113 * n_needless / n_hits, 113 * n_before / (n_wanted + n_before)
            said = f"Of 113 hits by edits in modules that ran {share:.0f} are needless; by reach {old:.0f} were."
    yield f"\n{said}"


def _drawn(copy: Path, modules: list[str], n: int, draw: random.Random) -> list[tuple[str, str]]:
    found: list[tuple[str, str]] = []
    while len(found) < n:
        module = draw.choice(modules)
        if (text := edited(file_of(copy, module), draw)) is not None:
            found.append((module, text))
    return found


def libraries_table(folder: Path, study: Path) -> Iterator[str]:
    """Each is installed alone, in a version that nobody has, before all others of its name."""
    yield "| installed | steps not fresh after it | of |"
    yield "|---|---:|---:|"
    for number, (name, group) in enumerate(
        [*((name, "") for name in LIBRARIES), *(("lab", group) for group in GROUPS)]
    ):
        site = folder / f"site{number}"
        info = site / f"{name.replace('-', '_')}-9.9.dist-info"
        info.mkdir(parents=True)
        (info / "METADATA").write_text(f"Metadata-Version: 2.1\nName: {name}\nVersion: 9.9\n")
        (info / "top_level.txt").write_text(f"{'skfem' if name == 'scikit-fem' else name}\n")
        (info / "entry_points.txt").write_text(f"[{group}]\nanother = lab:x\n" if group else "")
        environment = os.environ | {"PYTHONPATH": os.pathsep.join([str(site), str(PRODUCT), *sys.path])}
        done = subprocess.run([sys.executable, "-c", _STALE_STEPS, str(study)], env=environment, capture_output=True,
                              text=True, check=True)  # fmt: skip
        stale, of = done.stdout.split()
        yield f"| {f'a plugin of {group}' if group else name} | {stale} | {of} |"


if __name__ == "__main__":
    main()

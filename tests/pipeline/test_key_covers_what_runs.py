"""A step's key holds every module that runs in it and every library that it loads; the same step gives the same bytes.

Decided by what runs: each stage is run once more and traced, its child processes too.
"""

from __future__ import annotations

import ast
import json
import os
import random
import shutil
import subprocess
import sys
from dataclasses import dataclass
from importlib.metadata import packages_distributions
from pathlib import Path

import pytest

import emg2vsa
from emg2vsa.pipeline.stage_order import ORDER
from tests.once import Once

HERE = Path(__file__).parent
PRODUCT = Path(emg2vsa.__file__).parent.parent
STEPS = {
    "trials": "P01/S1",
    "fits": "P01/S1",
    "screening": "study",
    "pages": "P01",
    "hypotheses": "study",
    "exemplary": "study",
    "profiles": "study",
    "schedules": "study",
    "stiffness": "study",
    "emulation": "S1_0_modular",
    "runs": "S1_0_modular",
    "discrimination": "study",
    "calibration": "study",
    "paths": "study",
    "report": "study",
}


@dataclass(frozen=True)
class Trace:
    """What one step executed and imported, and the result file that came out."""

    executed: frozenset[str]
    imported: frozenset[str]
    product: bytes


def trace(study: Path, steps: dict[str, str], out: Path) -> None:
    """Run the step of each stage once more, and write what it did."""
    out.mkdir(parents=True)
    environment = os.environ | {"PYTHONHASHSEED": "7", "PYTHONPATH": os.pathsep.join([str(PRODUCT), *sys.path])}
    script = [sys.executable, str(HERE / "trace_step.py"), str(study), str(out), *map("/".join, steps.items())]
    done = subprocess.run(script, capture_output=True, text=True, env=environment, check=False)
    assert done.returncode == 0, done.stderr


def read_traces(out: Path) -> dict[str, Trace]:
    """Stage to what its step did."""
    texts = {of.name: [(of / f"{name}.txt").read_text().split() for name in ("executed", "imported")] for of in
             out.iterdir()}  # fmt: skip
    return {
        stage: Trace(frozenset(executed), frozenset(imported), (out / stage / "product.result").read_bytes())
        for stage, (executed, imported) in texts.items()
    }


@pytest.fixture(scope="session")
def traces(finished: Path, measured: Path, built_once: Once) -> dict[str, Trace]:
    """Stage to its trace; of a measured run too."""

    def build(root: Path) -> None:
        trace(measured / "study.toml", {"runs": "S1_0_modular", "report": "study"}, root / "measured")
        trace(finished / "study.toml", STEPS, root / "simulated")

    root = built_once("traces", build)
    of_measured = {f"{stage}, measured": found for stage, found in read_traces(root / "measured").items()}
    return read_traces(root / "simulated") | of_measured


def parts_of(study: Path) -> dict[str, dict[str, dict[str, str]]]:
    """Stage to code and libraries in the keys of its steps, as the ledger has them."""
    values, entries = {}, {}
    for line in next(study.parent.glob(".emg2vsa/*/ledger.jsonl")).read_text().splitlines():
        fields = json.loads(line)
        if "part" in fields:
            values[fields["part"]] = fields["value"]
        else:
            entries[fields["step"].partition("/")[0]] = fields["parts"]
    return {stage: {name: values[parts[name]] for name in ("code", "libraries")} for stage, parts in entries.items()}


def test_every_stage_is_traced() -> None:
    assert set(STEPS) == set(ORDER)


def test_what_runs_is_in_the_key(finished: Path, measured: Path, traces: dict[str, Trace]) -> None:
    of_distribution = packages_distributions()
    rows = [f"{'stage':<18}{'executed':>9}{'in key':>8}{'libraries':>11}"]
    missing = {}
    for name, found in traces.items():
        study = (measured if "measured" in name else finished) / "study.toml"
        parts = parts_of(study)[name.partition(",")[0]]
        libraries = {one for module in found.imported for one in of_distribution[module]}
        rows.append(f"{name:<18}{len(found.executed):>9}{len(parts['code']):>8}{len(parts['libraries']):>11}")
        assert len(found.executed) > 3
        if left := (found.executed - set(parts["code"])) | (libraries - set(parts["libraries"])):
            missing[name] = left
    print("\n".join(rows))
    assert missing == {}


def test_the_same_step_gives_the_same_bytes(finished: Path, measured: Path, traces: dict[str, Trace]) -> None:
    for name, found in traces.items():
        stage = name.partition(",")[0]
        folder, item = (measured, "S1_0_modular") if "measured" in name else (finished, STEPS[stage])
        item = "study" if stage == "report" else item
        (stored,) = folder.glob(f".emg2vsa/*/store/{stage}/{item}/*.result")
        assert found.product == stored.read_bytes(), name


STALE = """
import json, sys
from pathlib import Path
from emg2vsa.pipeline.plan import survey
from emg2vsa.pipeline.stage_order import ORDER
from emg2vsa.study_file import load_study
for line in sys.stdin:
    file, text = json.loads(line)
    path, before = Path(file), Path(file).read_bytes()
    path.write_text(text)
    plan = survey(load_study(sys.argv[1]), ORDER, print, asked=ORDER)
    path.write_bytes(before)
    stale = {s.stage: s.reasons for s in plan.steps.values() if s.status == "stale"}
    print(json.dumps(stale), flush=True)
"""


@pytest.mark.parametrize("n_edits", [4, pytest.param(36, marks=pytest.mark.slow)])
def test_an_edit_of_any_module_is_noticed(study: Path, traces: dict[str, Trace], tmp_path: Path, n_edits: int) -> None:
    """One constant or operator changed: what ran the module is stale, and nothing that cannot reach it."""
    copy = tmp_path / "product"
    for package in ("emg2vsa", "casr"):
        shutil.copytree(PRODUCT / package, copy / package, ignore=shutil.ignore_patterns("__pycache__"))
    executed_by: dict[str, set[str]] = {}
    for name, found in traces.items():
        for module in found.executed if "measured" not in name else ():
            executed_by.setdefault(module, set()).add(name)
    draw = random.Random(20261122)
    modules = sorted(executed_by)
    draw.shuffle(modules)
    edits = [(module, text) for module in modules if (text := edited(file_of(copy, module), draw)) is not None][
        :n_edits
    ]
    assert len(edits) == n_edits
    environment = os.environ | {"PYTHONPATH": os.pathsep.join([str(copy), *sys.path])}
    sent = "".join(json.dumps([str(file_of(copy, module)), text]) + "\n" for module, text in edits)
    program = [sys.executable, "-c", STALE, str(study)]
    done = subprocess.run(program, input=sent, capture_output=True, text=True, env=environment, check=False, cwd=copy)
    assert done.returncode == 0, done.stderr
    reaches = Reach(copy)
    caught = 0
    for (module, _), line in zip(edits, done.stdout.splitlines(), strict=True):
        stale = set(json.loads(line))
        possible = {stage for stage in ORDER if module in reaches.from_stage(stage)}
        assert executed_by[module] <= stale <= possible, (module, executed_by[module] - stale, stale - possible)
        caught += 1
    print(f"{caught} of {len(edits)} edits caught")


def file_of(root: Path, module: str) -> Path:
    base = root.joinpath(*module.split("."))
    return base.with_suffix(".py") if base.with_suffix(".py").is_file() else base / "__init__.py"


def edited(path: Path, draw: random.Random) -> str | None:
    """The source with one number or one operator changed; None where it has none."""
    text = path.read_text()
    lines = text.splitlines(keepends=True)
    places = []
    for node in ast.walk(ast.parse(text)):
        number = isinstance(node, ast.Constant) and type(node.value) in (int, float) and node.lineno == node.end_lineno
        if number and lines[node.lineno - 1].isascii():  # type: ignore[attr-defined]
            places.append((node.lineno - 1, node.col_offset, node.end_col_offset, f"{node.value + 1!r}"))  # type: ignore[attr-defined]
        if (
            isinstance(node, ast.BinOp)
            and isinstance(node.op, (ast.Add, ast.Sub))
            and node.left.end_lineno == node.lineno
        ):
            at = lines[node.lineno - 1].find("+" if isinstance(node.op, ast.Add) else "-", node.left.end_col_offset)
            if at >= 0 and lines[node.lineno - 1].isascii():
                places.append((node.lineno - 1, at, at + 1, "-" if isinstance(node.op, ast.Add) else "+"))
    if not places:
        return None
    line, first, last, new = draw.choice(sorted(places))
    lines[line] = lines[line][:first] + new + lines[line][last:]
    return "".join(lines)


class Reach:
    """What modules can import, by an import graph that is not the product's, with modules named in strings."""

    def __init__(self, root: Path) -> None:
        import grimp

        sys.path.insert(0, str(root))
        try:
            self._graph = grimp.build_graph("emg2vsa", "casr", cache_dir=None)
        finally:
            sys.path.remove(str(root))
        for module in list(self._graph.modules):
            source = file_of(root, module).read_text()
            for node in ast.walk(ast.parse(source)):
                if isinstance(node, ast.Constant) and isinstance(node.value, str):
                    named = node.value.partition(":")[0]
                    if named in self._graph.modules:
                        self._graph.add_import(importer=module, imported=named)
        self._known: dict[str, set[str]] = {}

    def from_stage(self, stage: str) -> set[str]:
        if stage not in self._known:
            root = f"emg2vsa.pipeline.stages.{stage}"
            reached = {root, *self._graph.find_upstream_modules(root)}
            parents = {name.rsplit(".", n)[0] for name in reached for n in range(name.count(".") + 1)}
            more = {up for parent in parents for up in (parent, *self._graph.find_upstream_modules(parent))}
            self._known[stage] = reached | more
        return self._known[stage]

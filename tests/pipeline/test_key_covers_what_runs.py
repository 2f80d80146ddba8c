"""A step's key holds every module that runs in it and every library that it loads; the same step gives the same bytes.

Decided by what runs: each stage is run once more and traced, its child processes too.
"""

from __future__ import annotations

import ast
import json
import random
import sys
from dataclasses import dataclass
from importlib.metadata import packages_distributions
from pathlib import Path
from typing import Any

import pytest

from benchmarks.edits.edit import PRODUCT, copy_of_product, edited, file_of, stale_after, trace
from emg2vsa.pipeline.stage_order import ORDER
from tests.once import Once

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
    "kappa": "0_modular",
    "calibration": "study",
    "paths": "study",
    "report": "study",
}


MEASURED = {"runs": "S1_0_modular", "report": "study"}
LOCAL = {"casr.child_process", "casr.blas_kernel"}
"""Starts what its caller names, which is the caller or told by it; looks where NumPy lies."""


@dataclass(frozen=True)
class Trace:
    """What one step executed, imported and told of as loaded by name, and the result file that came out."""

    executed: frozenset[str]
    imported: frozenset[str]
    loaded: tuple[str, ...]
    product: bytes


def read_traces(out: Path) -> dict[str, Trace]:
    """Stage to what its step did."""
    texts = {of.name: [(of / f"{name}.txt").read_text().splitlines() for name in ("executed", "imported", "loaded")]
             for of in out.iterdir()}  # fmt: skip
    return {
        stage: Trace(frozenset(ran), frozenset(imported), tuple(loaded), (out / stage / "product.result").read_bytes())
        for stage, (ran, imported, loaded) in texts.items()
    }


@pytest.fixture(scope="session")
def traces(finished: Path, measured: Path, built_once: Once) -> dict[str, Trace]:
    """Stage to its trace; of a measured run too."""

    def build(root: Path) -> None:
        trace(measured / "study.toml", MEASURED, root / "measured")
        trace(finished / "study.toml", STEPS, root / "simulated")

    root = built_once("traces", build)
    of_measured = {f"{stage}, measured": found for stage, found in read_traces(root / "measured").items()}
    return read_traces(root / "simulated") | of_measured


def parts_of(study: Path) -> dict[str, dict[str, Any]]:
    """Step to code and libraries in its key, and what it loaded, as the ledger has them."""
    values, entries = {}, {}
    for line in next(study.parent.glob(".emg2vsa/*/ledger.jsonl")).read_text().splitlines():
        fields = json.loads(line)
        if "part" in fields:
            values[fields["part"]] = fields["value"]
        else:
            entries[fields["step"]] = fields
    return {
        step: {name: values[of["parts"][name]] for name in ("code", "libraries")} | {"loaded": tuple(of["loaded"])}
        for step, of in entries.items()
    }


def step_of(name: str) -> str:
    """The step that a trace is of."""
    stage, _, measured = name.partition(", ")
    return f"{stage}/{(MEASURED if measured else STEPS)[stage]}"


def test_every_stage_is_traced() -> None:
    assert set(STEPS) == set(ORDER)


def test_what_runs_is_in_the_key(finished: Path, measured: Path, traces: dict[str, Trace]) -> None:
    of_distribution = packages_distributions()
    rows = [f"{'stage':<18}{'executed':>9}{'in key':>8}{'libraries':>11}"]
    missing = {}
    for name, found in traces.items():
        study = (measured if "measured" in name else finished) / "study.toml"
        parts = parts_of(study)[step_of(name)]
        libraries = {one_name(each) for module in found.imported for each in of_distribution[module]}
        rows.append(f"{name:<18}{len(found.executed):>9}{len(parts['code']):>8}{len(parts['libraries']):>11}")
        assert len(found.executed) > 3
        if left := (found.executed - set(parts["code"])) | (libraries - set(parts["libraries"])):
            missing[name] = left
    print("\n".join(rows))
    assert missing == {}


def one_name(library: str) -> str:
    return library.replace("_", "-").lower()


def test_what_is_loaded_by_name_is_told_in_a_process_of_many_steps_as_in_one_of_its_own(
    finished: Path, measured: Path, traces: dict[str, Trace]
) -> None:
    """The studies were run by one process, in which caches of earlier steps might hide what a later one uses."""
    for name, found in traces.items():
        study = (measured if "measured" in name else finished) / "study.toml"
        parts = parts_of(study)[step_of(name)]
        assert set(parts["loaded"]) <= set(found.loaded), name
        assert {each for each in found.loaded if each not in parts["code"]} <= set(parts["loaded"]), name
    assert "emg2vsa.readers.edf_bdf" in traces["trials"].loaded
    assert "emg2vsa.readers.edf_bdf" in traces["trials"].executed  # in the child process
    assert "casr.frame_files.tiff" in traces["runs"].loaded


def test_what_steps_use_imports_by_name_where_it_is_told(finished: Path, measured: Path) -> None:
    """Neither another way to import by name, nor a public name that a package loads when it is first asked for."""
    lazy = {"emg2vsa", "emg2vsa.rig", "emg2vsa.session", "casr", "casr.page", "casr.overlays"}
    of_steps = [of for study in (finished, measured) for of in parts_of(study / "study.toml").values()]
    used = {module for of in of_steps for module in of["code"]} - {"casr.by_name", "casr.lazy_names"}
    assert len(used) > 300
    for module in sorted(used):
        for node in ast.walk(ast.parse(file_of(PRODUCT, module).read_text())):
            if isinstance(node, ast.Call) and module not in LOCAL:
                called = node.func.attr if isinstance(node.func, ast.Attribute) else getattr(node.func, "id", "")
                assert called not in ("__import__", "find_spec", "exec", "eval"), (module, node.lineno)
                named = getattr(node.args[0], "value", "") if called == "import_module" else "sys"
                assert named in sys.stdlib_module_names, (module, node.lineno)
            if isinstance(node, ast.ImportFrom) and node.module in lazy and not node.level:
                for name in {alias.name for alias in node.names} - {"__version__"}:
                    assert file_of(PRODUCT, f"{node.module}.{name}").is_file(), (module, node.lineno)


def test_no_stage_hangs_on_another_by_its_file() -> None:
    """A stage that imports another's file would hang on all that the other one runs."""
    for name in ORDER:
        for node in ast.walk(ast.parse(file_of(PRODUCT, f"emg2vsa.pipeline.stages.{name}").read_text())):
            if isinstance(node, ast.ImportFrom):
                assert not (node.module or "").startswith("emg2vsa.pipeline.stages"), (name, node.lineno)


def test_the_same_step_gives_the_same_bytes(finished: Path, measured: Path, traces: dict[str, Trace]) -> None:
    for name, found in traces.items():
        folder = measured if "measured" in name else finished
        (stored,) = folder.glob(f".emg2vsa/*/store/{step_of(name)}/*.result")
        assert found.product == stored.read_bytes(), name


@pytest.mark.parametrize("n_edits", [4, pytest.param(36, marks=pytest.mark.slow)])
def test_an_edit_of_any_module_is_noticed(study: Path, traces: dict[str, Trace], tmp_path: Path, n_edits: int) -> None:
    """One constant or operator changed: what ran the module is stale, and little else; nothing that cannot reach it."""
    copy = copy_of_product(tmp_path / "product")
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
    told = stale_after(copy, study, edits)
    reaches = Reach(copy)
    hits = needless = 0
    for (module, _), stale in zip(edits, told, strict=True):
        possible = {stage for stage in ORDER if module in reaches.from_stage(stage)}
        assert executed_by[module] <= stale <= possible, (module, executed_by[module] - stale, stale - possible)
        hits, needless = hits + len(stale), needless + len(stale - executed_by[module])
    print(f"{n_edits} of {n_edits} edits caught; {needless} of {hits} hits needless")
    assert needless <= hits / 5 + 2


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

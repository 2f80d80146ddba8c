"""Mutants of a source, the sample of them, and one tried in a project of its own."""

from __future__ import annotations

import ast
import subprocess
import time
from collections import Counter
from pathlib import Path

import pytest

from benchmarks.mutation import trial
from benchmarks.mutation.mutants import mutants_of
from benchmarks.mutation.nearest import files_for, read_line_map
from benchmarks.mutation.sample import Chosen, package_of, sample
from benchmarks.mutation.table import wilson
from benchmarks.mutation.time_limit import EXIT_CODE
from benchmarks.mutation.trial import tried

ROOT = Path(__file__).resolve().parents[2]
SOURCE = '''\
"""Words – with a dash."""
import math

def share(part: int = 2, whole: float = 0.5) -> float:
    "Documented."
    if part <= whole and not part == 3:
        raise ValueError(f"{part + 1}")
    rows = [part, whole][1:]
    rows[0] = "é" * part + str(max(part, 1))
    return math.hypot(part, whole)
'''


def test_every_kind_of_change_is_made_where_it_stands_and_nothing_else_is_touched() -> None:
    mutants = mutants_of(SOURCE)
    found = {(mutant.kind, mutant.before, mutant.after) for mutant in mutants}
    assert {
        ("constant", "2", "3"),
        ("constant", "0.5", "0.55"),
        ("comparison", "part <= whole", "(part >= whole)"),
        ("off by one", "part <= whole", "(part < whole)"),
        ("comparison", "part == 3", "(part != 3)"),
        ("boolean", "not part == 3", "(part == 3)"),
        ("slice", "[part, whole][1:]", "[part, whole][:]"),
        ("off by one", "1", "2"),
        ("arithmetic", '"é" * part', "('é' / part)"),
        ("argument order", "math.hypot(part, whole)", "math.hypot(whole, part)"),
        ("return", "math.hypot(part, whole)", "None"),
        ("removed statement", 'raise ValueError(f"{part + 1}")', "pass"),
    } <= found
    assert not {mutant.before for mutant in mutants} & {"part + 1", '"Documented."', "max(part, 1)", "int", "math"}
    for mutant in mutants:
        changed = mutant.applied(SOURCE)
        assert ast.dump(ast.parse(changed)) != ast.dump(ast.parse(SOURCE))
        assert SOURCE.splitlines()[: mutant.line - 1] == changed.splitlines()[: mutant.line - 1]


def test_a_sample_is_repeatable_and_in_proportion_to_lines() -> None:
    chosen = sample(ROOT, seed=3, count=12, package="casr.f")
    assert chosen == sample(ROOT, seed=3, count=12, package="casr.f")
    assert len(set(chosen)) == 12
    lines: Counter[str] = Counter()
    for path in (ROOT / "casr").rglob("*.py"):
        lines[package_of(path.relative_to(ROOT))] += len(path.read_text(encoding="utf-8").splitlines())
    there = {package: n for package, n in lines.items() if package.startswith("casr.f")}
    assert set(there) == {"casr.flow", "casr.frame_files", "casr.frames"}
    counts = Counter(package_of(Path(each.module)) for each in chosen)
    for package, n in there.items():
        assert abs(counts[package] - 12 * n / sum(there.values())) <= 1 + 1e-9


def test_bad_input_is_named(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    from benchmarks.mutation.__main__ import main

    with pytest.raises(ValueError, match="--package: expected a package of emg2vsa or casr, but found 'nothing'"):
        sample(ROOT, seed=1, count=1, package="nothing")
    with pytest.raises(FileNotFoundError, match="expected coverage files"):
        read_line_map(tmp_path)
    assert main(["--count", "0"]) == 2
    assert capsys.readouterr().err.startswith("--count: expected 1 mutant or more, but found 0.")


def test_the_files_that_run_a_line_come_before_those_that_name_its_module() -> None:
    module = "emg2vsa/statistics/ranks.py"
    lines = {module: {10: frozenset({"tests/test_docs.py"}), 20: frozenset({"tests/extraction/test_extract.py"})}}
    near = files_for(ROOT, module, 12, {})
    assert near[0] == "tests/statistics/test_ranks.py"
    assert len(near) == 10
    by_line = files_for(ROOT, module, 12, lines)
    assert by_line[:2] == ["tests/statistics/test_ranks.py", "tests/test_docs.py"]
    assert "tests/extraction/test_extract.py" not in by_line


@pytest.mark.parametrize(("successes", "n", "low", "high"), [(0, 10, 0.0, 0.2775), (81, 263, 0.2553, 0.3662)])
def test_wilsons_interval(successes: int, n: int, low: float, high: float) -> None:
    """The second is the example of Newcombe 1998, table I."""
    assert wilson(successes, n) == pytest.approx((low, high), abs=1e-4)


@pytest.mark.slow
def test_a_mutant_is_killed_survives_or_never_ends(tmp_path: Path) -> None:
    tree = tmp_path / "project"
    (tree / "tests").mkdir(parents=True)
    for package in ("casr", "benchmarks", "benchmarks/mutation"):
        (tree / package).mkdir()
        (tree / package / "__init__.py").touch()
    source = "def low(x):\n    n = 0\n    while x > 0:\n        x -= 1\n        n += 1\n    return n + 0 * len('a')\n"
    (tree / "casr" / "low.py").write_text(source)
    (tree / "tests" / "test_low.py").write_text(
        "import sys; sys.path.insert(0, '.')\nfrom casr.low import low\ndef test_low():\n    assert low(3) == 3\n"
    )
    limit = (ROOT / "benchmarks" / "mutation" / "time_limit.py").read_text()
    assert "= 60.0, 400.0" in limit
    limit = limit.replace("= 60.0, 400.0", "= 2.0, 60.0")
    (tree / "benchmarks" / "mutation" / "time_limit.py").write_text(limit)
    for words in (
        ["init", "-q"],
        ["add", "."],
        ["-c", "user.name=a", "-c", "user.email=a@b.c", "commit", "-qm", "all"],
    ):
        subprocess.run(["git", "-C", str(tree), *words], check=True)
    found = {(mutant.kind, mutant.before): mutant for mutant in mutants_of(source)}
    (tmp_path / "work").mkdir()
    for kind, before, state in (
        ("return", "n + 0 * len('a')", "killed"),
        ("removed statement", "x -= 1", "timed out"),
        ("arithmetic", "0 * len('a')", "survived"),
    ):
        verdict = tried(tree, Chosen("casr/low.py", found[kind, before]), ["tests/test_low.py"], tmp_path / "work")
        assert (verdict.state, verdict.by) == (state, "tests/test_low.py::test_low" if state == "killed" else "")
    assert (tree / "casr" / "low.py").read_text() == source


@pytest.mark.slow
@pytest.mark.parametrize("fails", [True, False])
def test_a_run_that_hangs_after_its_last_test_is_ended(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, fails: bool
) -> None:
    monkeypatch.setattr(trial, "RUN_S", 10.0)
    (tmp_path / "test_hangs.py").write_text(
        "import threading\n"
        "def test_it():\n"
        "    threading.Thread(target=threading.Event().wait).start()\n"
        f"    assert not {fails}\n"
    )
    begin_s = time.monotonic()
    code, out = trial.run_tests(ROOT, [str(tmp_path / "test_hangs.py")], tmp_path)
    assert time.monotonic() - begin_s < 60
    assert code == (1 if fails else EXIT_CODE)
    assert [name.rpartition("::")[2] for name in trial.failed_tests(out)] == ["test_it"] * fails

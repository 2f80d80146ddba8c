"""The short stress table keeps its bounds, and breaks where a function is broken."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
from mpmath import mpf

import benchmarks.stress
from benchmarks.stress import all_cases, curves, run, signals
from benchmarks.stress.case import Case, Found, fewest_digits, judged
from emg2vsa.cli import main
from emg2vsa.curves import line
from emg2vsa.errors import DataError

SMOKE = tuple(all_cases(smoke=True))


@pytest.mark.parametrize("case", SMOKE, ids=[f"{case.function}: {case.world}" for case in SMOKE])
def test_a_function_keeps_its_bound(case: Case) -> None:
    row = judged(case)
    assert row.kept, row
    assert row.digits >= row.bound or row.said


def test_a_broken_function_breaks_its_row(monkeypatch: pytest.MonkeyPatch) -> None:
    case = next(case for case in SMOKE if case.function.endswith("fit_log") and "1e6" in case.world)
    assert judged(case).verdict == "kept"

    def from_sums(
        values: np.ndarray, weights: object, total: np.ndarray, first: object
    ) -> tuple[np.ndarray, np.ndarray]:
        mean = (np.sum(values, axis=1) / total).astype(np.float32).astype(np.float64)
        return mean, values - mean[:, None]

    monkeypatch.setattr(line, "_centred", from_sums)
    row = judged(case)
    assert row.verdict == "broken"
    assert row.digits < row.bound


def test_few_digits_without_a_word_are_broken_whatever_the_bound(monkeypatch: pytest.MonkeyPatch) -> None:
    case = next(case for case in SMOKE if "within 1e-12" in case.world)
    assert judged(case).verdict == "kept"
    monkeypatch.setattr(curves, "said_of_forces", lambda forces: [""] * len(forces))
    assert judged(case).verdict == "broken"


def _case(found: Found | Exception, bound: float = 10.0) -> Case:
    def ours(x: np.ndarray) -> Found:
        if isinstance(found, Exception):
            raise found
        return found

    return Case("made", "up", (np.array([3.0]),), ours, lambda x: {"y": [2 * x[0] + 1]}, bound)


@pytest.mark.parametrize(
    ("found", "verdict"),
    [
        (Found({"y": 7.0}), "kept"),
        (Found({"y": 7.0001}), "broken"),
        (Found({"y": 7.0001}, "four digits"), "broken"),
        (Found({"y": np.nan}), "broken"),
        (Found({"y": np.nan}, "undefined"), "says so"),
        (Found({}), "broken"),
        (DataError("made", wanted="more", found="less", do="Give more."), "says so"),
    ],
)
def test_verdicts(found: Found | Exception, verdict: str) -> None:
    assert judged(_case(found)).verdict == verdict


def test_what_the_condition_allows() -> None:
    def exact(x: np.ndarray) -> dict[str, object]:
        return {"y": [x[0] - 1_000_000]}

    case = Case("made", "up", (np.array([1_000_001.0]),), lambda x: Found({"y": x - 1e6}), exact, 15.0)
    assert judged(case).allowed == pytest.approx(16 - 6, abs=0.1)


def test_digits_are_counted() -> None:
    assert fewest_digits([1.0, 2.002], [mpf(1), mpf(2)]) == pytest.approx(3)
    assert fewest_digits([1.0, 0.001], [mpf(1), mpf(0)], "largest") == pytest.approx(3)
    assert fewest_digits(2.0, mpf(2)) == 16
    assert fewest_digits([1.0, 2.0], [mpf(1)]) == 0
    assert fewest_digits(None, mpf(1)) == 0


def test_tables_are_written_and_a_broken_row_is_an_error(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    good, bad = _case(Found({"y": 7.0})), _case(Found({"y": 7.1}, "a|b"))
    monkeypatch.setattr(benchmarks.stress, "all_cases", lambda smoke, areas: [good])
    assert run(tmp_path, smoke=True) == 0
    monkeypatch.setattr(benchmarks.stress, "all_cases", lambda smoke, areas: [good, bad])
    assert run(tmp_path, smoke=True) == 1
    assert "2 rows, 1 broken" in capsys.readouterr().out
    page = (tmp_path / "stress.md").read_text()
    assert "2 rows: 1 kept, 0 say so, 1 broken." in page
    assert "a\\|b" in page
    assert [row["verdict"] for row in json.loads((tmp_path / "stress.json").read_text())] == ["kept", "broken"]


def test_a_low_edge_says_its_digits() -> None:
    row = judged(signals.low_pass_case(1e-4, 0.0, 1.0, 2, "causal", 8.0, False, signals.noise(300)))
    assert row.kept
    assert "digits of a slow signal" in row.said


def test_the_command_hands_on_what_was_asked(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    asked = []
    monkeypatch.setattr(benchmarks.stress, "run", lambda out, smoke: asked.append((out, smoke)) or 1)
    assert main(["tools", "bench", "stress", "--smoke", "--out", str(tmp_path)]) == 1
    assert asked == [(tmp_path, True)]


def test_stress_goes_with_no_area(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["tools", "bench", "stress", "pins"]) == 2
    assert "bench stress: expected no other area, but found stress pins" in capsys.readouterr().err

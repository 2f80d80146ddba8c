"""``emg2vsa tools bench``: the turns of the ways, ratios, growth, pages, other revisions, and input that it refuses."""

from __future__ import annotations

import json
import sys
import tempfile
from collections.abc import Callable, Iterable
from pathlib import Path

import numpy as np
import pytest

from benchmarks.bench import compare, plots, run
from benchmarks.bench.case import Area, Case, NotHere, Size, Way
from benchmarks.bench.growth import exponent, growths
from benchmarks.bench.measure import measure
from benchmarks.bench.memory import peak_mb
from benchmarks.bench.plots import front_of, write_plots
from benchmarks.bench.results import AreaResult, digits_of
from benchmarks.bench.tables import page
from benchmarks.bench.timing import Timed, timed
from casr import source_checkout
from emg2vsa.cli import main
from emg2vsa.errors import SettingError


class Clock:
    """Seconds that the runs themselves let pass."""

    def __init__(self) -> None:
        self.now, self.order = 0.0, ""

    def __call__(self) -> float:
        return self.now

    def way(self, name: str, seconds: float) -> Callable[[], None]:
        def work() -> None:
            self.now += seconds
            self.order += name

        return work


def _way(library: str, name: str, run: Callable[[], object] = lambda: 1.0) -> Way:
    return Way(library, name, run, "equal")


def _case(size: float, *ways: Way) -> Case:
    error = {1.0: 0.5, 2.0: 0.0, 3.0: 1e-3}
    return Case(f"sum of {size:g}", size, "numbers", ways, error.__getitem__, "relative", "by hand", "sums")


def _two_sizes(_: Size) -> Iterable[Case]:
    for size in (10, 100):
        peer = _way("peer", "slow", lambda: 2.0)
        yield _case(size, _way("emg2vsa", "fast"), peer, _way("peer", "third", lambda: 3.0), _way("peer", "bad", _fail))


def _fail() -> object:
    raise ValueError("it breaks\nwith a second line")


def _lacks(_: Size) -> Iterable[Case]:
    raise NotHere("a data set: NAME says where it is")


def _older(_: Size) -> Iterable[Case]:
    from emg2vsa import no_such_function  # type: ignore[attr-defined]

    yield no_such_function


AREA = Area("demo", "Is it right?", (_two_sizes, _lacks), {"json": "json"}, "It means nothing.")


def _measured(rounds: int = 2) -> AreaResult:
    return measure(AREA, Size.SMOKE, rounds=rounds)


def test_ways_take_turns_and_the_order_turns_too() -> None:
    clock = Clock()
    ways = [clock.way("a", 1.0), clock.way("b", 3.0), clock.way("c", 2.0)]
    first, second, _ = timed(ways, [9.0, 9.0, 9.0], rounds=3, budget_s=100, clock=clock)
    assert clock.order == "abcbcacab"
    assert first.rounds_s == (1.0, 1.0, 1.0)
    assert second.ratio_to(first).median == 3.0


def test_short_runs_are_repeated_within_a_turn_and_long_ones_end_with_their_budget() -> None:
    clock = Clock()
    short, long = timed([clock.way("s", 1e-3), clock.way("l", 5.0)], [1e-3, 5.0], rounds=4, budget_s=8, clock=clock)
    assert clock.order.count("s") == 1 + 4 * 2
    assert clock.order.count("l") == 2
    assert short.median_s == pytest.approx(1e-3)
    assert np.isnan(long.rounds_s[2:]).all()
    assert long.ratio_to(short).median == pytest.approx(5000)


def test_ratios_are_taken_within_rounds() -> None:
    ours, theirs = Timed(0.0, (1.0, 2.0, 4.0)), Timed(0.0, (3.0, 6.0, 12.0))
    ratio = theirs.ratio_to(ours)
    assert (ratio.low, ratio.median, ratio.high) == (3.0, 3.0, 3.0)


def test_rows_hold_errors_digits_and_what_failed() -> None:
    result = _measured()
    ours, slow, third, bad = result.cases[0].rows
    assert (ours.error, ours.ratio) == (0.5, None)
    assert (slow.error, slow.digits) == (0.0, 16.0)
    assert third.digits == pytest.approx(3.0)
    assert slow.ratio is not None
    assert bad.failed == "ValueError: it breaks"
    assert bad.median_ms is None
    assert result.missing == ("a data set: NAME says where it is",)


@pytest.mark.skipif(sys.platform != "linux", reason="peaks are read from Linux's /proc")
def test_peak_memory_is_that_of_the_call() -> None:
    for _ in range(3):  # freed memory, that the process keeps for the next call
        np.ones(4_000_000).sum()
    peak = peak_mb(lambda: np.ones(4_000_000).sum())
    assert peak == pytest.approx(4_000_000 * 8 / 2**20, rel=0.2)


def test_the_first_way_must_be_ours_and_names_differ() -> None:
    with pytest.raises(AssertionError, match="ours"):
        _case(1, _way("peer", "fast"))
    with pytest.raises(AssertionError, match="one name"):
        _case(1, _way("emg2vsa", "fast"), _way("emg2vsa", "fast"))


def test_digits_of_errors() -> None:
    assert [digits_of(e) for e in (1e-3, 0.0, 5.0, float("nan"))] == [pytest.approx(3.0), 16.0, 0.0, 0.0]


def test_a_part_that_an_older_revision_lacks_is_said_and_else_raised() -> None:
    area = Area("demo", "?", (_older,), {}, "")
    with pytest.raises(ImportError):
        measure(area, Size.SMOKE, rounds=0)
    assert "no_such_function" in measure(area, Size.SMOKE, rounds=0, older=True).missing[0]


def test_exponents_have_their_standard_errors() -> None:
    assert exponent([(1, 3.0), (10, 300.0), (100, 30_000.0)]) == pytest.approx((2.0, 0.0), abs=1e-12)
    slope, se = exponent([(1, 1.0), (np.e, np.e), (np.e**2, np.e**2 * np.exp(0.3))])
    assert slope == pytest.approx(1.15)
    assert se == pytest.approx(0.3 / np.sqrt(12))
    assert {way.label for way in growths(_measured().cases)} == {"emg2vsa: fast", "peer: slow", "peer: third"}


def test_the_front_is_of_ways_that_none_beats() -> None:
    assert front_of([1, 2, 3, 4], [1.0, 0.5, 0.7, 0.5]) == [0, 1]


def test_page_names_what_was_not_measured_and_plots_are_svg(tmp_path: Path) -> None:
    result = _measured()
    written = write_plots(result, tmp_path)
    text = page(result, written)
    for expected in (
        "Is it right?",
        "| 2 | peer | slow | equal |",
        "ValueError: it breaks",
        "not measured: a data set",
    ):
        assert expected in text
    for name in (name for names in written.values() for name in names):
        assert f"({name})" in text
        assert 'width="450pt"' in (tmp_path / name).read_text()[:600]
    assert "exponent" in (tmp_path / written["sums"][0]).read_text()


def test_an_area_is_written_and_listed(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(run, "NAMES", ("demo",))
    monkeypatch.setattr(plots, "write_plots", lambda result, folder: {})
    (tmp_path / "demo-old.svg").write_text("of another case")
    run.write_area(_measured(), tmp_path)
    assert "[demo](demo.md)" in (tmp_path / "README.md").read_text()
    assert json.loads((tmp_path / "demo.json").read_text())["name"] == "demo"
    assert not (tmp_path / "demo-old.svg").exists()


def test_a_run_in_a_child_writes_and_prints(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    words = ["tools", "bench", "calibration", "--smoke", "--repeats", "1", "--only", "intervals"]
    assert main([*words, "--out", str(tmp_path), "--json", str(tmp_path / "all.json")]) == 0
    assert "points of coverage off 95 %" in capsys.readouterr().out
    (area,) = json.loads((tmp_path / "all.json").read_text())
    assert [case["name"] for case in area["cases"]] == ["intervals of kappa, 20 calibrations"]
    assert (tmp_path / "calibration.md").exists()


@pytest.mark.parametrize(
    ("words", "complaint"),
    [
        (["condtioning"], "Did you mean conditioning?"),
        (["--smoke", "weather"], "Choose one of these."),
        (["--compare", "no-such-revision", "records"], "a revision of this checkout"),
        (["--compare", "--repeats"], "expected one argument"),
        (["--repeats", "0"], "a whole number from 1"),
    ],
)
def test_bad_words_are_one_clear_error(words: list[str], complaint: str, capsys: pytest.CaptureFixture[str]) -> None:
    try:
        status = main(["tools", "bench", *words])
    except SystemExit as end:
        status = int(end.code or 0)
    assert status == 2
    said = capsys.readouterr().err
    assert complaint in said
    assert "Traceback" not in said


@pytest.mark.parametrize("option", ["--out", "--json"])
def test_a_place_that_cannot_be_written_is_said_before_anything_runs(
    option: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "file").touch()
    place = tmp_path / "file" / "x"
    assert main(["tools", "bench", "records", "--smoke", option, str(place)]) == 2
    said = capsys.readouterr().err
    assert said.count("\n") == 1
    assert f"emg2vsa: {option} {place if option == '--out' else place.parent}: expected a folder to write to" in said


def test_a_word_that_nothing_holds_is_said(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(run, "measured_in_child", lambda name, options: measure(AREA, Size.SMOKE, rounds=0, only="zz"))
    with pytest.raises(SettingError, match="--only: expected a word"):
        run.bench(["records"], only="zz")


def test_without_a_checkout_it_says_where_the_benchmarks_are(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(source_checkout, "SOURCE", tmp_path)
    assert main(["tools", "bench"]) == 2
    complaint = capsys.readouterr().err
    assert complaint.count("\n") == 1
    assert "benchmarks/ beside" in complaint
    assert "Get the sources of emg2vsa" in complaint


def test_stress_takes_no_options_of_areas(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["tools", "bench", "stress", "--only", "filters"]) == 2
    assert "bench stress, --only: expected no such option" in capsys.readouterr().err


def test_areas_are_listed(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["tools", "bench", "--list"]) == 0
    assert "conditioning" in capsys.readouterr().out


def test_the_folder_of_another_revision_is_removed_also_after_ctrl_c(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    if not (compare.SOURCE / ".git").exists():
        pytest.skip("this checkout has no git history to take a revision from")
    monkeypatch.setattr(tempfile, "tempdir", str(tmp_path))

    def stopped() -> None:
        with compare.product_of("HEAD") as folder:
            assert (folder / "emg2vsa" / "__init__.py").exists()
            assert not (folder / "benchmarks").exists()
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        stopped()
    assert list(tmp_path.iterdir()) == []


def test_revisions_take_turns_and_their_ratio_is_within_pairs(monkeypatch: pytest.MonkeyPatch) -> None:
    asked = []

    def child(name: str, options: dict[str, object], product: Path | None) -> AreaResult:
        asked.append("A" if product else "B")
        area = Area("demo", "?", (_two_sizes,), {}, "")
        return measure(area, Size.SMOKE, rounds=1, ours_alone=True, only="10" if product else "")

    monkeypatch.setattr(compare, "measured_in_child", child)
    found = compare.compare("demo", {}, Path("old"), 2)
    assert asked == ["A", "B", "B", "A"]
    assert [one.case for one in found] == ["sum of 10", "sum of 100"]
    assert all(one.ratio is not None and one.label == "emg2vsa: fast" for one in found)
    one = compare.Compared("case", "way", None, found[0].new, None)
    assert "not in v1" in compare.lines("v1", [one])[2]

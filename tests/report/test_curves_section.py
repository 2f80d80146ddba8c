"""The section on the whole curve: its numbers are those of the tests, its words name what differs."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from emg2vsa.companions.whole_curve import CellCurve, WholeCurve, compare_curves
from emg2vsa.figures.canvas import style, svg_text
from emg2vsa.figures.palette import ActivityScale, looks
from emg2vsa.figures.whole_curve import draw_whole_curve
from emg2vsa.report.section import rendered
from emg2vsa.report.sections.curves import CURVES
from emg2vsa.report.study_report import contents

EDGES_N = np.linspace(0.5, 6.5, 13)
NAMES = ("S1", "S2", "S3", "S5", "S6", "S7", "S8")


def curves(people: int, specimens: int = 4, alpha: float = 0.05, noise: float = 1.0) -> WholeCurve:
    """The first specimen differs from 2.5 N on, the others do not."""
    rng = np.random.default_rng(3)
    v = 20 + noise * rng.standard_normal((people, specimens, 12))
    v[:, 0, 4:] += 30 * noise
    names = np.ndindex(people, specimens)
    return compare_curves([CellCurve(f"P{p}", NAMES[s], 1e-6 * v[p, s], EDGES_N) for p, s in names], alpha)


def with_curves(results, found: WholeCurve):
    hypotheses = replace(results.people.hypotheses, curves=found)
    return replace(results, people=replace(results.people, hypotheses=hypotheses))


def test_every_number_is_that_of_the_tests(results) -> None:
    found = curves(9)
    content = contents(with_curves(results, found))
    q, tests = content.quantities, found.tests
    assert (q["curves.people"], q["curves.forces"], q["curves.from_n"], q["curves.to_n"]) == (9, 12, 0.5, 6.5)
    assert q["curves.all.threshold"] == tests.f_threshold.value
    assert q["curves.pairs.threshold.low"] == tests.t_threshold.low
    assert q["curves.all.largest_f"] == tests.f.max()
    assert q["curves.pairs.S2-S5.largest_t"] == np.abs(tests.pair_t[4]).max()
    assert q["curves.pairs.S2-S5.p"] == tests.pair_p[4].min()
    assert q["curves.pairs.S1-S2.differ_percent"] == pytest.approx(100 * 4 / 6)
    assert q["curves.pairs.S2-S3.differ_percent"] == 0
    ranges = content.tables["whole_curve"].rows
    assert [row["of"] for row in ranges] == ["all specimens", "S1–S2", "S1–S3", "S1–S5"]
    assert all((row["from_n"], row["to_n"]) == (2.5, 6.5) for row in ranges)
    assert len(content.tables["curves_by_force"].rows) == 12 * (1 + 6 + 4)
    assert next(content.tables["curves_by_force"].csv()).startswith("of,from_n,to_n,statistic,p,value_v,low_v,high_v\n")


def test_the_page_shows_the_picture_at_once_and_names_neighbours(results) -> None:
    study = with_curves(results, curves(9))
    content = contents(study)
    text = rendered(CURVES, study, content)
    assert text.index("<svg") < text.index("<details")
    assert "S1–S2 at 67" in text
    assert "9 people at 12 forces" in text
    assert "S1–S2 at 67" in content.drawings["curves"].description
    assert len(content.drawings["curves"].caption.split()) <= 35
    assert "simultaneous bands" in content.drawings["curves"].caption
    assert "bands need 4 people" in contents(with_curves(results, curves(3))).drawings["curves"].caption


def test_a_study_whose_curves_cannot_be_compared_says_why(results) -> None:
    for people, why in (
        (2, "3 people with curves of every specimen, and found 2"),
        (0, "2 specimens with curves of half of the people or more, and found 0"),
    ):
        study = with_curves(results, curves(people))
        content = contents(study)
        assert why in rendered(CURVES, study, content)
        assert not {"whole_curve", "curves_by_force"} & content.tables.keys()
        assert "curves" not in content.drawings
    nothing = replace(results, people=replace(results.people, hypotheses=None))
    assert "no hypotheses" in rendered(CURVES, nothing, contents(nothing))


@pytest.mark.parametrize(
    "found", [curves(3), curves(9, noise=0.0), curves(9, alpha=1e-5), curves(9, specimens=7)],
    ids=["three people", "no scatter", "alpha out of reach", "many specimens"],
)  # fmt: skip
def test_it_is_drawn_whatever_was_found(found: WholeCurve) -> None:
    names = found.specimens.tolist()
    with style():
        figure = draw_whole_curve(found, range(len(found.pairs)), [0], looks(names), ActivityScale("µV", 1e6))
        assert "nan" not in svg_text(figure).lower().replace("nand", "")
    trends, statistic, pairs = figure.axes
    assert [line.get_label() for line in trends.lines] == names
    assert len(pairs.get_yticks()) == len(found.pairs)
    assert statistic.get_yscale() == ("log" if np.isfinite(found.tests.f).any() else "linear")

"""The section on choices: what it shows of the paths, and how to ask for them where there are none."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from emg2vsa.multiverse import IndexPresets, Paths
from emg2vsa.report.section import Content, rendered
from emg2vsa.report.sections.robustness import ROBUSTNESS, paths_share, told_of_paths

PERCENT = np.array([[[20.0, 80.0], [20.0, 40.0]], [[20.0, 30.0], [30.0, 60.0]], [[np.nan] * 2] * 2])
PRESETS = IndexPresets("P01", ("sum", "minimum", "falconer-winter"), ("S1", "S5"), PERCENT, (20.0, 80.0))
NUMBERS = np.array([[1.0, 2.0, 3.0, 4.0], [np.nan] * 4])
PATHS = Paths(
    claims=("one", "two"),
    says=("specimens differ", "people do not"),
    own=np.array(["holds", "not determined"]),
    kind=np.array(["index", "index", "force bins", "several at once"]),
    name=np.array(["index minimum", "index rudolph", "samples", "index minimum, samples"]),
    verdict=np.array([["holds", "refuted", "holds", "not determined"], ["", "", "not determined", ""]]),
    estimate=NUMBERS, low=NUMBERS - 1, high=NUMBERS + 1, presets=PRESETS,
)  # fmt: skip


@pytest.fixture
def shown(results):
    """The whole study with paths, its content and the text of the section."""

    def of(**more):
        whole = replace(results, **more)
        content = Content(dict(ROBUSTNESS.quantities(whole)))
        content.tables = {table.name: table for table in ROBUSTNESS.tables(whole, content.quantities)}
        return whole, content, " ".join(rendered(ROBUSTNESS, whole, content).split())

    return of


def test_shares_and_the_choice_that_overturns_a_verdict_are_said(shown):
    whole, content, text = shown(paths=PATHS, presets=PRESETS)
    assert paths_share(whole) == {"one": (2, 4), "two": (1, 1)}
    q = content.quantities
    assert (q["paths.count"], q["paths.one.kept"], q["paths.one.applicable"], q["paths.one.share"]) == (4, 2, 4, 0.5)
    assert (q["paths.one.overturned_by"], q["paths.two.overturned_by"]) == ("index", "")
    assert "The fewest paths keep the verdict on “specimens differ”: 50" in text
    assert "Of single choices, “index” changes that verdict most often: index rudolph." in text
    assert "--paths" not in text
    assert len(content.tables["paths"].rows) == 6  # all paths and three kinds of one claim, two of the other
    assert len(content.tables["paths_all"].rows) == 5
    assert "".join(content.tables["paths_all"].csv()).splitlines()[1] == "one,index,index minimum,holds,1.0,0.0,2.0"
    (drawing,) = ROBUSTNESS.drawings(whole)
    assert "specimens differ: holds, kept by 50.0 % of paths." in drawing.description
    assert "people do not" not in drawing.description  # no path has an estimate
    assert len(drawing.caption.split()) <= 35
    assert told_of_paths(whole, "one") == "2 of 4 other paths of analysis keep this verdict."
    assert told_of_paths(whole, "two") == "None of 1 other paths of analysis gives an estimate."
    assert told_of_paths(whole, "three") == ""


def test_places_are_whole_numbers_and_presets_that_stay_are_not_said_to_move(shown):
    alike = np.array([PERCENT[0], PERCENT[0] + 1e-12])
    _, content, text = shown(presets=IndexPresets("P01", ("sum", "minimum"), ("S1", "S5"), alike, (20.0, 80.0)))
    rows = content.tables["index_presets"].rows
    assert [(type(row["place"]), row["place"], row["turned"]) for row in rows] == [(int, 1, False), (int, 2, False)]
    assert "moves a stiffness preset" not in text
    assert "index_presets" in text


def test_without_paths_the_page_says_how_to_ask_and_shows_presets_by_index(shown):
    whole, content, text = shown(presets=PRESETS)
    assert "<code>emg2vsa run study.toml --paths</code> judges every claim again" in text
    assert "moves a stiffness preset by up to 50 points of 60 (S1, minimum)" in text.replace("\u202f", " ")
    assert "By minimum the specimens change their order." in text
    assert list(content.tables) == ["index_presets"]
    assert list(ROBUSTNESS.drawings(whole)) == []
    assert paths_share(whole) == {}
    q = content.quantities
    assert q["index.minimum.S1.largest_move_points"] == 50
    assert q["index.minimum.S5.turned"] is True
    assert q["index.falconer-winter.S1.turned"] is False  # an index without a schedule turns nothing
    assert np.isnan(q["index.falconer-winter.S1.largest_move_points"])


def test_without_presets_only_the_way_to_ask_is_left(shown):
    _, content, text = shown()
    assert content.tables == {}
    assert "--paths" in text
    assert "preset" not in text


def test_a_study_without_claims_on_data_has_no_picture_of_paths(shown):
    empty = np.empty((0, 0))
    texts = dict.fromkeys(("own", "kind", "name"), np.array([], dtype=np.str_))
    numbers = dict.fromkeys(("estimate", "low", "high"), empty)
    nothing = replace(PATHS, claims=(), says=(), verdict=empty.astype(np.str_), **texts, **numbers)
    whole, content, text = shown(paths=nothing)
    assert list(ROBUSTNESS.drawings(whole)) == []
    assert "fewest paths" not in text
    assert content.quantities["paths.count"] == 0

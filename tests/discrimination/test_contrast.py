"""Contrasts over mountings: known answers, coverage, order of the tests, and words that are true."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy import stats

from emg2vsa.discrimination import discriminate
from emg2vsa.discrimination.contrast import _in_order, contrasts
from emg2vsa.discrimination.contrast_words import contrast_words, headline
from emg2vsa.discrimination.run_table import run_table
from emg2vsa.settings import DiscriminationSettings

FEW = DiscriminationSettings()
SPECIMENS = ("S1", "S_new", "S3", "S5")
TRUE_LN = {"S1": 2.0, "S_new": 2.07, "S3": 2.19, "S5": 2.553}


@pytest.fixture
def world(run_of):
    """Runs with given ln CASR: mountings and presses of a cell, scatter of both, and what a condition adds."""

    one = run_of("S1", 0.0, "modular", presses=1)

    def runs(mountings, presses, mounting_sd, press_sd, seed=0, adds=None, frame_sum=None):
        rng = np.random.default_rng(seed)
        made = []
        for condition in ("high-stiffness", "modular", "constant-mean"):
            for specimen in SPECIMENS:
                own = TRUE_LN[specimen] + (adds or {}).get((condition, specimen), 0.0)
                noise = np.repeat(mounting_sd * rng.standard_normal(mountings), presses)
                casr = np.exp(own + noise + press_sd * rng.standard_normal(noise.size))
                summed = np.exp(own + (frame_sum or {}).get((condition, specimen), 0.0) + noise)
                numbers = np.repeat(np.arange(1, mountings + 1), presses)
                made.append(of_presses(one, specimen, condition, numbers, {"front": casr, "paper": summed}))
        return made

    return runs


def of_presses(run, specimen, condition, mounting, casr):
    """A run with as many presses as ``mounting`` has numbers."""
    n = mounting.size
    each = {name: np.resize(getattr(run, name), n) for name in ("repetitions", "true_a_c0", "indent_n_per_mm")}
    areas = {name: {key: np.resize(run.a_c0["front"], n) for key in casr} for name in ("a_c0", "start_area")}
    began = np.random.default_rng([*f"{specimen}{condition}".encode()]).random(int(mounting.max()))[mounting - 1]
    return replace(
        run, pressed_at=began, specimen=specimen, condition=condition, mounting=mounting, casr=casr,
        verdicts=("ok",) * n, reasons=("",) * n, curves=run.curves * n, **each, **areas,
    )  # fmt: skip


def measured(runs, stiffness_n_per_mm, sd=0.025):
    """Pressed at one place, so that nothing is drift."""
    table = run_table(runs, stiffness_n_per_mm, "S_new")
    return contrasts(replace(table, position=np.ones(table.mounting.shape)), 0.05, sd)


def test_estimate_interval_and_p_are_those_of_the_mountings_means(world, stiffness_n_per_mm):
    runs = world(3, 4, 0.02, 0.03)
    slope, frame_sum = measured(runs, stiffness_n_per_mm)
    assert (slope.algorithm, frame_sum.algorithm) == ("front", "paper")
    assert slope.pairs == (("S5", "S1"), ("S_new", "S1"))
    i = headline(slope, ("high-stiffness", "modular", "constant-mean"))
    by_name = {(run.condition, run.specimen): np.log(run.casr["front"]).reshape(3, 4).mean(axis=1) for run in runs}
    cells = [by_name[c, s] for c in ("modular", "high-stiffness") for s in ("S5", "S1")]
    estimate = cells[0].mean() - cells[1].mean() - cells[2].mean() + cells[3].mean()
    pool = [by_name[c, s] for c in ("modular", "high-stiffness") for s in SPECIMENS]
    error = np.sqrt(max(np.mean([cell.var(ddof=1) for cell in each]) for each in (cells, pool)) * 4 / 3)
    assert slope.changes.estimate[i] == pytest.approx(estimate)
    assert slope.changes.df[i] == 16
    assert slope.changes.p[i] == pytest.approx(2 * stats.t.sf(abs(estimate) / error, 16))
    assert slope.changes.high[i] - estimate == pytest.approx(stats.t.ppf(0.975, 16) * error)
    assert slope.mountings.tolist() == [3, 3, 3]


@pytest.mark.parametrize("tries", [60, pytest.param(200, marks=pytest.mark.slow)])
def test_presses_of_one_mounting_are_no_replicates(tries, world, stiffness_n_per_mm):
    """Sixty presses that tell nothing of mountings: in a world without an effect as few as alpha are found."""
    found = 0
    for seed in range(tries):
        (slope, _) = measured(world(3, 20, 0.03, 0.01, seed), stiffness_n_per_mm)
        found += any(verdict in ("raises", "lowers") for verdict in slope.verdicts)
    assert found <= stats.binom.ppf(0.999, tries, 0.05)


@pytest.mark.parametrize(("tries", "least"), [(100, 91), pytest.param(400, 370, marks=pytest.mark.slow)])
def test_an_effect_is_found_and_the_interval_holds_it(tries, least, world, stiffness_n_per_mm):
    """If 88 % were covered instead of 95 %, 90 of 100 or fewer would be in 77 % of samples, 369 of 400 in 99.6 %."""
    adds, held, found = {("modular", "S5"): 0.15}, 0, []
    for seed in range(tries):
        (slope, _) = measured(world(3, 3, 0.025, 0.03, seed, adds), stiffness_n_per_mm)
        held += bool(slope.changes.low[0] < 0.15 < slope.changes.high[0])
        found.append(slope.verdicts[0])
    assert held >= least
    assert found.count("raises") >= 0.85 * tries
    assert (
        measured(world(3, 3, 0.01, 0.01, 0, {("modular", "S5"): -0.2}), stiffness_n_per_mm)[0].verdicts[0] == "lowers"
    )


def test_nothing_is_claimed_behind_a_first_test_that_found_nothing(world, stiffness_n_per_mm):
    (slope, _) = measured(world(3, 3, 0.01, 0.01, 1, {("constant-mean", "S5"): 0.5}), stiffness_n_per_mm)
    found = discriminate(world(3, 3, 0.01, 0.01, 1), stiffness_n_per_mm, "S_new", FEW).table
    first = headline(slope, found.conditions)
    assert slope.changes.p.min() < 1e-6
    assert slope.p_adjusted == pytest.approx(np.maximum(slope.p_adjusted, slope.changes.p[first]))
    assert set(slope.verdicts) == {"not shown"}


def test_one_mounting_tells_nothing_unless_mountings_are_said_to_be_alike(world, stiffness_n_per_mm):
    runs = world(1, 10, 0.0, 0.01, 0, {("modular", "S5"): 0.3})
    (slope, _) = measured(runs, stiffness_n_per_mm, 0.025)
    assert set(slope.verdicts) == {"cannot be told"}
    width = slope.changes.high[0] - slope.changes.low[0]
    assert width == pytest.approx(2 * 1.96 * np.sqrt(4 * (0.025**2 + 0.01**2 / 10)), rel=0.05)
    (alike, _) = measured(runs, stiffness_n_per_mm, 0.0)
    assert alike.verdicts[0] == "raises"
    assert alike.changes.df[0] == 72


def test_words_say_what_is_true(world, stiffness_n_per_mm):
    def said(runs, **more):
        found = discriminate(runs, stiffness_n_per_mm, "S_new", FEW, mounting_sd=0.025, **more)
        return " ".join(contrast_words(found))

    none = said(world(3, 3, 0.01, 0.01))
    assert "No change of the contrast S5 : S1 of CASR by slope by human-like stiffness" in none
    assert "3 mountings of each specimen" in none
    assert "label" not in none

    lost = world(3, 3, 0.01, 0.01)
    gone = next(i for i, run in enumerate(lost) if run.name == "S5_0_modular")
    lost[gone] = replace(lost[gone], verdicts=("rejected",) * 9)
    lost = [run for run in lost if run.specimen in ("S1", "S5")]
    assert "cannot be told, as presses with a score are missing." in said(lost)
    assert "nan" not in said(lost)

    unknown = [replace(run, pressed_at=np.nan * run.pressed_at) for run in world(3, 3, 0.01, 0.01)]
    assert "cannot be told, as nobody knows the order of mountings. It is" in said(unknown)

    once = said(world(1, 3, 0.01, 0.01))
    assert "cannot be told, as specimens were mounted once" in once
    assert "2.5 % (SD, assumed)" in once

    effect = said(world(3, 3, 0.005, 0.005, 0, {("modular", "S5"): 0.11}))
    assert "Human-like stiffness raises the contrast S5 : S1 of CASR by slope against the rigid motor: +1" in effect
    assert "carries the label of its specimen" in effect

    swapped = {"S1": "S5", "S5": "S1", "S_new": "S3", "S3": "S_new"}
    leak = world(3, 3, 0.005, 0.005, 0, frame_sum={("modular", "S_new"): -0.2})
    words = said(leak, schedule_of=swapped)
    assert "CASR by slope keeps the order of S1 and S5" in words
    assert "it keeps the order of S1 and S_new" in words
    assert "reverses S1 and S_new" in words
    same = said(leak, schedule_of={"S1": "S3", "S5": "S3", "S_new": "S3"})
    assert "no schedule tells the specimens apart" in same


@pytest.mark.parametrize("schedule_of", [{"S1": "S1"}, {"S3": "S_new"}, {"S1": "S_new"}])
def test_schedules_that_do_not_swap_the_pair_leave_the_warning_on_the_label(world, stiffness_n_per_mm, schedule_of):
    runs = world(3, 3, 0.005, 0.005, 0, {("modular", "S5"): 0.11})
    found = discriminate(runs, stiffness_n_per_mm, "S_new", FEW, mounting_sd=0.025, schedule_of=schedule_of)
    words = " ".join(contrast_words(found))
    assert "carries the label of its specimen" in words
    assert "keeps the order" not in words
    assert ("schedules of others" in words) == (schedule_of != {"S1": "S1"})


def test_swapped_schedules_need_no_warning(world, stiffness_n_per_mm):
    runs = world(3, 3, 0.005, 0.005, 0, {("modular", "S5"): 0.11})
    swapped = {"S1": "S5", "S5": "S1", "S_new": "S3", "S3": "S_new"}
    found = discriminate(runs, stiffness_n_per_mm, "S_new", FEW, mounting_sd=0.025, schedule_of=swapped)
    words = " ".join(contrast_words(found))
    assert "raises" in words
    assert "label" not in words


def test_runs_of_one_condition_say_nothing(run_of, stiffness_n_per_mm):
    found = discriminate([run_of(name, 0.0, "modular") for name in SPECIMENS], stiffness_n_per_mm, "S_new", FEW)
    assert contrast_words(found) == []


@pytest.mark.parametrize("at_the_smallest_angle", [("modular", "high-stiffness"), ("modular",)])
def test_gaps_are_listed_where_there_are_two_to_compare(run_of, stiffness_n_per_mm, at_the_smallest_angle):
    designs = [(condition, 0.0) for condition in at_the_smallest_angle]
    designs += [("modular", 30.0), ("high-stiffness", 30.0)]
    runs = [run_of(name, angle, condition) for condition, angle in designs for name in SPECIMENS]
    found = discriminate(runs, stiffness_n_per_mm, "S_new", FEW, mounting_sd=0.025)
    words = contrast_words(found)
    assert "Whether human-like stiffness raises" in words[0]
    at = [c for c, angle in zip(found.table.conditions, found.table.angles_deg, strict=True) if angle == 0]
    gaps = found.conditions.gaps
    ends = zip(gaps.gap, gaps.low, gaps.high, found.table.angles_deg, strict=True)
    known = [f"{gap:.1f} [{low:.1f}, {high:.1f}]" for gap, low, high, angle in ends if angle == 0]
    told = ", ".join(f"{name} {each}" for name, each in zip(at, known, strict=True))
    assert (f", in SDs of a press, by condition: {told}." in words[-1]) == (len(at) > 1)
    assert ("by condition" in words[-1]) == (len(at) > 1)


def test_a_step_without_a_p_ends_the_sequence():
    steps = [0, 1, 2, 2]
    assert np.isnan(_in_order(np.array([np.nan, 0.001, 0.001, 0.001]), steps, 0.05)).all()
    later = _in_order(np.array([0.01, np.nan, 0.001, 0.001]), steps, 0.05)
    assert later[0] == 0.01
    assert np.isnan(later[1:]).all()

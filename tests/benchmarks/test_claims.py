"""The benchmark of claims: what is true in a world is known, a false verdict counts as false, and a run goes on."""

from __future__ import annotations

import dataclasses
import json

import numpy as np
import pytest

from benchmarks.bench.record import RESULTS
from benchmarks.claims.__main__ import chunk, code_of, found, lines, main
from benchmarks.claims.laws import laws_of
from benchmarks.claims.people import drawn, fits_of, serially
from benchmarks.claims.rig import even, table_of, true_casr
from benchmarks.claims.verdicts import Rate, Truth, any_false, false_rates, powers, upper
from benchmarks.claims.worlds import DESIGNS, KAPPA, PRESSED, WORLDS, People, Rig, on_compliance
from emg2vsa.claims import calibrated
from emg2vsa.claims.claim import OF_A_STUDY
from emg2vsa.companions.force_laws import force_laws

NAMED = {world.name: world for world in WORLDS}


def test_there_are_enough_worlds_of_their_own_name():
    assert len(NAMED) == len(WORLDS)
    assert sum(world.effect for world in WORLDS) >= 8
    assert sum(not world.effect for world in WORLDS) >= 12


def test_a_few_studies_are_run_once_and_make_the_page(tmp_path, capsys):
    runs, words = tmp_path / "runs.jsonl", ["--worlds", "alike", "paper", "--studies", "5", "--chunk", "3"]
    assert main([str(runs), *words]) == 0
    made = runs.read_text()
    assert main([str(runs), *words]) == 0
    assert runs.read_text() == made  # nothing is run twice
    runs.write_text(made + made.splitlines()[-1][:40])
    assert list(lines(runs)) == [json.loads(line) for line in made.splitlines()]  # a line that was cut is left out
    verdicts, truths = found(runs)
    assert set(verdicts) == set(truths) == {"alike", "paper"}
    assert {len(letters) for own in verdicts.values() for letters in own.values()} == {6}
    capsys.readouterr()
    assert main([str(runs), "--table"]) == 0
    page = capsys.readouterr().out
    assert all(f"| {key} |" in page for key in verdicts["alike"])


def test_the_same_seed_gives_the_same_studies():
    one, other = (chunk(NAMED["half"], 7, 2)["verdicts"] for _ in range(2))
    assert one == other


def test_a_study_of_people_and_rig_has_as_many_claims_as_share_the_chance_of_a_false_verdict():
    of_plates = 1  # these worlds have none
    assert len(chunk(NAMED["paper"], 0, 1)["verdicts"]) == OF_A_STUDY - of_plates


def test_lines_of_another_world_or_code_do_not_count(tmp_path):
    world = NAMED["alike"]
    assert code_of(world) != code_of(dataclasses.replace(world, people=People(people=13)))
    runs = tmp_path / "runs.jsonl"
    runs.write_text(json.dumps({"code": "old", "world": "alike", "first": 0, "verdicts": {"x": "h"}}) + "\n")
    assert found(runs) == ({}, {})


@pytest.mark.parametrize(
    ("truth", "false", "right"),
    [
        (Truth(0.0, 1.0, "more"), "h", "r"),
        (Truth(1.5, 1.0, "more"), "r", "h"),
        (Truth(0.6, 1.0, "more"), "", "h"),  # there, and less than what matters: neither is false
        (Truth(0.5, 1.0, "within"), "r", "h"),
        (Truth(1.5, 1.0, "within"), "h", "r"),
        (Truth(np.nan, 1.0, "more"), "", ""),
    ],
)
def test_what_a_world_contradicts_is_false(truth, false, right):
    assert "".join(letter for letter in "hrn" if truth.wrong(letter)) == false
    assert truth.right == right


def test_rates_count_studies():
    truths = {"a": Truth(0.0, 1.0, "more"), "b": Truth(0.5, 1.0, "within")}
    verdicts = {"a": "hhnr", "b": "hrnh"}
    assert false_rates(verdicts, truths) == {"a": Rate(2, 4), "b": Rate(1, 4)}
    assert any_false(verdicts, truths) == Rate(2, 4)
    assert powers(verdicts, truths) == {"a": Rate(1, 4), "b": Rate(2, 4)}


def test_the_bound_of_a_rate_is_that_of_clopper_and_pearson():
    assert upper(0, 50) == pytest.approx(1 - 0.05 ** (1 / 50))
    assert upper(50, 50) == 1.0


def test_on_the_compliance_curve_the_law_holds_exactly():
    logs = np.array(on_compliance(0.4))
    assert logs[-1] == pytest.approx(0.4)
    slopes = np.diff(1 / KAPPA) / np.diff(np.exp(1.5 * logs))
    assert slopes == pytest.approx(np.full(3, slopes[0]))


def test_a_new_specimen_that_is_off_has_the_casr_of_another_stiffness():
    world = Rig(new_off={"front": (0.1, 0.2, -0.2)})
    logs, new = true_casr(world, "front"), PRESSED.index("S_new")
    for d, (_, angle) in enumerate(DESIGNS):
        x, y = np.exp(1.5 * logs[d]), 1 / KAPPA
        known = [i for i in range(4) if i != new]
        fitted = np.polyval(np.polyfit(x[known], y[known], 1), x[new])
        assert 1 / fitted / KAPPA[new] - 1 == pytest.approx({0.0: 0.1, 30.0: 0.2, 45.0: -0.2}[angle])


@pytest.mark.parametrize("law", ["normal", "t3", "lognormal"])
def test_draws_have_mean_0_and_sd_1_by_every_law_and_even_ones_exactly(law):
    values = drawn(np.random.default_rng(1), law, (200_000,))
    assert values.mean() == pytest.approx(0, abs=0.02)
    assert values.std() == pytest.approx(1, abs=0.1)
    spread = even(np.random.default_rng(1), law, (2, 9))
    assert spread.mean(axis=1) == pytest.approx(np.zeros(2), abs=1e-12)
    assert spread.std(axis=1, ddof=1) == pytest.approx(np.ones(2))


def test_serial_presses_are_correlated_and_scatter_the_same():
    values = serially(np.random.default_rng(1).standard_normal((4000, 8)), 0.7)
    assert values.std(axis=0) == pytest.approx(np.ones(8), abs=0.05)
    assert np.corrcoef(values[:, 3], values[:, 4])[0, 1] == pytest.approx(0.7, abs=0.03)


def test_a_table_scatters_as_its_world_says_and_every_mounting_has_a_place():
    world = Rig(mountings=40, presses=20, press=0.02, mounting=0.05, own_scatter=False)
    table = table_of(world, np.random.default_rng(2))
    logs = np.log(table.casr["front"]).reshape(len(DESIGNS), 4, 40, 20)
    assert logs.std(axis=3, ddof=1).mean() == pytest.approx(0.02, rel=0.03)
    assert logs.mean(axis=3).std(axis=2, ddof=1).mean() == pytest.approx(0.05, rel=0.05)
    assert table.position is not None
    assert np.array_equal(np.unique(table.position), np.arange(1, 9 * 4 * 40 + 1))


def test_fits_of_people_have_their_slopes():
    fits, place = fits_of(People(people=60, person=0.2), np.random.default_rng(3))
    for specimen, b in zip(("S1", "S5"), (20e-6, 7e-6), strict=True):
        own = fits.b_v[fits.specimen == specimen].reshape(60, 10)
        assert own.mean() == pytest.approx(b, rel=0.1)
        assert own.std(axis=1, ddof=1).mean() / own.mean() == pytest.approx(0.08, rel=0.15)  # as in the demo
    assert np.array_equal(np.sort(place, axis=1), np.tile(np.arange(5.0), (60, 1)))


@pytest.mark.parametrize("power_law", [False, True])
def test_errors_of_laws_are_those_of_fits_without_each_bin(power_law):
    fits, _ = fits_of(People(people=2, power_law=power_law), np.random.default_rng(4))
    exact = force_laws(fits, "ok").error[1]
    found = laws_of(fits, 10).error[1]
    assert found[[0, 2]] == pytest.approx(exact[[0, 2]], rel=1e-10)
    assert found[1] == pytest.approx(exact[1], rel=5e-3)


def test_every_claim_on_data_has_its_rates():
    assert set(calibrated.CLAIMS) == set(chunk(NAMED["alike"], 0, 1)["verdicts"])


def test_what_the_report_shows_is_what_the_benchmark_found():
    record = json.loads((RESULTS / "claims.json").read_text())
    tables = [block for block in record["blocks"] if isinstance(block, dict)]
    rows = {row[0]: row[1:3] for table in tables for row in table["rows"] if table["head"][0] == "claim"}
    shown = {key: [f"{100 * each.false:.1f}", f"{100 * each.bound:.1f}"] for key, each in calibrated.CLAIMS.items()}
    assert shown == rows

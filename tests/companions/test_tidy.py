"""All tests on a tidy table: exact digits, nothing that depends on the order of rows, and rows left out are counted."""

from __future__ import annotations

import json
from collections.abc import Callable
from decimal import Decimal
from pathlib import Path

import numpy as np
import pytest
from scipy import stats

from emg2vsa.cli import main
from emg2vsa.companions.tidy import TidyTests, tidy_tests
from emg2vsa.errors import DataError
from emg2vsa.report.tidy_text import hypotheses, outcomes, text
from emg2vsa.statistics.mixed import MixedModel

SETS = ("SiRstv", "SmLs01", "SmLs02", "SmLs03", "AtmWtAg", "SmLs04", "SmLs05", "SmLs07", "SmLs08")


def table(
    participants: int = 5, specimens: int = 3, repetitions: int = 6, seed: int = 0
) -> tuple[list[Decimal | None], list[str], list[str]]:
    rng = np.random.default_rng(seed)
    values = rng.normal(np.arange(specimens)[None, :, None], 1.0, (participants, specimens, repetitions))
    block, group, _ = (index.ravel() for index in np.indices(values.shape))
    numbers: list[Decimal | None] = [Decimal(repr(float(v))) for v in values.ravel()]
    return numbers, [f"S{j + 1}" for j in group], [f"P{i + 1}" for i in block]


@pytest.mark.parametrize("name", SETS)
def test_nist(name: str, shared_data: Callable[[str], Path]) -> None:
    lines = (shared_data("nist/nist_anova") / f"{name}.dat").read_text().splitlines()
    wanted = float(next(line.split()[-1] for line in lines if line.startswith("Between")))
    rows = [line.split() for line in lines[60:] if len(line.split()) == 2]
    found = tidy_tests([Decimal(y) for _, y in rows], [t for t, _ in rows], None, 0.05)
    f = found.together.between_groups.anova.f[0]
    assert -np.log10(max(abs(f - wanted) / wanted, 1e-16)) >= 14.5
    means = [np.mean([float(y) for t, y in rows if t == name]) for name in found.groups]
    np.testing.assert_allclose(found.mean, means, rtol=1e-13)


def test_one_way_is_scipys_without_blocks() -> None:
    values, group, _ = table()
    found = tidy_tests(values, group, None, 0.05)
    samples = [[float(v) for v, g in zip(values, group, strict=True) if g == name and v] for name in found.groups]
    assert found.by_block is None
    assert found.together.between_groups.anova.p[0] == pytest.approx(stats.f_oneway(*samples).pvalue, rel=1e-10)
    assert found.together.normality.raw.p[1] == pytest.approx(stats.kstest(samples[1], "norm").pvalue, rel=1e-9)
    np.testing.assert_allclose(found.sd, [np.std(s, ddof=1) for s in samples])


def test_blocks_add_tests_and_change_none() -> None:
    values, group, block = table()
    without, found = tidy_tests(values, group, None, 0.05), tidy_tests(values, group, block, 0.05)
    np.testing.assert_array_equal(found.together.pairs.lsd.p, without.together.pairs.lsd.p)
    assert found.by_block is not None
    assert found.by_block.blocks is not None
    assert found.by_block.between_groups.anova.f.size == 5
    cells = np.array([float(v or 0) for v in values]).reshape(5, 3, 6).mean(axis=2)
    assert found.by_block.blocks.friedman.p[0] == pytest.approx(stats.friedmanchisquare(*cells.T).pvalue, rel=1e-10)


@pytest.mark.parametrize("style", ["apa", "ieee", "latex", "plain"])
def test_order_of_rows_does_not_matter(style) -> None:
    values, group, block = table(seed=3)
    order = np.random.default_rng(1).permutation(len(values))
    shuffled = [[column[i] for i in order] for column in (values, group, block)]
    one = tidy_tests(values, group, block, 0.05, 0.5)
    other = tidy_tests(*shuffled, 0.05, 0.5)  # type: ignore[arg-type]
    assert len(text(one, style, details=True)) > len(text(one, style, details=False))
    assert [h.question for h in hypotheses(one, style)] == [h.question for h in hypotheses(other, style)]
    for (of, first), (of_other, second) in zip(outcomes(one), outcomes(other), strict=True):
        assert of == of_other
        assert first.p == second.p or first.p == pytest.approx(second.p, rel=1e-6, nan_ok=True)


def test_rows_left_out_are_counted() -> None:
    values, group, block = table()
    values[0], group[1], block[2] = None, "", ""
    found = tidy_tests(values, group, block, 0.05)
    assert (found.n, found.without_number, found.without_name) == (len(values) - 3, 1, 2)
    assert found.by_block is not None
    assert found.by_block.blocks is not None
    assert isinstance(found.by_block.blocks.model, MixedModel)


def test_one_value_a_cell_is_a_repeated_measures_design() -> None:
    found = tidy_tests(*table(8, 3, 1), 0.05)
    assert [h.question for h in hypotheses(found, "apa")] == [
        "Is each group Gaussian?", "Do groups differ?", "Which groups differ?", "Are groups equal?",
    ]  # fmt: skip
    assert found.by_block is not None
    assert found.by_block.blocks is not None
    assert found.by_block.blocks.mixed is None
    assert np.isfinite(found.by_block.blocks.repeated.p[0])


@pytest.mark.parametrize(
    ("values", "group", "found"),
    [
        ([1, 2, 3], ["a", "a", "a"], "one, 'a'"),
        ([1, 2, 3], ["a", "b", "c"], "3 values in 3 groups"),
        ([None, None], ["a", "b"], "no row with a number"),
    ],
)
def test_nothing_to_compare_is_one_error(values, group, found) -> None:
    with pytest.raises(DataError, match=found):
        tidy_tests([None if v is None else Decimal(v) for v in values], group, None, 0.05)


def test_hostile_values_are_said_to_be_undefined_not_raised() -> None:
    for numbers in (
        ["5"] * 6,
        ["1", "1", "1", "2", "2", "2"],
        ["1e-300", "2e-300", "4e-300"] * 2,
        ["1e300"] * 5 + ["-1e300"],
    ):
        found: TidyTests = tidy_tests([Decimal(n) for n in numbers], list("aaabbb"), list("xyzxyz"), 0.05, 1.0)
        said = text(found, "apa", details=True)
        assert "nan" not in said.lower().split()
        assert "Do groups differ?" in said


def blocked_table(folder: Path, gap: bool = False) -> Path:
    """Four blocks of two groups, five values each."""
    rng = np.random.default_rng(1)
    rows = [f"P{i},S{j},{5 + i + 0.5 * j + rng.normal():.4f}" for i in range(4) for j in range(2) for _ in range(5)]
    path = folder / "table.csv"
    path.write_text("block,group,value\n" + "\n".join(rows[gap:]) + "\n")
    return path


@pytest.mark.parametrize("gap", [False, True])
def test_with_blocks_tests_over_blocks_come_first_and_residuals_of_the_model_are_in_json(
    gap: bool, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    command = ["stats", str(blocked_table(tmp_path, gap)), "--value", "value", "--group", "group", "--block", "block"]
    assert main([*command, "--json"]) == 0
    found = json.loads(capsys.readouterr().out)
    assert found["outcomes"][0]["of"] == "groups over blocks"
    over = [each["method"] for each in found["outcomes"] if each["of"] == "groups over blocks"]
    assert over[0] == "repeated-measures ANOVA, Greenhouse-Geisser"
    assert over[3].startswith("linear mixed model")
    assert set(found["hypotheses"][1]["rows"][0]) == {"paper", "companion", "effect"}
    assert {len(values) for values in found["residuals"].values()} == {40 - gap}
    between = [each for each in found["outcomes"] if each["of"] == "blocks in S1" and "one-way" in each["method"]]
    assert between[0]["estimate_name"] == "omega2"
    assert main(command) == 0
    said = capsys.readouterr().out
    places = [" ".join(said.split()).index(test) for test in ("Greenhouse-Geisser", "Linear mixed", "Welch's")]
    assert places == sorted(places)
    assert " verdict" not in said
    assert "participants / repetitions: ratio of SD" in said


@pytest.mark.parametrize("alpha", ["0", "0.5", "nan"])
def test_a_level_that_no_test_takes_is_refused(alpha: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = blocked_table(tmp_path)
    assert main(["stats", str(path), "--value", "value", "--group", "group", "--alpha", alpha]) != 0
    assert "between 0 and 0.5" in capsys.readouterr().err


def test_participants_of_one_group_each_have_no_mixed_model() -> None:
    values, group, block = table(4)
    found = tidy_tests(values, group, [f"{g}{b}" for g, b in zip(group, block, strict=True)], 0.05)
    said = text(found, "plain", details=False)
    assert "every participant has values of one specimen only" in said
    assert "one-way ANOVA: F(2, 69)" in said


def test_one_block_has_no_tests_over_blocks_and_says_so() -> None:
    values, group, block = table(1)
    said = text(tidy_tests(values, group, block, 0.05), "apa", details=True)
    assert "There are no tests over blocks: they take two blocks or more" in " ".join(said.split())


def test_constant_decimals_are_told_apart_without_an_error() -> None:
    _, group, block = table(4)
    found = tidy_tests([Decimal(g[1:]) / 10 for g in group], group, block, 0.05)
    assert found.by_block is not None
    assert found.by_block.blocks is not None
    assert found.by_block.blocks.variances is None
    said = text(found, "plain", details=True)
    assert "F(2, 6) = inf" in said or "F(2, 6) = ∞" in said
    assert "nan" not in said


def test_paired_t_leads_the_pairs() -> None:
    found = tidy_tests(*table(), 0.05)
    assert found.by_block is not None
    blocks = found.by_block.blocks
    assert blocks is not None
    assert list(blocks.pair_families) == ["Paired t", "Signed ranks", "Mixed-model contrasts"]
    assert "intervals: paired t" in text(found, "apa", details=False)


def test_two_people_have_no_g_and_are_told() -> None:
    found = tidy_tests(*table(2), 0.05)
    assert found.by_block is not None
    assert found.by_block.blocks is not None
    outcome = found.by_block.blocks.pair_outcomes(0)[0]
    assert outcome.effect_size != outcome.effect_size
    assert any("two blocks" in note for note in outcome.notes)


def test_names_that_differ_in_capitals_are_kept_apart_and_told() -> None:
    values, group, block = table()
    found = tidy_tests(values, [g.lower() if b == "P2" else g for g, b in zip(group, block, strict=True)], block, 0.05)
    assert found.groups.size == 6
    assert found.alike() == ("'S1', 's1'", "'S2', 's2'", "'S3', 's3'")

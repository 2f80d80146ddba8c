"""A study of measured runs alone has no people; a half of them is a slip."""

from __future__ import annotations

from pathlib import Path

import pytest

ALONE = """\
[study]
name = "alone"

[[specimens]]
name = "S1"
stiffness_n_per_mm = 7.63

[profile]
new_specimen = "S_new"
new_stiffness_n_per_mm = 9.5

[runs]
root = "lab"
"""


def test_it_needs_no_participants_recordings_or_channels(load):
    study = load(ALONE)
    assert study.recordings == study.participants == ()
    assert study.runs_source.root.name == "lab"
    assert study.data == study.path.parent


@pytest.mark.parametrize(
    ("old", "new", "missing"),
    [
        ('root = "lab"', 'rig = "rig.toml"', "participants recordings"),
        ("[runs]", '[participants]\nids = ["P1"]\n[runs]', "recordings"),
        ('[runs]\nroot = "lab"\n', "", "participants recordings"),
    ],
)
def test_a_rig_that_is_emulated_needs_people_and_so_does_any_word_of_them(problems, old, new, missing):
    found = [line.split(": ")[1] for line in problems(ALONE.replace(old, new))]
    assert set(missing.split()) <= set(found)


def test_the_example_in_the_guide_is_a_study(load):
    guide = (Path(__file__).parents[2] / "docs" / "how-to" / "measured-runs.md").read_text()
    example = guide.partition("```toml\n")[2].partition("```")[0]
    assert load(example).profile.new_specimen == "S_new"

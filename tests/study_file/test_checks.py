"""Every check across keys: one fault each, and the key that it is reported at.

A study of measured runs alone has no people; a half of them is a slip.
"""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import pytest

from emg2vsa.errors import StudyError
from emg2vsa.study import Study

FILE = '[[recordings.files]]\nparticipant = "P01"\nspecimen = "S1"\n'
NEW = '[profile]\nnew_specimen = "N"\n'
EXCLUDE = '[[exclude]]\nparticipant = "P01"\nspecimen = "S1"\nrepetition = 2\nreason = "sneezed"\n'
MVC = '[[mvc]]\nparticipant = "P01"\nemg = "mvc.csv"\n'

CASES = [
    # names
    ('"P02"]', '"p01"]', "participants.ids[1]", "'p01' after 'P01'"),
    ('name = "S3"', 'name = "S1"', "specimens[1].name", "'S1' again"),
    ("ids = ", 'file = "people.tsv"\nids = ', "participants", "both"),
    ('ids = ["P01", "P02"]', "", "participants", "neither"),
    ('ids = ["P01", "P02"]', "ids = []", "participants.ids", "at least 1 entry"),
    ('ids = ["P01", "P02"]', 'ids = ["P/1"]', "participants.ids[0]", "letters, digits"),
    ("+", '[hypotheses]\nkept_specimens = ["S1", "S4"]', "hypotheses.kept_specimens[1]", "Did you mean"),
    ("+", '[hypotheses]\nkept_specimens = ["S1", "S1"]', "hypotheses.kept_specimens[1]", "once"),
    ("+", '[profile]\nparticipant = "P1"', "profile.participant", "Did you mean"),
    ("+", '[profile]\nspecimens = ["S2"]', "profile.specimens[0]", "a specimen of this study"),
    ("+", '[profile]\nnew_specimen = "S1"\nnew_stiffness_n_per_mm = 5', "profile.new_specimen", "a new name"),
    ("+", "[profile]\nnew_height_mm = 10", "profile.new_specimen", "a name for the new height"),
    # a person's word on presses, and maximum contractions
    ("+", EXCLUDE.replace("P01", "P03"), "exclude[0].participant", "a participant of this study"),
    ("+", EXCLUDE.replace("S1", "S2"), "exclude[0].specimen", "a specimen of this study"),
    ("+", EXCLUDE + EXCLUDE, "exclude[1]", "press 2 of P01/S1 in [[exclude]] already"),
    ("+", EXCLUDE + EXCLUDE.replace("exclude", "accept"), "accept[0]", "press 2 of P01/S1 in [[exclude]] already"),
    ("+", EXCLUDE.replace("= 2", "= 0"), "exclude[0].repetition", ">= 1"),
    ("+", EXCLUDE.replace('reason = "sneezed"', ""), "exclude[0].reason", "a key 'reason'"),
    ("+", EXCLUDE.replace("sneezed", ""), "exclude[0].reason", "not empty"),
    ("+", MVC, "mvc", "normalise = 'none'"),
    ("+", MVC.replace("P01", "P9"), "mvc[0].participant", "a participant of this study"),
    ("+", MVC + '[cocontraction]\nnormalise = "mvc"', "cocontraction.mvc_v.EDC", "or record it of P02"),
    ("+", MVC.replace('emg = "mvc.csv"', ""), "mvc[0].emg", "a key 'emg'"),
    ("+", "[fit]\nmin_adj_r2 = 1.5", "fit.min_adj_r2", "< 1"),
    ("+", "[fit]\nmax_b_error = -1", "fit.max_b_error", ">= 0"),
    ("+", "[window]\nmax_missed_n = 0", "window.max_missed_n", "> 0"),
    ("+", "[cocontraction]\ncrosstalk = { EDC = { EDC = 0.2 } }", "cocontraction.crosstalk.EDC", "told apart"),
    (
        "+",
        "[cocontraction]\ncrosstalk = { EDC = { FDS = 1.0 }, FDS = { EDC = 1.0 } }",
        "cocontraction.crosstalk.EDC",
        "back 1",
    ),
    # recordings and channels
    ('layout = "pattern"', 'layout = "bids"', "recordings.root", "a key 'root'"),
    ('layout = "pattern"', 'layout = "bids"', "recordings.pattern", "keys of this layout only"),
    ('layout = "pattern"', 'layout = "bids"\ntask = "a_b"', "recordings.task", "letters and digits only"),
    ("{participant}_", "", "recordings.pattern", "{participant} in it, as there are 2 participants"),
    ("_{specimen}", "", "recordings.pattern", "{specimen} in it"),
    ("{specimen}", "{specimens}", "recordings.pattern", "Did you mean 'specimen'?"),
    ("+", FILE + FILE, "recordings.files[1].emg", "a further recording of P01/S1 without a file"),
    ("+", FILE + 'emg = "a"\n\n' + FILE + 'emg = "a"\n', "recordings.files[1].emg", '"a" again for P01/S1'),
    ("+", FILE + 'emg = "a"\n' + FILE + 'emg = "b"\nwindow.min_duration_s = 1', "recordings.files[1].window", "first"),
    ("data/", "**/", "recordings.pattern", "'**'"),
    (
        'pattern = "data/',
        'force_pattern = "{participant}_{specimen}"\npattern = "{repetition}/',
        "recordings.force_pattern",
        "{repetition} in it",
    ),
    (
        'name = "Fz"',
        'name = "Fz"\ngauges = ["a", "b", "c", "d", "e", "f"]',
        "channels.force.gauges",
        "a key 'cal_file'",
    ),
    ('name = "Fz"', 'name = "Fz"\ncal_file = "a.cal"', "channels.force.gauges", "the six gauge channels"),
    (
        'name = "Fz"',
        'name = "F"\ncal_file = "a.cal"\ngauges = ["a", "b", "c", "d", "e", "f"]',
        "channels.force.name",
        "Fx, Fy, Fz with cal_file",
    ),
    (
        'name = "Fz"',
        'name = "Fz"\ncal_file = "a.cal"\ngauges = ["a", "b", "c", "d", "e", "a"]',
        "channels.force.gauges",
        "six different channels",
    ),
    (
        'name = "Fz"',
        'name = "Fz"\ncal_file = "a"\ngauges = ["a", "b", "c", "d", "e", "f"]\nnewtons_per_unit = 1',
        "channels.force.newtons_per_unit",
        "either cal_file",
    ),
    (
        'name = "Fz"',
        'name = "Fz"\ncal_file = "a"\ngauges = ["a", "b", "c", "d", "e", "f"]\nunit = "V"\nvolts_per_unit = 1',
        "channels.force.unit",
        "either unit or volts_per_unit",
    ),
    ('name = "EMG 1"', 'name = "EMG 1"\nfs_hz = 0', "channels.emg.EDC.fs_hz", "a number > 0"),
    ("+", FILE.replace("P01", "P9"), "recordings.files[0].participant", "a participant of this study"),
    ("+", FILE.replace("S1", "S9"), "recordings.files[0].specimen", "a specimen of this study"),
    ("+", FILE + "window.force_n = [1, 2]", "recordings.files[0].window.force_n", "one force window"),
    ("+", FILE + "filters.band_hz = [450, 10]", "recordings.files[0].filters.band_hz", "smaller number first"),
    ("+", FILE + "window.min_duration_s = 30", "recordings.files[0].window.max_duration_s", "more than"),
    ('pattern"\npattern = "data/{participant}_{specimen}.csv"', 'files"', "recordings.files", "a key 'files'"),
    ('name = "EMG 2"', 'name = "EMG 1"', "channels.emg.FDS.name", "'EMG 1', as for EDC"),
    ('name = "Fz"', 'name = "EMG 2"', "channels.force.name", "'EMG 2', as for FDS"),
    # stages
    ("+", "[filters]\nband_hz = [450, 10]", "filters.band_hz", "smaller number first"),
    ("+", "[filters]\nband_hz = [10, 10]", "filters.band_hz", "smaller number first"),
    ("+", "[filters]\nfir_order = 51", "filters.fir_order", "Take 52"),
    ("+", "[window]\nforce_n = [7, 0.5]", "window.force_n", "[7.0, 0.5]"),
    ("+", "[window]\nmax_duration_s = 0.5", "window.max_duration_s", "more than min_duration_s = 0.5"),
    ("+", "[window]\nwarn_falling_share = 0.2", "window.warn_falling_share", "at most max_falling_share = 0.1"),
    ("+", '[cocontraction]\nnormalise = "mvc"\nmvc_v = { EDC = 1e-4 }', "cocontraction.mvc_v.FDS", "none for 'FDS'"),
    ("+", "[cocontraction]\nmvc_v = { EDL = 1e-4 }", "cocontraction.mvc_v.EDL", "Did you mean 'EDC'?"),
    (
        '[channels.emg.FDS]\nname = "EMG 2"',
        '[cocontraction]\nindex = "minimum"',
        "cocontraction.index",
        "two or more muscles",
    ),
    (
        "[channels.force]",
        '[channels.emg.FCR]\nname = "E 3"\n[channels.force]',
        "simulation.muscle_share",
        "EDC, FDS, FCR",
    ),
    (
        "+",
        f'{FILE}channels.emg = {{ EDC.name = "E" }}\n[cocontraction]\nindex = "rudolph"',
        "cocontraction.index",
        "EDC.",
    ),
    ("+", "[fit]\nbin_n = 3", "fit.bin_n", "three bins"),
    ("+", "[fit]\nbin_n = 0.001", "fit.bin_n", "at most 1000 bins from 0.5 to 7 N"),
    ("+", NEW, "profile.new_stiffness_n_per_mm", "the stiffness of 'N'"),
    ("+", "[profile]\nnew_stiffness_n_per_mm = 5", "profile.new_specimen", "a name"),
    ("+", NEW + "new_stiffness_n_per_mm = 9", "profile.new_stiffness_n_per_mm", "between 3.35 and 7.63"),
    (
        'name = "S1"',
        'name = "S1"\nstiffness_range_n = [7, 7]',
        "specimens[0].stiffness_range_n",
        "smaller number first",
    ),
    ('name = "S1"', 'name = "S1"\nstiffness_change = 0.2', "specimens[0].stiffness_change", "stiffness_range_n too"),
    ('name = "S1"', 'name = "S1"\nstiffness_change = 9', "specimens[0].stiffness_change", "a number <= 5"),
    ('name = "S1"', 'name = "S1"\ndiameter_mm = 50', "specimens[0].height_mm", "height_mm beside diameter_mm"),
    ('name = "S1"', 'name = "S1"\nheight_mm = 0', "specimens[0].height_mm", "a number > 0"),
    ('name = "S1"', 'name = "S1"\nends = "glued"', "specimens[0].ends", "frictionless"),
    ("+", "[schedule]\nstiffness_percent = [80, 20]", "schedule.stiffness_percent", "smaller number first"),
    ("+", "[schedule]\nstep_n = 6.6", "schedule.step_n", "at most 6.5, the width of the force window"),
    # simulation
    ("a_v = { S1 = 40e-6, S3", "a_v = { S3", "simulation.a_v.S1", "none for 'S1'"),
    ("b_v = { S1", "b_v = { S2 = 1e-5, S1", "simulation.b_v.S2", "a specimen of this study"),
    ("S3 = 30e-6", "S3 = 10e-6", "simulation.a_v.S3", "a + b log F > 0 from 0.5 to 7 N"),
    ("+", "muscle_share = { EDC = 1.0 }", "simulation.muscle_share", "a share for each of EDC, FDS"),
    ("+", "muscle_share = { EDC = 0.5, FDS = 0.6 }", "simulation.muscle_share", "a sum of 1.1"),
    ("+", "loading_s = [3, 2]", "simulation.loading_s", "smaller number first"),
    ("+", "rest_s = [3, 2]", "simulation.rest_s", "smaller number first"),
]


@pytest.mark.parametrize(("old", "new", "key", "says"), CASES, ids=[f"{c[2]}-{i}" for i, c in enumerate(CASES)])
def test_each_check(small: str, problems: Callable[[str], list[str]], old: str, new: str, key: str, says: str) -> None:
    text = f"{small}{new}\n" if old == "+" else small.replace(old, new, 1)
    assert text != small
    said = [line for line in problems(text) if f": {key}: " in line]
    assert len(said) == 1
    assert says in said[0]


def test_the_small_study_itself_is_sound(small: str, load: Callable[[str], Study]) -> None:
    assert load(small).name == "small"


def test_limits_that_are_no_faults(small: str, load: Callable[[str], Study]) -> None:
    load(f"{small}loading_s = [2, 2]\n{NEW}new_stiffness_n_per_mm = 7.63\n")
    load(f"{small}{NEW}new_stiffness_n_per_mm = 9\nextrapolate = true\n")
    load(small + "[schedule]\nstep_n = 6.5\n")
    load(small + "[filters]\noutput_fs_hz = 100\n[fit]\nconfidence = 0.5\n")


def test_channels_may_be_left_out_only_where_every_recording_has_its_own(
    small: str, problems: Callable[[str], list[str]]
) -> None:
    start, stop = small.index("[channels"), small.index("[simulation]")
    said = problems(small[:start] + small[stop:])
    assert ["channels" in line for line in said] == [True]


def test_participants_table_without_the_column(
    small: str, problems: Callable[[str], list[str]], tmp_path: Path
) -> None:
    folder = tmp_path / "studies" / "small"
    folder.mkdir(parents=True)
    text = small.replace('ids = ["P01", "P02"]', 'file = "people.tsv"')
    assert problems(text)[0].startswith(
        '5: participants.file: expected a readable table, but found "people.tsv": No such'
    )
    (folder / "people.tsv").write_text("name\nP01\n")
    assert "participant_id in every row" in problems(text)[0]
    (folder / "people.tsv").write_text("participant_id\nsub-P01\nsub-P01\n")
    assert "'P01' again" in problems(text)[0]


def test_people_and_judgements_reach_the_study(small: str, load: Callable[[str], Study], tmp_path: Path) -> None:
    folder = tmp_path / "studies" / "small"
    folder.mkdir(parents=True)
    (folder / "people.tsv").write_text(
        "participant_id\tage\tsex\thandedness\nsub-P01\t24\tF\tright\nP02\tn/a\tm\tn/a\n"
    )
    text = small.replace('ids = ["P01", "P02"]', 'file = "people.tsv"') + EXCLUDE
    text += EXCLUDE.replace("exclude", "accept").replace("repetition = 2\n", "").replace("S1", "S3")
    study = load(text + MVC + MVC.replace("P01", "P02") + '[cocontraction]\nnormalise = "mvc"\n')
    assert study.participants == ("P01", "P02")
    assert [(p.age, p.sex, p.handedness) for p in study.people] == [("24", "F", "right"), ("", "m", "")]
    told = [(j.specimen, j.repetition, j.excludes) for j in study.judgements]
    assert told == [("S1", 2, True), ("S3", None, False)]
    assert [entry.mvc_files for entry in study.recordings] == [(folder / "mvc.csv",)] * 4


@pytest.mark.parametrize("age", ["young", "-3", "24 years"])
def test_an_age_that_is_none(small: str, problems: Callable[[str], list[str]], tmp_path: Path, age: str) -> None:
    folder = tmp_path / "studies" / "small"
    folder.mkdir(parents=True)
    (folder / "people.tsv").write_text(f"participant_id\tage\nP01\t{age}\nP02\t30\n")
    (said,) = problems(small.replace('ids = ["P01", "P02"]', 'file = "people.tsv"'))
    assert "participants.file: expected an age in years" in said
    assert repr(age) in said


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


@pytest.mark.parametrize(
    ("recordings", "free"),
    [
        ('pattern = "{participant}_{specimen}_emg.csv"\nforce_pattern = "{participant}_{specimen}_force.csv"', True),
        ('pattern = "{participant}_{specimen}.csv"\nforce_pattern = "{participant}_{specimen}.csv"', False),
        (
            'pattern = "{participant}_{specimen}_emg.csv"\nforce_pattern = "{participant}_{specimen}_force.csv"\n'
            '[[recordings.files]]\nparticipant = "P01"\nspecimen = "S1"\nemg = "both.csv"',
            False,
        ),
    ],
)
def test_force_in_a_file_of_its_own_may_bear_the_name_of_an_emg_channel(
    small: str, load: Callable[[str], Study], recordings: str, free: bool
) -> None:
    text = small.replace('pattern = "data/{participant}_{specimen}.csv"', recordings)
    text = text.replace('name = "Fz"', 'name = "EMG 2"')
    if free:
        assert load(text).recordings[0].channels.force.name == "EMG 2"
    else:
        with pytest.raises(
            StudyError, match=r"channels.force.name: expected a channel of its own.*'EMG 2', as for FDS"
        ):
            load(text)


def test_listed_files_of_force_of_its_own(small: str, load: Callable[[str], Study]) -> None:
    listed = "".join(
        f'[[recordings.files]]\nparticipant = "{person}"\nspecimen = "{name}"\nemg = "{person}_{name}.csv"\n'
        f'force = "{person}_{name}_force.csv"\n'
        for person in ("P01", "P02")
        for name in ("S1", "S3")
    )
    text = small.replace(
        'layout = "pattern"\npattern = "data/{participant}_{specimen}.csv"\n', 'layout = "files"\n' + listed
    )
    text = text.replace('name = "Fz"', 'name = "EMG 2"')
    assert {each.channels.force.name for each in load(text).recordings} == {"EMG 2"}
    with pytest.raises(StudyError, match=r"channels\.force\.name"):
        load(text.replace('force = "P01_S1_force.csv"\n', ""))

"""From a study file to a study: paths, layouts, exceptions, paper mode; and the studies that come with the program."""

from __future__ import annotations

import os
import subprocess
import sys
import time
from collections.abc import Callable
from pathlib import Path

import pytest

from emg2vsa.settings import PAPER, RECIPES, ReadingSettings
from emg2vsa.study import Study
from emg2vsa.study_file import load_study, missing_files

ROOT = Path(__file__).resolve().parents[2]
Load = Callable[[str], Study]


def test_paths_start_at_the_folder_of_the_study_file(small: str, load: Load, tmp_path: Path) -> None:
    study = load(small)
    folder = tmp_path / "studies" / "small"
    assert study.path == folder / "study.toml"
    assert study.results == folder / ".emg2vsa" / study.name
    assert study.reports == tmp_path / "reports" / "small"
    assert study.data == folder / "data"
    assert [r.key for r in study.recordings] == ["P01/S1", "P01/S3", "P02/S1", "P02/S3"]
    assert study.recordings[1].emg_file == folder / "data" / "P01_S3.csv"
    assert study.recordings[1].force_file is None


def test_outside_the_shipped_layout_the_report_lies_beside_the_study_file(small: str, tmp_path: Path) -> None:
    for place in ("lab/study.toml", "studies/study.toml", "studies/2026/small/study.toml"):
        path = tmp_path / place
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(small)
        assert load_study(path).reports == path.parent / "reports" / "small"
    path.write_text(small.replace('name = "small"', 'name = "small"\nreports = "../out"'))
    assert load_study(path).reports == path.parents[1] / "out"


@pytest.mark.parametrize(
    ("runs", "root"),
    [
        ('rig = "rig.toml"', "runs-virtual"),
        ('rig = "rig.toml"\nroot = "runs"', "runs"),
        ("", "runs"),
        ('camera = "c.toml"', "runs"),
        ('root = "../lab"', "../lab"),
    ],
)
def test_runs_of_an_emulated_rig_lie_apart_from_measured_ones(small: str, load: Load, runs: str, root: str) -> None:
    study = load(f"{small}[runs]\n{runs}\n")
    assert study.runs_source is not None
    assert study.runs_source.root == Path(os.path.normpath(study.path.parent / root))
    assert (study.runs_source.rig is not None) == ("rig" in runs)


def test_absolute_paths_stay_and_nothing_is_expanded(small: str, load: Load, tmp_path: Path) -> None:
    text = small.replace('name = "small"', f'name = "small"\nreports = "{tmp_path / "out"}"\nresults = "~/$HOME"')
    study = load(text)
    assert study.reports == tmp_path / "out"
    assert study.results == tmp_path / "studies" / "small" / "~" / "$HOME"


def test_title_is_the_name_where_none_is_given(small: str, load: Load) -> None:
    assert load(small).title == "small"
    assert load(small.replace('name = "small"', 'name = "small"\ntitle = "A b"')).title == "A b"


def test_bids_layout(small: str, load: Load, tmp_path: Path) -> None:
    old = small[small.index("layout = ") : small.index("[channels.emg.EDC]")]
    study = load(small.replace(old, 'layout = "bids"\nroot = "../data"\ntask = "press"\nextension = "edf"\n'))
    root = tmp_path / "studies" / "data"
    assert study.recordings[3].emg_file == root / "sub-P02" / "emg" / "sub-P02_task-press_acq-S3_emg.edf"
    assert study.data == root


def test_participants_from_a_bids_table(small: str, load: Load, tmp_path: Path) -> None:
    folder = tmp_path / "studies" / "small"
    folder.mkdir(parents=True)
    (folder / "people.tsv").write_text("age\tparticipant_id\n30\tsub-A1\n31\tB2\n", encoding="utf-8-sig")
    assert load(small.replace('ids = ["P01", "P02"]', 'file = "people.tsv"')).participants == ("A1", "B2")


def test_a_recording_may_differ_from_the_layout_in_what_it_names_only(small: str, load: Load) -> None:
    text = small.replace("[channels.emg.EDC]", "[filters]\nfir_order = 60\nband_order = 4\n[channels.emg.EDC]", 1)
    study = load(
        f"""{text}
[[recordings.files]]
participant = "P02"
specimen = "S1"
force = "data/forces.csv"
filters = {{ fir_order = 80 }}
window = {{ min_duration_s = 0.1 }}
channels.force = {{ name = "Fz", sign = -1 }}
"""
    )
    plain, own = study.recordings[0], study.recordings[2]
    assert own.key == "P02/S1"
    assert own.emg_file.name == "P02_S1.csv"
    assert own.force_file == own.emg_file.with_name("forces.csv")
    assert (own.filters.fir_order, own.filters.band_order) == (80, 4)
    assert (plain.filters.fir_order, plain.filters.band_order) == (60, 4)
    assert own.window.min_duration_s == 0.1
    assert own.window.force_n == study.window.force_n
    assert own.channels.emg == plain.channels.emg
    assert (own.channels.force.sign, plain.channels.force.sign) == (-1, 1)


def test_force_in_files_of_its_own(small: str, load: Load) -> None:
    study = load(
        small.replace("[channels.emg.EDC]", 'force_pattern = "f/{specimen}/{participant}.txt"\n[channels.emg.EDC]')
    )
    assert study.recordings[1].force_file == study.path.parent / "f" / "S3" / "P01.txt"


def test_paper_mode_sets_what_the_study_does_not(small: str, load: Load) -> None:
    paper = small.replace('name = "small"', 'name = "small"\nmode = "paper"')
    study = load(paper + '[filters]\nphase = "compensated"\n')
    filters = study.recordings[0].filters
    assert filters.phase == "compensated"
    assert filters.band_hz == PAPER["filters"]["band_hz"]
    assert filters.output_fs_hz == "native"
    assert (study.fit.points, study.fit.weights) == ("samples", "none")
    assert study.profile.interpolation == "paper"
    assert load(small).fit.points == "bins"


def test_paper_mode_scores_presses_as_the_paper_says_unless_told_otherwise(small: str, load: Load) -> None:
    paper = small.replace('name = "small"', 'name = "small"\nmode = "paper"')
    steps = ("horn-schunck", "mean", "paper", "paper", "paper", "contact")
    assert load(f"{paper}[runs]\n").scoring.recipe == steps
    assert load(f'{paper}[runs]\nregion = "image"\nrate = "slope"\n').scoring.recipe == (*steps[:4], "slope", "image")
    assert load(f'{paper}[runs]\nalgorithm = "edge"\n').scoring.recipe == RECIPES["edge"]
    assert load(f"{small}[runs]\n").scoring.recipe == RECIPES["front"]
    pins = load(f'{paper}[runs]\narea_rule = "circle"\nengine = "pin-affine"\n').scoring.recipe
    assert (pins.engine, pins.area_rule, pins.law) == ("pin-affine", "circle", "paper")
    image = load(f'{small}[runs]\nalgorithm = "edge"\nengine = "dis"\nregion = "image"\n').scoring.recipe
    assert image == RECIPES["edge"]._replace(engine="dis", region="image")


def test_paper_mode_holds_in_a_recording_of_its_own(small: str, load: Load) -> None:
    paper = small.replace('name = "small"', 'name = "small"\nmode = "paper"')
    text = paper + '[[recordings.files]]\nparticipant = "P01"\nspecimen = "S1"\nfilters.fir_order = 60\n'
    filters = load(text).recordings[0].filters
    assert (filters.fir_order, filters.phase) == (60, "causal")


def test_whole_numbers_are_numbers_and_become_floats(small: str, load: Load) -> None:
    force_n = load(small + "[window]\nforce_n = [1, 7]\n").window.force_n
    assert force_n == (1.0, 7.0)
    assert all(isinstance(f, float) for f in force_n)


def test_missing_files_are_told_by_recording(small: str, load: Load) -> None:
    study = load(small)
    study.data.mkdir()
    (study.data / "P01_S3.csv").touch()
    assert [r.key for r in missing_files(study)] == ["P01/S1", "P02/S1", "P02/S3"]


@pytest.mark.parametrize("name", ["palpation", "recorded"])
def test_the_studies_that_come_with_the_program(name: str) -> None:
    path = ROOT / "studies" / name / "study.toml"
    study = load_study(path)
    assert study.name == name
    assert study.reports == ROOT / "reports" / name
    assert path.read_text().splitlines()[0] == "#:schema ../study.schema.json"


def test_the_palpation_study_is_the_papers() -> None:
    study = load_study(ROOT / "studies/palpation/study.toml")
    assert len(study.participants) == 14
    assert study.stiffness_n_per_mm == {"S1": 7.63, "S2": 5.32, "S3": 3.35, "S4": 3.12, "S5": 1.11}
    assert len(study.recordings) == 70
    assert all(r.window.expected_trials == 10 for r in study.recordings)
    assert study.hypotheses.kept_specimens == ("S1", "S3", "S5")


def test_the_recorded_study_names_channels_that_its_files_hold(shared_data: Callable[[str], Path]) -> None:
    from emg2vsa.errors import RecordingError
    from emg2vsa.readers.roles import read_roles

    shared_data("emg/emg_force")
    shared_data("emg/c3d")
    recordings = load_study(ROOT / "studies/recorded/study.toml").recordings
    if not any(entry.emg_file.exists() for entry in recordings):
        pytest.skip("the recorded study looks for its data beside the checkout, and they lie elsewhere")
    refused = []
    for entry in recordings:
        try:
            roles = read_roles(entry.emg_file, entry.force_file, entry.channels)
        except RecordingError as error:
            refused.append((entry.participant, error.where.rpartition("/")[2]))
        else:
            assert roles.force.samples.max() > entry.window.force_n[1]
    assert refused == [("noplate", "btk_1123x01EMG.c3d, channel 'plate 1 Fz'")]


def test_recordings_share_the_settings_that_they_do_not_replace(small: str, load: Load) -> None:
    own = '[[recordings.files]]\nparticipant = "P01"\nspecimen = "S3"\nwindow.min_duration_s = 0.1\n'
    study = load(f"{small}{own}")
    for recording in study.recordings:
        assert recording.filters is study.filters
        assert recording.channels is study.recordings[0].channels
        assert (recording.window is study.window) == (recording.key != "P01/S3")


@pytest.mark.parametrize("listed", [False, True])
def test_many_recordings_load_at_once(small: str, load: Load, listed: bool) -> None:
    people = [f"P{i:04d}" for i in range(1000)]
    text = small.replace('ids = ["P01", "P02"]', f"ids = {people}")
    if listed:
        layout = text[text.index("layout = ") : text.index("[channels.emg.EDC]")]
        cells = [
            f'{{ participant = "{p}", specimen = "{s}", emg = "{p}{s}.csv" }}' for p in people for s in ("S1", "S3")
        ]
        text = text.replace(layout, f'layout = "files"\nfiles = [{", ".join(cells)}]\n')
    start = time.process_time()
    study = load(text)
    assert time.process_time() - start < 2
    assert len({recording.emg_file for recording in study.recordings}) == 2000


def test_how_long_a_file_may_be_read(small: str, load: Load) -> None:
    assert load(small).reading == ReadingSettings()
    assert load(small + "[reading]\nmax_seconds = 60\n").reading.max_seconds == 60.0


def test_loading_leaves_heavy_libraries_alone() -> None:
    code = (
        "import sys; from emg2vsa.study_file import load_study;"
        f"load_study({str(ROOT / 'studies/palpation/study.toml')!r});"
        "print(sorted({'numpy', 'scipy', 'pandas', 'matplotlib', 'pyarrow', 'pydantic'} & set(sys.modules)))"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "[]"

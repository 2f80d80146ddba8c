"""Whatever names and channels a folder has, the study that ``emg2vsa new`` drafts has no contradiction in it."""

from __future__ import annotations

import itertools
import re
import sys
from pathlib import Path

import pytest

from emg2vsa.errors import StudyError
from emg2vsa.study_file import load_study
from emg2vsa.study_file.draft import draft, halves, naming_of_pairs
from emg2vsa.study_file.draft_channel import FILL, DraftChannel

NAMES = {
    "person and specimen": ["ama_hard.csv", "ama_soft.csv", "bob_hard.csv", "bob_soft.csv"],
    "folders": ["P01/S1.csv", "P01/S2.csv", "P02/S1.csv", "P02/S2.csv"],
    "repetitions": [f"{p}_{s}_{r}.csv" for p in ("P1", "P2") for s in ("S1", "S2") for r in (1, 2, 3)],
    "dates": [f"2026-05-0{2 * i + j}_{p}_{s}.csv" for i, p in enumerate("ab") for j, s in enumerate(("x", "y"))],
    "one person": ["S1.csv", "S2.csv", "S3.csv"],
    "one specimen": ["ama.csv", "bob.csv", "cleo.csv"],
    "one file": ["recording.csv"],
    "one pair": ["anna_hard_emg.csv", "anna_hard_force.csv"],
    "pairs": [f"{p}_{s}_{k}.csv" for p in ("ama", "bob") for s in ("hard", "soft") for k in ("emg", "force")],
    "pairs in folders": [f"{k}/{p}_{s}.csv" for k in ("emg", "force") for p in ("ama", "bob") for s in ("a", "b")],
    "pairs of repetitions": [f"{p}_S1_{r}_{k}.csv" for p in ("P1", "P2") for r in (1, 2) for k in ("emg", "force")],
    "pairs without pattern": ["anna hard emg.csv", "anna hard force.csv", "b_soft_2_emg.csv", "b_soft_2_force.csv"],
    "no pattern": ["a.csv", "b_c.csv", "d_e_f.csv"],
    "signs": ["Ünal k_weich #1.csv", "Ünal k_hart #1.csv", "Böhm k_weich #1.csv", "Böhm k_hart #1.csv"],
    "quotes": ['a"b_x.csv', 'a"b_y.csv', "c'd_x.csv", "c'd_y.csv"],
}  # fmt: skip
EMG = {
    "muscles": {"EDC": DraftChannel("EDC", "mV"), "FDS": DraftChannel("FDS", "mV")},
    "channels": {"Channel 1": DraftChannel("Channel 1", "mV"), "Channel 2": DraftChannel("Channel 2", None)},
    "rows": {"row 2": DraftChannel("row 2", None, no_rate=True)},
    "odd signs": {'E"1 \\ (l)': DraftChannel('E"1 \\ (l)', "counts", fs_hz=2000.0)},
}
FORCE = {
    "newtons": DraftChannel("Fz", "N", sign=-1), "same name": DraftChannel("Channel 1", "N"),
    "mass": DraftChannel("weight", "kg"), "no unit": DraftChannel("row 2", None, no_rate=True),
    "another unit": DraftChannel("load", "%MVC"),
}  # fmt: skip


FORMS = {
    "keys before values": (
        [f"sub-{p}/sub-{p}_task-{s}_run-001.xdf" for p in ("P001", "P002") for s in ("gel", "pu")],
        "sub-{participant}/*_task-{specimen}_run-001.xdf", ("P001", "P002"), ("gel", "pu"),
    ),
    "numbers of people": (
        [f"Proband {p}/{s}.txt" for p in (1, 2) for s in ("hard", "soft")],
        "Proband {participant}/{specimen}.txt", ("1", "2"), ("hard", "soft"),
    ),
    "blocks": (
        [f"{p}_block{b}_{s}.mat" for p in ("P3", "P4") for b, s in enumerate(("low", "high"), 1)],
        "{participant}_*_{specimen}.mat", ("P3", "P4"), ("low", "high"),
    ),
    "hyphens": (
        [f"S{p}-{s}-ramp.csv" for p in (1, 2) for s in ("soft", "stiff")],
        "{participant}-{specimen}-ramp.csv", ("S1", "S2"), ("soft", "stiff"),
    ),
}  # fmt: skip


@pytest.mark.parametrize(("files", "pattern", "people", "specimens"), FORMS.values(), ids=FORMS)
def test_parts_of_names_get_their_roles(
    files: list[str], pattern: str, people: tuple[str, ...], specimens: tuple[str, ...]
) -> None:
    naming, force_files = naming_of_pairs(files)
    assert naming is not None
    assert (naming.pattern, naming.participants, naming.specimens) == (pattern, people, specimens)
    assert not force_files


def test_halves_are_told_by_form_or_by_a_part_of_two_values() -> None:
    by_form = [f"{p}_{s}{end}" for p in ("a", "b") for s in ("x", "y") for end in (".hpf", "_loadcell.csv")]
    assert halves(by_form) == [(by_form[::2], by_form[1::2])]
    by_part = [f"{p}_{s}_{k}.csv" for p in ("a", "b", "c") for s in ("x", "y", "z") for k in ("myo", "mini45")]
    assert halves(by_part) == [(by_part[::2], by_part[1::2])]
    assert halves(by_part[:-1]) == halves(by_form[:-1]) == halves(["a.csv", "b.txt", "c.mat"]) == []


@pytest.mark.parametrize("names", NAMES)
@pytest.mark.parametrize(("emg", "force"), list(itertools.product(EMG, FORCE)))
def test_a_drafted_study_passes_the_schema(tmp_path: Path, names: str, emg: str, force: str) -> None:
    """A channel may bear one name in the file of EMG and in that of force; in one file it cannot play both roles."""
    naming, force_files = naming_of_pairs(NAMES[names])
    if FORCE[force].name in {channel.name for channel in EMG[emg].values()} and not force_files:
        pytest.skip("one channel of one file is never taken for both")
    text = draft("mine", naming, NAMES[names], EMG[emg], FORCE[force], {}, ["a.csv"])
    for name in NAMES[names]:
        if sys.platform == "win32" and '"' in name:
            pytest.skip("no name of a file there")
        (tmp_path / name).parent.mkdir(exist_ok=True)
        (tmp_path / name).touch()
    path = tmp_path / "study.toml"
    path.write_text(text, encoding="utf-8")
    study = load_study(path)
    channels = study.recordings[0].channels
    assert {channel.name for channel in channels.emg.values()} == {channel.name for channel in EMG[emg].values()}
    assert channels.force.name == FORCE[force].name
    parts = [part for entry in study.recordings for part in entry.parts]
    files = [file for part in parts for file in (part.emg_file, part.force_file) if file is not None]
    assert sorted(files) == sorted(tmp_path / name for name in NAMES[names])
    assert bool(force_files) == (study.recordings[0].force_file is not None)


@pytest.mark.parametrize("names", NAMES)
def test_what_no_file_tells_is_the_only_thing_that_a_draft_lacks(tmp_path: Path, names: str) -> None:
    """Without a channel that looks like EMG or force, every problem is one whose line is marked."""
    naming, _ = naming_of_pairs(NAMES[names])
    path = tmp_path / "study.toml"
    path.write_text(draft("mine", naming, NAMES[names], {}, None, {}, []), encoding="utf-8")
    with pytest.raises(StudyError) as error:
        load_study(path)
    assert error.value.problems
    assert all(re.search(r"channels\.(emg|force)", problem) for problem in error.value.problems)
    assert path.read_text(encoding="utf-8").count(f"{FILL}: no channel looks like") == 2

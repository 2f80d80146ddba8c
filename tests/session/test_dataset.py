"""A session as BIDS-EMG: what is in it, when, and what the analysis makes of it."""

from __future__ import annotations

import csv
import json
import re
import shutil
import subprocess
import sys
from dataclasses import dataclass, replace
from functools import reduce
from pathlib import Path

import edfio
import numpy as np
import pytest

from benchmarks.small_study import SIMULATED_SESSION, small_study
from emg2vsa.devices.streams import Block, StreamInfo
from emg2vsa.errors import DataError, RecordingError, SettingError
from emg2vsa.pipeline.stages.trials import trials_of
from emg2vsa.readers.bids_sidecars import session_events
from emg2vsa.readers.session_events import session_presses, with_gaps
from emg2vsa.recordings import Channel
from emg2vsa.session.dataset import refuse_foreign, write_dataset
from emg2vsa.session.journal import (
    PLACED,
    Begun,
    Checked,
    Commanded,
    Decided,
    Ended,
    Judged,
    Noted,
    Paused,
    PressBegun,
    PressEnded,
)
from emg2vsa.session.plan import Plan, draw_presses
from emg2vsa.session.record import SessionRecord, new_session, resume_session, session_folder
from emg2vsa.session.stays import data_record
from emg2vsa.session_settings import SessionAbout
from emg2vsa.study import Study
from emg2vsa.study_file import load_study

STUDY = small_study(
    specimens=["S1", "S3"],
    task="press",
    tables=f"""
[session]
{SIMULATED_SESSION}
training_specimens = ["T1"]
training_repetitions = 1
repetitions = 3
ethics = "2026-7"
[session.about]
power_line_hz = 50
electrode_mm = 10
skin_preparation = "alcohol"
ground = "elbow"
manufacturer = "Delsys"
model = "Bagnoli"
serial_number = "7"
band_hz = [20, 450]
electrodes = "DE-2.1"
electrode_manufacturer = "Delsys"
electrode_type = "bar"
electrode_material = "Ag"
institution = "An institute"
institution_address = "A street"
department = "A department"
authors = ["A. Author", "B. Author"]
licence = "CC0"
[session.places]
system = "x from the elbow to the wrist, y across"
pairs = {{ EDC = [[0, 0], [10, 0]], FDS = [[0, 5], [10, 5]] }}
""",
).replace('name = "FDS"', 'name = "FDS right"')
PRESS_S, LOAD_S = 5.0, 2.5
NOT_TO_BE_MET = {"HEDVersion", "SourceDatasets"}


@dataclass
class Device:
    """A stream with a crystal of its own, whose blocks arrive late by chance."""

    record: SessionRecord
    info: StreamInfo
    ppm: float
    begun_s: float

    def __post_init__(self) -> None:
        self.writer = self.record.open_stream(self.info.kind, self.info)
        self.rng = np.random.default_rng(int(self.info.fs_hz))
        self.step_s = 1 / (self.info.fs_hz * (1 + 1e-6 * self.ppm))

    def times_s(self, stop_s: float) -> np.ndarray:
        return self.begun_s + self.step_s * np.arange(int((stop_s - self.begun_s) / self.step_s))

    def send(self, samples: np.ndarray, lost: slice = slice(0, 0)) -> None:
        size = round(self.info.fs_hz / 50)
        for first in range(0, len(samples) - size + 1, size):
            if not lost.start <= first < lost.stop:
                due_s = self.begun_s + self.step_s * (first + size - 1)
                late_s = 2e-4 + self.rng.exponential(1e-3)
                self.writer.append(Block(samples[first : first + size], first, due_s + late_s))


def force_at(times_s: np.ndarray, starts_s: list[float]) -> np.ndarray:
    """Newtons: a ramp to 7.2 N after each start, and down again."""
    force_n = np.zeros(times_s.size)
    for start_s in starts_s:
        x = times_s - start_s - 0.3
        up = np.clip(x / LOAD_S, 0, 1) * 7.2
        down = np.clip((LOAD_S + 0.8 - x) / 0.5, 0, 1)
        force_n = np.maximum(force_n, up * down)
    return force_n


@dataclass
class Made:
    """A session that was pressed, with the truth."""

    study: Study
    folder: Path
    record: SessionRecord
    starts_s: dict[tuple[int, int], float]


def study_in(folder: Path) -> Study:
    (folder / "study.toml").write_text(STUDY)
    return load_study(folder / "study.toml")


@pytest.fixture
def study(tmp_path: Path) -> Study:
    return study_in(tmp_path)


def pressed(
    study: Study, record: SessionRecord, attempts: list[tuple[int, str, str]], begin_s: float = 2.0, lost: int = 0
) -> dict[tuple[int, int], float]:
    """Press what ``attempts`` say: (number of the press, verdict, decision), and send the samples."""
    emg = Device(record, StreamInfo("emg", ("EDC", "FDS"), "V", 2000.0, facts={"model": "none"}), +30, 0.1)
    force = Device(record, StreamInfo("force", ("force",), "N", 1000.0), -20, 0.2573)
    starts_s: dict[tuple[int, int], float] = {}
    now_s, last = begin_s, 0
    for number, verdict, decision in attempts:
        press = record.plan.presses[number - 1]
        if press.stay != last:
            record.append(Checked(PLACED, press.specimen), now_s)
            now_s, last = now_s + 3, press.stay
        attempt = 1 + sum(press == number for press, _ in starts_s)
        record.append(PressBegun(number, attempt, press.specimen, press.phase, press.repetition, press.stay), now_s)
        record.append(Commanded("start", number, attempt), now_s)
        record.append(Commanded("stop", number, attempt), now_s + 2.9)
        how = "aborted" if decision == "abort" else "complete"
        record.append(PressEnded(number, attempt, now_s + 0.3, now_s + 3.8, how, 7.2), now_s + 3.8)
        problems = (("too fast", "press more slowly"),) if verdict == "rejected" else ()
        record.append(Judged(number, attempt, verdict, problems, {"load_s": 2.3}), now_s + 4.5)
        if decision not in ("", "abort"):
            record.append(Decided(number, attempt, decision), now_s + 4.6)
        record.append(Commanded("rest"), now_s + 4.7)
        starts_s[number, attempt] = now_s
        now_s += PRESS_S
    end_s = now_s + 2
    rng = np.random.default_rng(7)
    times_s = emg.times_s(end_s)
    newton = np.maximum(force_at(times_s + 1e-9, list(starts_s.values())), 0.3)
    level_v = 30e-6 + 12e-6 * np.log(newton)
    carrier = rng.normal(size=(times_s.size, 2))
    emg.send(carrier * level_v[:, None] * 0.6, slice(4000, 4000 + lost))
    times_s = force.times_s(end_s)
    force.send((force_at(times_s, list(starts_s.values())) + 0.01 * rng.normal(size=times_s.size))[:, None])
    return starts_s


def begun(study: Study, participant: str = "P01") -> SessionRecord:
    presses = draw_presses(study.name, participant, [s.name for s in study.specimens], study.session)
    plan = Plan(study.name, participant, study.session.seed, "2026-11-23T10:00:00", presses)
    folder = session_folder(study.data, participant, study.task)
    record = new_session(folder, plan, lambda: 0.0, background=False)
    record.append(Begun(participant, study.name, "0.9", "Linux"))
    return record


ALL = [(1, "ok", ""), (2, "ok", ""), (3, "rejected", "repeat"), (3, "warned", ""), (4, "rejected", "abort"),
       (4, "ok", ""), (5, "ok", ""), (6, "rejected", "accept"), (7, "rejected", "skip")]  # fmt: skip


@pytest.fixture(scope="module")
def made_once(tmp_path_factory: pytest.TempPathFactory) -> Made:
    study = study_in(tmp_path_factory.mktemp("made"))
    record = begun(study)
    starts_s = pressed(study, record, ALL)
    record.append(Noted("the participant\tcoughed", 5, 1), starts_s[5, 1] + 2)
    record.append(Paused("operator"), starts_s[5, 1] + 4.8)
    record.append(Ended("completed"), 70)
    record.close()
    return Made(study, record.folder, record, starts_s)


@pytest.fixture
def made(made_once: Made, study: Study) -> Made:
    """The same in a folder of the test's own."""
    shutil.copytree(made_once.study.data, study.data)
    return replace(made_once, study=study, folder=session_folder(study.data, "P01", study.task))


def rows_of(path: Path) -> list[dict[str, str]]:
    with path.open(newline="") as file:
        return list(csv.DictReader(file, delimiter="\t"))


def events_of(recording: Path) -> list[dict[str, str]]:
    return rows_of(recording.with_name(recording.name.replace("_emg.bdf", "_events.tsv")))


def main_files(study: Study) -> list[Path]:
    return sorted((study.data / "sub-P01" / "emg").glob("*_task-press_*_emg.bdf"))


def test_one_recording_for_each_stay_named_as_the_study_looks_for_it(made):
    written = write_dataset(made.folder, made.study)
    names = {path.name for path in written.files}
    assert names == {
        "sub-P01_task-training_acq-T1_emg.bdf", "sub-P01_task-press_acq-S1_emg.bdf", "sub-P01_task-press_acq-S3_emg.bdf"
    }  # fmt: skip
    assert written.left_out == ()
    assert any("note" in note for note in written.notes)
    for entry in made.study.recordings:
        assert entry.emg_file.exists() == (entry.participant == "P01")


def test_events_say_what_happened_and_when(made):
    written = write_dataset(made.folder, made.study)
    press = made.record.plan.presses[2]
    own = next(path for path in written.files if f"acq-{press.specimen}_" in path.name)
    rows = events_of(own)
    presses = [row for row in rows if row["trial_type"] == "press"]
    found = {(int(row["press"]), int(row["attempt"])): row for row in presses}
    assert found[3, 1]["counts"] == "false"
    assert found[3, 1]["reason"] == "operator: repeat: too fast"
    assert found[3, 2] | {"counts": "true", "verdict": "warned", "decision": "n/a"} == found[3, 2]
    assert (found[4, 1]["counts"], found[4, 1]["reason"]) == ("false", "aborted: too fast")
    apart_s = float(found[4, 2]["onset"]) - float(found[3, 1]["onset"])
    assert apart_s == pytest.approx((made.starts_s[4, 2] - made.starts_s[3, 1]) * (1 + 30e-6), abs=2e-6)
    assert {row["trial_type"] for row in rows} >= {"command_start", "command_stop", "press", "rest"}
    everything = [row for path in written.files for row in events_of(path)]
    assert {row["note"] for row in everything} >= {"the participant coughed"}
    assert {row["trial_type"] for row in everything} >= {"pause", "operator_note"}
    described = json.loads(own.with_name(own.name.replace("_emg.bdf", "_events.json")).read_text())
    assert set(rows[0]) <= set(described)


def test_the_validator_finds_no_error(made):
    program = shutil.which("bids-validator-deno", path=str(Path(sys.executable).parent))
    if program is None:
        pytest.skip("bids-validator-deno is not installed (extra 'test')")
    write_dataset(made.folder, made.study)
    done = subprocess.run(
        [program, str(made.study.data), "--format", "json"], capture_output=True, text=True, timeout=300
    )
    issues = json.loads(done.stdout)["issues"]["issues"]
    assert [issue for issue in issues if issue["severity"] == "error"] == []
    # what nobody has: tags of events (HED), a source of the sources, and a name for a columns' file of its own
    assert {issue.get("subCode") for issue in issues} <= NOT_TO_BE_MET, issues
    assert len(main_files(made.study)) == 2


def test_what_is_stated_of_devices_and_electrodes_stands_where_bids_wants_it(made):
    write_dataset(made.folder, made.study)
    folder = made.study.data / "sub-P01" / "emg"
    told = json.loads((folder / "sub-P01_task-press_acq-S1_emg.json").read_text())
    assert (told["Manufacturer"], told["ManufacturersModelName"]) == ("Delsys", "Bagnoli")
    assert told["HardwareFilters"]["Band of EDC"] == {"High-pass cut-off (Hz)": 20, "Low-pass cut-off (Hz)": 450}
    channels = rows_of(folder / "sub-P01_task-press_acq-S1_channels.tsv")
    electrodes = rows_of(folder / "sub-P01_electrodes.tsv")
    pairs = {name for row in channels if row["type"] == "EMG" for name in (row["signal_electrode"], row["reference"])}
    assert {row["name"] for row in electrodes} == pairs
    assert [(row["x"], row["y"]) for row in electrodes] == [
        ("0.0", "0.0"),
        ("10.0", "0.0"),
        ("0.0", "5.0"),
        ("10.0", "5.0"),
    ]
    assert {row["type"] for row in electrodes} == {"bar"}
    system = json.loads((folder / "sub-P01_space-forearm_coordsystem.json").read_text())
    assert (system["EMGCoordinateSystem"], system["EMGCoordinateUnits"]) == ("Other", "mm")


def test_what_nobody_stated_of_electrodes_is_not_made_up(made):
    session = replace(made.study.session, places=None, about=SessionAbout())
    write_dataset(made.folder, replace(made.study, session=session))
    folder = made.study.data / "sub-P01" / "emg"
    assert {(row["x"], row["type"]) for row in rows_of(folder / "sub-P01_electrodes.tsv")} == {("n/a", "n/a")}
    system = json.loads((folder / "sub-P01_space-forearm_coordsystem.json").read_text())
    assert (system["EMGCoordinateUnits"], system["EMGCoordinateSystemDescription"][:24]) == (
        "n/a",
        "Positions were not state",
    )
    told = json.loads((folder / "sub-P01_task-press_acq-S1_emg.json").read_text())
    assert (told["Manufacturer"], told["HardwareFilters"]) == ("n/a", "n/a")


def test_written_again_every_file_has_the_same_bytes_and_the_originals_stay(made):
    originals = {path: path.read_bytes() for path in made.folder.iterdir()}
    refuse_foreign(made.folder, made.study, "P01")
    write_dataset(made.folder, made.study)
    refuse_foreign(made.folder, made.study, "P01")
    first = {path: path.read_bytes() for path in made.study.data.rglob("*") if path.is_file()}
    write_dataset(made.folder, made.study)
    assert {path: path.read_bytes() for path in made.study.data.rglob("*") if path.is_file()} == first
    assert {path: path.read_bytes() for path in originals} == originals


def test_presses_that_do_not_count_are_rejected_and_told(made):
    write_dataset(made.folder, made.study)
    said: dict[str, list[str]] = {}
    counted = 0
    for entry in made.study.recordings[:2]:
        trials = trials_of(
            entry.emg_file, None, "P01", entry.specimen, channels=entry.channels, filters=entry.filters,
            window=entry.window, cocontraction=made.study.cocontraction,
        )  # fmt: skip
        said[entry.specimen] = [reason.split("; ")[0] for reason in trials.reasons]
        counted += int(np.sum(trials.verdict != "rejected"))
        assert trials.peak_force_n.min() > 7.0
    reasons = sorted(reason for own in said.values() for reason in own if ":" in reason)
    assert reasons == ["operator: repeat: too fast", "operator: skip: too fast", "session: aborted: too fast"]
    assert counted == 5


def test_events_of_other_programs_change_nothing(made):
    write_dataset(made.folder, made.study)
    entry = made.study.recordings[0]
    path = session_events(entry.emg_file)
    assert path is not None
    path.write_text(path.read_text().replace("decision", "decided", 1))
    assert session_events(entry.emg_file) is None
    assert session_events(entry.emg_file.with_name("other.csv")) is None


@pytest.mark.parametrize(("old", "new"), [("\ttrue\t", "\tyes\t"), ("\tpress\t", "\tpress"), ("press", "press\tx")])
def test_events_that_cannot_be_read_are_told_with_their_line(made, old, new):
    write_dataset(made.folder, made.study)
    path = session_events(made.study.recordings[0].emg_file)
    lines = path.read_text().splitlines(keepends=True)
    at = next(i for i, line in enumerate(lines) if "\tpress\t" in line and "\ttrue\t" in line)
    lines[at] = lines[at].replace(old, new, 1)
    path.write_text("".join(lines))
    if old == "\tpress\t":
        assert len(session_presses(path)) < sum("\tpress\t" in line for line in lines) + 1
        return
    with pytest.raises(RecordingError, match=rf"events.tsv, line {at + 1}.*counts true or false.*Correct the line"):
        session_presses(path)


def test_a_known_moment_is_found_in_both_streams_within_a_sample_over_ten_minutes(study):
    """EMG at +30 ppm and force at -20 ppm: 50 ppm apart, 30 ms in ten minutes."""
    record = begun(study)
    emg = Device(record, StreamInfo("emg", ("EDC", "FDS"), "V", 2000.0), +30, 0.1)
    force = Device(record, StreamInfo("force", ("force",), "N", 1000.0), -20, 0.2573)
    moments_s = np.array([5.0, 100.1234, 350.777, 598.7])
    record.append(Checked(PLACED, "T1"), 2.0)
    record.append(PressBegun(1, 1, "T1", "training", 1, 1), 4.0)
    record.append(PressEnded(1, 1, 4.5, 600.0), 600.0)
    record.append(Judged(1, 1, "ok"), 600.1)
    for device, width in ((emg, 2), (force, 1)):
        times_s = device.times_s(604)
        bumps = np.exp(-0.5 * ((times_s[:, None] - moments_s) / 0.01) ** 2).sum(axis=1)
        device.send(np.repeat(bumps[:, None], width, axis=1))
    record.close()
    written = write_dataset(record.folder, study)
    file = edfio.read_bdf(written.files[0])
    found_s = {}
    for signal in file.signals:
        times_s = np.arange(signal.data.size) / signal.sampling_frequency
        around = [np.abs(times_s - (moment - 2.0)) < 0.2 for moment in moments_s]
        found_s[signal.label] = np.array(
            [np.sum(times_s[a] * np.abs(signal.data[a])) / np.sum(np.abs(signal.data[a])) for a in around]
        )
    assert [signal.label for signal in file.signals] == ["EDC", "FDS right", "Fz"]
    assert file.signals[0].sampling_frequency == pytest.approx(2000, rel=1e-6)
    apart = np.abs(found_s["Fz"] - found_s["EDC"]) * 2000
    assert apart.max() < 1.0, apart
    onsets = (moments_s - 2.0) * (1 + 30e-6)
    assert np.abs(found_s["EDC"] - onsets).max() * 2000 < 3.0, (found_s["EDC"] - onsets) * 2000


def test_a_session_that_was_interrupted_becomes_numbered_recordings(study):
    record = begun(study)
    pressed(study, record, ALL[:3])
    record.close()
    first = write_dataset(record.folder, study)
    assert any("_run-" not in path.name and "task-press" in path.name for path in first.files)
    again = resume_session(record.folder, lambda: 0.0, background=False)
    again.append(Begun("P01", "small", "0.9", "Linux", resumed=True))
    pressed(study, again, ALL[3:])
    again.close()
    written = write_dataset(record.folder, study)
    specimen = record.plan.presses[1].specimen
    own = sorted(path.name for path in main_files(study) if f"acq-{specimen}_" in path.name)
    assert own == [f"sub-P01_task-press_acq-{specimen}_run-{n}_emg.bdf" for n in (1, 2)]
    assert set(main_files(study)) <= set(written.files)
    assert not list((study.data / "sub-P01" / "emg").glob(f"*_task-press_acq-{specimen}_events.tsv"))
    entry = next(e for e in load_study(study.path).recordings if (e.participant, e.specimen) == ("P01", specimen))
    assert len(entry.parts) == 2
    scans = rows_of(study.data / "sub-P01" / "sub-P01_scans.tsv")
    assert sorted(row["filename"] for row in scans) == sorted(f"emg/{path.name}" for path in written.files)


def test_lost_samples_are_gaps(study):
    record = begun(study)
    starts_s = pressed(study, record, [(1, "ok", "")], begin_s=1.0, lost=400)
    record.close()
    written = write_dataset(record.folder, study)
    rows = events_of(written.files[0])
    gap = next(row for row in rows if row["trial_type"] == "gap")
    assert float(gap["duration"]) == pytest.approx(0.2, abs=1e-3)
    assert float(gap["onset"]) == pytest.approx(0.1 + 4000 / 2000 - 1.0, abs=2e-3)
    assert starts_s
    assert any("400 samples of the EMG are lost" in note for note in written.notes)
    path = session_events(written.files[0])
    assert path is not None
    first = round(float(gap["onset"]) * 2000)
    for stream, n in (("EMG", 400), ("force", 0)):
        channel = with_gaps(path, stream, Channel("A", np.zeros(20_000), "V", 2000.0, 0.0, ""))
        missing = np.isnan(channel.samples)
        assert missing.sum() == n
        assert missing[first : first + n].all()


def test_recordings_that_no_session_wrote_are_never_replaced(made):
    target = made.study.recordings[0].emg_file
    target.parent.mkdir(parents=True)
    target.write_bytes(b"precious")
    with pytest.raises(DataError, match=r"acq-S1_emg.bdf.*one that this session did not write.*Move it away"):
        write_dataset(made.folder, made.study)
    assert target.read_bytes() == b"precious"
    with pytest.raises(DataError, match=r"one that this session did not write"):
        refuse_foreign(made.folder, made.study, "P01")
    refuse_foreign(made.folder, made.study, "P02")
    assert [path.name for path in target.parent.iterdir()] == [target.name]


def test_rows_of_other_people_stay(made):
    table = made.study.data / "participants.tsv"
    table.write_text("participant_id\tage\nsub-P09\t31\n")
    write_dataset(made.folder, made.study)
    assert table.read_text() == "participant_id\tage\nsub-P09\t31\nsub-P01\tn/a\n"
    table.write_text("age\tparticipant_id\n31\tsub-P09\n")
    with pytest.raises(DataError, match=r"participants.tsv.*columns participant_id"):
        write_dataset(made.folder, made.study)


def without_force(made):
    (made.folder / "sitting-1_force.samples").unlink()


def study_text(*changes):
    return lambda made: made.study.path.write_text(reduce(lambda text, change: text.replace(*change), changes, STUDY))


SHARES = "[simulation]\nmuscle_share = { EDC = 0.4, FCR = 0.6 }\n"
LEFT_OUT = {
    "expected force from .* no samples": without_force,
    r"expected the muscle FCR of \[channels.emg\], but found EDC, FDS": study_text(
        ("FDS]", "FCR]"), ("FDS = [[0", "FCR = [[0"), ("[simulation]\n", SHARES)
    ),
    r"Put the code back into \[participants\]": study_text(('"P01", ', "")),
}


@pytest.mark.parametrize("why", LEFT_OUT)
def test_a_stay_that_cannot_be_cut_out_is_left_out_and_told(made, why):
    LEFT_OUT[why](made)
    written = write_dataset(made.folder, load_study(made.study.path))
    assert written.files == ()
    assert len(written.left_out) == 3
    assert all(re.search(why, said) for _, said in written.left_out)
    gone = not (made.folder / "sitting-1_force.samples").exists()
    assert any("force.samples" in note and "No such file" in note for note in written.notes) == gone


REFUSED = {
    r"written.json.*no list of names.*session finish": lambda made: (made.folder / "written.json").write_text("{}"),
    r"participants.tsv.*a tab-separated table in UTF-8": lambda made: (
        made.study.data / "participants.tsv"
    ).write_bytes(b"participant_id\n\xff\xfe"),
    r"a table \[session\]": lambda made: made.study.path.write_text(STUDY.split("[session]")[0]),
}


@pytest.mark.parametrize("said", REFUSED)
def test_what_cannot_be_written_is_refused(made, said):
    REFUSED[said](made)
    with pytest.raises((DataError, SettingError), match=said):
        write_dataset(made.folder, load_study(made.study.path))


def test_data_records_keep_the_ratio_of_the_rates_and_end_soon_after_the_stay():
    rng = np.random.default_rng(3)
    for emg_hz in (1000.0, 2000.0, 1925.92592592593):
        for stated in (200.0, 1000.0, 148.148148):
            for stay_s in (6.0, 90.0, 300.0):
                force_hz = stated * (1 + rng.normal() * 10 ** rng.uniform(-7, -4))
                length_s, n_emg, n_force = data_record(emg_hz, force_hz, stay_s)
                drift = abs(n_force / n_emg / (force_hz / emg_hz) - 1) * stay_s * max(emg_hz, force_hz)
                assert drift < 0.51
                assert -(-stay_s // length_s) * length_s - stay_s < 1.51
                assert len(f"{length_s:g}") <= 8
    assert data_record(1000.0, 1000.0, 60.0) == (1.0, 1000, 1000)


def test_of_two_attempts_that_count_the_last_one_stands_for_the_press(study):
    record = begun(study)
    pressed(study, record, [(1, "ok", ""), (2, "ok", ""), (3, "ok", ""), (3, "warned", ""), (4, "ok", "")])
    record.append(Ended("completed"), 60)
    record.close()
    write_dataset(record.folder, study)
    files = sorted(study.data.rglob("*_events.tsv"))
    rows = [row for file in files for row in rows_of(file) if row["trial_type"] == "press" and row["press"] == "3"]
    assert [(row["counts"], row["reason"]) for row in rows] == [("false", "superseded by attempt 2"), ("true", "n/a")]


def test_a_session_without_a_complete_press(study):
    record = begun(study)
    pressed(study, record, [(1, "rejected", "abort")])
    record.close()
    written = write_dataset(record.folder, study)
    assert written.files == written.left_out == ()
    assert any("No complete press was recorded" in note for note in written.notes)

"""Own recordings as BIDS-EMG: valid, complete, and read back as they were."""

from __future__ import annotations

import csv
import errno
import json
import os
import shutil
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from emg2vsa.cli import main
from emg2vsa.readers.front_door import read
from emg2vsa.readers.roles import read_roles
from emg2vsa.settings import SimulationSettings
from emg2vsa.study_file import load_study
from emg2vsa.worlds.people.recording import RecordingStream
from tests.small import study_of_files

STUDY = study_of_files(
    "{participant}_{specimen}_{repetition}.csv", name="mine", participants=("anna_k", "ben"), specimens=["foam"],
    emg='[channels.emg.EDC]\nname = "EMG 1"\ngain = 1000\n[channels.emg.FDS]\nname = "EMG 2"\ngain = 1000\n',
    force='name = "Fz"\nunit = "kgf"\nsign = -1\n',
)  # fmt: skip


def recording(path: Path, seed: int, fs_hz: float = 1000.0, hole: int = 0) -> None:
    made = RecordingStream(
        np.random.SeedSequence(seed), SimulationSettings(repetitions=2, fs_hz=fs_hz), a_v=4e-5, b_v=2e-5,
        window_n=(0.5, 7),
    ).whole()  # fmt: skip
    edc = 1e6 * made.emg_v["EDC"]
    edc[500 : 500 + hole] = np.nan
    time = np.arange(edc.size) / fs_hz
    table = np.column_stack([time, edc, 1e6 * made.emg_v["FDS"], made.force_n / -9.80665])
    np.savetxt(path, table[:-7], "%.10g", ",", header="time (s),EMG 1 (mV),EMG 2 (mV),Fz", comments="")


@pytest.fixture(scope="module")
def converted(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("own")
    recording(folder / "anna_k_foam_1.csv", 1)
    recording(folder / "anna_k_foam_2.csv", 2, hole=30)
    recording(folder / "ben_foam_7.csv", 3, fs_hz=1 / 0.0135 * 26)
    (folder / "study.toml").write_text(STUDY)
    (folder / "about.json").write_text('{"Manufacturer": "Delsys", "ManufacturersModelName": "Bagnoli-4"}')
    words = ["--mains", "50", "--electrode-distance", "10", "--about", str(folder / "about.json")]
    assert main(["tools", "convert", str(folder / "study.toml"), "--out", str(folder / "bids"), *words, "--json"]) == 0
    return folder


def test_the_validator_finds_no_error(converted: Path) -> None:
    program = shutil.which("bids-validator-deno", path=str(Path(sys.executable).parent))
    if program is None:
        pytest.skip("bids-validator-deno is not installed (extra 'test')")
    done = subprocess.run(
        [program, str(converted / "bids"), "--format", "json"], capture_output=True, text=True, timeout=300
    )
    issues = json.loads(done.stdout)["issues"]["issues"]
    assert issues
    assert [issue for issue in issues if issue["severity"] == "error"] == []


def table(path: str) -> list[dict[str, str]]:
    with Path(path).open(newline="") as file:
        return list(csv.DictReader(file, delimiter="\t"))


def test_recordings_without_events_have_no_table_of_them(tmp_path: Path) -> None:
    time = np.arange(2000) / 1000
    np.savetxt(tmp_path / "rest.csv", np.column_stack([time, np.sin(99 * time), 0 * time]), delimiter=",",
               header="time (s),EMG 1 (mV),Fz (N)", comments="")  # fmt: skip
    asked = ["tools", "convert", str(tmp_path / "rest.csv"), "--emg", "EMG 1", "--force", "Fz", "--out"]
    assert main([*asked, str(tmp_path / "bids"), "--participant", "P1"]) == 0
    assert not list((tmp_path / "bids").rglob("*_events.*"))


def test_side_files_say_what_is_known(converted: Path) -> None:
    stem = converted / "bids" / "sub-annak" / "emg" / "sub-annak_task-palpation_acq-foam_run-2"
    emg = json.loads(Path(f"{stem}_emg.json").read_text())
    assert (emg["PowerLineFrequency"], emg["InterelectrodeDistance"], emg["Manufacturer"]) == (50, 10, "Delsys")
    assert (emg["SamplingFrequency"], emg["EMGChannelCount"], emg["MiscChannelCount"]) == (1000, 2, 1)
    rows = table(f"{stem}_channels.tsv")
    assert [(row["name"], row["type"], row["units"]) for row in rows] == [
        ("EDC", "EMG", "uV"), ("FDS", "EMG", "uV"), ("Fz", "MISC", "N"),
    ]  # fmt: skip
    assert rows[0]["target_muscle"] == "extensor digitorum communis"
    assert rows[0]["interelectrode_distance"] == "10"
    assert "gain 1000" in rows[0]["description"]
    events = table(f"{stem}_events.tsv")
    assert [event["trial_type"] for event in events] == ["gap", "press", "press"]
    assert (float(events[0]["onset"]), float(events[0]["duration"])) == (0.5, 0.03)
    assert [event["repetition"] for event in events[1:]] == ["1", "2"]


def test_what_is_read_back_is_what_was_recorded(converted: Path) -> None:
    study = load_study(converted / "study.toml")
    for entry in study.recordings:
        for number, part in enumerate(entry.parts, 1):
            roles = read_roles(part.emg_file, None, part.channels)
            subject = entry.participant.replace("_", "")
            run = f"_run-{number}" if len(entry.parts) > 1 else ""
            name = f"sub-{subject}/emg/sub-{subject}_task-palpation_acq-foam{run}_emg.bdf"
            back = read(converted / "bids" / name, ["EDC", "FDS", "Fz"])
            for own, stored in zip((*roles.emg.values(), roles.force), back.channels, strict=True):
                assert stored.fs_hz == pytest.approx(own.fs_hz, rel=1e-6)
                known = np.isfinite(own.samples)
                n, largest = own.samples.size, np.nanmax(np.abs(own.samples))
                assert 0 <= stored.samples.size - n < 2 * own.fs_hz
                error = np.abs(stored.samples[:n] - own.samples)[known].max()
                assert error < 1e-7 * 1.1 * largest  # 24 bits over a symmetric range of two digits
    again = STUDY.replace("anna_k", "annak").replace(
        'layout = "pattern"', 'layout = "bids"\nroot = "bids"\ntask = "palpation"'
    )
    again = again.replace('pattern = "{participant}_{specimen}_{repetition}.csv"', "").replace("gain = 1000", "")
    again = again.replace('"EMG 1"', '"EDC"').replace('"EMG 2"', '"FDS"').replace('unit = "kgf"\nsign = -1', "")
    (converted / "again.toml").write_text(again)
    assert [len(entry.parts) for entry in load_study(converted / "again.toml").recordings] == [2, 1]


def test_activity_as_a_share_of_mvc_leaves_the_events_as_they_are(converted: Path, tmp_path: Path) -> None:
    for name in ("ben_foam_7.csv", "ben_mvc.csv"):
        shutil.copy(converted / "ben_foam_7.csv", tmp_path / name)
    mvc = '[cocontraction]\nnormalise = "mvc"\n[[mvc]]\nparticipant = "ben"\nemg = "ben_mvc.csv"\n'
    (tmp_path / "study.toml").write_text(STUDY.replace('"anna_k", ', "") + mvc)
    assert main(["tools", "convert", str(tmp_path / "study.toml"), "--out", str(tmp_path / "b")]) == 0
    name = "sub-ben/emg/sub-ben_task-palpation_acq-foam_events.tsv"
    assert (tmp_path / "b" / name).read_text() == (converted / "bids" / name).read_text()


def test_events_have_the_verdicts_that_count(converted: Path, tmp_path: Path) -> None:
    """Of fits and of people: press 3 of all is the first of the second file; a limit of the fits rejects all."""
    words = ["participant", "specimen", "repetition", "reason"]
    entry = dict(zip(words, ('"anna_k"', '"foam"', "3", '"sneezed"'), strict=True))
    extra = "".join(f"{key} = {value}\n" for key, value in entry.items())
    study = STUDY.replace('pattern = "', f'pattern = "{converted.as_posix()}/')
    (tmp_path / "study.toml").write_text(f"{study}[fit]\nmax_b_error_ratio = 0.001\n[[exclude]]\n{extra}")
    assert main(["tools", "convert", str(tmp_path / "study.toml"), "--out", str(tmp_path / "bids")]) == 0
    found = []
    for run in (1, 2):
        rows = table(f"{tmp_path}/bids/sub-annak/emg/sub-annak_task-palpation_acq-foam_run-{run}_events.tsv")
        found += [(row["verdict"], row["reason"]) for row in rows if row["trial_type"] == "press"]
    assert [verdict for verdict, _ in found] == ["rejected"] * 4
    assert ["excluded by hand: sneezed" in reason for _, reason in found] == [False, False, True, False]
    assert all("times less certain than the others" in reason for _, reason in found)


def test_one_file(converted: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    file = str(converted / "ben_foam_7.csv")
    words = ["--emg", "EMG 1", "--force", "Fz", "--force-unit", "kgf", "--sign", "-1", "--participant", "ben"]
    assert main(["tools", "convert", file, "--out", str(tmp_path / "b"), *words]) == 0
    assert (tmp_path / "b/sub-ben/emg/sub-ben_task-palpation_emg.bdf").exists()
    assert "1 recording in" in capsys.readouterr().out


def test_a_channel_between_two_samples_is_moved_and_told(
    converted: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    time = np.arange(2000) / 100 + 0.0123
    force = np.column_stack([time, 3 - 3 * np.cos(time)])
    np.savetxt(tmp_path / "f.csv", force, "%.9g", ",", header="time (s),F (N)", comments="")
    words = ["--emg", "EMG 1", "--force", "F", "--force-file", str(tmp_path / "f.csv"), "--participant", "ben"]
    assert main(["tools", "convert", str(converted / "anna_k_foam_1.csv"), "--out", str(tmp_path / "b"), *words]) == 0
    moved = "moved by -2.3 ms, to its nearest sample"
    assert f"F: {moved}" in capsys.readouterr().out
    rows = table(f"{tmp_path}/b/sub-ben/emg/sub-ben_task-palpation_channels.tsv")
    assert rows[1]["status_description"] == f"the first 1 samples repeat the first one recorded; {moved}"
    assert rows[0]["status_description"] == "n/a"


def test_rates_that_share_no_record_become_two_files(tmp_path: Path) -> None:
    rng = np.random.default_rng(0)
    for name, rate, head in (("e", 999.937, "EMG (mV)"), ("f", 148.1484, "Fz (N)")):
        time = np.arange(int(8 * rate)) / rate
        table = np.column_stack([time, rng.normal(0, 1, time.size)])
        np.savetxt(tmp_path / f"{name}.csv", table, "%.9g", ",", header=f"time (s),{head}", comments="")
    words = ["--emg", "EMG", "--force", "Fz", "--force-file", str(tmp_path / "f.csv"), "--participant", "p"]
    assert main(["tools", "convert", str(tmp_path / "e.csv"), "--out", str(tmp_path / "b"), *words]) == 0
    names = sorted(path.name for path in (tmp_path / "b/sub-p/emg").glob("*.bdf"))
    assert names == [f"sub-p_task-palpation_recording-rate{n}_emg.bdf" for n in (1, 2)]


def test_nothing_is_overwritten(converted: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["tools", "convert", str(converted / "study.toml"), "--out", str(converted / "bids")]) == 2
    assert "expected an empty or absent folder" in capsys.readouterr().err


def test_a_bad_recording_costs_itself_only(converted: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (tmp_path / "study.toml").write_text(STUDY)
    for name in ("anna_k_foam_1.csv", "anna_k_foam_2.csv"):
        shutil.copy(converted / name, tmp_path / name)
    (tmp_path / "ben_foam_1.csv").write_text("")
    assert main(["tools", "convert", str(tmp_path / "study.toml"), "--out", str(tmp_path / "b")]) == 1
    said = capsys.readouterr()
    assert "not converted: ben/foam: " in said.err
    assert "2 recordings in" in said.out


def test_a_full_disk_leaves_nothing_and_is_told_with_the_folder(
    converted: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    words = ["tools", "convert", str(converted / "study.toml"), "--out", str(tmp_path / "b")]
    (tmp_path / "b").mkdir()
    with monkeypatch.context() as patched:
        calls: list[Path] = []

        def full(path: Path, *content: object) -> None:
            calls.append(path)
            if len(calls) == 3:
                raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))
            path.parent.mkdir(parents=True, exist_ok=True)
            path.touch()

        patched.setattr("emg2vsa.bids.recording_files.write_json", full)
        assert main(words) == 2
    assert f"{tmp_path / 'b'}: expected a folder with room" in (said := capsys.readouterr().err)
    assert "No space left on device" in said
    assert list((tmp_path / "b").iterdir()) == []
    (tmp_path / "b" / ".unfinished").mkdir()  # as a killed conversion leaves it
    assert main(words) == 0
    assert sorted(path.name for path in (tmp_path / "b").iterdir()) == sorted(
        path.name for path in (converted / "bids").iterdir()
    )

"""The folder of a session: what is done, what is interrupted, and who holds it."""

from __future__ import annotations

import json
import os
import stat
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from emg2vsa.devices.simulated import SimulatedEmgSettings, SimulatedForceSettings
from emg2vsa.devices.streams import Block, StreamInfo
from emg2vsa.errors import DataError, DeviceError, SettingError
from emg2vsa.session.dataset import write_dataset
from emg2vsa.session.journal import (
    JOURNAL_FILE,
    Begun,
    Decided,
    Ended,
    Interrupted,
    Judged,
    Noted,
    PressAdded,
    PressBegun,
    PressEnded,
    StreamOpened,
    Told,
    read_journal,
)
from emg2vsa.session.plan import Plan, draw_presses
from emg2vsa.session.presses import Presses, folded
from emg2vsa.session.raw_files import SampleFile
from emg2vsa.session.record import SessionRecord, new_session, resume_session
from emg2vsa.session_settings import SessionSettings

SETTINGS = SessionSettings(
    emg=SimulatedEmgSettings(),
    force=SimulatedForceSettings(),
    training_specimens=("T1",),
    training_repetitions=1,
    repetitions=2,
)
EMG = StreamInfo("emg", ("EDC", "FDS"), "V", 1000.0, facts={"device": "none"})


def a_plan(participant: str = "P03") -> Plan:
    presses = draw_presses("palpation", participant, ("S1", "S2", "S3"), SETTINGS)
    return Plan("palpation", participant, 1, "2026-11-23T10:00:00+01:00", presses)


def begin(record: SessionRecord, number: int, attempt: int = 1) -> None:
    press = record.plan.presses[number - 1]
    record.append(PressBegun(number, attempt, press.specimen, press.phase, press.repetition, press.stay))


def presses(record: SessionRecord) -> Presses:
    """As the journal on the disk has them."""
    assert record.wait()
    return folded(read_journal(record.folder / JOURNAL_FILE)[0], record.plan.presses)


def finish(record: SessionRecord, number: int, attempt: int = 1, verdict: str = "ok") -> None:
    record.append(PressEnded(number, attempt, 1.0, 2.0, peak_n=7.1, load_s=2.0))
    record.append(Judged(number, attempt, verdict, (("too fast", "slower"),), {"b": float("nan")}))


def a_session(tmp_path: Path) -> SessionRecord:
    return new_session(tmp_path / "sub-P03", a_plan(), lambda: 0.0)


def resumed(tmp_path: Path) -> SessionRecord:
    return resume_session(tmp_path / "sub-P03", lambda: 0.0)


@pytest.mark.slow
@pytest.mark.skipif(os.name != "posix", reason="permissions of POSIX")
def test_only_their_owner_reads_the_files_of_a_session_also_when_it_was_resumed_and_written(play):
    old = os.umask(0)
    try:
        for resume in (False, True):
            played = play(session="repetitions = 2", resume=resume, most_presses=1)
        write_dataset(played.folder, played.study)
    finally:
        os.umask(old)
    modes = {path.name: stat.filemode(path.stat().st_mode) for path in (played.folder, *played.folder.iterdir())}
    assert modes.pop(played.folder.name) == "drwx------"
    assert set(modes) >= {"plan.json", "journal.jsonl", ".lock", "written.json", "sitting-1_emg.samples"}
    assert set(modes.values()) == {"-rw-------"}


def test_a_session_goes_on_at_the_first_press_that_is_not_done(tmp_path):
    record = a_session(tmp_path)
    record.append(Begun("P03", "palpation", "emg2vsa 0", "a computer"))
    begin(record, 1)
    finish(record, 1)
    begin(record, 2)
    finish(record, 2, verdict="rejected")
    assert presses(record).next.number == 2
    record.append(Decided(2, 1, "repeat"))
    assert presses(record).next.number == 2
    begin(record, 2, 2)
    finish(record, 2, 2, "warned")
    begin(record, 3)
    finish(record, 3, verdict="rejected")
    record.append(Decided(3, 1, "accept"))
    begin(record, 4)
    record.append(PressEnded(4, 1, 1.0, 1.5, "aborted"))
    begin(record, 4, 2)
    record.close()

    again = resumed(tmp_path)
    assert again.sitting == 2
    assert again.plan == a_plan()
    assert presses(again).next.number == 4
    aborted, interrupted = presses(again).tried[-2:]
    assert (aborted.key, aborted.over, aborted.complete, aborted.interrupted) == ((4, 1), True, False, False)
    assert (interrupted.key, interrupted.interrupted) == ((4, 2), True)
    begin(again, 4, 3)
    finish(again, 4, 3)
    for number in (5, 6):
        begin(again, number)
        finish(again, number, verdict="rejected")
        again.append(Decided(number, 1, "skip"))
    begin(again, 7)
    finish(again, 7)
    assert presses(again).next is None
    again.append(PressAdded(8, "main", "S1", 3, 4, "interval wider than 0.2"))
    assert presses(again).next.number == 8
    again.append(Ended("completed"))
    again.close()
    lines, _ = read_journal(tmp_path / "sub-P03" / "journal.jsonl")
    assert [line.number for line in lines] == list(range(1, len(lines) + 1))
    assert Interrupted(4, 2) in [line.event for line in lines]


@pytest.mark.parametrize("torn", [1, 20, 60])
def test_a_torn_last_line_is_cut_off_and_told(tmp_path, torn):
    record = a_session(tmp_path)
    begin(record, 1)
    finish(record, 1)
    record.append(Noted("the last line"))
    record.close()
    path = tmp_path / "sub-P03" / "journal.jsonl"
    whole = path.read_bytes()
    path.write_bytes(whole[:-torn])
    again = resumed(tmp_path)
    _lines, size = read_journal(path)
    assert again.wait()
    assert whole.startswith(path.read_bytes()[: size - 200].rpartition(b"\n")[0])
    again.close()
    events = [line.event for line in read_journal(path)[0]]
    assert isinstance(events[-1], Told)
    assert "was cut off" in events[-1].text
    assert Noted("the last line") not in events
    assert folded(read_journal(path)[0], again.plan.presses).next.number == 2


def test_a_torn_line_of_nothing_but_zeros_is_cut_off(tmp_path):
    record = a_session(tmp_path)
    begin(record, 1)
    record.close()
    path = tmp_path / "sub-P03" / "journal.jsonl"
    with path.open("ab") as file:
        file.write(b"\0" * 90 + b"\n")
    resumed(tmp_path).close()
    assert isinstance(read_journal(path)[0][0].event, PressBegun)


def test_a_damaged_line_before_the_last_is_told_with_its_number(tmp_path):
    record = a_session(tmp_path)
    begin(record, 1)
    record.append(Noted("first"))
    record.append(Noted("second"))
    record.close()
    path = tmp_path / "sub-P03" / "journal.jsonl"
    path.write_bytes(path.read_bytes().replace(b"first", b"fyrst"))
    with pytest.raises(DataError, match=r"journal.jsonl, line 2.*checksum.*Put the file back"):
        resumed(tmp_path)


def test_a_line_of_a_later_version_is_told(tmp_path):
    record = a_session(tmp_path)
    record.close()
    path = tmp_path / "sub-P03" / "journal.jsonl"
    import zlib

    text = '{"line": 1, "sitting": 1, "time_s": 0.0, "at": "", "kind": "sung", "event": {}'
    line = f'{text}, "crc": "{zlib.crc32(text.encode()):08x}"}}\n'
    path.write_text(line * 2)
    with pytest.raises(DataError, match=r"line 1.*this version does not know.*sung"):
        resumed(tmp_path)


def test_two_processes_never_record_one_session(tmp_path):
    record = a_session(tmp_path)
    try:
        with pytest.raises(DataError, match=r"no other process records.*held by process \d+"):
            resumed(tmp_path)
        with pytest.raises(DataError, match="held by process"):
            a_session(tmp_path)
    finally:
        record.close()
    resumed(tmp_path).close()


def test_a_new_session_never_takes_the_place_of_another(tmp_path):
    a_session(tmp_path).close()
    with pytest.raises(DataError, match=r"without a session of this task.*2026-11-23.*--resume"):
        a_session(tmp_path)


@pytest.mark.parametrize("made", [False, True])
def test_no_session_to_resume(tmp_path, made):
    if made:
        (tmp_path / "sub-P03").mkdir()
    with pytest.raises(DataError, match=r"a session to resume.*without --resume"):
        resumed(tmp_path)


def test_a_damaged_plan_is_told(tmp_path):
    a_session(tmp_path).close()
    path = tmp_path / "sub-P03" / "plan.json"
    content = json.loads(path.read_text())
    del content["presses"][0]["stay"]
    path.write_text(json.dumps(content))
    with pytest.raises(DataError, match=r"plan.json.*the plan of a session.*stay.*copy"):
        resumed(tmp_path)


@pytest.mark.parametrize("name", ["Mario Rossi", "mario", "P03/../P04", "", "Mariangela1"])
def test_a_name_is_no_code(tmp_path, name):
    with pytest.raises(SettingError, match=r"a code: at most four letters and then a number.*names apart"):
        new_session(tmp_path / "x", replace(a_plan(), participant=name), lambda: 0.0)
    assert not (tmp_path / "x").exists()


def test_samples_are_read_as_they_were_written_with_what_is_lost(tmp_path):
    record = a_session(tmp_path)
    stream = record.open_stream("emg", EMG)
    rng = np.random.default_rng(5)
    parts = {0: rng.normal(size=(40, 2)), 40: rng.normal(size=(7, 2)), 60: rng.normal(size=(20, 2))}
    for first, samples in parts.items():
        assert stream.append(Block(samples, first, first / 1000))
    second = record.open_stream("emg", EMG)
    second.append(Block(np.zeros((3, 2)), 0, 1.0))
    record.close()
    opened = [line.event for line in read_journal(tmp_path / "sub-P03" / "journal.jsonl")[0]]
    assert [event.file for event in opened] == ["sitting-1_emg.samples", "sitting-1_emg-2.samples"]
    assert isinstance(opened[0], StreamOpened)
    assert opened[0].facts == {"device": "none"}
    file = SampleFile(tmp_path / "sub-P03" / "sitting-1_emg.samples")
    assert (file.info, file.stop, file.passed_over) == (EMG, 80, 0)
    assert np.isnan(file.read(0, 80)).any(axis=1).sum() == 13
    assert file.blocks.arrived_s.tolist() == [0.0, 0.04, 0.06]
    samples = file.read(30, 70)
    np.testing.assert_array_equal(samples[:10], parts[0][30:].astype(np.float32))
    np.testing.assert_array_equal(samples[30:], parts[60][:10].astype(np.float32))
    assert np.isnan(samples[17:30]).all()
    assert np.isfinite(samples[:17]).all()


def test_the_devices_own_times_are_kept(tmp_path):
    record = a_session(tmp_path)
    stream = record.open_stream("emg", EMG)
    stream.append(Block(np.zeros((3, 2)), 0, 1.0))
    stream.append(Block(np.ones((2, 2)), 5, 1.1, np.array([1.05, 1.051])))
    record.close()
    file = SampleFile(stream.path)
    assert file.passed_over == 0
    assert stream.path.read_bytes().endswith(np.array([1.05, 1.051]).tobytes())
    np.testing.assert_array_equal(file.read(5, 7), np.ones((2, 2)))


def test_a_file_of_samples_is_readable_wherever_it_was_cut(tmp_path):
    record = a_session(tmp_path)
    stream = record.open_stream("emg", EMG)
    for i in range(5):
        stream.append(Block(np.full((10, 2), i), 10 * i, 0.0))
    record.close()
    path = tmp_path / "sub-P03" / "sitting-1_emg.samples"
    content = path.read_bytes()
    block = 4 + 28 + 80
    head = len(content) - 5 * block
    for size in range(head, len(content), 7):
        path.write_bytes(content[:size])
        file = SampleFile(path)
        assert file.stop == 10 * ((size - head) // block)
        assert file.passed_over == (size - head) % block
    damaged = bytearray(content)
    damaged[head + 2 * block + 50] ^= 1
    path.write_bytes(damaged)
    file = SampleFile(path)
    assert (file.stop, file.passed_over) == (50, block)
    assert np.isnan(file.read(0, 50)[:, 0]).sum() == 10
    for size in (0, 5, head - 1):
        path.write_bytes(content[:size])
        with pytest.raises(DataError, match="a file of samples of a session"):
            SampleFile(path)


def test_a_folder_that_cannot_be_written_to(tmp_path):
    (tmp_path / "file").write_text("")
    with pytest.raises(DeviceError, match="a folder to record to"):
        new_session(tmp_path / "file" / "sub-P03", a_plan(), lambda: 0.0)


def test_a_text_that_cannot_be_written_uses_up_no_line(tmp_path):
    record = a_session(tmp_path)
    begin(record, 1)
    for event in (Noted("\ud83d", 1, 1), Told("\udcff")):
        with pytest.raises(UnicodeEncodeError):
            record.append(event)
    finish(record, 1)
    record.close()
    lines, _ = read_journal(tmp_path / "sub-P03" / "journal.jsonl")
    assert [line.number for line in lines] == [1, 2, 3]
    assert record.is_safe


def test_a_gap_in_the_numbers_is_passed_over_and_told_once(tmp_path):
    record = a_session(tmp_path)
    for text in ("one", "two", "three"):
        record.append(Told(text))
    record.close()
    path = tmp_path / "sub-P03" / "journal.jsonl"
    first, _, third = path.read_bytes().splitlines(keepends=True)
    path.write_bytes(first + third)
    for _ in range(2):
        again = resumed(tmp_path)
        assert again.wait()
        assert again.is_safe
        again.close()
    lines, _ = read_journal(path)
    assert [line.number for line in lines] == [1, 3, 4]
    assert "no line between 1 and 3" in lines[-1].event.text
    path.write_bytes(third + first + third)
    with pytest.raises(DataError, match="line 1 after line 3"):
        read_journal(path)


def test_every_attempt_without_a_verdict_was_interrupted(tmp_path):
    record = a_session(tmp_path)
    begin(record, 1)
    record.append(PressEnded(1, 1, 1.0, 2.0))
    begin(record, 1, 2)
    record.close()
    again = resumed(tmp_path)
    assert [tried.interrupted for tried in presses(again).tried] == [True, True]
    assert presses(again).next.number == 1
    again.close()


def test_a_press_of_which_an_earlier_attempt_counts_is_done(tmp_path):
    record = a_session(tmp_path)
    begin(record, 1)
    finish(record, 1)
    begin(record, 1, 2)
    finish(record, 1, 2, "rejected")
    assert 1 in presses(record).done
    record.append(Decided(1, 2, "accept"))
    assert presses(record).counting == {1: 2}
    record.close()

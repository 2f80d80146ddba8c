"""Names of recordings and of what stands beside them."""

from __future__ import annotations

from pathlib import Path

import pytest

from emg2vsa.bids.names import RecordingName, beside, is_label, label_of, remove_recording


@pytest.mark.parametrize(
    ("name", "stem"),
    [
        (RecordingName("P01", "press"), "sub-P01_task-press"),
        (RecordingName("P01", "press", "S1"), "sub-P01_task-press_acq-S1"),
        (RecordingName("P01", "press", "S1", 2, "rate1"), "sub-P01_task-press_acq-S1_run-2_recording-rate1"),
    ],
)
def test_labels_stand_in_the_order_of_the_standard(name: RecordingName, stem: str) -> None:
    assert name.stem == stem
    assert name.path(Path("data")) == Path(f"data/sub-P01/emg/{stem}_emg.bdf")
    assert beside(name.path(Path("data")), "_events.tsv") == Path(f"data/sub-P01/emg/{stem}_events.tsv")


@pytest.mark.parametrize(("text", "label"), [("anna_k", "annak"), ("S1", "S1"), ("é", ""), ("1-2", "12"), ("²", "")])
def test_a_label_has_letters_and_digits_only(text: str, label: str) -> None:
    assert label_of(text) == label
    assert is_label(text) == (text == label)


def test_a_recording_goes_with_all_of_its_files_and_no_other(tmp_path: Path) -> None:
    endings = ("_emg.bdf", "_emg.json", "_channels.tsv", "_events.tsv", "_events.json", "_run-2_emg.bdf")
    for ending in endings:
        (tmp_path / f"sub-P01_task-press{ending}").touch()
    remove_recording(tmp_path / "sub-P01_task-press_emg.bdf")
    assert [path.name for path in tmp_path.iterdir()] == ["sub-P01_task-press_run-2_emg.bdf"]

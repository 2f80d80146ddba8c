"""The order in which a participant's recordings were made, from the tables that may tell it."""

from __future__ import annotations

from math import nan
from pathlib import Path

import pytest

from emg2vsa.errors import DataError
from emg2vsa.readers.acquisition_order import order_files, places

NAMES = ("S1", "S3", "S5")


def recording(data: Path, person: str, specimen: str) -> Path:
    return data / f"sub-{person}" / "emg" / f"sub-{person}_acq-{specimen}_emg.bdf"


def dataset(data: Path, scans: dict[str, str], order: str = "") -> dict[tuple[str, str], Path]:
    """scans : person to what the file holds below its head."""
    for person, rows in scans.items():
        folder = data / f"sub-{person}"
        (folder / "emg").mkdir(parents=True)
        if rows:
            (folder / f"sub-{person}_scans.tsv").write_text(f"filename\tacq_time\n{rows}")
    if order:
        (data / "order.tsv").write_text(order)
    return {(person, name): recording(data, person, name) for person in scans for name in NAMES}


def row(person: str, specimen: str, time: str) -> str:
    return f"emg/sub-{person}_acq-{specimen}_emg.bdf\t{time}\n"


def read(data: Path, recordings: dict[tuple[str, str], Path]) -> dict[tuple[str, str], float]:
    return places(recordings, order_files(recordings.values(), data))


def of(found: dict[tuple[str, str], float], person: str) -> list[float]:
    return [found[person, name] for name in NAMES]


def test_times_of_scans_give_the_order_and_others_rows_do_not_count(tmp_path):
    at = ("2026-01-06T09:05:00", "2026-01-06T09:00:00.5", "2026-01-06T08:59:00Z")
    rows = "".join(row("P1", *each) for each in zip(NAMES, at, strict=True)) + "emg/other_emg.bdf\tn/a\n"
    assert of(read(tmp_path, dataset(tmp_path, {"P1": rows})), "P1") == [3, 2, 1]


@pytest.mark.parametrize("last", ["n/a", "", "2026-01-06T09:00:00"])
def test_without_a_time_of_its_own_for_every_recording_nobody_knows_the_order(tmp_path, last):
    rows = row("P1", "S1", "2026-01-06T09:00:00") + row("P1", "S3", "2026-01-06T09:05:00") + row("P1", "S5", last)
    assert of(read(tmp_path, dataset(tmp_path, {"P1": rows})), "P1") == pytest.approx([nan] * 3, nan_ok=True)


def test_a_table_of_places_counts_for_those_without_times(tmp_path):
    rows = "".join(row("P1", name, f"2026-01-06T09:0{i}:00") for i, name in enumerate(NAMES))
    table = "participant\torder\tspecimen\n" + "".join(
        f"{who}\t{place}\t{name}\n" for who in ("P1", "P2") for place, name in zip((5, 2, 9), NAMES, strict=True)
    )
    found = read(tmp_path, dataset(tmp_path, {"P1": rows, "P2": ""}, table))
    assert of(found, "P1") == [1, 2, 3]
    assert of(found, "P2") == [2, 1, 3]


def test_without_a_table_nobody_knows_the_order(tmp_path):
    recordings = dataset(tmp_path, {"P1": ""})
    assert order_files(recordings.values(), tmp_path) == []
    assert of(read(tmp_path, recordings), "P1") == pytest.approx([nan] * 3, nan_ok=True)


def test_a_scans_table_without_times_is_allowed(tmp_path):
    recordings = dataset(tmp_path, {"P1": ""})
    (tmp_path / "sub-P1" / "sub-P1_scans.tsv").write_text("filename\noperator.txt\n")
    assert of(read(tmp_path, recordings), "P1") == pytest.approx([nan] * 3, nan_ok=True)


@pytest.mark.parametrize(
    ("scans", "order", "said"),
    [
        (row("P1", "S1", "6 January"), "", "acq_time of emg/sub-P1_acq-S1_emg.bdf: expected a date and time"),
        ("", "participant\tspecimen\norder\n", "expected columns participant, specimen, order"),
        ("", "participant\tspecimen\torder\nP1\tS1\tfirst\n", "order.tsv, order: expected a number, or n/a"),
        ("", "participant\tspecimen\torder\nP1\tS1\tinf\n", "order.tsv, order: expected a number, or n/a"),
    ],
)
def test_a_table_that_is_wrong_is_refused_in_words(tmp_path, scans, order, said):
    recordings = dataset(tmp_path, {"P1": scans}, order)
    with pytest.raises(DataError, match=said.replace("(", r"\(")):
        read(tmp_path, recordings)


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("", "found an empty file"),
        ("filename,acq_time\nemg/x.bdf,n/a\n", r"with tabs between them, but found 'filename,acq_time'"),
        ("filename\tacq_time\nemg/x.bdf\tn/a\nemg/x.bdf\t2026-01-06T09:00:00\n", r"emg/x\.bdf more than once"),
    ],
)
def test_a_scans_table_that_is_empty_or_no_table_or_says_a_thing_twice_is_refused(tmp_path, text, said):
    recordings = dataset(tmp_path, {"P1": row("P1", "S1", "n/a")})
    (tmp_path / "sub-P1" / "sub-P1_scans.tsv").write_text(text)
    with pytest.raises(DataError, match=said):
        read(tmp_path, recordings)


def test_what_is_no_text_is_refused_in_words(tmp_path):
    recordings = dataset(tmp_path, {"P1": ""})
    (tmp_path / "sub-P1" / "sub-P1_scans.tsv").write_bytes(b"\xff\xfe\x00")
    with pytest.raises(DataError, match="expected a tab-separated table in UTF-8"):
        read(tmp_path, recordings)


@pytest.mark.parametrize(
    ("stated", "expected"),
    [
        (("2026-01-06 09:05:00", "2026-01-06 09:00:00", "2026-01-06T10:00:00"), [2, 1, 3]),
        (("09:05:00", "09:00:00", "10:00:00"), [nan] * 3),  # anonymised: nobody knows whether it was one day
        (("1985-01-01 00:00:00",) * 3, [nan] * 3),
        (("2026-01-06 09:05:00", "", "Tuesday"), [nan] * 3),
    ],
)
def test_without_a_table_the_recordings_own_times_count(tmp_path, stated, expected):
    recordings = dataset(tmp_path, {"P1": ""})
    began = dict(zip(recordings, stated, strict=True))
    assert of(places(recordings, [], began), "P1") == pytest.approx(expected, nan_ok=True)


def test_tables_count_before_the_recordings_own_times(tmp_path):
    rows = "".join(row("P1", name, f"2026-01-06T09:0{i}:00") for i, name in enumerate(NAMES))
    recordings = dataset(tmp_path, {"P1": rows})
    began = {cell: f"2026-01-06 08:0{9 - i}:00" for i, cell in enumerate(recordings)}
    assert of(places(recordings, order_files(recordings.values(), tmp_path), began), "P1") == [1, 2, 3]

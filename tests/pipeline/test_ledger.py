"""The ledger survives being cut short, and says what changed."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

from emg2vsa.pipeline.ledger import Entry, Ledger, Parts, differences

PARTS = Parts({"fit": {"bin_n": 0.3}}, {"a.bdf": "1"}, {"trials/P1/S1": "k"}, {"emg2vsa.fits": "c"}, {"numpy": "2"})


def entry(step: str = "fits/P1/S1", key: str = "k1", status: str = "done") -> Entry:
    return Entry(step, key, status, "", False, PARTS)


def test_the_newest_entry_of_a_step_counts(tmp_path: Path) -> None:
    ledger = Ledger(tmp_path)
    ledger.record(entry(key="k1"))
    ledger.record(entry(key="k2", status="failed"))
    assert Ledger(tmp_path).last("fits/P1/S1") == entry(key="k2", status="failed")
    assert Ledger(tmp_path).last("fits/P2/S1") is None


def test_half_a_line_is_skipped_and_closed(tmp_path: Path) -> None:
    Ledger(tmp_path).record(entry(key="k1"))
    path = tmp_path / "ledger.jsonl"
    path.write_bytes(path.read_bytes() + b'{"step": "fits/P1/S2", "ke')
    cut = Ledger(tmp_path)
    assert cut.last("fits/P1/S1") == entry(key="k1")
    cut.record(entry("fits/P1/S3"))
    again = Ledger(tmp_path)
    assert again.last("fits/P1/S3") == entry("fits/P1/S3")
    assert again.last("fits/P1/S2") is None


def test_compact_keeps_the_newest_and_the_result_before(tmp_path: Path) -> None:
    ledger = Ledger(tmp_path)
    for i in range(5):
        ledger.record(entry(key=f"k{i}"))
        path = ledger.result_path("fits/P1/S1", f"k{i}")
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(str(i))
    ledger.compact()
    assert len((tmp_path / "ledger.jsonl").read_text().splitlines()) == 1
    assert Ledger(tmp_path).last("fits/P1/S1") == entry(key="k4")
    kept = {p.stem for p in (tmp_path / "store" / "fits" / "P1" / "S1").iterdir()}
    assert "k4" in kept
    assert len(kept) == 2


def test_differences_name_the_leaf() -> None:
    new = replace(
        PARTS,
        settings={"fit": {"bin_n": 0.2, "robust": True}},
        files={"a.bdf": "2", "b.tsv": "1"},
        inputs={},
        code={"emg2vsa.fits": "d"},
        libraries={"numpy": "3"},
    )
    assert differences(PARTS, new) == [
        "setting fit.bin_n: 0.3 -> 0.2",
        "setting fit.robust: unset -> true",
        "changed file a.bdf",
        "new file b.tsv",
        "removed input trials/P1/S1",
        "changed code emg2vsa.fits",
        "library numpy 2 -> 3",
    ]
    assert differences(PARTS, PARTS) == []

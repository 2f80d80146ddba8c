"""The parsers of emg2vsa's own under changed bytes; the hour's run is ``python -m benchmarks.fuzz_readers``."""

from __future__ import annotations

import time
from pathlib import Path

import pytest

from benchmarks.fuzz_readers import FOUND, Tally, tried
from benchmarks.made_recordings import MADE

TRIES = 60


@pytest.mark.parametrize("name", MADE)
def test_nothing_but_a_refusal_comes_of_changed_bytes(tmp_path: Path, name: str) -> None:
    tally = tried(name, iter([*FOUND.get(name, ()), *range(TRIES)]), tmp_path, Tally(name))
    assert not tally.failed
    assert tally.outcomes["read"] > 0
    assert tally.outcomes["refused"] > 0


@pytest.mark.slow
@pytest.mark.parametrize("name", MADE)
def test_nothing_but_a_refusal_comes_of_ten_seconds_of_changed_bytes(tmp_path: Path, name: str) -> None:
    tally = tried(name, range(10**6, 10**7), tmp_path, Tally(name), until=time.monotonic() + 10)
    assert not tally.failed

"""What changed bytes do to the parsers of emg2vsa's own: nothing but a RecordingError may come of a file.

Run as ``python -m benchmarks.fuzz_readers [--seconds 600]``; it prints a Markdown table. Each try changes one
of the made recordings (`benchmarks.made_recordings`): bytes flipped, cut out, doubled, overwritten by numbers and words
that parsers stumble over, a part of another file put in, the end cut off. Then every channel is listed and read in this
process. A try fails if anything but a RecordingError is raised, if it takes more than LONGEST_S, or if it makes the
process grow by more than MOST_GROWTH_MB. The seed of every try that failed once is kept in FOUND and tried first.
"""

from __future__ import annotations

import argparse
import contextlib
import resource
import signal
import struct
import sys
import tempfile
import time
import warnings
from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from benchmarks.made_recordings import MADE
from emg2vsa.errors import RecordingError
from emg2vsa.readers.front_door import open_recording

LONGEST_S = 2.0
MOST_GROWTH_MB = 200.0
FOUND: dict[str, tuple[int, ...]] = {
    "nexus.vicon.csv": (10, 145, 170),
    "v150.discover.csv": (101113, 106446),
    "counts.anc": (202886,),
    "matrix.txt": (104364, 104785),
    "two_groups.hpf": (156, 1631, 1632),
    "multi_x_gap.lvm": (1004741,),
}
"""Made file to the seeds of tries that once failed."""
_NUMBERS = tuple(
    struct.pack(layout, value)
    for layout, values in (
        ("<i", (0, -1, 1, 2**31 - 1, -(2**31), 65536)),
        ("<q", (0, -1, 2**63 - 1, -(2**63), 2**40)),
        ("<d", (0.0, -1.0, float("nan"), float("inf"), 1e308, 1e-308)),
    )
    for value in values
)
_WORDS = (
    b"nan", b"inf", b"-1", b"0", b"1e999", b"9" * 40, b"1e-320", b"", b",", b";", b"\t", b"\n", b"\r", b'"', b"\0",
    b"[]", b"{}", b"null", b"true", b"\xff\xfe", b"\xef\xbb\xbf", b"0x10", b"1_000", b"\xc2\xb5V",
    b"***End_of_Header***", b"<a>", b"</Name>", b"#", b" " * 300, b"Hz", b"65535", b"1.5", b"-0.0", b"2**", b"(", b")",
)  # fmt: skip


@dataclass
class Tally:
    """Outcomes of the tries on one made file. failed : seed to what happened."""

    name: str
    outcomes: Counter[str] = field(default_factory=Counter)
    failed: dict[int, str] = field(default_factory=dict)
    slowest_s: float = 0.0
    growth_mb: float = 0.0


def changed(content: bytes, seed: int, others: tuple[bytes, ...]) -> bytes:
    """The content with one to eight changes, decided by the seed alone."""
    rng = np.random.default_rng(seed)
    for _ in range(int(rng.integers(1, rng.choice([2, 4, 9])))):
        within = len(content) if rng.random() < 0.5 else min(len(content), 1024)
        at = int(rng.integers(0, within + 1))
        length = int(rng.choice([1, 2, 4, 8, 16, 64, 512]))
        match rng.choice(["flip", "cut", "double", "number", "word", "word", "splice", "end"]):
            case "flip":
                flip = bytes([content[at] ^ int(rng.integers(1, 256))]) if at < len(content) else b""
                content = content[:at] + flip + content[at + 1 :]
            case "cut":
                content = content[:at] + content[at + length :]
            case "double":
                content = content[:at] + content[at : at + length] * int(rng.integers(2, 5)) + content[at + length :]
            case "number":
                number = _NUMBERS[rng.integers(len(_NUMBERS))]
                content = content[:at] + number + content[at + len(number) :]
            case "word":
                keep = int(rng.choice([0, 0, 1, 4, 8]))
                content = content[:at] + _WORDS[rng.integers(len(_WORDS))] + content[at + keep :]
            case "splice":
                other = others[rng.integers(len(others))]
                start = int(rng.integers(0, len(other)))
                content = content[:at] + other[start : start + length] + content[at + length :]
            case "end":
                content = content[:at] if rng.random() < 0.2 else content[: len(content) - length]
        content = content or b"\n"
    return content


@contextlib.contextmanager
def _no_longer_than(seconds: float) -> Iterator[None]:
    def late(*_: object) -> None:
        raise TimeoutError(f"longer than {seconds} s")

    before = signal.signal(signal.SIGALRM, late)
    signal.setitimer(signal.ITIMER_REAL, seconds)
    try:
        yield
    finally:
        signal.setitimer(signal.ITIMER_REAL, 0)
        signal.signal(signal.SIGALRM, before)


def read_all(path: Path) -> None:
    """List and read every channel of a file."""
    _, opened = open_recording(path)
    assert len(opened.describe()) == len(opened.contents.names)
    for i in range(len(opened.contents.names)):
        with contextlib.suppress(RecordingError):  # one channel may be unusable, the next is not
            opened.load([i])


def tried(name: str, seeds: Iterator[int] | range, folder: Path, tally: Tally, until: float = float("inf")) -> Tally:
    """Try the seeds on a made file, until the time (time.monotonic) is up."""
    content = MADE[name]()
    others = tuple(make() for make in MADE.values())
    path = folder / name
    for seed in seeds:
        if time.monotonic() > until:
            break
        path.write_bytes(changed(content, seed, others))
        before_mb, started = _peak_mb(), time.process_time()
        try:
            with _no_longer_than(10 * LONGEST_S), warnings.catch_warnings():
                warnings.filterwarnings("error", category=RuntimeWarning, module="emg2vsa")
                read_all(path)
            tally.outcomes["read"] += 1
        except RecordingError:
            tally.outcomes["refused"] += 1
        except Exception as error:
            tally.failed[seed] = f"{type(error).__name__}: {error}"
        took_s = time.process_time() - started
        grown_mb = _peak_mb() - before_mb
        tally.slowest_s, tally.growth_mb = max(tally.slowest_s, took_s), max(tally.growth_mb, grown_mb)
        if took_s > LONGEST_S:
            tally.failed.setdefault(seed, f"took {took_s:.1f} s")
        if grown_mb > MOST_GROWTH_MB:
            tally.failed.setdefault(seed, f"grew by {grown_mb:.0f} MB")
    return tally


def _peak_mb() -> float:
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / (1e6 if sys.platform == "darwin" else 1e3)


def main() -> int:
    """Exit status: 1 where a try failed."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--seconds", type=float, default=60.0, help="in all (default %(default)s)")
    parser.add_argument("--seed", type=int, default=0, help="of the first try (default %(default)s)")
    parser.add_argument("--only", default="", help="names that contain this")
    options = parser.parse_args()
    names = [name for name in MADE if options.only in name]
    started = time.monotonic()
    tallies = {name: Tally(name) for name in names}
    with tempfile.TemporaryDirectory() as folder:
        for name in names:
            tried(name, iter(FOUND.get(name, ())), Path(folder), tallies[name])
        first = options.seed
        while (left := started + options.seconds - time.monotonic()) > 0:
            for name in names:  # turn by turn, so that every format gets the same share
                until = min(time.monotonic() + 2.0, time.monotonic() + left)
                tally = tallies[name]
                done = sum(tally.outcomes.values()) + len(tally.failed)
                tried(name, range(first + done, first + done + 10**6), Path(folder), tally, until)
                for seed, what in tally.failed.items():
                    print(f"{name}, seed {seed}: {what}", flush=True) if seed >= first + done else None
    took_s = time.monotonic() - started
    print(f"\n{took_s:.0f} s in all, peak memory {_peak_mb():.0f} MB.\n")
    print("| file | tries | read | refused | failed | slowest, s | largest growth, MB |\n|---|---|---|---|---|---|---|")
    for tally in tallies.values():
        n = sum(tally.outcomes.values())
        numbers = (
            f"{n + len(tally.failed)} | {tally.outcomes['read']} | {tally.outcomes['refused']} | {len(tally.failed)}"
        )
        print(f"| {tally.name} | {numbers} | {tally.slowest_s:.2f} | {tally.growth_mb:.0f} |")
    return int(any(tally.failed for tally in tallies.values()))


if __name__ == "__main__":
    sys.exit(main())

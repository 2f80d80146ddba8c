"""What flipped bytes do to the program: refused or read, decoders that crashed or met a limit, time and memory.

Run as ``python -m benchmarks.corrupted_files [--flips 500]``; it prints a Markdown table. A try changes 1 to 8 bytes of
a good file, half of the tries in its first 4 kB, and then lists and reads every channel. The C3D files are those of
``../shared/data`` (or EMG2VSA_TEST_DATA), where it is there. The sizes of the others are those of a short recording.
"""

from __future__ import annotations

import argparse
import os
import resource
import tempfile
import time
from collections import Counter
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path

import edfio
import ezc3d
import numpy as np
import pandas as pd
import scipy.io

from benchmarks.made_recordings import save_opensignals_hdf5, save_tdms, xdf
from casr.decoder_process import DecoderFailed, InChild, Limits, child_pid, end_child
from emg2vsa.errors import RecordingError
from emg2vsa.readers.front_door import load_named, open_recording

FS_HZ, N = 1000, 5000
CHANNELS = {"EDC": "mV", "FDS": "mV", "Fz": "N"}
HEAD_BYTES = 4096
REAL = Path(os.environ.get("EMG2VSA_TEST_DATA", Path(__file__).parents[2] / "shared" / "data")) / "emg" / "c3d"
OUTCOMES = ("read", "refused", "crashed", "too slow", "too much memory", "other exception")


@dataclass
class Tally:
    """Outcomes of the tries on one file. peak_mb : largest memory of a child, resident, where /proc tells it."""

    name: str
    size_mb: float
    outcomes: Counter[str] = field(default_factory=Counter)
    slowest_s: float = 0.0
    peak_mb: float = 0.0
    examples: dict[str, str] = field(default_factory=dict)

    @property
    def tries(self) -> int:
        return sum(self.outcomes.values())


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--flips", type=int, default=500, help="tries of each format (default %(default)s)")
    flips = parser.parse_args().flips
    with tempfile.TemporaryDirectory() as name:
        tallies = []
        for good in good_files(Path(name)):
            tallies.append(flipped(good, flips))
            print(f"{tallies[-1].name}: {dict(tallies[-1].outcomes)}", flush=True)
        endless = [given_to(path, how) for path, how in endless_files(Path(name))]
    end_child()
    print("\n" + table([*tallies, *endless]) + "\n")
    for tally in [*tallies, *endless]:
        for outcome, text in tally.examples.items():
            print(f"* {tally.name}, {outcome}: {text}")
    whose = (resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN)
    own, children = (resource.getrusage(who).ru_maxrss / 1000 for who in whose)
    print(f"\nPeak memory, resident: this process {own:.0f} MB, its children {children:.0f} MB.")
    print("Deaths of this process: 0, for it lived to write this.")


def good_files(folder: Path) -> list[Path]:
    """One good file of each format."""
    rng = np.random.default_rng(0)
    samples = {name: rng.normal(size=N) for name in CHANNELS}
    time_s = np.arange(N) / FS_HZ
    paths = [folder / name for name in ("rec.edf", "rec.bdf", "plain.mat", "compressed.mat", "emgworks.csv")]
    for path, file, signal in zip(paths, (edfio.Edf, edfio.Bdf), (edfio.EdfSignal, edfio.BdfSignal), strict=False):
        file([signal(x, FS_HZ, label=k, physical_dimension=CHANNELS[k]) for k, x in samples.items()]).write(path)
    labels = np.array([f"{name} [{unit}]" for name, unit in CHANNELS.items()], dtype=object)
    variables = {"data": np.stack(list(samples.values())), "labels": labels, "info": {"fs": FS_HZ, "by": "x"}}
    for path in paths[2:4]:
        scipy.io.savemat(path, variables, do_compression=path.stem == "compressed")
    columns = {f"{mark}{k}": x for k, x in samples.items() for mark, x in (("t", time_s), ("EMG ", x))}
    header = ",".join("X[s]" if name.startswith("t") else f'"Sensor: {name}"' for name in columns)
    pd.DataFrame(columns).to_csv(paths[4], index=False, header=header.split(","), float_format="%.7g", quoting=3)
    real = REAL / "btk_PiG_Motion-FlatFoot-Full.c3d"
    for name, save in (("rec.tdms", save_tdms), ("rec.h5", save_opensignals_hdf5)):
        paths.append(folder / name)
        save(paths[-1])
    paths.append(folder / "rec.xdf")
    paths[-1].write_bytes(xdf())
    return [*paths[:2], real if real.exists() else _c3d(folder / "rec.c3d", samples), *paths[2:]]


def _c3d(path: Path, samples: dict[str, np.ndarray]) -> Path:
    file = ezc3d.c3d()
    file["parameters"]["POINT"]["RATE"]["value"] = [100.0]
    file["parameters"]["ANALOG"]["RATE"]["value"] = [float(FS_HZ)]
    file["parameters"]["ANALOG"]["LABELS"]["value"] = list(samples)
    file["parameters"]["ANALOG"]["UNITS"]["value"] = list(CHANNELS.values())
    file["data"]["points"] = np.zeros((4, 0, N // 10))
    file["data"]["analogs"] = np.stack(list(samples.values()))[np.newaxis]
    file.write(str(path))
    return path


def flipped(good: Path, tries: int, seed: int = 0) -> Tally:
    """Outcomes of ``tries`` changes of a good file."""
    rng = np.random.default_rng(seed)
    content = np.frombuffer(good.read_bytes(), np.uint8)
    tally = Tally(good.name, content.size / 1e6)
    end_child()
    _read_all(good)  # the time of a try is not that of starting a child
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / good.name
        for attempt in range(tries):
            within = min(content.size, HEAD_BYTES) if attempt % 2 else content.size
            changed = content.copy()
            places = rng.integers(0, within, rng.integers(1, 9))
            changed[places] ^= rng.integers(1, 256, places.size, dtype=np.uint8)
            path.write_bytes(changed.tobytes())
            _count(tally, lambda: _read_all(path))
    return tally


def endless_files(folder: Path) -> list[tuple[Path, Callable[[Path], object]]]:
    """C3D files on which ezc3d never ends, and how each is given to it."""
    bkin = REAL / "btk_BKINtechnologies.c3d"
    if not bkin.exists():
        return []
    content = bytearray(bkin.read_bytes())
    content[512 + content[512:].index(b"\xa3Session identification numbers")] = 0xA4  # a length that fits nothing
    (folder / "bkin_damaged.c3d").write_bytes(content)
    return [(bkin, _read_all), (folder / "bkin_damaged.c3d", _read_all), (bkin, _ezc3d_alone)]


def given_to(path: Path, how: Callable[[Path], object]) -> Tally:
    """The outcome of one file."""
    name = path.name + (", given to ezc3d as it is" if how is _ezc3d_alone else "")
    tally = Tally(name, path.stat().st_size / 1e6)
    end_child()
    _count(tally, lambda: how(path))
    return tally


def _ezc3d_alone(path: Path) -> object:
    return InChild("ezc3d", "ezc3d", "c3d", (str(path),), Limits())


def _read_all(path: Path) -> object:
    _, opened = open_recording(path)
    return load_named(opened, [channel.name for channel in opened.describe()])


def _count(tally: Tally, read: Callable[[], object]) -> None:
    start = time.perf_counter()
    try:
        read()
        outcome = "read"
    except (RecordingError, DecoderFailed) as error:
        failure = error if isinstance(error, DecoderFailed) else error.__cause__
        outcome = _kind(failure) if isinstance(failure, DecoderFailed) else "refused"
        tally.examples.setdefault(outcome, str(error).rpartition("/")[2])
    except Exception as error:
        outcome = "other exception"
        tally.examples.setdefault(outcome, repr(error))
    tally.outcomes[outcome] += 1
    tally.slowest_s = max(tally.slowest_s, time.perf_counter() - start)
    tally.peak_mb = max(tally.peak_mb, _resident_mb())


def _kind(failure: DecoderFailed) -> str:
    return {None: "crashed", "seconds": "too slow", "memory": "too much memory"}[failure.limit]


def _resident_mb() -> float:
    """Largest memory so far of the child that lives, MB."""
    status = Path(f"/proc/{child_pid()}/status")
    if not status.exists():
        return 0.0
    fields = dict(line.split(":", 1) for line in status.read_text().splitlines() if ":" in line)
    return int(fields["VmHWM"].split()[0]) / 1000


def table(tallies: list[Tally]) -> str:
    """The tallies in Markdown."""
    lines = [
        "| file | MB | tries | " + " | ".join(OUTCOMES) + " | slowest s | child, peak MB |",
        "|---|" + "---:|" * (len(OUTCOMES) + 4),
    ]
    for tally in tallies:
        counts = " | ".join(str(tally.outcomes[outcome]) for outcome in OUTCOMES)
        lines.append(
            f"| {tally.name} | {tally.size_mb:.2f} | {tally.tries} | {counts} | {tally.slowest_s:.2f} "
            f"| {tally.peak_mb:.0f} |"
        )
    return "\n".join(lines)


if __name__ == "__main__":
    main()

"""Radio frames that a Trigno server loses without a word: the lag of force behind EMG, b, and the verdict.

Run with ``python -m benchmarks.session_losses [--seeds N]``. An emulated participant presses two specimens six times
each in virtual time. Of the samples that its sensors gave, frames of 26 are left out; the rest arrives as from a
server's port: whole frames, up to some milliseconds late, read every 5 ms, without time or number. Times, gaps, presses
and b are then found from the files of the session, as ``emg2vsa session finish`` finds them. True b is the
participant's own.
"""

from __future__ import annotations

import argparse
import tempfile
from collections.abc import Iterator
from dataclasses import dataclass, replace
from itertools import pairwise
from pathlib import Path
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from benchmarks.small_study import SIMULATED_SESSION, small_study
from emg2vsa.devices.clock import VirtualClock
from emg2vsa.devices.streams import Block
from emg2vsa.extraction.extract import extract_trials
from emg2vsa.fits import fit_trials
from emg2vsa.recordings import Channel
from emg2vsa.session.journal import JOURNAL_FILE, StreamOpened, read_journal
from emg2vsa.session.judge_feed import how_judged
from emg2vsa.session.open_session import folder_of, open_session
from emg2vsa.session.plan import PLAN_FILE, read_plan
from emg2vsa.session.presses import folded
from emg2vsa.session.raw_files import SampleFile, block_bytes, head_bytes
from emg2vsa.session.stays import StaySignals, StayWindow, StoredStream, cut, stay_windows, stored_streams
from emg2vsa.settings import CocontractionSettings
from emg2vsa.study import Study
from emg2vsa.study_file import load_study
from emg2vsa.worlds.people.pages import EmulatedOperator
from emg2vsa.worlds.people.participant import EmulatedParticipant
from emg2vsa.worlds.people.person import person_of
from emg2vsa.worlds.people.sensors import simulated_emg, simulated_force

FRAME, FRAME_S = 26, 0.0135
FS_HZ = FRAME / FRAME_S
POLL_S, JITTER_S = 0.005, 1e-3
PERSON = "P01"
STUDY = small_study(
    participants=[PERSON], specimens=["S1", "S3"], task="press",
    tables=f"[session]\n{SIMULATED_SESSION}repetitions = 6\npause_s = 1.0\n",
)  # fmt: skip


class Loss(NamedTuple):
    """A share of the frames is lost, so many in a row; at random, or evenly."""

    name: str
    share: float
    burst: int = 1
    evenly: bool = False


LOSSES = (
    Loss("none", 0.0),
    Loss("single frames, one in 10 s", 0.1 * FRAME_S, evenly=True),
    Loss("1 % at random", 0.01),
    Loss("2 % at random", 0.02),
    Loss("5 % at random", 0.05),
    Loss("2 % in bursts of 5 frames", 0.02, 5),
    Loss("5 % in bursts of 5 frames", 0.05, 5),
    Loss("5 % in bursts of 37 frames (0.5 s)", 0.05, 37),
)


@dataclass(frozen=True)
class Recorded:
    """A session without losses: its stays, streams by sitting and kind, and what is true of its presses."""

    study: Study
    windows: list[StayWindow]
    emg: StoredStream
    force: StoredStream
    person: EmulatedParticipant


def recorded(folder: Path, seed: int) -> Recorded:
    """A session of an emulated participant at once, with its sensors within the process."""
    (folder / "study.toml").write_text(STUDY.replace("seed = 3", f"seed = {seed}"))
    study, clock = load_study(folder / "study.toml"), VirtualClock()
    assert study.session is not None
    person = EmulatedParticipant(person_of(study, PERSON), range_n=study.session.force_n)
    emg = simulated_emg(person, tuple(person.person.muscle_share), FS_HZ, clock)
    force = simulated_force(person, clock)
    with open_session(study, PERSON, clock, (lambda: emg, lambda: force), at_once=True) as desk:
        person.watch(desk)
        desk.run(clock, EmulatedOperator(desk, person.place).turn)
    place = folder_of(study, PERSON)
    lines, _ = read_journal(place / JOURNAL_FILE)
    streams, _ = stored_streams(place, lines)
    windows = stay_windows(folded(lines, read_plan(place / PLAN_FILE).presses))
    return Recorded(study, windows, streams[1, "emg"][0], streams[1, "force"][0], person)


def lost_frames(loss: Loss, n: int, seed: int) -> NDArray[np.bool_]:
    """Which of ``n`` frames are lost."""
    lost = np.zeros(n, dtype=np.bool_)
    chance = loss.share / loss.burst
    every = round(1 / chance) if loss.evenly else 0
    begins = (
        np.arange(every // 2, n, every) if every else np.flatnonzero(np.random.default_rng(seed).random(n) < chance)
    )
    for begin in begins.tolist():
        lost[begin : begin + loss.burst] = True
    return lost


def received(stream: StoredStream, lost: NDArray[np.bool_], path: Path, seed: int) -> StoredStream:
    """What arrives of a stream that was measured from time 0 on, as a session stores it."""
    rng = np.random.default_rng([seed, 1])
    n = lost.size
    ends_s = (np.arange(1, n + 1) * FRAME) / FS_HZ
    sent_s = np.maximum.accumulate(ends_s + rng.exponential(JITTER_S, n))[~lost]
    looks = np.ceil(sent_s / POLL_S).astype(np.int64)
    frames = stream.file.read(0, n * FRAME).reshape(n, FRAME, -1)[~lost]
    begins = [*np.flatnonzero(np.diff(looks, prepend=-1)).tolist(), len(looks)]
    info = replace(stream.file.info, frame=FRAME)
    with path.open("wb") as file:
        file.write(head_bytes(info))
        for a, b in pairwise(begins):
            samples = frames[a:b].reshape(-1, frames.shape[2])
            file.write(block_bytes(Block(samples, a * FRAME, float(looks[a]) * POLL_S)))
    opened: StreamOpened = replace(stream.opened, frame=FRAME, file=str(path))
    return StoredStream(opened, SampleFile(path)).hear()


def presses(
    own: Recorded, signals: StaySignals, window: StayWindow
) -> Iterator[tuple[float, float, float, str, float]]:
    """Of each press of a stay: error of b as a share, half width, missing share, verdict, lag (s)."""
    how = how_judged(own.study, PERSON, window.specimen)
    emg = {
        muscle: Channel(muscle, np.ascontiguousarray(row), "V", signals.emg_fs_hz, 0.0, "")
        for muscle, row in zip(signals.muscles, signals.emg_v.T, strict=True)
    }
    force = Channel("force", signals.force_n, "N", signals.force_fs_hz, 0.0, "")
    trials = extract_trials(
        emg, force, participant=PERSON, specimen=window.specimen, filters=how.filters,
        cocontraction=CocontractionSettings(), window=how.window, force_channel=how.force_channel,
    )  # fmt: skip
    fits = fit_trials(trials, how.fit, how.window)
    for i, start_s in enumerate(fits.start_s.tolist()):
        at = slice(round(start_s * signals.emg_fs_hz), round(trials.stop_s[i] * signals.emg_fs_hz))
        missing = float(np.isnan(signals.emg_v[at, 0]).mean())
        onset_s = np.array([signals.onset_s(each.onset_s) for each in own.person.presses])
        true = own.person.presses[int(np.nanargmin(np.abs(onset_s - start_s)))]
        half = (fits.b_hi_v[i] - fits.b_lo_v[i]) / 2 / true.b_v
        yield fits.b_v[i] / true.b_v - 1, half, missing, str(fits.verdict[i]), trials.lag_s


def rows(seeds: int) -> Iterator[str]:
    """A row of the table for each loss."""
    with tempfile.TemporaryDirectory() as place:
        sessions = []
        for seed in range(seeds):
            folder = Path(place) / str(seed)
            folder.mkdir()
            sessions.append(recorded(folder, seed + 3))
        for loss in LOSSES:
            found, counted, true, rates = [], 0, 0, []
            for seed, own in enumerate(sessions):
                lost = lost_frames(loss, own.emg.file.stop // FRAME, seed)
                stream = received(own.emg, lost, Path(place) / "lossy", seed)
                counted, true = counted + stream.clock.report().missing // FRAME, true + int(lost.sum())
                rates.append(stream.clock.report().rate_hz)
                for window in own.windows:
                    if window.phase == "main":
                        found += presses(own, cut(window, [stream], [own.force]), window)
            errors, halves, missing, verdicts, lags_s = zip(*found, strict=True)
            used = np.array(verdicts) == "ok"
            off, half = np.array(errors), np.array(halves)
            limit = own.study.session.limits.lost_share[1] if own.study.session else 0.0
            cells = (
                loss.name, f"{true}", f"{counted}", f"{np.mean([rate or np.nan for rate in rates]):.2f}",
                f"{1e3 * np.abs(lags_s).max():.0f}",
                f"{100 * off[used].mean():+.1f}" if used.any() else "",
                f"{(off[used] / half[used]).mean():+.2f}" if used.any() else "",
                f"{np.abs(off[used] / half[used]).max():.1f}" if used.any() else "",
                f"{used.sum()} of {used.size}", f"{np.mean(np.array(missing) <= limit):.0%}",
            )  # fmt: skip
            yield f"| {' | '.join(cells)} |"


def main() -> None:
    """The table."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--seeds", type=int, default=2)
    seeds = parser.parse_args().seeds
    print(f"""# Radio frames that are lost without a word

{seeds} sessions of 12 presses. Frames of {FRAME} samples, 13.5 ms; the true rate is {FS_HZ:.2f} Hz. Lag: the largest
that a recording shows. Bias of b: of the presses that are used, against the participant's own b. Within 1 %: presses
of which no more is lost; the session rejects the others at once (`session.limits.lost_share`).

| lost | frames | counted | rate, Hz | lag, ms | bias of b, % | in half widths | largest | used | within 1 % |
|---|---:|---:|---:|---:|---:|---:|---:|---:|---:|""")
    for row in rows(seeds):
        print(row, flush=True)


if __name__ == "__main__":
    main()

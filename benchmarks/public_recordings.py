"""What is said of recordings of other laboratories, and whether it is right.

Public files (``../shared/data/emg``, or EMG2VSA_TEST_DATA; origins and licences in its SOURCES.md), judged as
``emg2vsa check`` judges a recording. Those that hold force too are judged as they are. No public file was found that
holds palpation, so of the others the EMG is the carrier of five simulated presses (``benchmarks.laboratory``): where it
is active it is divided by its own slow level, and follows 30 + 15 ln F uV above 1 uV of noise. Its spectrum, its motor
units, its converter and what disturbs it are real, and b is known. Three stretches of each, as three specimens of a
person, are compared with those of all others.

    python -m benchmarks.public_recordings     # writes benchmarks/results/public_recordings.json
"""

from __future__ import annotations

import os
import re
from collections import Counter
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from scipy import signal

from benchmarks.bench.record import keep
from benchmarks.laboratory import Laboratory, activity_v, simulate_session
from emg2vsa.arrays import Floats
from emg2vsa.errors import Emg2vsaError
from emg2vsa.extraction import Trials
from emg2vsa.extraction.extract import extract_trials
from emg2vsa.fits import fit_trials
from emg2vsa.readers.front_door import load_named, open_recording
from emg2vsa.readers.opened import to_si
from emg2vsa.recordings import Channel
from emg2vsa.screening.screen import screen, traits_by_recording
from emg2vsa.session_verdict import SessionVerdict, judge_session
from emg2vsa.settings import (
    CocontractionSettings,
    FilterSettings,
    FitSettings,
    ForceChannelSettings,
    WindowSettings,
)

FILES = Path(os.environ.get("EMG2VSA_TEST_DATA", Path(__file__).parents[2] / "shared" / "data")) / "emg"
RESULTS = Path(__file__).parent / "results" / "public_recordings.json"
SLOW_HZ, ACTIVE, PIECE_S, NOISE_V, B_V = 1.0, 0.5, 0.4, 1e-6, 15e-6
"""The level of a carrier; active above this share of its upper tenth; pieces of it are so long."""
COUNTS_V = 3.0 / 2**16 / 1000
"Volts of a count of a 16 bit converter of 3 V behind a gain of 1000."
VL = "Vastus Lateralis - AUX 3 (Channel 1->1) - GR08MM1305 ({})"


@dataclass(frozen=True)
class Case:
    """Channels of a file. force : with its newtons per stored unit, and the file that holds it if another does."""

    file: str
    emg: tuple[str, ...]
    why: str
    force: str = ""
    newtons: float = 1.0
    volts: float = 1.0
    fs_hz: float | None = None
    force_file: str = ""


WITH_FORCE = {
    "grip on a Mini45, 50 s": Case(
        "ati/atusa_myo_mini45_raw_01.csv", ("emg0", "emg4"),
        "right: 18 % of the readings are two, glued together (SOURCES.md)", "Fz", volts=1e-6, fs_hz=243.0,
    ),
    "grip, 5 s": Case(
        "emg_force/novainstrumentation_emg.txt", ("row 2",),
        "right: the file begins within a grip, at a quarter of its peak", "row 2", 0.1, 1e-3,
        force_file="emg_force/novainstrumentation_force.txt",
    ),
    "knee, force in % MVC, 32 s": Case(
        "emg_force/openhdemg_otb_testfile_VL64_force.mat", (VL.format(1), VL.format(40)),
        "right: the file begins and ends within the contraction, so its two rests are none", "acquired data", 0.4,
    ),
    "walking over a plate": Case(
        "c3d/btk_PiG_Motion-FlatFoot-Full.c3d", ("R_TA", "R_GL"),
        "right: a heel strike lasts .1 s, and TA works before it, in the rest of the plate", "plate 1 Fz", 0.02,
    ),
}  # fmt: skip
STEPS = (
    "right: the muscle works in bursts of .1 s, some larger than a level of 1 Hz follows, so that b is poorly known; "
    "what is slow and large in them may be the limb that moves the electrode"
)
ARM = "right: fast arm movements tug at the cables, and burst"
CARRIERS = {
    **{f"knee, grid channel {k}": Case("emg_force/openhdemg_otb_testfile_VL64_force.mat", (VL.format(k),), "")
       for k in range(1, 65, 6)},
    **{f"repeated movement, channel {k}": Case("delsys_native/btk_Set1_Rep2_v3.emg", (f"EMG Ch{k}",), STEPS)
       for k in range(2, 9)},
    **{f"arm movements, {m}": Case("delsys_native/btk_Run34_EDC_FCR_BIC_TRI.hpf", (f"{m}: EMG {k}",), ARM)
       for m, k in (("R EXTENSOR DIGITORUM", 3), ("R FLEXOR CARPI RADIALIS", 5))},
    **{f"gait, {m}": Case("c3d/btk_PiG_Motion-FlatFoot-Full.c3d", (m,), STEPS)
       for m in ("R_TA", "R_GL", "R_PE", "L_TA")},
    **{f"leg in mV, {m}": Case("c3d/btk_1123x01EMG.c3d", (m,), STEPS)
       for m in ("Right Tibialis Anterior", "Left Tibialis Anterior", "Right Gastrocnemius Lateralis")},
    "bursts of one muscle": Case("opensignals/bsnb_emg_bursts.h5", ("PORT3_CHN1",), "", volts=COUNTS_V),
    "no EMG: slow sensor": Case("opensignals/bsnb_raw_3ch_2018_7_4.txt", ("CH1",), "right: it holds no EMG",
                               volts=COUNTS_V),
    "no EMG: mains of a sensor that is off": Case(
        "delsys_csv/emgio_emgworks_verbose_truncated.csv", ("Mini sensor 10: EMG 10",),
        "right: 88 % of its power is mains, which as a carrier is there in presses alone",
    ),
}  # fmt: skip


def channels(case: Case) -> tuple[list[Channel], Channel | None]:
    """EMG in volts, and force in newtons where the case has one."""
    asked = [(case.file, (*case.emg, *((case.force,) if case.force and not case.force_file else ())))]
    asked += [(case.force_file, (case.force,))] if case.force_file else []
    found = []
    for file, names in asked:
        _, opened = open_recording(FILES / file)
        found += [to_si(each) for each in load_named(opened, names, [case.fs_hz] * len(names))]
    factors = [case.volts] * len(case.emg) + [case.newtons] * bool(case.force)
    units = ["V"] * len(case.emg) + ["N"] * bool(case.force)
    scaled = [
        Channel(each.name, factor * each.samples, unit, each.fs_hz, each.start_s, each.conversion)
        for each, factor, unit in zip(found, factors, units, strict=True)
    ]
    return scaled[: len(case.emg)], scaled[-1] if case.force else None


def carrier(channel: Channel, begin: float, end: float) -> Floats:
    """Samples of a stretch of a channel, shares of its length, where it is active; of mean size 1."""
    samples = channel.samples[np.isfinite(channel.samples)]
    samples = samples - samples.mean()
    low = signal.butter(1, SLOW_HZ, fs=channel.fs_hz, output="sos")
    slow = np.maximum(signal.sosfiltfilt(low, np.abs(samples)), 1e-12)
    active = slow > ACTIVE * np.quantile(slow, 0.9)
    steady = (samples / slow)[active]
    steady = steady[round(begin * steady.size) : round(end * steady.size)]
    return np.asarray(steady / np.abs(steady).mean(), dtype=np.float64)


def long(stretch: Floats, n: int, piece: int, rng: np.random.Generator) -> Floats:
    """Pieces of a stretch as they come by chance, of either sign so that none repeats a line, faded over, (n,)."""
    overlap = piece // 8
    fade = np.sin(np.pi / 2 * (np.arange(overlap) + 0.5) / overlap)
    window = np.concatenate((fade, np.ones(piece - 2 * overlap), fade[::-1]))
    joined = np.zeros(n + 2 * piece)
    for at in range(0, n + piece, piece - overlap):
        begin = int(rng.integers(0, stretch.size - piece + 1))
        joined[at : at + piece] += rng.choice([-1.0, 1.0]) * window * stretch[begin : begin + piece]
    return joined[overlap : n + overlap]


def pressed(channel: Channel, begin: float, end: float, seed: int) -> tuple[Channel, Channel]:
    """EMG and force of five presses with the carrier of a stretch."""
    fs_hz = channel.fs_hz
    world = Laboratory(presses=5, fs_hz=fs_hz, force_fs_hz=fs_hz, force_noise_n=0.0)
    made = simulate_session(world, seed)
    rng = np.random.default_rng([seed, 3])
    stretch = carrier(channel, begin, end)
    wave = long(stretch, made.force_n.size, min(round(PIECE_S * fs_hz), stretch.size), rng)
    emg_v = activity_v(made.force_n - made.zero_n, world) * wave + NOISE_V * rng.standard_normal(wave.size)
    force_n = made.force_n + 0.01 * rng.standard_normal(wave.size)
    return Channel("M", emg_v, "V", fs_hz, 0.0, "V"), Channel("force", force_n, "N", fs_hz, 0.0, "N")


def judged(emg: list[Channel], force: Channel, who: str, what: str) -> tuple[Trials, SessionVerdict, Floats]:
    window = WindowSettings()
    trials = extract_trials(
        {f"M{k}" if len(emg) > 1 else "M": each for k, each in enumerate(emg)}, force, participant=who, specimen=what,
        filters=FilterSettings(), cocontraction=CocontractionSettings(), window=window,
        force_channel=ForceChannelSettings(name="force"),
    )  # fmt: skip
    fits = fit_trials(trials, FitSettings(), window)
    return trials, judge_session(who, [trials], {what: fits}, {what: None}, {}), fits.b_v / B_V


def _kind(text: str) -> str:
    """What is said, without the presses and with N for numbers; its cause alone where it is a verdict on b."""
    text = re.sub(r"^most likely: |^press(es)? [0-9, -]+ |^(ok|doubtful|rejected): ", "", text)
    text = re.sub(r"^(ok|doubtful|rejected): ", "", text)
    return re.sub(r"-?\b[0-9]+(\.[0-9]+)?( to -?[0-9.]+)?\b", "N", text).replace("|", "/")


def table() -> list[str]:
    lines = ["## With their own force", "", "| recording | file | verdict | said | right? |", "|---|---|---|---|---|"]
    for name, case in WITH_FORCE.items():
        try:
            emg, force = channels(case)
            assert force is not None
            _, session, _ = judged(emg, force, "P", "S")
            verdict, said = session.verdict, "; ".join(each.text.removeprefix("S: ") for each in session.advice)
        except Emg2vsaError as error:
            verdict, said = "refused", str(error).partition(": ")[2]
        lines.append(f"| {name} | {case.file} | {verdict} | {said.replace('|', '/')} | {case.why} |")
    lines += ["", "## As carriers", "", "| recording | verdicts of three stretches | b × | said | right? |"]
    lines += ["|---|---|---|---|---|"]
    studies: dict[str, list[Trials]] = {}
    for seed, (name, case) in enumerate(CARRIERS.items()):
        (channel,), _ = channels(case)
        words: Counter[str] = Counter()
        told: Counter[str] = Counter()
        shares = []
        for k in range(3):
            carried, pressing = pressed(channel, k / 3, (k + 1) / 3, 10 * seed + k)
            one, session, ratio = judged([carried], pressing, name, f"S{k + 1}")
            studies.setdefault(name.partition(",")[0], []).append(one)
            words[session.verdict] += 1
            shares += ratio[np.isfinite(ratio)].tolist()
            kinds = (_kind(each) for advice in session.advice for each in advice.text[4:].split("; "))
            told.update(dict.fromkeys(kinds, 1))
        verdicts = ", ".join(f"{word} {n}" for word, n in words.items())
        said = "; ".join(f"{text} ({n} of 3)" for text, n in told.items()) or "nothing"
        why = case.why if told else "right: a carrier without fault"
        lines.append(f"| {name} | {verdicts} | {np.mean(shares) if shares else np.nan:.2f} | {said} | {why} |")
    lines += ["", "Compared with each other, by laboratory:", ""]
    for laboratory, trials in studies.items():
        if len(trials) > 3:
            found = screen(traits_by_recording(trials)).found
            said = "; ".join(f"{each.participant}/{each.specimen}: {each.said}" for each in found)
            lines.append(f"- {laboratory}, {len(trials)} recordings: {said or 'nothing is said'}")
    return lines


if __name__ == "__main__":
    about = (__doc__ or "").partition("\n")[2].strip().partition("    python")[0].strip()
    text = "# Public recordings\n\n" + about + "\n\n" + "\n".join(table()) + "\n"
    keep(RESULTS, text)
    print(text)

"""Control worlds with known answers: is nothing found where nothing is, and found what is there?

``python -m benchmarks.controls`` prints the tables of ``benchmarks/results/controls.json``. Spread rates come from the
true slopes of press mechanics (power law, the demo study's profiles), with the scatter of presses and mountings that
frames showed (``control_scatter.json``, from ``benchmarks.control_runs --scatter``). Whole experiments from frames are
those of ``benchmarks.control_runs``, kept in ``control_runs.jsonl``.
"""

from __future__ import annotations

import json
import sys
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path

import numpy as np
from scipy import stats

from casr.specimens import SPECIMENS
from emg2vsa.devices.qbmove.springs import SPRINGS, SpringJoint
from emg2vsa.devices.qbmove.ticks import DEG_PER_TICK
from emg2vsa.discrimination.contrast import Contrast, contrasts
from emg2vsa.discrimination.run_table import RunTable
from emg2vsa.dome_contact import PowerLaw
from emg2vsa.stiffness_effect import StiffnessEffect
from emg2vsa.worlds.bench.controls import ArtificialEffect
from emg2vsa.worlds.bench.settings import RELAXATION, EmulatedSettings
from emg2vsa.worlds.contact import Drive, Relaxation, StiffnessSteps, simulate_presses
from emg2vsa.worlds.contact.stiffness_effect import (
    Bench,
    FrameErrors,
    Material,
    frames_of,
    power_rates,
    stiffness_effect,
)
from emg2vsa.worlds.tactile import ContactWorld

RESULTS = Path(__file__).resolve().parent / "results"
NAMES = ("S1", "S2", "S3", "S5")
CONDITIONS = ("high-stiffness", "modular", "constant-min", "constant-mean", "constant-max")
MODEL, WINDOW_N, STEP_N = "qbmove-maker-pro", (0.5, 7.0), 0.3
JOINT = SpringJoint(MODEL, 3000 * DEG_PER_TICK)
A_B = {"S1": (42.0, 20.0), "S2": (36.0, 17.0), "S3": (28.0, 13.0), "S5": (16.0, 7.0)}
"Profiles a + b ln F of the demo study's [simulation], microvolts."
ALPHA, EXPERIMENTS, DRAWS = 0.05, 200, 2000


class Steps:
    """A schedule by force, as `ArtificialEffect` asks for it."""

    def __init__(self, percent: Sequence[float]) -> None:
        self.step_force_n = WINDOW_N[0] + STEP_N * np.arange(len(percent) + 1)
        self.preset = JOINT.rounded(np.array(percent) / 100)
        self.stiffness_nm_per_rad = JOINT.stiffness_nm_per_rad(self.preset)

    @property
    def steps(self) -> StiffnessSteps:
        return StiffnessSteps(self.step_force_n, JOINT.preset_rad(self.preset))


def schedules() -> dict[str, dict[str, Steps]]:
    """Condition to specimen to its schedule, and all specimens at 20, 50 and 80 %."""
    count = int(np.ceil((WINDOW_N[1] - WINDOW_N[0]) / STEP_N))
    centres_n = WINDOW_N[0] + STEP_N * (np.arange(count) + 0.5)
    low, high = A_B["S5"][0] + A_B["S5"][1] * np.log(WINDOW_N[0]), A_B["S1"][0] + A_B["S1"][1] * np.log(WINDOW_N[1])
    percent = {
        n: np.clip(20 + 60 * (a + b * np.log(centres_n) - low) / (high - low), 20, 80) for n, (a, b) in A_B.items()
    }
    of = {"modular": percent}
    of |= {
        f"constant-{level}": {n: np.full(count, pick(each)) for n, each in percent.items()}
        for level, pick in (("min", np.min), ("mean", np.mean), ("max", np.max))
    }
    of |= {f"all-{level}": {n: np.full(count, float(level)) for n in NAMES} for level in (20, 50, 80)}
    return {condition: {n: Steps(each.tolist()) for n, each in own.items()} for condition, own in of.items()}


def contact(name: str) -> PowerLaw:
    world = ContactWorld()
    return PowerLaw(world.modulus_mpa(SPECIMENS[name]), world.tip_radius_mm, world.exponent)


def effects(material: Material, errors: FrameErrors, *, swapped: bool = False) -> StiffnessEffect:
    """Mechanics of all conditions; with the schedules swapped from both ends of stiffness where asked for."""
    world, whose = ContactWorld(), dict(zip(NAMES, reversed(NAMES) if swapped else NAMES, strict=True))
    bench = Bench(
        stiffness_mpa={n: SPECIMENS[n] / (2 * world.punch_radius_mm) for n in NAMES},
        sensor_mpa=world.sensor_modulus_mpa,
        tip_radius_mm=world.tip_radius_mm,
        exponent=world.exponent,
        area_mm2=lambda name, force: contact(name).area_mm2(force),
        drive=Drive(springs=SPRINGS[MODEL]),
        steps={c: {n: own[whose[n]].steps for n in NAMES} for c, own in schedules().items()},
        window_n=WINDOW_N,
        rate_hz=20.0,
    )
    elastic = Material("elastic", 0.0, dict.fromkeys(NAMES, 0.0))
    return stiffness_effect(bench, (elastic, material), errors, "high-stiffness")


def p1_slopes(exponent: float) -> np.ndarray:
    """(K, C) slopes of area times the artificial factor, uniform in force, elastic bodies."""
    force_n = WINDOW_N[0] + (WINDOW_N[1] - WINDOW_N[0]) * (np.arange(2600) + 0.5) / 2600
    off, own = force_n - force_n.mean(), schedules()
    rows = []
    for name in NAMES:
        effect = [ArtificialEffect(exponent, None)]
        effect += [ArtificialEffect(exponent, each[name]) for each in own.values()]  # type: ignore[arg-type]
        areas = contact(name).area_mm2(force_n)
        rows.append([off @ (areas * [e.factor(f) for f in force_n.tolist()]) / (off @ off) for e in effect])
    return np.array(rows)


def p4_rates(draws: int, rng: np.random.Generator) -> dict[str, np.ndarray]:
    """Condition to (K, draws) ln spread rates of elastic presses, their areas as noisy as the stiffness is wrong."""
    own, springs = schedules(), SPRINGS[MODEL]
    right = own["modular"]["S3"]
    everyone = {"S3's profile": right} | {level: own[level]["S1"] for level in ("all-50", "all-20", "all-80")}
    found = {}
    for condition, each in (*everyone.items(), ("high-stiffness", None)):
        effect = ArtificialEffect(None, each, right)  # type: ignore[arg-type]
        steps = [each.steps] * len(NAMES) if each else ()
        drive = Drive(springs=springs if each else None)
        paths = simulate_presses([contact(n) for n in NAMES], Relaxation.of_share(0.0), drive, steps, f_max_n=7.0)
        rates = []
        for k in range(len(NAMES)):
            force, area = frames_of(paths, k, rng.uniform(0, 0.05, draws), FrameErrors(), rng)
            sd = np.array([[effect.noise_sd(f) if np.isfinite(f) else 0.0 for f in row] for row in force.tolist()])
            rates.append(np.log(power_rates(force, area * np.exp(sd * rng.standard_normal(sd.shape)), by_force=False)))
        found[condition] = np.array(rates)
    return found


def table_of(
    logs: np.ndarray,
    mountings: int,
    presses: int,
    press_sd: np.ndarray,
    mounting_sd: np.ndarray,
    rng: np.random.Generator,
) -> RunTable:
    """An experiment: ``logs`` (K, C) true ln slopes, scatter of each condition (C,)."""
    shape = (logs.shape[1], logs.shape[0], mountings, presses)
    shared = mounting_sd[:, None, None, None] * rng.standard_normal((*shape[:3], 1))
    casr = np.exp(logs.T[:, :, None, None] + shared + press_sd[:, None, None, None] * rng.standard_normal(shape))
    numbers = np.broadcast_to(np.arange(1, mountings + 1)[:, None], shape)
    flat = (*shape[:2], mountings * presses)
    return RunTable(
        conditions=CONDITIONS[: shape[0]],
        angles_deg=np.zeros(shape[0]),
        specimens=NAMES,
        stiffness_n_per_mm=np.array([SPECIMENS[n] for n in NAMES]),
        new=1,
        algorithm="front",
        area_unit="mm2",
        a_c0={},
        start_area={},
        casr={"front": casr.reshape(flat)},
        true_a_c0=np.full(flat, np.nan),
        mounting=numbers.reshape(flat),
    )


def claimed(found: Contrast) -> bool:
    return any(verdict in ("raises", "lowers") for verdict in found.verdicts)


def false_claims(
    logs: np.ndarray,
    scatter: tuple[np.ndarray, np.ndarray],
    count: int,
    seed: int,
    mountings: int = 3,
    presses: int = 3,
) -> int:
    """How many of ``count`` experiments claim anything."""
    rng = np.random.default_rng(seed)
    return sum(
        claimed(contrasts(table_of(logs, mountings, presses, *scatter, rng), ALPHA, 0.025)[0]) for _ in range(count)
    )


def power(
    logs: np.ndarray,
    pair: int,
    mountings: int,
    presses: int,
    press_sd: float,
    mounting_sd: float,
    count: int,
    seed: int,
) -> float:
    """Share of experiments in which human-like stiffness is found to raise the contrast of a pair against rigid."""
    rng, c = np.random.default_rng(seed), logs.shape[1]
    scatter, found = (np.full(c, press_sd), np.full(c, mounting_sd)), 0
    for _ in range(count):
        (slope,) = contrasts(table_of(logs, mountings, presses, *scatter, rng), ALPHA, mounting_sd)
        at = (slope.one == 1) & (slope.other == 0) & (slope.pair == pair)
        found += slope.verdicts[int(np.flatnonzero(at)[0])] == "raises"
    return found / count


def measured_scatter() -> tuple[np.ndarray, np.ndarray]:
    """(C,) SD of ln CASR from press to press, and from mounting to mounting, as frames of control N1 showed them."""
    said: Mapping[str, Mapping[str, float]] = json.loads((RESULTS / "control_scatter.json").read_text())
    press, mounting = ([said[c][key] for c in CONDITIONS] for key in ("press_sd", "mounting_sd"))
    return np.array(press), np.array(mounting)


def mountings_needed(logs: np.ndarray, pair: int, press_sd: float, mounting_sd: float, presses: int) -> int:
    """Fewest mountings per cell for a power of 80 %: noncentral t of four cells."""
    sd = float(np.hypot(mounting_sd, press_sd / np.sqrt(presses)))
    return next(m for m in range(2, 5000) if exact_power(logs, pair, m, sd) >= 0.8)


def exact_power(logs: np.ndarray, pair: int, replicates: int, sd: float) -> float:
    """Of that many in each of four cells, by the noncentral t; tests before it in the order are not counted."""
    contrast, df = logs[[3, 1][pair]] - logs[0], 4 * (replicates - 1)
    shift = float(contrast[1] - contrast[0]) / (sd * float(np.sqrt(4 / replicates)))
    return float(stats.nct.sf(stats.t.ppf(1 - ALPHA / 2, df), df, shift))


def timing_errors() -> FrameErrors:
    """Of P2."""
    return FrameErrors(area_share=0.01, force_n=0.01, latency_sd_s=0.005, jitter_s=0.005)


def worlds() -> dict[str, np.ndarray]:
    """Control to (K, 5) ln of true slopes: N1 to N3."""
    honest = Material("honest", EmulatedSettings().sensor_relaxation, {n: RELAXATION[n] for n in NAMES})
    usual, swapped = (effects(honest, timing_errors(), swapped=each) for each in (False, True))
    return {
        "N1": np.log(usual.slope[0, :, :5]),
        "N2": np.log(usual.slope[1, :, :5]),
        "N3": np.log(swapped.slope[1, :, :5]),
    }


def _row(*cells: object) -> str:
    return "| " + " | ".join(f"{cell:.3f}" if isinstance(cell, float) else str(cell) for cell in cells) + " |"


def _head(*names: str) -> str:
    return _row(*names) + "\n" + _row(*["---"] * len(names))


def _contrasts_told(logs: np.ndarray) -> list[str]:
    return [f"{softest:.3f} / {close:.4f}" for softest, close in zip(logs[3] - logs[0], logs[1] - logs[0], strict=True)]


def main() -> int:
    print("# Controls: what is found in worlds with a known answer\n")
    print("Made by `python -m benchmarks.controls`. Contrasts are ln(S5/S1) / ln(S2/S1) of true slopes.\n")
    print("\n".join(_truth()))
    print("\n".join(_negatives()))
    print("\n".join(_positives()))
    print("\n".join(_from_frames()))
    return 0


def _truth() -> Iterator[str]:
    yield "## True contrasts\n"
    yield _head("world", *CONDITIONS)
    for name, logs in worlds().items():
        yield _row(name, *_contrasts_told(logs))
    for exponent in (0.02, 0.05, 0.10):
        yield _row(f"P1, exponent {exponent:g}", *_contrasts_told(np.log(p1_slopes(exponent)[:, :5])))
    elastic = Material("elastic", 0.0, dict.fromkeys(NAMES, 0.0))
    for name, swapped in (("P3, frame sum", False), ("N3, frame sum", True)):
        yield _row(name, *_contrasts_told(np.log(effects(elastic, FrameErrors(), swapped=swapped).frame_sum[:, :5])))
    yield ""


def _negatives() -> Iterator[str]:
    yield "## No effect: experiments of 200 in which anything is claimed\n"
    yield "Five conditions, four specimens, three mountings of three presses; 5 % allowed.\n"
    yield _head("world", "scatter of frames", "2.5 % and 4 % a press", "2.5 %, presses 8 % rigid and 2 % others")
    press, mounting = measured_scatter()
    uneven = np.array([0.08, 0.02, 0.02, 0.02, 0.02])
    scatters = ((press, mounting), (np.full(5, 0.04), np.full(5, 0.025)), (uneven, np.full(5, 0.025)))
    for place, (name, logs) in enumerate(worlds().items()):
        counts = [false_claims(logs, each, EXPERIMENTS, 100 * place + k) for k, each in enumerate(scatters)]
        yield _row(name, *(f"{count} ({100 * count / EXPERIMENTS:.1f} %)" for count in counts))
    yield ""


def _positives() -> Iterator[str]:
    logs = np.log(p1_slopes(0.05)[:, :5])
    yield "## P1, exponent 0.05: power of human-like against rigid, 80 % wanted\n"
    yield "One mounting, mountings alike, 3 % a press:\n"
    yield _head("pair", "presses per cell", "power (2000 experiments)", "by the noncentral t")
    for pair, name, presses in ((0, "S5 : S1", 3), (1, "S2 : S1", 40)):
        yield _row(
            name, presses, power(logs, pair, 1, presses, 0.03, 0.0, 2000, 7 + pair),
            exact_power(logs, pair, presses, 0.03),
        )  # fmt: skip
    yield "\nWith mountings that differ (three presses each, 3 % a press):\n"
    yield _head("pair", "SD of mountings", "power with 3 mountings", "mountings needed for 80 %")
    measured = float(np.sqrt(np.mean(measured_scatter()[1] ** 2)))
    for pair, name in ((0, "S5 : S1"), (1, "S2 : S1")):
        for sd in (0.025, measured):
            yield _row(
                name, f"{100 * sd:.1f} %", power(logs, pair, 3, 3, 0.03, sd, 300, 20 + pair),
                mountings_needed(logs, pair, 0.03, sd, 3),
            )  # fmt: skip
    timing = effects(Material("P2", 0.10, dict.fromkeys(NAMES, 0.05)), timing_errors())
    yield "\n## P2, errors of timing: d' of S1 and S2\n"
    yield _head("condition", "CV S1 (%)", "CV S2 (%)", "d'")
    for c in np.argsort(timing.timing_d):
        cv = 100 * timing.timing_cv[:, c]
        yield _row(timing.conditions[c], f"{cv[0]:.1f}", f"{cv[1]:.1f}", f"{timing.timing_d[c]:.1f}")
    yield "\n## P4, noise of the area: d' of S1 and S2\n"
    yield _head("condition", "CV S1 (%)", "CV S2 (%)", "CV S5 (%)", "d'", "ln(S5/S1)")
    for condition, rates in p4_rates(DRAWS, np.random.default_rng(4)).items():
        sd, mean = rates.std(axis=1, ddof=1), rates.mean(axis=1)
        separate = (mean[1] - mean[0]) / np.sqrt((sd[0] ** 2 + sd[1] ** 2) / 2)
        cells = [f"{100 * each:.1f}" for each in (sd[0], sd[1], sd[3])]
        yield _row(condition, *cells, f"{separate:.1f}", float(mean[3] - mean[0]))
    yield ""


def _from_frames() -> Iterator[str]:
    path = RESULTS / "control_runs.jsonl"
    if not path.is_file():
        return
    yield "## Whole experiments from frames (`benchmarks.control_runs`)\n"
    yield "Rigid and human-like, four specimens, three mountings of two presses.\n"
    yield _head("world", "seed", "slope: change of S5 : S1 (%)", "claims", "equation (2): change (%)", "claims")
    for line in path.read_text().splitlines():
        found = json.loads(line)
        cells = []
        for measure in ("slope", "frame_sum"):
            ends = [f"{100 * np.expm1(end):+.1f}" for end in found[measure]["change"]]
            claims = sum(verdict in ("raises", "lowers") for verdict in found[measure]["verdicts"])
            cells += [f"{ends[0]} [{ends[1]}, {ends[2]}]", claims]
        yield _row(found["world"], found["seed"], *cells)


if __name__ == "__main__":
    sys.exit(main())

"""Control worlds with known answers: is nothing found where nothing is, and found what is there?

``python -m benchmarks.controls`` prints the tables of ``benchmarks/results/controls.json``. Spread rates come from the
true rates of press mechanics (finite elements of the skin, as the emulated bench has them, and the demo study's
profiles), with the scatter of presses and mountings that frames showed (``control_scatter.json``, from
``benchmarks.control_runs --scatter``). Whole experiments from frames are those of ``benchmarks.control_runs``, kept in
``control_runs.jsonl``.
"""

from __future__ import annotations

import json
import sys
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np
from scipy import stats

from casr.errors import FramesError
from casr.specimens import SPECIMENS
from casr.spread import fit_power_laws, spread_rate
from emg2vsa.arrays import Floats
from emg2vsa.devices.qbmove.springs import SPRINGS, SpringJoint
from emg2vsa.devices.qbmove.ticks import DEG_PER_TICK
from emg2vsa.discrimination.contrast import contrasts
from emg2vsa.discrimination.mountings import Mountings
from emg2vsa.discrimination.run_table import RunTable
from emg2vsa.discrimination.separation import gaps_of, sd_ratio
from emg2vsa.dome_contact import PowerLaw
from emg2vsa.stiffness_effect import StiffnessEffect
from emg2vsa.worlds.bench.controls import ArtificialEffect
from emg2vsa.worlds.bench.settings import RELAXATION, EmulatedSettings
from emg2vsa.worlds.contact import Drive, Relaxation, StiffnessSteps, in_series, simulate_presses, specimen_share
from emg2vsa.worlds.contact.stiffness_effect import Bench, FrameErrors, Material, frames_of, stiffness_effect
from emg2vsa.worlds.tactile import ContactWorld, TabulatedWorld

RESULTS = Path(__file__).resolve().parent / "results"
NAMES = ("S1", "S2", "S3", "S5")
CONDITIONS = ("high-stiffness", "modular", "constant-min", "constant-mean", "constant-max")
MODEL, WINDOW_N, STEP_N = "qbmove-maker-pro", (0.5, 7.0), 0.3
JOINT = SpringJoint(MODEL, 3000 * DEG_PER_TICK)
A_B = {"S1": (42.0, 20.0), "S2": (36.0, 17.0), "S3": (28.0, 13.0), "S5": (16.0, 7.0)}
"Profiles a + b ln F of the demo study's [simulation], microvolts."
WORLD, SKIN = ContactWorld(), TabulatedWorld()
"What moves the probe, and the contact that the camera sees, of the emulated bench by default."
ALPHA, EXPERIMENTS, DRAWS = 0.05, 200, 300
TIMING = FrameErrors(force_n=0.01, latency_sd_s=0.005, jitter_s=0.005)
"Of P2."


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
    """Condition to specimen to its schedule."""
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
    return {condition: {n: Steps(each.tolist()) for n, each in own.items()} for condition, own in of.items()}


def contact(name: str) -> PowerLaw:
    return PowerLaw(WORLD.modulus_mpa(SPECIMENS[name]), WORLD.tip_radius_mm, WORLD.exponent)


def area_mm2(name: str, force_n: Floats) -> Floats:
    """Of the contact under an elastic force, by finite elements."""
    return np.asarray(np.pi * SKIN.radius_mm(force_n, SPECIMENS[name]) ** 2)


def stiffness_mpa(name: str) -> float:
    return WORLD.specimen_mpa(SPECIMENS[name])


def effects(material: Material, errors: FrameErrors, *, swapped: bool = False) -> StiffnessEffect:
    """Mechanics of all conditions; with the schedules swapped from both ends of stiffness where asked for."""
    whose = dict(zip(NAMES, reversed(NAMES) if swapped else NAMES, strict=True))
    bench = Bench(
        stiffness_mpa={n: stiffness_mpa(n) for n in NAMES},
        sensor_mpa=WORLD.sensor_modulus_mpa,
        tip_radius_mm=WORLD.tip_radius_mm,
        exponent=WORLD.exponent,
        area_mm2=area_mm2,
        drive=Drive(springs=SPRINGS[MODEL]),
        steps={c: {n: own[whose[n]].steps for n in NAMES} for c, own in schedules().items()},
        window_n=WINDOW_N,
        rate_hz=20.0,
    )
    elastic = Material("elastic", 0.0, dict.fromkeys(NAMES, 0.0))
    return stiffness_effect(bench, (elastic, material), errors, "high-stiffness")


def p1_rates(exponent: float) -> np.ndarray:
    """(K, C) spread rates of area times the artificial factor, elastic bodies."""
    force_n, own = np.linspace(*WINDOW_N, 2600), schedules()
    rows = []
    for name in NAMES:
        effect = [ArtificialEffect(exponent, None)]
        effect += [ArtificialEffect(exponent, each[name]) for each in own.values()]  # type: ignore[arg-type]
        areas = area_mm2(name, force_n)
        seen = np.array([areas * [e.factor(f) for f in force_n.tolist()] for e in effect])
        rows.append(fit_power_laws(seen, np.broadcast_to(force_n, seen.shape)).mean_rates(*WINDOW_N))
    return np.array(rows)


def seen_logs(
    own: Mapping[str, Mapping[str, Steps]],
    relaxation: tuple[float, float],
    errors: FrameErrors,
    rng: np.random.Generator,
    right: Steps | None = None,
) -> Floats:
    """(K, C, draws) ln spread rates as casr makes them of the frames of a press, the rigid motor first.

    relaxation : shares of sensor and specimens. right : the schedule with which areas are least noisy, of P4.
    """
    contacts, bodies = [contact(n) for n in NAMES], []
    for name in NAMES:
        share = specimen_share(stiffness_mpa(name), WORLD.sensor_modulus_mpa)
        parts = [(share, Relaxation.of_share(relaxation[1])), (1 - share, Relaxation.of_share(relaxation[0]))]
        bodies.append(in_series(parts))
    found = np.full((len(NAMES), len(CONDITIONS), DRAWS), np.nan)
    for c, condition in enumerate(CONDITIONS):
        each = own.get(condition)
        drive = Drive(springs=SPRINGS[MODEL] if each else None)
        steps = [each[n].steps for n in NAMES] if each else ()
        paths = simulate_presses(contacts, bodies, drive, steps, f_max_n=WINDOW_N[1])
        areas = [area_mm2(n, force) for n, force in zip(NAMES, paths.convolved_n.T, strict=True)]
        paths = replace(paths, area_mm2=np.stack(areas, axis=1))
        for k, name in enumerate(NAMES):
            force, area = frames_of(paths, k, rng.uniform(0, 0.05, DRAWS), errors, rng)
            if right:
                effect = ArtificialEffect(None, each[name] if each else None, right)  # type: ignore[arg-type]
                sd = np.array([[effect.noise_sd(f) if np.isfinite(f) else 0.0 for f in row] for row in force.tolist()])
                area = area * np.exp(sd * rng.standard_normal(sd.shape))
            found[k, c] = [_log_rate(*press) for press in zip(area, force, strict=True)]
    return found


def _log_rate(area: Floats, force_n: Floats) -> float:
    seen = np.isfinite(force_n)
    try:
        return float(np.log(spread_rate(area[seen], force_n[seen]).value))
    except FramesError:
        return np.nan


def table_of(
    logs: np.ndarray,
    mountings: int,
    presses: int,
    press_sd: np.ndarray,
    mounting_sd: np.ndarray,
    rng: np.random.Generator,
) -> RunTable:
    """An experiment in random order: ``logs`` (K, C) true ln rates, scatter of each condition (C,)."""
    shape = (logs.shape[1], logs.shape[0], mountings, presses)
    shared = mounting_sd[:, None, None, None] * rng.standard_normal((*shape[:3], 1))
    casr = np.exp(logs.T[:, :, None, None] + shared + press_sd[:, None, None, None] * rng.standard_normal(shape))
    numbers = np.broadcast_to(np.arange(1, mountings + 1)[:, None], shape)
    order = 1.0 + rng.permutation(numbers[..., 0].size).reshape(*shape[:3], 1)
    flat = (*shape[:2], mountings * presses)
    return RunTable(
        conditions=CONDITIONS[: shape[0]],
        angles_deg=np.zeros(shape[0]),
        specimens=NAMES,
        stiffness_n_per_mm=np.array([SPECIMENS[n] for n in NAMES]),
        new=1,
        algorithm="front",
        area_unit="mm2",
        casr={"front": casr.reshape(flat)},
        mounting=numbers.reshape(flat),
        position=np.broadcast_to(order, shape).reshape(flat),
    )


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
    tables = (table_of(logs, mountings, presses, *scatter, rng) for _ in range(count))
    return sum(bool({"raises", "lowers"} & {*contrasts(each, ALPHA, 0.025)[0].verdicts}) for each in tables)


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


def measured_scatter(world: str = "N1", of: str = "") -> tuple[np.ndarray, np.ndarray]:
    """(C,) SD of ln CASR from press to press, and from mounting to mounting, as frames of a control showed them.

    of : "vision_" for CASR over that of truth.json."""
    said: Mapping[str, Mapping[str, float]] = json.loads((RESULTS / "control_scatter.json").read_text())[world]
    press, mounting = ([said[c][f"{of}{key}"] for c in CONDITIONS] for key in ("press_sd", "mounting_sd"))
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


def p2_logs() -> tuple[Floats, np.ndarray]:
    """(K, C, draws) ln rates in P2, and (C,) what the delay of the camera adds from mounting to mounting."""
    rng = np.random.default_rng(2)
    late = FrameErrors(latency_sd_s=TIMING.latency_sd_s)
    return seen_logs(schedules(), (0.10, 0.05), TIMING, rng), _press_sd(seen_logs(schedules(), (0.10, 0.05), late, rng))


def p4_logs() -> Floats:
    """(K, C, draws) ln rates in P4, all specimens under the schedules of S3."""
    of_one = {condition: dict.fromkeys(NAMES, own["S3"]) for condition, own in schedules().items()}
    rng = np.random.default_rng(4)
    return seen_logs(of_one, (0.0, 0.0), FrameErrors(force_n=0.01), rng, of_one["modular"]["S3"])


def _press_sd(logs: Floats) -> np.ndarray:
    return np.asarray(np.sqrt(np.nanvar(logs, axis=2, ddof=1).mean(axis=0)))


def gaps_told(logs: Floats, mounting_sd: np.ndarray) -> Iterator[str]:
    """d' of S1 and S2 by condition: of the presses themselves, with what vision adds, and as experiments find it."""
    mean, own = np.nanmean(logs, axis=2), _press_sd(logs)
    press, mounting = measured_scatter("P1", "vision_")
    press, mounting = np.hypot(own, press), np.hypot(mounting_sd, mounting)
    rng = np.random.default_rng(8)
    tables = [table_of(mean, 3, 4, press, mounting, rng) for _ in range(5 * EXPERIMENTS)]
    scores = [Mountings.of_table(each, each.casr["front"], 0.0) for each in tables]
    gaps, at = [gaps_of(each, (0, 1), 1 - ALPHA) for each in scores], np.arange(len(CONDITIONS))[:, None]
    found = np.array([each.gap for each in gaps]).T
    yield _head("condition", "SD of a press (%)", "d'", "with vision: SD (%)", "d'", "d' found, 95 %",
                "above rigid (%)", "by its interval (%)", "SD unlike human-like's (%)")  # fmt: skip
    for c, condition in enumerate(CONDITIONS):
        apart = mean[1, c] - mean[0, c]
        sds = [(f"{100 * sd:.1f}", f"{apart / sd:.1f}") for sd in (own[c], press[c])]
        ends = "{:.1f} to {:.1f}".format(*np.quantile(found[c], (0.025, 0.975)))
        shown = [each.at(at[c]).less(each.at(at[0])).low[0] > 0 for each in gaps]
        ratios = [sd_ratio(each, 1, c, 1 - ALPHA) for each in scores]
        unlike = [low > 1 or high < 1 for _, low, high in ratios]
        shares = [f"{100 * np.mean(each):.0f}" for each in (found[c] > found[0], shown, unlike)]
        yield _row(condition, *sds[0], *sds[1], ends, *shares)
    yield ""


def worlds() -> dict[str, np.ndarray]:
    """Control to (K, 5) ln of true rates: N1 to N3."""
    honest = Material("honest", EmulatedSettings().sensor_relaxation, {n: RELAXATION[n] for n in NAMES})
    usual, swapped = (effects(honest, TIMING, swapped=each) for each in (False, True))
    return {
        "N1": np.log(usual.rate[0]),
        "N2": np.log(usual.rate[1]),
        "N3": np.log(swapped.rate[1]),
    }


def _row(*cells: object) -> str:
    return "| " + " | ".join(f"{cell:.3f}" if isinstance(cell, float) else str(cell) for cell in cells) + " |"


def _head(*names: str) -> str:
    return _row(*names) + "\n" + _row(*["---"] * len(names))


def _contrasts_told(logs: np.ndarray) -> list[str]:
    return [f"{softest:.3f} / {close:.4f}" for softest, close in zip(logs[3] - logs[0], logs[1] - logs[0], strict=True)]


def main() -> int:
    print("# Controls: what is found in worlds with a known answer\n")
    print("Made by `python -m benchmarks.controls`. Contrasts are ln(S5/S1) / ln(S2/S1) of true rates.\n")
    for part in (_truth, _negatives, _positives, _from_frames):
        print("\n".join(part()))
    return 0


def _truth() -> Iterator[str]:
    yield "## True contrasts\n"
    yield _head("world", *CONDITIONS)
    for name, logs in worlds().items():
        yield _row(name, *_contrasts_told(logs))
    for exponent in (0.02, 0.05, 0.10):
        yield _row(f"P1, exponent {exponent:g}", *_contrasts_told(np.log(p1_rates(exponent))))
    elastic = Material("elastic", 0.0, dict.fromkeys(NAMES, 0.0))
    for name, swapped in (("P3, frame sum", False), ("N3, frame sum", True)):
        yield _row(name, *_contrasts_told(np.log(effects(elastic, FrameErrors(), swapped=swapped).frame_sum)))
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
    logs = np.log(p1_rates(0.05))
    yield "## P1, exponent 0.05: power of human-like against rigid, 80 % wanted\n"
    yield "Three presses of each mounting, 3 % a press:\n"
    yield _head("pair", "SD of mountings", "power with 3 mountings", "mountings needed for 80 %")
    measured = float(np.sqrt(np.mean(measured_scatter()[1] ** 2)))
    for pair, name in ((0, "S5 : S1"), (1, "S2 : S1")):
        for sd in (0.025, measured):
            yield _row(
                name, f"{100 * sd:.1f} %", power(logs, pair, 3, 3, 0.03, sd, 300, 20 + pair),
                mountings_needed(logs, pair, 0.03, sd, 3),
            )  # fmt: skip
    yield "\n## d' of S1 and S2, three mountings of four presses\n"
    yield "SDs are of ln CASR of a press within its mounting, over the specimens, as in the report.\n"
    for world, logs, mounting_sd in (
        ("P2, errors of timing", *p2_logs()),
        ("P4, noise of the area", p4_logs(), np.zeros(5)),
    ):
        yield f"{world}:\n"
        yield from gaps_told(logs, mounting_sd)


def _from_frames() -> Iterator[str]:
    path = RESULTS / "control_runs.jsonl"
    if not path.is_file():
        return
    runs = [json.loads(line) for line in path.read_text().splitlines()]
    yield "## Whole experiments from frames (`benchmarks.control_runs`)\n"
    yield "Studies of `studies/controls`; changes of S5 : S1 by human-like stiffness against the rigid motor.\n"
    yield _head("world", "seed", "true (%)", "slope (%)", "equation (2) (%)", "d' rigid", "d' human-like", "d' softest")
    for found in runs:
        changes = [f"{e[0]:+.1f} [{e[1]:+.1f}, {e[2]:+.1f}]" for e in
                   (100 * np.expm1(found[measure]["change"]) for measure in ("slope", "frame_sum"))]  # fmt: skip
        gaps = ["{:.1f} [{:.1f}, {:.1f}]".format(*found["gaps"][condition]) for condition in CONDITIONS[:3]]
        yield _row(found["world"], found["seed"], f"{100 * np.expm1(found['true_change']):+.1f}", *changes, *gaps)
    yield "\nVerdicts on the rig's claims:\n"
    yield _head("claim", *(f"{found['world']}, {found['seed']}" for found in runs))
    for claim in dict.fromkeys(key for found in runs for key in found["claims"]):
        yield _row(claim, *(found["claims"].get(claim, "") for found in runs))


if __name__ == "__main__":
    sys.exit(main())

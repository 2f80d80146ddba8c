"""Control worlds end to end, from frames: ``python -m benchmarks.control_runs OUT [WORLD ...] [--seeds N]``.

Every experiment is a study of ``studies/controls``, whole, with a seed of its own. OUT gets one line of JSON for each:
the change of contrast that ``emg2vsa run`` finds beside that of truth.json, how far conditions set the closest
specimens apart, and the verdict of every claim on the rig.

``python -m benchmarks.control_runs OUT --scatter STUDY ...`` writes what presses and mountings of control studies that
have been run scatter by: SDs of ln CASR by condition, of the scores and of the scores over truth.json, which is what
vision adds.
"""

from __future__ import annotations

import argparse
import json
import sys
import tempfile
import time
from pathlib import Path

import numpy as np

from emg2vsa import artifacts
from emg2vsa.arrays import Floats
from emg2vsa.cli import main as emg2vsa
from emg2vsa.discrimination.contrast_words import contrast_words, headline
from emg2vsa.discrimination.discriminate import Discrimination
from emg2vsa.discrimination.mountings import Mountings
from emg2vsa.discrimination.run_table import HUMAN_LIKE, RIGID, RunTable
from emg2vsa.rig.experiment import run_name
from emg2vsa.worlds.bench.truth import read_truth

STUDIES = Path(__file__).resolve().parent.parent / "studies"


def experiment(world: str, seed: int, folder: Path) -> dict[str, object]:
    """One experiment in a control world; what was found of both measures."""
    data = folder / "palpation"
    if not data.exists():
        data.mkdir()
        for name in ("study.toml", "rig.toml"):
            (data / name).write_text((STUDIES / "palpation" / name).read_text())
        assert emg2vsa(["tools", "simulate", str(data / "study.toml"), "--json"]) == 0
    own = folder / f"{world}-{seed}"
    own.mkdir()
    for name in (f"{world}.toml", f"{world}-rig.toml"):
        text = (STUDIES / "controls" / name).read_text()
        (own / name).write_text(text + (f"seed = {seed}\n" if name.endswith("-rig.toml") else ""))
    start = time.monotonic()
    assert emg2vsa(["run", str(own / f"{world}.toml"), "--json"]) == 0
    seconds = time.monotonic() - start
    found = discrimination(own, world)
    table, gaps = found.table, found.conditions.gaps
    told: dict[str, object] = {"world": world, "seed": seed, "seconds": round(seconds, 1)}
    true, rigid, human = np.log(true_casr(own / f"runs-{world}", table)), *_at_zero(table)
    for contrast in found.contrasts:
        i = headline(contrast, table.conditions)
        assert i is not None
        told[contrast.measure] = {"change": list(contrast.changes.at(i)), "verdicts": list(contrast.verdicts)}
    rise = np.nanmean(true[human] - true[rigid], axis=1)
    told["true_change"] = float(rise[-1] - rise[0])  # softest over stiffest, as the headline
    told["gaps"] = {
        table.conditions[d]: [float(each[d]) for each in (gaps.gap, gaps.low, gaps.high)]
        for d in np.flatnonzero(table.angles_deg == 0).tolist()
    }
    results = json.loads((own / "reports" / f"control-{world}" / "results.json").read_text())
    ends = {key.removesuffix(".unit_of_error"): unit for key, unit in results.items() if key.endswith(".unit_of_error")}
    told["claims"] = {
        key.removeprefix("claims."): results[f"{key}.verdict"] for key, unit in ends.items() if unit in _OF_RIG
    }
    return told | {"presses": int((table.mounting > 0).sum()), "words": contrast_words(found)}


_OF_RIG = ("mounting", "press")


def discrimination(folder: Path, world: str) -> Discrimination:
    """What the newest run of a control study in ``folder`` found."""
    results = (folder / ".emg2vsa" / f"control-{world}" / "store" / "discrimination" / "study").glob("*.result")
    found: Discrimination = artifacts.load(max(results, key=lambda path: path.stat().st_mtime))
    return found


def true_casr(runs: Path, table: RunTable) -> Floats:
    """(D, S, R) of truth.json, mm2/N, for the presses of ``table``; NaN where there is none."""
    true = np.full(table.mounting.shape, np.nan)
    designs = enumerate(zip(table.conditions, table.angles_deg.tolist(), strict=True))
    for d, (condition, angle_deg) in designs:
        for s, specimen in enumerate(table.specimens):
            for m in range(1, int(table.mounting[d, s].max()) + 1):
                own = [each.casr_mm2_per_n for each in read_truth(runs / run_name(specimen, angle_deg, condition, m))]
                true[d, s, table.mounting[d, s] == m] = own
    return true


def scatter(study: Path) -> dict[str, dict[str, float]]:
    """Condition to the SD of ln CASR at 0 degrees from press to press of a mounting, and between mountings."""
    table = discrimination(study.parent, study.stem).table
    seen = table.casr[table.algorithm]
    true = true_casr(study.parent / f"runs-{study.stem}", table)
    found = {}
    for condition in dict.fromkeys(table.conditions):
        own = [table.design(condition, 0.0)]
        sds = [_sds(each, table.mounting, own) for each in (seen, seen / true)]
        keys = ("press_sd", "mounting_sd", "vision_press_sd", "vision_mounting_sd")
        found[condition] = dict(zip(keys, [*sds[0], *sds[1]], strict=True))
        found[condition]["presses"] = int((table.mounting[own] > 0).sum())
    return found


def _sds(scores: Floats, mounting: np.ndarray, designs: list[int]) -> tuple[float, float]:
    of = Mountings.of(scores[designs], mounting[designs], 0.0)
    press_sd, _ = of.press_sd(range(len(designs)))
    between = of.scatter.sum() / np.maximum(of.count - 1, 0).sum() - press_sd**2 * np.mean(1 / of.presses)
    return press_sd, float(np.sqrt(max(between, 0.0)))


def _at_zero(table: RunTable) -> tuple[int, int]:
    return table.design(RIGID, 0.0), table.design(HUMAN_LIKE, 0.0)


def main(words: list[str]) -> int:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("out", type=Path)
    parser.add_argument("worlds", nargs="*", default=["N1", "N2", "N3", "P1", "P2", "P3", "P4"])
    parser.add_argument("--seeds", type=int, default=1)
    parser.add_argument("--scatter", type=Path, nargs="+", metavar="STUDY")
    arguments = parser.parse_args(words)
    if arguments.scatter:
        told = {study.stem: scatter(study) for study in arguments.scatter}
        arguments.out.write_text(json.dumps(told, indent=1) + "\n")
        return 0
    with tempfile.TemporaryDirectory() as folder:
        for seed in range(1, arguments.seeds + 1):
            for world in arguments.worlds:
                found = experiment(world, seed, Path(folder))
                with arguments.out.open("a") as out:
                    out.write(json.dumps(found) + "\n")
                print(world, seed, found["seconds"], found["words"], file=sys.stderr)
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))

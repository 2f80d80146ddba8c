"""Control worlds end to end, from frames: ``python -m benchmarks.control_runs OUT [WORLD ...] [--seeds N]``.

``python -m benchmarks.control_runs OUT --scatter STUDY`` writes what presses and mountings of a study that has been run
scatter by: a line of JSON with the SD of ln CASR by condition.

Every experiment is a study of its own: the emulated rig presses four specimens with the rigid motor and with human-like
stiffness, three mountings of two presses, and ``emg2vsa run`` says what it finds. OUT gets one line of JSON for each.
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
from emg2vsa.cli import main as emg2vsa
from emg2vsa.discrimination.contrast_words import contrast_words, headline

STUDIES = Path(__file__).resolve().parent.parent / "studies"
_FEWER = (
    ("repetitions = 3", "repetitions = 2"),
    ("constant-min = [0]\nconstant-mean = [0]\nconstant-max = [0]\n", ""),
)


def experiment(world: str, seed: int, folder: Path) -> dict[str, object]:
    """One experiment in a control world; what was found of both measures."""
    data = folder / "palpation"
    if not data.exists():
        data.mkdir()
        (data / "study.toml").write_text((STUDIES / "palpation" / "study.toml").read_text())
        (data / "rig.toml").write_text((STUDIES / "palpation" / "rig.toml").read_text())
        assert emg2vsa(["tools", "simulate", str(data / "study.toml"), "--json"]) == 0
    own = folder / f"{world}-{seed}"
    own.mkdir()
    for name in (f"{world}.toml", f"{world}-rig.toml"):
        text = (STUDIES / "controls" / name).read_text()
        for before, after in _FEWER:
            text = text.replace(before, after)
        (own / name).write_text(text + (f"seed = {seed}\n" if name.endswith("-rig.toml") else ""))
    start = time.monotonic()
    assert emg2vsa(["run", str(own / f"{world}.toml"), "--only", "discrimination", "--json"]) == 0
    (path,) = own.glob(".emg2vsa/*/store/discrimination/study/*.result")
    found = artifacts.load(path)
    told: dict[str, object] = {"world": world, "seed": seed, "seconds": round(time.monotonic() - start, 1)}
    table = found.table
    human = table.of_condition("modular")[0]
    for contrast in found.contrasts:
        i = headline(contrast, table.conditions)
        changes, levels, last = contrast.changes, contrast.levels, len(contrast.pairs) - 1
        level = human * len(contrast.pairs) + last
        told[contrast.measure] = {
            "change": [float(each[i]) for each in (changes.estimate, changes.low, changes.high)],
            "p": float(changes.p[i]),
            "verdicts": list(contrast.verdicts),
            "closest": [float(each[level]) for each in (levels.estimate, levels.low, levels.high)],
            "rising": bool(np.all(np.diff([_mean(table, contrast.algorithm, human, s) for s in range(4)]) > 0)),
        }
    return told | {"presses": int((table.mounting > 0).sum()), "words": contrast_words(found)}


def scatter(study: Path) -> dict[str, dict[str, float]]:
    """Condition to the SD of ln CASR from press to press of a mounting, and between mountings, over specimens."""
    (path,) = (study.parent / ".emg2vsa" / f"control-{study.stem}" / "store" / "discrimination" / "study").glob(
        "*.result"
    )
    table = artifacts.load(path).table
    found = {}
    for d, condition in enumerate(table.conditions):
        within, between, presses = [], [], []
        for s in range(len(table.specimens)):
            logs, mounting = np.log(table.casr[table.algorithm][d, s]), table.mounting[d, s]
            own = [logs[(mounting == m) & np.isfinite(logs)] for m in range(1, mounting.max() + 1)]
            within += [each.var(ddof=1) for each in own]
            between.append(np.var([each.mean() for each in own], ddof=1))
            presses += [each.size for each in own]
        press = float(np.mean(within))
        mounting_variance = max(0.0, float(np.mean(between)) - press * float(np.mean(1 / np.array(presses))))
        found[condition] = {"press_sd": press**0.5, "mounting_sd": mounting_variance**0.5, "presses": sum(presses)}
    return found


def _mean(table, algorithm: str, design: int, specimen: int) -> float:  # type: ignore[no-untyped-def]
    return float(np.nanmean(table.casr[algorithm][design, specimen]))


def main(words: list[str]) -> int:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("out", type=Path)
    parser.add_argument("worlds", nargs="*", default=["N1", "N2", "N3"])
    parser.add_argument("--seeds", type=int, default=3)
    parser.add_argument("--scatter", type=Path, metavar="STUDY")
    arguments = parser.parse_args(words)
    if arguments.scatter:
        arguments.out.write_text(json.dumps(scatter(arguments.scatter), indent=1) + "\n")
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

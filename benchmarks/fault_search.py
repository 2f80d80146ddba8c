"""A search for the faults that press hardest: kind, size, time, healing, and pairs, on the emulated rig with bytes.

``python -m benchmarks.fault_search [--runs 400] [--seconds 60] [--seed 1] | python -m benchmarks.bench.record
fault_search``. Half of the runs have one fault, half two. Then the worst are changed by chance and kept where the
specimen feels more, for so many seconds an actuator.

``python -m benchmarks.fault_search --plots FOLDER`` draws the worst cases of the record, and searches nothing.
"""

from __future__ import annotations

import argparse
import json
import math
import random
import time
from collections.abc import Callable, Iterator
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from tempfile import TemporaryDirectory

from benchmarks.bench.record import RESULTS
from benchmarks.dynamixel_faults import built as dynamixel_bench
from benchmarks.rig.fault_bench import Built, FaultBench
from benchmarks.rig.fault_case import plan_of
from emg2vsa.errors import Emg2vsaError, SettingError
from emg2vsa.worlds.bench.faults import faults_of, put

PROCESSES = 2
BENCHES = {"qbmove": Built(), "rigid": Built(rigid=True), "dynamixel": dynamixel_bench()}
LIMIT_N, MOST_N, COMPLETED_N, LEFT_N = 10.0, 13.0, 11.0, 0.5
RUN_S = 4.0
"""In which a fault may strike: longer than a run of one press."""
_CAMERA = {"drop", "dark", "few-frames", "old-frames"}
WORST = 10


Names = dict[str, tuple[str, float, float, float, bool]]
"""Of faults: kind, usual size, least, most, and whether it lasts."""


@dataclass(frozen=True)
class Result:
    """One run. lines : its faults as they are typed. true_n : largest force on the specimen; left_n : at the end."""

    actuator: str
    lines: tuple[str, ...]
    how: str
    cause: str
    true_n: float
    left_n: float

    @property
    def completed_n(self) -> float:
        """The largest force of a run that says it is whole."""
        return self.true_n if self.how == "completed" else 0.0


def draw(rng: random.Random, names: Names) -> str:
    """A fault as it is typed."""
    name = rng.choice(sorted(names))
    kind, usual, least, most, lasts = names[name]
    how = ""
    if kind == "amount":
        size = (abs(usual) if math.isfinite(usual) and usual else 1.0) * 10 ** rng.uniform(-1.2, 0.8)
        value = size * (-1 if least < 0 and rng.random() < 0.5 else 1)
        how = f" {min(max(value, least), most):.3g}"
        how = how if name not in ("shuffled",) else f" {max(2, round(size))}"
    elif kind == "count":
        how = f" {rng.randint(1, 200)}" if rng.random() < 0.7 else ""
    when = f" at {rng.uniform(0, RUN_S):.2f} s" if rng.random() < 0.7 else f" at {rng.uniform(0.1, 7):.2f} N"
    lasting = f" for {10 ** rng.uniform(-1.5, 0.5):.2f} s" if lasts and rng.random() < 0.4 else ""
    return f"{name}{how}{when}{lasting}"


def changed(rng: random.Random, lines: tuple[str, ...], names: Names) -> tuple[str, ...]:
    """Another fault for one of them, one more or less, or other numbers in one."""
    found, at = list(lines), rng.randrange(len(lines))
    choice = rng.random()
    if choice < 0.25:
        found[at] = draw(rng, names)
    elif choice < 0.4 and len(found) < 2:
        found.append(draw(rng, names))
    else:
        words = found[at].split()
        for i, word in enumerate(words):
            if i and word.replace(".", "", 1).lstrip("-").replace("e", "", 1).isalnum() and not word.isalpha():
                whole = word.lstrip("-").isdecimal()
                moved = float(word) * math.exp(rng.gauss(0, 0.3))
                words[i] = str(max(1, round(moved))) if whole else f"{moved:.3g}"
        found[at] = " ".join(words)
    return tuple(found)


def carry_out(
    lines: tuple[str, ...], actuator: str, see: Callable[[FaultBench], None] | None = None, run: Path | None = None
) -> Result:
    """One run with these faults, on a bench of its own. see : called every 5 ms. run : its folder, else one for now."""
    bench = FaultBench(BENCHES[actuator])
    most_n = 0.0

    def look() -> None:
        nonlocal most_n
        most_n = max(most_n, bench.true_force_n())
        if see:
            see(bench)

    bench.clock.strike_s, bench.clock.watch = bench.clock.now_s(), look
    try:
        for line in lines:
            put(bench.emulated, line)
    except SettingError as error:
        return Result(actuator, lines, "no fault", error.found, 0.0, 0.0)
    with TemporaryDirectory() as folder:
        try:
            bench.run(plan_of(bench.built), run := run or Path(folder) / "run")
            told = json.loads((run / "ended.json").read_text())
        except Emg2vsaError as error:
            told = {"how": "refused", "cause": str(error)[:60]}
        except Exception as error:  # an error of the program is a finding
            told = {"how": "broken", "cause": repr(error)[:60]}
    bench.clock.watch = lambda: None
    return Result(actuator, lines, told["how"], told["cause"], most_n, bench.true_force_n())


def search(actuator: str, runs: int, seconds: float, seed: int) -> tuple[list[Result], list[Result]]:
    """Random runs, and what was found from the worst of them."""
    bench = FaultBench(BENCHES[actuator])
    names = {
        name: (each.kind, each.usual, each.least, each.most, each.lasts)
        for name, each in faults_of(bench.emulated).items()
        if name not in _CAMERA
    }
    rng = random.Random(seed)
    drawn = [tuple(draw(rng, names) for _ in range(1 + i % 2)) for i in range(runs)]
    with ProcessPoolExecutor(PROCESSES) as pool:
        found = list(pool.map(partial(carry_out, actuator=actuator), drawn, chunksize=8))
        better: list[Result] = []
        end_s = time.monotonic() + seconds
        while time.monotonic() < end_s:
            known = sorted({*found, *better}, key=lambda each: -max(each.true_n, 2 * each.completed_n))[:WORST]
            tries = [changed(rng, rng.choice(known).lines, names) for _ in range(16)]
            better += pool.map(partial(carry_out, actuator=actuator), tries, chunksize=2)
    return found, better


def rows(actuator: str, found: list[Result], name: str) -> str:
    made = [each for each in found if each.how not in ("no fault", "refused")]
    over = [sum(each.true_n > limit for each in made) for limit in (LIMIT_N, MOST_N)]
    whole = [each for each in made if each.how == "completed"]
    left = sum(each.left_n > LEFT_N for each in made)
    cells = [str(len(made)), *(str(sum(each.how == how for each in found)) for how in ("refused", "broken"))]
    cells += [f"{max((each.true_n for each in made), default=0):.1f}", *map(str, over), str(len(whole))]
    cells += [f"{max((each.true_n for each in whole), default=0):.1f}"]
    cells += [str(sum(each.true_n > COMPLETED_N for each in whole)), str(left)]
    return f"| {actuator} | {name} | {' | '.join(cells)} |"


def tables(runs: int, seconds: float, seed: int) -> Iterator[str]:
    yield "# Search for the faults that press hardest\n"
    yield f"One press to 7 N on S1, forces on the specimen, limit {LIMIT_N:g} N; {runs} random runs of each actuator,"
    yield f"half with one fault and half with two; then {seconds:g} s of search from the worst; seed {seed}.\n"
    yield (
        "| actuator | faults | runs | refused | broken | largest (N) | above 10 N | above 13 N | completed "
        "| largest of these (N) | completed above 11 N | left pressed above .5 N |"
    )
    yield "|---|---|" + "---:|" * 10
    worst: list[Result] = []
    for actuator in BENCHES:
        found, better = search(actuator, runs, seconds, seed)
        yield rows(actuator, found[::2], "one")
        yield rows(actuator, found[1::2], "two")
        yield rows(actuator, better, "searched")
        worst += sorted({*found, *better}, key=lambda each: -each.true_n)[:WORST]
        worst += sorted({*found, *better}, key=lambda each: -each.completed_n)[: WORST // 2]
    yield "\nThe worst of each actuator, and the worst that were completed:\n"
    yield "| actuator | faults | ended | cause | largest (N) | left (N) |"
    yield "|---|---|---|---|---:|---:|"
    for each in dict.fromkeys(worst):
        faults, forces = "; ".join(each.lines), f"{each.true_n:.1f} | {each.left_n:.1f}"
        yield f"| {each.actuator} | {faults} | {each.how} | {each.cause} | {forces} |"


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--runs", type=int, default=400)
    parser.add_argument("--seconds", type=float, default=60.0)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--plots", type=Path, metavar="FOLDER", help="draw the worst cases of the record there")
    given = parser.parse_args()
    if given.plots:
        from benchmarks.fault_plots import draw

        print(*draw(RESULTS / "fault_search.json", given.plots), sep="\n")
        return
    for line in tables(given.runs, given.seconds, given.seed):
        print(line, flush=True)


if __name__ == "__main__":
    main()

"""Force and depth over time of the worst cases that `benchmarks.fault_search` has found, pressed once more."""

from __future__ import annotations

import json
from dataclasses import dataclass, field
from pathlib import Path
from tempfile import TemporaryDirectory

from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

from benchmarks.fault_search import BENCHES, LIMIT_N, Result, carry_out
from benchmarks.rig.fault_bench import GAP_MM, FaultBench
from benchmarks.rig.fault_case import read_log
from casr.palette import BLUE, GREY, INK, RED, SKY, YELLOW

EACH = 4
_AGREES_N = 0.1
"""A case that is pressed once more gives the force of the record, rounded there."""
_BEFORE_S, _AFTER_S, _TOUCH_N = 0.3, 0.1, 0.2


@dataclass
class Traced:
    """A run: true_s, true_n, true_mm every 5 ms, and felt_s, felt_n, told_mm as its log has them, s from its begin.

    faults : begin and end, s, of each that struck; the end is that of the run where it lasts. ended_s : when the run
    ended; what follows is the way out. recorded_n : the largest force by the record.
    """

    result: Result
    recorded_n: float
    true_s: list[float] = field(default_factory=list)
    true_n: list[float] = field(default_factory=list)
    true_mm: list[float] = field(default_factory=list)
    felt_s: list[float] = field(default_factory=list)
    felt_n: list[float] = field(default_factory=list)
    told_mm: list[float] = field(default_factory=list)
    faults: list[tuple[float, float]] = field(default_factory=list)
    ended_s: float = 0.0


def worst(record: Path) -> list[tuple[str, tuple[str, ...], float]]:
    """Actuator, faults and largest force of ``EACH`` cases an actuator: the worst of each way to end, then the next."""
    rows = json.loads(record.read_text(encoding="utf-8"))["blocks"][-1]["rows"]
    found = []
    for actuator in BENCHES:
        own = [row for row in rows if row[0] == actuator]
        firsts = list({(row[2], row[3]): row for row in reversed(own)}.values())
        chosen = sorted(firsts, key=own.index)[:EACH]
        chosen += [row for row in own if row not in chosen][: EACH - len(chosen)]
        found += [(actuator, tuple(row[1].split("; ")), float(row[4])) for row in sorted(chosen, key=own.index)]
    return found


def trace(actuator: str, lines: tuple[str, ...], recorded_n: float) -> Traced:
    """The case once more."""
    true: list[tuple[float, float, float]] = []

    def see(bench: FaultBench) -> None:
        true.append((bench.clock.now_s(), bench.true_force_n(), bench.true_probe_mm()))

    with TemporaryDirectory() as root:
        run = Path(root) / "run"
        traced = Traced(carry_out(lines, actuator, see, run), recorded_n)
        rows = read_log(run / "log.csv") if (run / "log.csv").is_file() else []
        ended = json.loads((run / "ended.json").read_text()) if rows else {"time_s": true[-1][0]}
    begun_s, rig = true[0][0], BENCHES[actuator].true
    traced.true_s, traced.true_n, traced.true_mm = ([*each] for each in zip(*true, strict=True))
    traced.true_s = [each - begun_s for each in traced.true_s]
    felt = [(row.time_s - begun_s, row.force_n, row.at) for row in rows if row.force_n is not None and row.at]
    traced.felt_s, traced.felt_n = [each[0] for each in felt], [each[1] for each in felt]
    traced.told_mm = [rig.depth_at(at.shaft_deg) for *_, at in felt]
    traced.ended_s = ended["time_s"] - begun_s
    traced.faults = [span for line in lines if (span := _span(line, traced))]
    return traced


def _span(line: str, traced: Traced) -> tuple[float, float] | None:
    """When the fault began and was over; None of one that waits for a force that did not come."""
    words = line.split()
    begun_s: float | None = 0.0
    if "at" in words:
        at, unit = float(words[words.index("at") + 1]), words[words.index("at") + 2]
        reached = (s for s, n in zip(traced.true_s, traced.true_n, strict=True) if n >= at)
        begun_s = at if unit == "s" else next(reached, None)
    if begun_s is None or begun_s > traced.true_s[-1]:
        return None
    lasts_s = float(words[words.index("for") + 1]) if "for" in words else traced.true_s[-1]
    return begun_s, min(begun_s + lasts_s, traced.true_s[-1])


def draw(record: Path, folder: Path) -> list[str]:
    """fault_search.svg and .png in ``folder``; what to say of it: files, and cases that no longer press as recorded."""
    cases = [trace(*case) for case in worst(record)]
    figure = Figure(figsize=(4.4 * EACH, 4.4 * len(BENCHES)), layout="constrained")
    FigureCanvasAgg(figure)
    grid = figure.add_gridspec(2 * len(BENCHES), EACH, height_ratios=(2, 1) * len(BENCHES))
    for place, traced in enumerate(cases):
        row, column = divmod(place, EACH)
        force = figure.add_subplot(grid[2 * row, column])
        _draw_force(force, traced)
        _draw_depth(figure.add_subplot(grid[2 * row + 1, column], sharex=force), traced)
    handles = {label: one for axes in figure.axes for one, label in zip(*axes.get_legend_handles_labels(), strict=True)}
    figure.legend(handles.values(), handles.keys(), loc="outside lower center", ncols=len(handles), frameon=False)
    folder.mkdir(parents=True, exist_ok=True)
    paths = [folder / f"fault_search.{kind}" for kind in ("svg", "png")]
    for path in paths:
        figure.savefig(path, dpi=110, metadata={"Date": None} if path.suffix == ".svg" else None)
    return [str(path) for path in paths] + [
        f"{each.result.actuator}, {'; '.join(each.result.lines)}: {each.result.true_n:.1f} N now, "
        f"{each.recorded_n:g} N in the record"
        for each in cases
        if abs(each.result.true_n - each.recorded_n) > _AGREES_N
    ]


def _draw_force(axes: Axes, traced: Traced) -> None:
    result = traced.result
    ended = f"{result.how}, {result.cause}" if result.cause else result.how
    axes.set_title(
        f"{result.actuator}: " + ";\n".join(result.lines) + f"\n{ended}: {result.true_n:.1f} N",
        fontsize=9, loc="left",
    )  # fmt: skip
    _mark(axes, traced)
    axes.axhline(LIMIT_N, color=RED, lw=1, ls="--", label=f"limit, {LIMIT_N:g} N")
    axes.plot(traced.felt_s, traced.felt_n, color=SKY, lw=3.5, label="felt, and depth by the encoder (log)")
    axes.plot(traced.true_s, traced.true_n, color=INK, lw=1.2, label="true")
    axes.set_ylabel("force (N)")
    axes.set_ylim(-1, max(LIMIT_N, result.true_n) + 1.5)
    axes.tick_params(labelbottom=False)
    contact_s = next((s for s, n in zip(traced.true_s, traced.true_n, strict=True) if n > _TOUCH_N), _BEFORE_S)
    first_s = min([contact_s, *(begun for begun, _ in traced.faults)])
    axes.set_xlim(max(0.0, first_s - _BEFORE_S), traced.true_s[-1] + _AFTER_S)


def _draw_depth(axes: Axes, traced: Traced) -> None:
    _mark(axes, traced)
    axes.axhline(GAP_MM, color=GREY, lw=1, ls=":", label="specimen's surface")
    axes.plot(traced.felt_s, traced.told_mm, color=SKY, lw=3.5)
    axes.plot(traced.true_s, traced.true_mm, color=INK, lw=1.2)
    axes.set_ylabel("depth (mm)")
    axes.set_ylim(-0.5, max(traced.true_mm) + 0.5)
    axes.set_xlabel("time (s)")


def _mark(axes: Axes, traced: Traced) -> None:
    for begun_s, over_s in traced.faults:
        axes.axvspan(begun_s, over_s, color=YELLOW, alpha=0.15, lw=0)
        axes.axvline(begun_s, color=YELLOW, lw=1.5, label="fault begins")
    axes.axvline(traced.ended_s, color=BLUE, lw=1.2, ls="-.", label="the run ends: guard, or whole")

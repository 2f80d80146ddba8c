"""Results of the scale benchmark: kept as JSON, shown as curves, and on the site as tables with exponents of growth."""

from __future__ import annotations

import json
from collections.abc import Callable, Sequence
from datetime import date
from pathlib import Path
from typing import Any

import numpy as np

from benchmarks.bench.measure import revision
from benchmarks.bench.tables import table
from casr.atomic import write_text_atomic
from emg2vsa.figures.canvas import style, svg_text

Rows = list[dict[str, Any]]
KEYS = {
    "participants": "people", "frames": "frames", "specimens": "specimens", "session_s": "sessions",
    "workers": "clusters",
}  # fmt: skip
"""What a size is of, to the name of its rows."""
FOLDER = Path(__file__).resolve().parent.parent.parent / "docs" / "benchmarks"
STAGES = ("fits", "screening", "pages", "hypotheses", "exemplary", "profiles", "report")
PEOPLE: dict[str, tuple[str, Callable[[dict[str, Any]], float]]] = {
    "whole": ("whole run after the trials, CPU s", lambda row: row["cpu_s"]),
    **{name: (f"{name}, CPU s", lambda row, name=name: row["stages"][name]["cpu_s"]) for name in STAGES},
    "status": ("warm `status`, CPU s", lambda row: row["status_cpu_s"]),
    "warm": ("warm `run`, CPU s", lambda row: row["warm_cpu_s"]),
    **{
        f"{name} memory": (f"{name}, peak MB", lambda row, name=name: row["stages"][name]["peak_mb"]) for name in STAGES
    },
    "index": ("index.html, MB", lambda row: row["index_mb"]),
    "reports": ("folder of the report, MB", lambda row: row["reports_mb"]),
    "store": ("store, MB", lambda row: row["store_mb"]),
}


def kept() -> dict[str, Rows]:
    """What earlier runs measured."""
    path = FOLDER / "scale.json"
    found = json.loads(path.read_text()) if path.exists() else {}
    return {name: found.get(name, []) for name in KEYS.values()}


def keep(kind: str, key: str, row: dict[str, Any]) -> None:
    """Keep a row in the place of an earlier one of the same size, and write page and curves anew."""
    found = kept()
    row |= {"date": date.today().isoformat(), "commit": revision()}
    rows = [other for other in found[kind] if other[key] != row[key]] + [row]
    found[kind] = sorted(rows, key=lambda each: each[key])
    write_text_atomic(FOLDER / "scale.json", json.dumps(found, indent=1) + "\n")
    write_text_atomic(FOLDER / "scale.md", PAGE)
    _draw(found)


def growth(sizes: Sequence[float], values: Sequence[float]) -> tuple[float, float]:
    """Exponent of the power law through the points, by least squares in logarithms, and its standard error; NaN where
    there are too few points."""
    if len(sizes) < 2:
        return float("nan"), float("nan")
    x, y = np.log(np.asarray(sizes, float)), np.log(np.asarray(values, float))
    dx = x - x.mean()
    slope = float(dx @ y / (dx @ dx))
    left = y - y.mean() - slope * dx
    return slope, float(np.sqrt(left @ left / (x.size - 2) / (dx @ dx))) if x.size > 2 else float("nan")


def per_person(sizes: Sequence[float], values: Sequence[float]) -> float:
    """Slope of the straight line through the points."""
    return float(np.polyfit(sizes, values, 1)[0]) if len(sizes) > 1 else float("nan")


PAGE = """\
# Scale on one machine

Made by `python -m benchmarks.scale`. CPU seconds of one process, one thread. The tables are in `scale.json`; the
documentation site shows them here.

**Answer.** Time, memory and files of a whole run grow no faster than the participants up to 1 000. With 5 000, five
times as many, it took 5.9 times the CPU, beside other work, and 3.2 times the memory: screening compares all pairs of
recordings, and is a fifth of it. Memory of a stream of frames does not grow. A second of a session costs no more after
two hours. Rows of different commits may be of different processors: seconds compare within one commit.

![People: time, memory and page over participants](scale_people.svg)

![Frames: time and memory over frames](scale_frames.svg)

<!-- tables: scale.json -->
"""


def tables(found: dict[str, Rows]) -> str:
    """What the documentation site shows of the JSON."""
    lines: list[str] = []
    if people := found["people"]:
        sizes = [row["participants"] for row in people]
        lines += ["## People", "", ABOUT_PEOPLE, ""]
        rows = []
        for head, value in PEOPLE.values():
            values = [value(row) for row in people]
            slope, error = growth(sizes, values)
            shown = [f"{each:.3g}" for each in values]
            rows.append([head, *shown, f"{slope:.2f} ± {error:.2f}", f"{per_person(sizes, values):.2g}"])
        rows += [[of, *(row.get(of, "") for row in people), "", ""] for of in ("date", "commit")]
        lines += table(["", *map(str, sizes), "exponent", "slope for a participant"], rows)
    for kind, (title, about, columns) in OTHERS.items():
        if found[kind]:
            rows = [
                [*(show(row) for show in columns.values()), row.get("date", ""), row.get("commit", "")]
                for row in found[kind]
            ]
            lines += ["", f"## {title}", "", about, "", *table([*columns, "date", "commit"], rows)]
    return "\n".join(lines) + "\n"


ABOUT_PEOPLE = (
    "Five recordings a participant, no rig. Trials are stored beforehand (`benchmarks/scale/people.py`); all else is "
    "computed. The exponent is of value over participants, with its standard error. A constant part, such as loading "
    "libraries, makes it smaller."
)
OTHERS: dict[str, tuple[str, str, dict[str, Callable[[dict[str, Any]], str]]]] = {
    "specimens": (
        "Specimens",
        "Four participants, three presses each, from recordings to the report; all pairs of specimens are compared.",
        {
            "specimens": lambda row: str(row["specimens"]),
            "whole run, CPU s": lambda row: f"{row['cpu_s']:.1f}",
            "trials": lambda row: f"{row['stages']['trials']['cpu_s']:.1f}",
            "hypotheses": lambda row: f"{row['stages']['hypotheses']['cpu_s']:.2f}",
            "report": lambda row: f"{row['stages']['report']['cpu_s']:.1f}",
            "peak MB": lambda row: f"{row['peak_mb']:.0f}",
            "warm run": lambda row: f"{row['warm_cpu_s']:.2f}",
            "index.html, MB": lambda row: f"{row['index_mb']:.2f}",
        },
    ),
    "frames": (
        "Frames",
        "Through `casr.stream.StreamScorer`, 300 x 300 px, one press every 50 000 frames, rest between.",
        {
            "frames": lambda row: str(row["frames"]),
            "in contact": lambda row: str(row["in_contact"]),
            "CPU s": lambda row: f"{row['cpu_s']:.2f}",
            "ms a frame": lambda row: f"{1e3 * row['cpu_s'] / row['frames']:.3f}",
            "resident MB": lambda row: f"{row['memory_mb']:.0f}",
        },
    ),
    "sessions": (
        "A session",
        "One sitting in virtual time, with the emulated participant and its sensors in the same process: CPU seconds "
        "for a second of the session, in its first and its last ten minutes.",
        {
            "length, s": lambda row: f"{row['length_s']:.0f}",
            "presses": lambda row: str(row["presses"]),
            "CPU s": lambda row: f"{row['cpu_s']:.0f}",
            "of a second, first": lambda row: f"{row['first']:.4f}",
            "last": lambda row: f"{row['last']:.4f}",
            "peak MB": lambda row: f"{row['memory_mb']:.0f}",
        },
    ),
    "clusters": (
        "Workers that die",
        "Eight participants and an emulated rig on workers of Dask over loopback. Two workers are killed, then the "
        "scheduler: the run ends with an error and keeps what was done. A new scheduler and new workers finish it. "
        "Equal: files that are, byte for byte, those of one process.",
        {
            "workers": lambda row: str(row["workers"]),
            "killed": lambda row: f"{row['killed']} and the scheduler",
            "files kept": lambda row: str(row["files_kept"]),
            "exit": lambda row: f"{row['first_exit']}, then {row['second_exit']}",
            "files": lambda row: str(row["files"]),
            "equal": lambda row: str(row["equal"]),
            "beyond those": lambda row: str(row["more"]),
        },
    ),
}  # fmt: skip


def _draw(found: dict[str, Rows]) -> None:
    from matplotlib.figure import Figure

    with style():
        for kind, key, curves in (
            ("people", "participants", {n: PEOPLE[n] for n in ("whole", "report", "report memory", "index")}),
            (
                "frames",
                "frames",
                {n: (head, lambda row, n=n: row[n]) for n, head in (("cpu_s", "CPU s"), ("memory_mb", "resident MB"))},
            ),
        ):
            if len(rows := found[kind]) < 2:
                continue
            figure = Figure(figsize=(5, 3.2), layout="constrained")
            axes = figure.subplots()
            for head, value in curves.values():
                axes.loglog([row[key] for row in rows], [value(row) for row in rows], marker="o", label=head)
            axes.set(xlabel=key)
            figure.legend(loc="outside upper center", ncols=2)
            write_text_atomic(FOLDER / f"scale_{kind}.svg", svg_text(figure))

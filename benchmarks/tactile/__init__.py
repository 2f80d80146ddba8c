"""``casr bench``: flow beside other libraries, whole presses against their truth, arithmetic at its edges."""

from __future__ import annotations

from importlib import import_module
from pathlib import Path

from benchmarks.tactile.table import Table
from casr.atomic import write_text_atomic
from casr.errors import SettingError

KINDS = ("flow", "presses", "numerics")


def run(
    what: str, out: Path | None = None, *, n_seeds: int = 6, n_repetitions: int = 10, n_jobs: int = 1
) -> list[Table]:
    """Measure, print the tables, and with ``out`` write them there as text and CSV, with the plot.

    Parameters
    ----------
    what : one of ``KINDS``.
    out : folder, made where it is absent.
    n_seeds : pairs of frames at each motion (``flow``, ``numerics``).
    n_repetitions : presses of each specimen and angle (``presses``); 10 in the paper.
    n_jobs : processes (``presses``).

    Raises
    ------
    SettingError : an unknown comparison, or a number below 1.
    """
    if what not in KINDS:
        raise SettingError("bench", wanted=" or ".join(KINDS), found=repr(what), do="Choose one of these.")
    for name, number in (("seeds", n_seeds), ("repetitions", n_repetitions), ("jobs", n_jobs)):
        if number < 1:
            raise SettingError(name, wanted="1 or more", found=repr(number), do="Ask for more.")
    tables = _measured(what, out, n_seeds, n_repetitions, n_jobs)
    text = "\n\n".join(table.text() for table in tables)
    print(text)
    if out:
        write_text_atomic(out / f"{what}.txt", text + "\n")
        for table in tables:
            table.write(out)
    return tables


def _measured(what: str, out: Path | None, n_seeds: int, n_repetitions: int, n_jobs: int) -> list[Table]:
    # each loads other libraries, some of them slowly
    module = import_module(f"benchmarks.tactile.{what}")
    tables: list[Table]
    if what == "flow":
        tables = module.run_flow(out, n_seeds)
    elif what == "presses":
        tables = module.run_presses(n_repetitions, n_jobs)
    else:
        tables = module.run_numerics(n_seeds)
    return tables

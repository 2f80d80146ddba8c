"""Studies of ``casr bench``: whole presses against their truth, and the scene's part in the divergence.

Time beside error, and other libraries, are areas of ``emg2vsa tools bench``: ``pins``, ``flow``, ``growth``, ``area``
and ``scoring``.
"""

from __future__ import annotations

from collections.abc import Sequence
from importlib import import_module
from pathlib import Path

from benchmarks.tactile.table import Table
from casr.atomic import write_text_atomic
from casr.errors import SettingError

KINDS = ("presses", "kappa", "numerics")


def run(
    what: str,
    out: Path | None = None,
    *,
    n_seeds: int = 6,
    n_repetitions: int = 10,
    n_jobs: int = 1,
    worlds: Sequence[str] = (),
    show: bool = True,
) -> list[Table]:
    """Measure, print the tables, and with ``out`` write them there as text and CSV.

    Parameters
    ----------
    what : one of ``KINDS``.
    out : folder, made where it is absent.
    n_seeds : pairs of frames (``numerics``).
    n_repetitions : presses of each specimen and angle (``presses``), 10 in the paper; of each design (``kappa``).
    n_jobs : processes (``presses``, ``kappa``).
    worlds : areas, CASR and kappa by world instead of by chain (``presses``); names of ``worlds.GROUPS``.
    show : False: nothing is printed.

    Raises
    ------
    SettingError : an unknown comparison or world, or a number below 1.
    """
    if what not in KINDS:
        raise SettingError("bench", wanted=" or ".join(KINDS), found=repr(what), do="Choose one of these.")
    for name, number in (("seeds", n_seeds), ("repetitions", n_repetitions), ("jobs", n_jobs)):
        if number < 1:
            raise SettingError(name, wanted="1 or more", found=repr(number), do="Ask for more.")
    if worlds and what != "presses":
        raise SettingError("--world", wanted="it with presses", found=f"it with {what}", do="Leave --world out.")
    tables = _measured(what, n_seeds, n_repetitions, n_jobs, worlds)
    text = "\n\n".join(table.text() for table in tables)
    if show:
        print(text)
    if out:
        write_text_atomic(out / f"{'worlds' if worlds else what}.txt", text + "\n")
        for table in tables:
            table.write(out)
    return tables


def _measured(what: str, n_seeds: int, n_repetitions: int, n_jobs: int, worlds: Sequence[str]) -> list[Table]:
    # each loads other libraries, some of them slowly
    if what == "kappa":
        return list(import_module("benchmarks.kappa").kappa_tables(n_repetitions, n_jobs))
    module = import_module(f"benchmarks.tactile.{'world_tables' if worlds else what}")
    tables: list[Table]
    if worlds:
        tables = module.run_worlds(worlds, n_repetitions, n_jobs)
    elif what == "presses":
        tables = module.run_presses(n_repetitions, n_jobs)
    else:
        tables = module.run_numerics(n_seeds)
    return tables

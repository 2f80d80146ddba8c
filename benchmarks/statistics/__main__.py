"""``python -m benchmarks.statistics``: the three tables."""

from __future__ import annotations

import os

os.environ.setdefault("OMP_NUM_THREADS", "1")
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import warnings

from benchmarks.statistics.acceptance import acceptance
from benchmarks.statistics.curve_tasks import curve_tasks
from benchmarks.statistics.group_tasks import group_tasks
from benchmarks.statistics.mixed_tasks import mixed_tasks
from benchmarks.statistics.nist_tables import nist_tables
from benchmarks.statistics.sample_tasks import sample_tasks
from benchmarks.statistics.task import measured


def main() -> None:
    """Speed and digits of every task, NIST's sets, and the numbers wanted beside those found."""
    warnings.simplefilter("ignore")  # peers warn of what the digits show
    tasks = [measured(task) for task in (*curve_tasks(), *sample_tasks(), *group_tasks(), *mixed_tasks())]
    tables = nist_tables()
    acceptance(tasks, tables)


if __name__ == "__main__":
    main()

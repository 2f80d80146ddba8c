"""The order in which the runs of an experiment are done: drawn once, kept in the folder of the runs, and kept to."""

from __future__ import annotations

import json
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, Literal, get_args

from casr.atomic import write_text_atomic
from emg2vsa.errors import DataError, SettingError
from emg2vsa.rig.experiment import ExperimentSettings
from emg2vsa.rig_file.plans import Run

ORDER_FILE = "order.json"
Order = Literal["random", "listed"]


@dataclass(frozen=True)
class RunOrder:
    """Runs in their order. seed : that they were drawn with; None of runs as listed."""

    order: Order
    seed: int | None
    runs: tuple[Run, ...]

    def __str__(self) -> str:
        return _told(self.order, self.seed)

    def place(self, run: Run) -> int:
        """From 1."""
        return self.runs.index(run) + 1


def ordered(experiment: ExperimentSettings, order: Order | None = None, seed: int | None = None) -> RunOrder:
    """The runs in the order that is asked for, else that of the experiment; likewise its seed. SettingError : there is
    no such order, or the seed is no whole number."""
    if order not in (None, *get_args(Order)):
        listed = " or ".join(get_args(Order))
        raise SettingError("order", wanted=listed, found=repr(order), do="Choose one of them.")
    if not isinstance(seed, int | None):
        raise SettingError("seed", wanted="a whole number", found=repr(seed), do="Choose a whole number.")
    settings = replace(experiment, order=order or experiment.order, seed=experiment.seed if seed is None else seed)
    return RunOrder(settings.order, settings.seed if settings.order == "random" else None, settings.ordered_runs())


def run_order(root: Path, experiment: ExperimentSettings, order: Order | None, seed: int | None) -> RunOrder:
    """The order kept in ``root``; without one that of `ordered`, which is then kept.

    order, seed : as asked for; None takes what is kept, else what the experiment says.

    DataError : another order or seed is kept, its file is of another form, or the experiment has other runs by now.
    """
    path, runs = root / ORDER_FILE, experiment.all_runs()
    if not path.exists():
        drawn = ordered(experiment, order, seed)
        root.mkdir(parents=True, exist_ok=True)
        write_text_atomic(path, json.dumps(_document(drawn), indent=1) + "\n")
        return drawn
    kept = _read(path)
    asked = order or kept.order, kept.seed if seed is None else seed
    if asked != (kept.order, kept.seed):
        do = "Leave out --order and --seed to go on, or choose another folder with --out."
        raise DataError(path, wanted=f"order {_told(*asked)}", found=f"{kept}, begun", do=do)
    if set(kept.runs) != set(runs):
        do = "Choose another folder with --out, or undo the change of [experiment]."
        raise DataError(
            path, wanted=f"the {len(runs)} runs of the rig file", found=f"{len(kept.runs)}, not the same", do=do
        )
    return kept


def _told(order: str, seed: int | None) -> str:
    return order if seed is None else f"{order} with seed {seed}"


def _document(drawn: RunOrder) -> dict[str, Any]:
    return {
        "order": drawn.order, "seed": drawn.seed, "runs": [run._asdict() for run in drawn.runs]
    }  # fmt: skip


def _read(path: Path) -> RunOrder:
    try:
        kept = json.loads(path.read_text(encoding="utf-8"))
        runs = tuple(
            Run(run["specimen"], float(run["angle_deg"]), run["condition"], int(run.get("mounting", 1)))
            for run in kept["runs"]
        )
        if kept["order"] in ("file", "listed"):  # as versions up to 0.2 called it
            return RunOrder("listed", None, runs)
        if kept["order"] == "random":
            return RunOrder("random", kept["seed"], runs)
        raise ValueError(f"order {kept['order']!r}")
    except (OSError, ValueError, TypeError, KeyError, AttributeError) as error:
        do = "Move it away: the runs that are done stay done, and the others get a new order."
        raise DataError(path, wanted="an order as emg2vsa rig run writes it", found=str(error), do=do) from error

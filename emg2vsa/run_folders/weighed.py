"""What the presses of a run tell of its specimen, as its own files say: nothing is computed anew."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator
from pathlib import Path

from emg2vsa.rig.record.new_folder import PLAN_FILE
from emg2vsa.rig.record.press_counts import PressKappa, verdicts, weighed
from emg2vsa.run_folders.documents import document
from emg2vsa.run_scores.product import WeighedPress

_NOTHING = PressKappa(math.nan, math.nan, math.nan)
_ENDED_EARLY = "guard", "stopped", "interrupted", "failed"


def weighed_presses(folders: Iterable[Path]) -> Iterator[WeighedPress]:
    """By plan.json, presses.csv and ended.json; of folders where no press tells kappa, and no guard for it, none."""
    for folder in folders:
        plan, ended = document(folder / PLAN_FILE).get("plan"), document(folder / "ended.json")
        kappas = weighed(folder)
        if not isinstance(plan, dict) or not (kappas or ended.get("cause") == "specimen"):
            continue
        stated = plan.get("stiffness_n_per_mm")
        of_plan = str(plan.get("specimen")), float(stated) if isinstance(stated, (int, float)) else math.nan
        last = ended.get("repetitions_done") if ended.get("how") in _ENDED_EARLY else None
        for number, (verdict, why) in verdicts(folder).items():
            here = isinstance(last, int) and number > last and verdict == "ok"
            told = ("ended", f"{ended.get('cause')}: {ended.get('why')}") if here else (verdict, why)
            yield WeighedPress(folder.name, number, *of_plan, *kappas.get(number, _NOTHING), *told)

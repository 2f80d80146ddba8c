"""Where every number comes from: its key in results.json, the steps that made it, what those steps took."""

from __future__ import annotations

import json
import os
from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path

from emg2vsa.pipeline.plan import DONE, Step, StepPlan
from emg2vsa.pipeline.stage_order import ORDER, stage
from emg2vsa.study import Study

_MADE_BY = {
    "study": ("report",), "trials": ("trials",), "fit": ("fits",), "power": ("hypotheses", "report"),
    "recovery": ("fits", "report"), "runs": ("runs", "discrimination"),
}  # fmt: skip
"""First word of a key to the stages behind it, where that word is not a stage's own name."""


@dataclass(frozen=True)
class Lineage:
    """numbers : key to step ids. steps : id to the step as the ledger has it. inputs : path beside the study file to
    the digest the steps took it with.
    """

    numbers: dict[str, tuple[str, ...]]
    steps: dict[str, dict[str, object]]
    inputs: dict[str, str]
    libraries: dict[str, str]

    def json(self) -> str:
        """What provenance.json holds."""
        about = (
            "numbers: key in results.json to the steps that made it. steps: key of the step's result in the ledger, "
            "and all it depends on: settings, files and inputs with their digests, code, libraries."
        )
        whole = {"about": about, "numbers": self.numbers, "steps": self.steps}
        return json.dumps(whole, indent=1, sort_keys=True, ensure_ascii=False) + "\n"


def lineage(plan: StepPlan, keys: Iterable[str]) -> Lineage:
    """Lineage of the numbers ``keys`` of a study that has just been run."""
    done = [step for step in plan.steps.values() if step.status in DONE]
    base = plan.study.path.parent
    files: dict[str, str] = {}
    libraries: dict[str, str] = {}
    for step in done:
        files |= {_beside(path, base): value for path, value in step.parts.files.items()}
        libraries |= step.parts.libraries.value
    return Lineage(
        numbers={key: _steps_of(key, done, plan.study) for key in keys},
        steps={step.id: _plain(step, base) for step in done},
        inputs=dict(sorted(files.items())),
        libraries=dict(sorted(libraries.items())),
    )


def _steps_of(key: str, steps: Iterable[Step], study: Study) -> tuple[str, ...]:
    """Steps of the key's stages; of one specimen where the key names it. The report made what no stage claims."""
    first, second = [*key.split("."), ""][:2]
    stages = _MADE_BY.get(first, (first,) if first in ORDER else ("report",))
    of = [step for step in steps if step.stage in stages]
    if second in {specimen.name for specimen in study.specimens}:
        of = [step for step in of if stage(step.stage).per != "recording" or step.item.endswith(f"/{second}")]
    return tuple(step.id for step in of)


def _plain(step: Step, base: Path) -> dict[str, object]:
    parts = step.parts
    return {
        "key": step.key,
        "result": step.result,
        "settings": parts.settings.value,
        "files": {_beside(path, base): value for path, value in parts.files.items()},
        "inputs": dict(parts.inputs),
        "code": parts.code.digest,
        "libraries": parts.libraries.value,
    }


def _beside(path: str, base: Path) -> str:
    """A path as seen from the study file, wherever the project lies."""
    return Path(os.path.relpath(base / path, base)).as_posix()

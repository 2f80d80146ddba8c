"""Runs: every press of one run of the rig, all its mountings, scored by every vision algorithm."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from emg2vsa.pipeline.shared_settings import emulation_settings, own_domes
from emg2vsa.pipeline.stage import Given, Keyed, Stage

if TYPE_CHECKING:
    from emg2vsa.arrays import Floats
    from emg2vsa.pipeline.campaign import Campaign
    from emg2vsa.run_scores import RunScores


_FRAMES = "frames"
"""The one folder that casr opens through a link; its own name for it comes with OpenCV, which planning does without."""


def settings(campaign: Campaign, item: str) -> dict[str, Any]:
    """Where the run lies is no part of the key. The emulated world is: it tells the true areas."""
    entry, source = campaign.runs[item], campaign.study.runs_source
    assert source is not None
    used = {"scoring": campaign.study.scoring, "run": (entry.specimen, entry.angle_deg, entry.condition)}
    used["specimen_height_mm"] = campaign.study.heights_mm.get(entry.specimen)
    if source.domes:
        used["domes"] = Keyed(str(source.domes), None)
    if campaign.rig is None:
        inside = [_folders_in(folder) for folder in entry.folders]
        more = {"folders": Keyed(entry.folders, inside), "camera": Keyed(source.camera, None), "order": entry.order}
        return used | more
    world = emulation_settings(campaign, item)
    return used | {
        "folders": Keyed(entry.folders, len(entry.folders)),
        "camera": Keyed(None, None),
        "order": (),
        "rig": world["rig"],
        "emulated": world["emulated"],
    }


def files(campaign: Campaign, item: str) -> dict[str, Sequence[Path]]:
    """What a measured run consists of; the files of an emulated one are the result of its emulation."""
    source = campaign.study.runs_source
    assert source is not None
    inside = [] if campaign.rig else [path for folder in campaign.runs[item].folders for path in _files_in(folder)]
    return {"camera": [source.camera] if source.camera else [], "run": inside, **own_domes(campaign, item)}


def _folders_in(folder: Path) -> list[str]:
    """Names of the folders of presses: one without a file in it is a press too, which is told."""
    return sorted(path.name for path in folder.glob("[!.]*") if path.is_dir())


def _files_in(folder: Path) -> list[Path]:
    """Every file below; of linked folders those with frames, as of no other a link is followed."""
    found: list[Path] = []
    for path in sorted(folder.rglob("*")):
        if path.is_file():
            found.append(path)
        elif path.is_symlink() and path.name == _FRAMES and path.is_dir():
            found += sorted(frame for frame in path.iterdir() if frame.is_file())
    return found


def takes(campaign: Campaign, item: str) -> list[tuple[str, str]]:
    return [] if campaign.rig is None else [("emulation", folder.name) for folder in campaign.runs[item].folders]


def run(given: Given) -> RunScores:
    """Score the presses of one run. DataError : its folders hold none."""
    from emg2vsa.errors import DataError
    from emg2vsa.rig.record.new_folder import over_bytes
    from emg2vsa.run_folders.presses import is_simulated, read_presses, run_notes, run_setup
    from emg2vsa.run_folders.weighed import weighed_presses
    from emg2vsa.run_scores.domes import NO_DOMES, Domes, notes_on_height
    from emg2vsa.run_scores.score_run import score_run

    used = given.settings
    specimen, angle_deg, condition = used["run"]
    height_mm = used.get("specimen_height_mm")
    notes = () if "domes" in used else notes_on_height(height_mm)
    scores = score_run(
        read_presses(used["folders"], used["camera"], used["order"]),
        used["scoring"],
        specimen=specimen,
        angle_deg=angle_deg,
        condition=condition,
        simulated=is_simulated(used["folders"]),
        notes=(*run_notes(used["folders"]), *notes),
        domes=Domes(used["domes"], height_mm) if "domes" in used else NO_DOMES,
    )
    if not scores.verdicts:
        do = "See that its folder holds the presses' frames."
        raise DataError(given.item, wanted="one press or more", found="none", do=do)
    spoken, weighed = all(map(over_bytes, used["folders"])), tuple(weighed_presses(used["folders"]))
    setup = run_setup(used["folders"], used["camera"])
    scores = replace(scores, setup=setup, over_bytes=spoken, weighed=weighed)
    return replace(scores, true_a_c0=_true_a_c0(given, scores)) if "emulated" in used else scores


def _true_a_c0(given: Given, scores: RunScores) -> Floats:
    from emg2vsa.worlds.bench.truth import true_areas_mm2

    return true_areas_mm2(given.settings["folders"], [curve.first_n for curve in scores.curves])


def says(scores: RunScores) -> str:
    rejected = scores.verdicts.count("rejected")
    of_all = f"{rejected} of {len(scores.verdicts)} presses rejected: {scores.most_frequent_reason}"
    return of_all if rejected else ""


STAGE = Stage(
    per="run", of="runs", needs=("emulation",), run=run,
    loads=("emg2vsa.run_folders.presses", "emg2vsa.run_folders.weighed", "emg2vsa.run_scores.score_run"),
    settings=settings, files=files, takes=takes, says=says,
)  # fmt: skip

"""Where the electrodes of a participant are: electrodes.tsv and coordsystem.json of BIDS-EMG, a pair for each visit."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

from emg2vsa.bids.names import visit_folder
from emg2vsa.bids.tables import ABSENT, write_json, write_tsv

SPACE = "forearm"
_COLUMNS = ("name", "x", "y", "z", "coordinate_system", "type", "material", "impedance", "group")
_NOT_STATED = "Positions were not stated. placement_description in the channels files names the muscles."

Point = tuple[float, float]


@dataclass(frozen=True)
class Electrodes:
    """pairs : name of a pair to x and y of its two electrodes, in ``unit``; None where they are not stated.

    system : where 0 is and what x and y follow. kind, material : of all electrodes, "" where they are not known.
    """

    pairs: Mapping[str, tuple[Point, Point] | None]
    system: str
    unit: str
    kind: str = ""
    material: str = ""


def write_electrodes(root: Path, participant: str, visit: str, electrodes: Electrodes) -> None:
    """Both files, which hold for all recordings of a participant, or of a visit."""
    folder = visit_folder(root, participant, visit)
    stem = "_".join(part for part in folder.relative_to(root).parts)
    rows = [
        (f"{name}{i + 1}", *(points[i] if points else (ABSENT, ABSENT)), ABSENT, SPACE, electrodes.kind or ABSENT,
         electrodes.material or ABSENT, ABSENT, name)
        for name, points in electrodes.pairs.items()
        for i in range(2)
    ]  # fmt: skip
    write_tsv(folder / "emg" / f"{stem}_electrodes.tsv", _COLUMNS, rows)
    told = {"EMGCoordinateSystem": "Other", "EMGCoordinateUnits": electrodes.unit}
    told["EMGCoordinateSystemDescription"] = electrodes.system or _NOT_STATED
    write_json(folder / "emg" / f"{stem}_space-{SPACE}_coordsystem.json", told)

"""ATI transducers: their .cal files, from the six gauge voltages to force and torque; and the units of ATI's boxes and
calibration files, by name, in N, N·m and m."""

from __future__ import annotations

import math
from dataclasses import dataclass
from pathlib import Path
from xml.etree import ElementTree

import numpy as np
from numpy.typing import NDArray

from emg2vsa.errors import DeviceError

LBF_N = 4.4482216152605
KGF_N = 9.80665
INCH_M = 0.0254

FORCE_N = {"lbf": LBF_N, "N": 1.0, "klbf": 1e3 * LBF_N, "kN": 1e3, "kgf": KGF_N, "gf": 1e-3 * KGF_N}
TORQUE_NM = {
    "lbf-in": LBF_N * INCH_M,
    "lbf-ft": LBF_N * 12 * INCH_M,
    "N-m": 1.0,
    "N-mm": 1e-3,
    "kgf-cm": 1e-2 * KGF_N,
    "kN-m": 1e3,
}
LENGTH_M = {"in": INCH_M, "ft": 12 * INCH_M, "mm": 1e-3, "cm": 1e-2, "m": 1.0}

_SPELLINGS = {"Nm": "N-m", "Nmm": "N-mm", "kNm": "kN-m", "kg-cm": "kgf-cm", "in-lbf": "lbf-in", "ft-lbf": "lbf-ft"}

AXES = ("Fx", "Fy", "Fz", "Tx", "Ty", "Tz")


@dataclass(frozen=True, eq=False)
class GaugeCalibration:
    """A transducer's calibration.

    serial : as in the file.
    wrench_per_volt : (6, 6) Fx, Fy, Fz in N and Tx, Ty, Tz in N·m for a volt on each gauge.
    range_v : (least, greatest) voltage of a gauge, V.
    largest : ``max`` of the six axes, N and N·m; None where one of them has none.
    """

    serial: str
    wrench_per_volt: NDArray[np.float64]
    range_v: tuple[float, float]
    largest: tuple[float, ...] | None = None


def unit_in_si(units: dict[str, float], name: str, where: object) -> float:
    """Size of the unit ``name`` of one of the tables above in N, N·m or m. Raises DeviceError when it is not there."""
    name = name.strip()
    size = units.get(_SPELLINGS.get(name, name))
    if size is None:
        do = "Choose one of these on the sensor's configuration page, or give the right file."
        raise DeviceError(where, wanted=f"one of the units {', '.join(units)}", found=repr(name), do=do)
    return size


def read_calibration(path: Path | str) -> GaugeCalibration:
    """The calibration in a .cal file of version 1.0 or 1.1, in N and N·m whatever its units.

    Version 1.1 gives the matrix (``UserAxis``). Version 1.0 gives ``Axis`` rows to be divided by their ``scale`` and
    moved by ``BasicTransform`` to the transducer's origin, T - D x F; the version 1.1 files that carry both agree to
    their last digit.

    Raises
    ------
    DeviceError : not readable, not such a file, a number or unit missing, six gauges not, a rotated basic transform in
        a file of version 1.0 (none is known to exist, so its sense of rotation is not either).
    """
    path = Path(path)
    sensor = _root(path)
    calibration = _child(sensor, "Calibration", path)
    size = np.repeat(
        [
            unit_in_si(FORCE_N, _text(calibration, "ForceUnits", path), path),
            unit_in_si(TORQUE_NM, _text(calibration, "TorqueUnits", path), path),
        ],
        3,
    )
    kind = "UserAxis" if calibration.find("UserAxis") is not None else "Axis"
    axes = [_axis(calibration, kind, name, path) for name in AXES]
    matrix = np.array([_values(axis, path) for axis in axes]) * size[:, None]
    largest = None
    if all(axis.get("max") for axis in axes):
        largest = tuple((np.array([_number(axis, "max", path) for axis in axes]) * size).tolist())
    if kind == "Axis":
        matrix = _to_origin(matrix / [[_number(axis, "scale", path)] for axis in axes], calibration, path)
    span_v = _number(calibration, "OutputRange", path)
    bipolar = _text(calibration, "OutputBipolar", path).lower() == "true"
    return GaugeCalibration(
        serial=_text(sensor, "Serial", path),
        wrench_per_volt=matrix,
        range_v=(-span_v / 2, span_v / 2) if bipolar else (0.0, span_v),
        largest=largest,
    )


def _to_origin(matrix: NDArray[np.float64], calibration: ElementTree.Element, path: Path) -> NDArray[np.float64]:
    transform = _child(calibration, "BasicTransform", path)
    if any(_number(transform, turn, path) for turn in ("Rx", "Ry", "Rz")):
        raise DeviceError(
            f"{path}, BasicTransform",
            wanted="no rotation",
            found=f"Rx, Ry, Rz = {', '.join(transform.get(turn, '') for turn in ('Rx', 'Ry', 'Rz'))}",
            do="Ask ATI for the calibration as a file of version 1.1.",
        )
    metre = unit_in_si(LENGTH_M, _text(calibration, "DistUnits", path), path)
    offset_m = metre * np.array([_number(transform, name, path) for name in ("Dx", "Dy", "Dz")])
    force, torque = matrix[:3], matrix[3:]
    return np.vstack([force, torque - np.cross(offset_m, force, axisb=0, axisc=0)])


def _root(path: Path) -> ElementTree.Element:
    try:
        root = ElementTree.parse(path).getroot()
    except OSError as error:
        raise DeviceError(
            path, wanted="a calibration file", found=error.strerror or str(error), do="Check the path."
        ) from error
    except ElementTree.ParseError as error:
        raise DeviceError(
            path, wanted="a .cal file of ATI", found=str(error), do="Give the file that came with the transducer."
        ) from error
    if root.tag != "FTSensor" or root.get("NumGages") != "6":
        raise DeviceError(
            path,
            wanted="an FTSensor with six gauges",
            found=f"{root.tag} with NumGages {root.get('NumGages')}",
            do="Give the file that came with the transducer.",
        )
    return root


def _axis(calibration: ElementTree.Element, kind: str, name: str, path: Path) -> ElementTree.Element:
    for axis in calibration.iter(kind):
        if axis.get("Name") == name:
            return axis
    raise _missing(f"{kind} {name}", path)


def _child(parent: ElementTree.Element, tag: str, path: Path) -> ElementTree.Element:
    child = parent.find(tag)
    if child is None:
        raise _missing(tag, path)
    return child


def _text(element: ElementTree.Element, key: str, path: Path) -> str:
    text = element.get(key)
    if text is None:
        raise _missing(f"{element.tag} {key}", path)
    return text


def _number(element: ElementTree.Element, key: str, path: Path) -> float:
    return _finite(_text(element, key, path), f"{path}, {element.tag} {element.get('Name', '')} {key}")


def _values(axis: ElementTree.Element, path: Path) -> list[float]:
    where = f"{path}, {axis.tag} {axis.get('Name')} values"
    values = [_finite(value, where) for value in _text(axis, "values", path).split()]
    if len(values) != 6:
        raise DeviceError(where, wanted="six numbers", found=f"{len(values)}", do="Give the file as ATI made it.")
    return values


def _finite(text: str, where: str) -> float:
    try:
        value = float(text)
    except ValueError:
        value = math.nan
    if not math.isfinite(value):
        raise DeviceError(where, wanted="a number", found=repr(text), do="Give the file as ATI made it.")
    return value


def _missing(what: str, path: Path) -> DeviceError:
    return DeviceError(path, wanted=what, found="none", do="Give the file as ATI made it.")

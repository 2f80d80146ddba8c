"""Files beside a recording that hold its samples: a header that names none of them is all that a study names.

They are those that the decoder of the format (neo) reads. Of every other format all samples stand in the file named.
"""

from __future__ import annotations

import filecmp
from pathlib import Path

_OPEN_EPHYS = ("**/structure.oebin", "**/continuous/*/*", "**/events/*/*", "**/events/*/*/*")
_INTAN = ("**/*.dat",)
"""One file for each kind of signal, or one for each channel; further down too, for neo looks there."""
_BESIDE = {"structure.oebin": _OPEN_EPHYS, "info.rhd": _INTAN, "info.rhs": _INTAN}


def sample_file_paths(path: Path) -> tuple[Path, ...]:
    """Every file but ``path`` that may hold samples of the recording, in order; a folder is listed for few names."""
    patterns = _BESIDE.get(path.name, ())
    found = {file for pattern in patterns for file in path.parent.glob(pattern) if file.is_file()}
    return tuple(sorted(found - {path}))


def same_samples(one: Path, other: Path) -> bool:
    """Whether two recordings are one, byte by byte, the files beside them included."""
    ones, others = ([path, *sample_file_paths(path)] for path in (one, other))
    pairs = zip(ones, others, strict=False)
    return len(ones) == len(others) and all(filecmp.cmp(*pair, shallow=False) for pair in pairs)

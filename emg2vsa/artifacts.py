"""Results on disk: written whole or not at all, read back as the same frozen dataclass, refused when damaged.

A product (a dataclass of arrays, text, numbers, tuples, dicts and further dataclasses) is stored as a checksum, a JSON
tree and its raw arrays: a study has hundreds of small results, and this reads ten times faster than ``.npz``. No
pickle: a file from elsewhere cannot run code. The same product gives the same bytes. NumPy is loaded for arrays only.
"""

from __future__ import annotations

import dataclasses
import hashlib
import json
import math
from pathlib import Path
from typing import TYPE_CHECKING, Any

from casr.atomic import write_bytes_atomic
from casr.by_name import module_named
from casr.counts import count
from emg2vsa.errors import DataError

if TYPE_CHECKING:
    import numpy as np

_OWN_PACKAGES = ("emg2vsa.", "casr.")
_MAGIC = b"emg2vsa result 2\n"
_SUM_BYTES = 16
_START = len(_MAGIC) + _SUM_BYTES


class DamagedResult(DataError):
    """A stored result is not as it was written; ``where`` is its path."""


def save(path: Path, product: Any) -> None:
    """Write a dataclass instance, or a tuple of them, to ``path``. TypeError : a value of a kind that cannot be
    stored."""
    arrays: list[np.ndarray] = []
    tree = _encode(product, arrays)
    shapes = [[array.dtype.str, array.shape] for array in arrays]
    head = json.dumps({"tree": tree, "arrays": shapes}).encode()
    body = b"".join([len(head).to_bytes(8, "little"), head, *(array.tobytes() for array in arrays)])
    write_bytes_atomic(path, _MAGIC + _sum(body) + body)


def load(path: str | Path) -> Any:
    """Read what ``save`` wrote. Raises DamagedResult where the file is not that."""
    data = _checked(path)
    try:
        start = _START + 8
        position = start + int.from_bytes(data[_START:start], "little")
        head = json.loads(data[start:position])
        arrays = []
        for dtype, shape in head["arrays"]:
            array = _array(data, dtype, shape, position)
            arrays.append(array)
            position += array.nbytes
        return _decode(head["tree"], arrays)
    except (ValueError, KeyError, TypeError, AttributeError, ImportError) as error:
        raise _damaged(path, f"another version's ({error})") from error


def digest_of(path: Path) -> str:
    """Checksum of a stored result, 32 hexadecimal digits: equal results have equal ones. DamagedResult as ``load``."""
    return _checked(path)[len(_MAGIC) : _START].hex()


def _checked(path: str | Path) -> bytes:
    """The bytes of a result whose checksum holds."""
    try:
        with open(path, "rb") as file:
            data = file.read()
    except OSError as error:
        raise _damaged(path, error.strerror or str(error)) from error
    count("files read")
    count("bytes read", len(data))
    if not data.startswith(_MAGIC):
        raise _damaged(path, "not a result file")
    if _sum(data[_START:]) != data[len(_MAGIC) : _START]:
        raise _damaged(path, "a wrong checksum")
    return data


def _damaged(path: str | Path, found: str) -> DamagedResult:
    return DamagedResult(path, wanted="a stored result", found=found, do="Run the study again; it is made anew.")


def _sum(body: bytes) -> bytes:
    return hashlib.blake2b(body, digest_size=_SUM_BYTES).digest()


def _array(data: bytes, dtype: str, shape: list[int], position: int) -> np.ndarray:
    import numpy as np

    count = math.prod(shape)
    array = np.frombuffer(data, dtype, count, position) if count else np.empty(0, dtype)
    return array.reshape(shape)


def _encode(value: Any, arrays: list[np.ndarray]) -> Any:
    if value is None or isinstance(value, (str, bool, int, float)):
        return value
    if isinstance(value, tuple):
        return {"@": "tuple", "items": [_encode(item, arrays) for item in value]}
    if isinstance(value, dict):
        return {"@": "dict", "items": [[_encode(k, arrays), _encode(v, arrays)] for k, v in value.items()]}
    if dataclasses.is_dataclass(value) and not isinstance(value, type):
        fields = {f.name: _encode(getattr(value, f.name), arrays) for f in dataclasses.fields(value)}
        return {"@": f"{type(value).__module__}:{type(value).__qualname__}", "fields": fields}
    import numpy as np

    if isinstance(value, np.ndarray):
        arrays.append(value)
        return {"@": "array", "at": len(arrays) - 1}
    if isinstance(value, np.generic):
        return _encode(value.item(), arrays)
    raise TypeError(f"cannot store a {type(value).__name__}")


def _decode(tree: Any, arrays: list[np.ndarray]) -> Any:
    if not isinstance(tree, dict):
        return tree
    kind = tree["@"]
    if kind == "array":
        return arrays[tree["at"]]
    if kind == "tuple":
        return tuple([_decode(item, arrays) if isinstance(item, dict) else item for item in tree["items"]])
    if kind == "dict":
        return {_decode(k, arrays): _decode(v, arrays) for k, v in tree["items"]}
    module, name = kind.split(":")
    if not module.startswith(_OWN_PACKAGES):
        raise ValueError(f"foreign type {kind}")
    cls = getattr(module_named(module), name)
    return cls(**{key: _decode(item, arrays) for key, item in tree["fields"].items()})

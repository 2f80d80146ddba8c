"""Results on disk: written whole or not at all, read back as the same frozen dataclass.

A product (a dataclass of arrays, text, numbers, tuples, dicts and further dataclasses) is stored as one uncompressed
``.npz``: its arrays, and a JSON tree that says where they go. No pickle: a file from elsewhere cannot run code.
"""

from __future__ import annotations

import dataclasses
import importlib
import io
import json
import os
import tempfile
from pathlib import Path
from typing import Any

import numpy as np

from emg2vsa.errors import DataError

_OWN_PACKAGE = "emg2vsa."


def write_bytes_atomic(path: Path, data: bytes) -> None:
    """Write ``data`` so that a reader sees the old file or the new one, never a part."""
    path.parent.mkdir(parents=True, exist_ok=True)
    handle, temporary = tempfile.mkstemp(dir=path.parent, prefix=f".{path.name}.")
    try:
        with os.fdopen(handle, "wb") as file:
            file.write(data)
        os.chmod(temporary, 0o644)
        os.replace(temporary, path)
    except BaseException:
        Path(temporary).unlink(missing_ok=True)
        raise


def write_text_atomic(path: Path, text: str) -> None:
    """``write_bytes_atomic`` for UTF-8 text, newlines as given."""
    write_bytes_atomic(path, text.encode())


def save(path: Path, product: Any) -> None:
    """Write a dataclass instance to ``path`` (.npz)."""
    arrays: dict[str, np.ndarray] = {}
    tree = _encode(product, arrays)
    buffer = io.BytesIO()
    np.savez(buffer, tree=np.frombuffer(json.dumps(tree).encode(), dtype=np.uint8), **arrays)  # type: ignore[arg-type]
    write_bytes_atomic(path, buffer.getvalue())


def load(path: Path) -> Any:
    """Read what ``save`` wrote."""
    try:
        with np.load(path, allow_pickle=False) as stored:
            return _decode(json.loads(stored["tree"].tobytes()), stored)
    except (ValueError, KeyError, OSError, EOFError) as error:
        raise DataError(
            path, wanted="a stored result", found=f"an unreadable file ({error})", do="Delete it; a run makes it again."
        ) from error


def _encode(value: Any, arrays: dict[str, np.ndarray]) -> Any:
    if dataclasses.is_dataclass(value) and not isinstance(value, type):
        fields = {f.name: _encode(getattr(value, f.name), arrays) for f in dataclasses.fields(value)}
        return {"@": f"{type(value).__module__}:{type(value).__qualname__}", "fields": fields}
    if isinstance(value, np.ndarray):
        name = f"a{len(arrays)}"
        arrays[name] = value
        return {"@": "array", "name": name}
    if isinstance(value, np.generic):
        return _encode(value.item(), arrays)
    if isinstance(value, tuple):
        return {"@": "tuple", "items": [_encode(item, arrays) for item in value]}
    if isinstance(value, dict):
        return {"@": "dict", "items": [[_encode(k, arrays), _encode(v, arrays)] for k, v in value.items()]}
    if value is None or isinstance(value, (str, bool, int, float)):
        return value
    raise TypeError(f"cannot store a {type(value).__name__}")


def _decode(tree: Any, arrays: Any) -> Any:
    if not isinstance(tree, dict):
        return tree
    kind = tree["@"]
    if kind == "array":
        return arrays[tree["name"]]
    if kind == "tuple":
        return tuple(_decode(item, arrays) for item in tree["items"])
    if kind == "dict":
        return {_decode(k, arrays): _decode(v, arrays) for k, v in tree["items"]}
    module, name = kind.split(":")
    if not module.startswith(_OWN_PACKAGE):
        raise ValueError(f"foreign type {kind}")
    cls = getattr(importlib.import_module(module), name)
    return cls(**{key: _decode(item, arrays) for key, item in tree["fields"].items()})

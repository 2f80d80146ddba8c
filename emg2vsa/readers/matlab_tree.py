"""Numeric arrays and text lists out of the nested structs and cells of a .mat file."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray


@dataclass(frozen=True)
class Leaves:
    """arrays : dotted name to a numeric array. texts : dotted name to the entries of a text cell array."""

    arrays: dict[str, NDArray[Any]] = field(default_factory=dict)
    texts: dict[str, list[str]] = field(default_factory=dict)


def flatten(variables: dict[str, Any]) -> Leaves:
    """All numeric arrays of one or two dimensions and all text lists; ``__header__`` and its like are left out."""
    leaves = Leaves()
    for name, value in variables.items():
        if not name.startswith("__"):
            _walk(name, value, leaves)
    return leaves


def _walk(name: str, value: Any, leaves: Leaves) -> None:
    if isinstance(value, dict):
        for key, item in value.items():
            _walk(f"{name}.{key}", item, leaves)
    elif isinstance(value, np.ndarray) and value.dtype.names:
        for element, where in zip(value.reshape(-1), _numbered(name, value.size), strict=True):
            for key in value.dtype.names:
                _walk(f"{where}.{key}", element[key], leaves)
    elif isinstance(value, list) or (isinstance(value, np.ndarray) and value.dtype == object):
        _walk_cell(name, list(value) if isinstance(value, list) else list(value.reshape(-1)), leaves)
    elif np.asarray(value).dtype.kind in "buif" and np.asarray(value).ndim <= 2:
        leaves.arrays[name] = np.asarray(value)


def _walk_cell(name: str, items: list[Any], leaves: Leaves) -> None:
    texts = [_text(item) for item in items]
    if items and all(text is not None for text in texts):
        leaves.texts[name] = [str(text) for text in texts]
        return
    for item, where in zip(items, _numbered(name, len(items)), strict=True):
        _walk(where, item, leaves)


def _numbered(name: str, n: int) -> list[str]:
    return [name] if n == 1 else [f"{name}{{{i + 1}}}" for i in range(n)]


def _text(item: Any) -> str | None:
    if isinstance(item, str):
        return item
    if isinstance(item, np.ndarray) and item.dtype.kind == "U" and item.size == 1:
        return str(item.reshape(-1)[0])
    return None

"""Lists in random order, drawn by a rule that anybody can follow with pencil and hash.

The draw depends on nothing but a text. Random 64-bit numbers are the first eight bytes, most significant first, of the
SHA-256 of that text in UTF-8, a line feed and a counter (0, 1, 2, ... in decimal). A number below n is such a number
modulo n, where it lies below the largest multiple of n; else the next is taken. A list is shuffled from its end (Fisher
and Yates): for i = n - 1, ..., 1 element i changes places with element j, a number below i + 1. So the order is the
same on every computer and with every version of Python.
"""

from __future__ import annotations

import hashlib
from collections.abc import Iterator, Sequence
from itertools import count
from typing import TypeVar

T = TypeVar("T")


def random_numbers(text: str) -> Iterator[int]:
    """Random 64-bit numbers."""
    return (int.from_bytes(hashlib.sha256(f"{text}\n{n}".encode()).digest()[:8], "big") for n in count())


def shuffled(items: Sequence[T], numbers: Iterator[int]) -> list[T]:
    """All of ``items``, in an order that the next of ``numbers`` decide."""
    order = list(items)
    for i in range(len(order) - 1, 0, -1):
        limit = 2**64 // (i + 1) * (i + 1)
        j = next(number for number in numbers if number < limit) % (i + 1)
        order[i], order[j] = order[j], order[i]
    return order

"""Which format a file has, from its name and first bytes alone; nothing here parses or imports anything heavy."""

from __future__ import annotations

import re
from pathlib import Path

HEAD_BYTES = 4096
"""Number of leading bytes the recognisers look at."""

_NUMBERS = re.compile(r"[\s,;]*([+-]?(\d+[.,]?\d*|[.,]\d+)([eE][+-]?\d+)?|nan|inf)([\s,;]|$)", re.IGNORECASE)
_X_PAIRS = re.compile(r'"?X\s*\[s\]"?\s*[,;\t][^,;\t]*([,;\t]\s*"?X\s*\[s\]|[,;\t]*$)')


def first_line(head: bytes) -> str:
    """First line of a text head that is neither blank nor a ``#`` comment; "" where the head is not text."""
    if head.startswith((b"\xff\xfe", b"\xfe\xff")):
        text = head[: len(head) // 2 * 2].decode("utf-16", errors="replace")
    else:
        text = head.removeprefix(b"\xef\xbb\xbf").decode("latin-1")
    if "\0" in text:
        return ""
    return next((line for line in re.split(r"[\r\n]+", text) if line.strip() and not line.startswith("#")), "")


def is_edf(path: Path, head: bytes) -> bool:
    return head.startswith(b"0       ") or (path.suffix.lower() == ".edf" and not is_bdf(path, head))


def is_bdf(path: Path, head: bytes) -> bool:
    return head.startswith(b"\xffBIOSEMI") or (path.suffix.lower() == ".bdf" and not head.startswith(b"0       "))


def is_c3d(path: Path, head: bytes) -> bool:
    return path.suffix.lower() == ".c3d" or (head[1:2] == b"\x50" and b"\0" in head)


def is_matlab(path: Path, head: bytes) -> bool:
    return path.suffix.lower() == ".mat" or head.startswith(b"MATLAB ")


def is_discover(path: Path, head: bytes) -> bool:
    return "Trigno Discover" in first_line(head)


def is_emgworks(path: Path, head: bytes) -> bool:
    line = first_line(head)
    return bool(_X_PAIRS.match(line)) or (line.startswith("Label:") and "Sampling frequency:" in line)


def is_text_matrix(path: Path, head: bytes) -> bool:
    return bool(_NUMBERS.match(first_line(head)))


def is_plain_csv(path: Path, head: bytes) -> bool:
    return bool(re.search(r"[A-Za-z]", first_line(head)))

"""A zip archive whose bytes depend on its files alone."""

from __future__ import annotations

import io
import zipfile
from collections.abc import Mapping

_EPOCH = (1980, 1, 1, 0, 0, 0)
"""The first time that a zip archive can say."""


def zip_bytes(files: Mapping[str, bytes]) -> bytes:
    """Archive of ``files`` (name to content), sorted by name, without times, owners or compression.

    Compressed bytes change with the version of the compressor; stored ones never do.
    """
    buffer = io.BytesIO()
    with zipfile.ZipFile(buffer, "w", zipfile.ZIP_STORED) as archive:
        for name in sorted(files):
            entry = zipfile.ZipInfo(name, _EPOCH)
            entry.create_system = 3
            entry.external_attr = 0o100644 << 16
            archive.writestr(entry, files[name])
    return buffer.getvalue()

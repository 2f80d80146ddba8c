"""What an installation consists of, from requirements.lock: CycloneDX 1.6 as JSON on standard output.

``python scripts/sbom.py > sbom.cdx.json``. The same lock and version give the same bytes: the serial number is made of
them, and a time stands in it only where SOURCE_DATE_EPOCH is set. It names packages by purl and no host.
"""

from __future__ import annotations

import datetime
import json
import os
import re
import sys
import tomllib
import uuid
from pathlib import Path
from typing import Any

ROOT = Path(__file__).resolve().parent.parent
_LINE = re.compile(r"^([a-z0-9._-]+)==(\S+)(?: ; (.*?))?((?: --hash=\S+)+)$")


def components(lock: str) -> list[dict[str, Any]]:
    """One for each locked version, with the hashes of its wheels and sdist. ValueError : a line that is no pin."""
    found = []
    for line in lock.replace("\\\n", " ").splitlines():
        match = _LINE.match(re.sub(r"\s+", " ", line.strip()))
        if match is None:
            raise ValueError(f"requirements.lock: expected NAME==VERSION with hashes, but found {line[:80]!r}.")
        name, version, marker, hashes = match.groups()
        purl = f"pkg:pypi/{name}@{version}"
        one: dict[str, Any] = {"type": "library", "bom-ref": purl, "name": name, "version": version, "purl": purl}
        one["hashes"] = [{"alg": "SHA-256", "content": text} for text in re.findall(r"sha256:([0-9a-f]{64})", hashes)]
        if marker:
            one["properties"] = [{"name": "python:marker", "value": marker}]
        found.append(one)
    return found


def bom(lock: str, version: str, licence: str, epoch: str | None) -> dict[str, Any]:
    """The document. epoch : seconds since 1970 as text, or None."""
    parts = components(lock)
    purl = f"pkg:pypi/emg2vsa@{version}"
    metadata: dict[str, Any] = {
        "component": {
            "type": "application", "bom-ref": purl, "name": "emg2vsa", "version": version, "purl": purl,
            "licenses": [{"license": {"id": licence}}],
        }
    }  # fmt: skip
    if epoch is not None:
        metadata["timestamp"] = datetime.datetime.fromtimestamp(int(epoch), datetime.UTC).isoformat()
    return {
        "bomFormat": "CycloneDX",
        "specVersion": "1.6",
        "serialNumber": f"urn:uuid:{uuid.uuid5(uuid.NAMESPACE_URL, purl + lock)}",
        "version": 1,
        "metadata": metadata,
        "components": parts,
        "dependencies": [{"ref": purl, "dependsOn": [one["bom-ref"] for one in parts]}],
    }


def main() -> int:
    licence = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]["license"]
    found = re.search(r'^__version__ = "(.+)"$', (ROOT / "casr" / "__init__.py").read_text(encoding="utf-8"), re.M)
    assert found is not None
    lock = (ROOT / "requirements.lock").read_text(encoding="utf-8")
    json.dump(bom(lock, found[1], licence, os.environ.get("SOURCE_DATE_EPOCH")), sys.stdout, indent=1)
    print()
    return 0


if __name__ == "__main__":
    sys.exit(main())

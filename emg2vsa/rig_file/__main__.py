"""``python -m emg2vsa.rig_file`` in the checkout writes the schema and the reference anew."""

from __future__ import annotations

import json
from pathlib import Path

from emg2vsa.rig_file.reference import json_schema, reference

SCHEMA = Path("studies/rig.schema.json")
REFERENCE = Path("docs/reference/rig-file.md")


def main() -> None:
    SCHEMA.write_text(json.dumps(json_schema(), indent=2) + "\n", encoding="utf-8")
    REFERENCE.write_text(reference(), encoding="utf-8")


if __name__ == "__main__":
    main()

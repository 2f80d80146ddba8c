"""``python -m emg2vsa.study_file`` in the checkout writes the schema and the reference anew."""

from __future__ import annotations

import json
from pathlib import Path

from emg2vsa.study_file.reference import reference
from emg2vsa.study_file.schema import json_schema

SCHEMA = Path("studies/study.schema.json")
REFERENCE = Path("docs/reference/study-file.md")


def main() -> None:
    SCHEMA.write_text(json.dumps(json_schema(), indent=2) + "\n", encoding="utf-8")
    REFERENCE.write_text(reference(), encoding="utf-8")


if __name__ == "__main__":
    main()

"""What README, docs and notebooks show of Python passes mypy --strict, as people copy it into typed code."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from tests.snippets import blocks_of

ROOT = Path(__file__).resolve().parent.parent
CACHE = ROOT / ".mypy_cache" / "snippets"
CELLS = re.compile(r"^```\{code-cell\} python\n(.*?)^```$", flags=re.M | re.S)


def python_of(page: Path) -> str:
    """All Python of a page: its blocks share their names, as those of a notebook do."""
    cells = CELLS.findall(page.read_text(encoding="utf-8"))
    return "\n".join([*cells, *(block.text for block in blocks_of(page) if block.language == "python")])


@pytest.mark.slow
def test_python_of_all_pages_is_typed(tmp_path: Path) -> None:
    mypy = pytest.importorskip("mypy.api")
    written = []
    for page in [ROOT / "README.md", *sorted((ROOT / "docs").rglob("*.md"))]:
        if "_build" not in page.parts and (text := python_of(page)):
            written.append(tmp_path / (re.sub(r"\W", "_", str(page.relative_to(ROOT))) + ".py"))
            written[-1].write_text(text, encoding="utf-8")
    assert len(written) > 10
    options = ["--strict", "--no-warn-unused-ignores", "--ignore-missing-imports", "--cache-dir", str(CACHE)]
    told, wrong, status = mypy.run([*options, "--config-file", str(ROOT / "pyproject.toml"), *map(str, written)])
    assert status == 0, told + wrong

"""The plan of the house in docs/architecture.md, and the budgets of lines in pyproject.toml.

``python scripts/house.py`` writes the plan anew: layers, what stands in them, and their sizes.
``python scripts/house.py --check`` changes nothing. It fails where a package has more lines than its budget, where a
package has none, or where the page does not show the layers as they are. Sizes on the page may be old.
"""

from __future__ import annotations

import ast
import re
import sys
import tomllib
from dataclasses import dataclass
from pathlib import Path
from typing import Any

ROOT = Path(__file__).resolve().parent.parent
PAGE = ROOT / "docs" / "architecture.md"
MARK = "<!-- plan of the house: {} -->"


@dataclass(frozen=True)
class Part:
    """A package or a module below ``emg2vsa`` or ``casr``. files : of Python."""

    name: str
    about: str
    files: tuple[Path, ...]

    @property
    def lines(self) -> int:
        return sum(lines_of(path) for path in self.files)


def lines_of(path: Path) -> int:
    return len(path.read_text(encoding="utf-8").splitlines())


def words_of(folder: Path) -> int:
    """Words of the pages in a folder, without what the site makes."""
    pages = (path for path in folder.rglob("*.md") if not {"_build", "made"} & set(path.parts))
    return sum(len(path.read_text(encoding="utf-8").split()) for path in pages)


def part(package: str, name: str) -> Part:
    """One member of a layer; its first sentence says what it is."""
    folder, module = ROOT / package / name, ROOT / package / f"{name}.py"
    # a module that was a folder leaves one with compiled code behind
    first = module if module.is_file() else folder / "__init__.py"
    files = (module,) if module.is_file() else tuple(sorted(folder.rglob("*.py")))
    about = ast.get_docstring(ast.parse(first.read_text(encoding="utf-8"))) or ""
    return Part(name, " ".join(about.split("\n\n")[0].split()), files)


def sizes(budgets: dict[str, int]) -> dict[str, int]:
    """Lines of what has a budget, words of ``docs``: ``emg2vsa/*.py`` are the modules that stand alone."""
    found = {}
    for place in budgets:
        if place == "docs":
            found[place] = words_of(ROOT / place)
        elif place.endswith("*.py"):
            found[place] = sum(map(lines_of, sorted((ROOT / place).parent.glob("*.py"))))
        else:
            found[place] = sum(map(lines_of, sorted((ROOT / place).rglob("*.py"))))
    return found


def layers(tools: dict[str, Any]) -> dict[str, list[list[str]]]:
    """Layers of each distribution, top to bottom, as the import contracts have them."""
    whole = [one for one in tools["importlinter"]["contracts"] if one.get("containers") in (["emg2vsa"], ["casr"])]
    return {one["containers"][0]: [layer.split(" | ") for layer in one["layers"]] for one in whole}


def plan(tools: dict[str, Any]) -> str:
    """The tables of the page."""
    lines = []
    for package, rows in layers(tools).items():
        lines += [f"### `{package}`", "", "| part | what it is | files | lines |", "|---|---|---:|---:|"]
        for row in rows:
            for one in (part(package, name) for name in row):
                about = one.about.replace("|", "\\|")
                lines.append(f"| `{one.name}` | {about} | {len(one.files)} | {one.lines} |")
            lines.append("| | | | |")
        lines[-1:] = [""]
    budgets = tools["house"]["budgets"]
    rest = {place: size for place, size in sizes(budgets).items() if place.count("/") == 0 or place.endswith("*.py")}
    lines += ["### All", "", "| place | lines (docs: words) |", "|---|---:|"]
    lines += [f"| `{place}` | {size} |" for place, size in rest.items()]
    return "\n".join(lines)


def faults(tools: dict[str, Any]) -> list[str]:
    """What is wrong with budgets and page, a sentence each."""
    budgets = tools["house"]["budgets"]
    said = [
        f"{place}: {size} lines, but its budget is {budgets[place]}. Make it smaller, or raise its budget in "
        "[tool.house.budgets] of pyproject.toml, in a commit that says why."
        for place, size in sizes(budgets).items()
        if size > budgets[place]
    ]
    for package in layers(tools):
        folders = sorted(path.parent.name for path in (ROOT / package).glob("*/__init__.py"))
        said += [
            f"{package}/{name}: no budget. Give it one in [tool.house.budgets] of pyproject.toml."
            for name in folders
            if f"{package}/{name}" not in budgets
        ]
    if without_sizes(between(PAGE.read_text(encoding="utf-8"))) != without_sizes(plan(tools)):
        said.append("docs/architecture.md: the plan of the house is old. Run: python scripts/house.py")
    return said


def between(page: str) -> str:
    """The plan in the page."""
    return page.partition(MARK.format("begin"))[2].partition(MARK.format("end"))[0].strip()


def without_sizes(text: str) -> str:
    """Rows without their files and lines."""
    return re.sub(r"(\| \d+ )+\|$", "|", text, flags=re.M)


def main(words: list[str]) -> int:
    tools = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["tool"]
    if words == ["--check"]:
        said = faults(tools)
        print(
            "\n".join(said) or f"The house: {sum(sizes(tools['house']['budgets']).values())} lines and words in budget."
        )
        return 1 if said else 0
    before, _, rest = PAGE.read_text(encoding="utf-8").partition(MARK.format("begin"))
    after = rest.partition(MARK.format("end"))[2]
    page = f"{before}{MARK.format('begin')}\n\n{plan(tools)}\n\n{MARK.format('end')}{after}"
    PAGE.write_text(page, encoding="utf-8")
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))

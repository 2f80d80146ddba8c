"""``emg2vsa stats``: every test of the study and its companions on any tidy table, without a study."""

from __future__ import annotations

import argparse
import dataclasses
from pathlib import Path
from typing import TYPE_CHECKING

from casr.command_line import Commands, add_command, add_json, print_json

if TYPE_CHECKING:
    from emg2vsa.companions.tidy import TidyTests
    from emg2vsa.readers.tidy_table import TidyTable
    from emg2vsa.statistics.mixed_variances import MixedResiduals


def add_to(commands: Commands) -> None:
    parser = add_command(
        commands,
        "stats",
        run,
        "Compare groups of a tidy table (one row an observation): each usual test beside its companions.",
        "For every hypothesis one table: the test of the palpation paper, its companion, the effect, and whether the "
        "verdict changes. "
        "Numbers are read exactly as they are written. Rows without a number, group or block are left out and counted. "
        "Without --value and --group the columns are listed. "
        "Statistics of other installed packages (plugins) follow ours; the status is 1 where one of them fails. "
        "Example: emg2vsa stats slopes.csv --value b --group specimen --block participant",
    )
    parser.add_argument("table", type=Path, metavar="TABLE", help="CSV, TSV or semicolon-separated text with a header")
    parser.add_argument("--value", metavar="COLUMN", help="the number that is compared")
    parser.add_argument("--group", metavar="COLUMN", help="what tells the groups apart")
    parser.add_argument(
        "--block", metavar="COLUMN", help="who or what was measured repeatedly (participant); adds tests over blocks"
    )
    parser.add_argument("--alpha", type=float, default=0.05, metavar="P", help="significance level (default 0.05)")
    parser.add_argument(
        "--margin", type=float, metavar="X", help="means closer than this count as equal (TOST), unit of the value"
    )
    parser.add_argument(
        "--protected", action="store_true", help="Fisher's LSD only where the F test is significant (default: always)"
    )
    parser.add_argument("--details", action="store_true", help="add every result of every group, pair and block")
    parser.add_argument(
        "--style", choices=("apa", "ieee", "latex", "plain"), default="apa",
        help="how results are written (default apa; plain: full digits)",
    )  # fmt: skip
    add_json(parser)


def run(arguments: argparse.Namespace) -> int:
    from emg2vsa.companions.plugin_statistics import BROKEN
    from emg2vsa.companions.tidy import tidy_tests
    from emg2vsa.readers.tidy_table import read_tidy_table

    _check(arguments)
    table = read_tidy_table(arguments.table)
    if arguments.value is None or arguments.group is None:
        return _list_columns(table, arguments)
    found = tidy_tests(
        table.numbers(arguments.value),
        table.texts(arguments.group),
        table.texts(arguments.block) if arguments.block else None,
        arguments.alpha,
        arguments.margin,
        protected=arguments.protected,
    )
    if arguments.json:
        print_json(_as_json(found, arguments))
    else:
        _print(found, arguments)
    return 1 if any(note.startswith(BROKEN) for _, outcome in found.of_plugins for note in outcome.notes) else 0


def _check(arguments: argparse.Namespace) -> None:
    from emg2vsa.errors import SettingError

    for name, good, wanted in (
        ("alpha", 0 < arguments.alpha < 0.5, "a level between 0 and 0.5"),
        ("margin", arguments.margin is None or 0 < arguments.margin < float("inf"), "a number above 0"),
    ):
        if not good:
            raise SettingError(
                f"--{name}", wanted=wanted, found=str(getattr(arguments, name)), do=f"Give --{name} such a value."
            )
    columns = [c for c in (arguments.value, arguments.group, arguments.block) if c]
    if len(set(columns)) < len(columns):
        found = ", ".join(map(repr, columns))
        raise SettingError(
            "--value, --group, --block",
            wanted="different columns",
            found=found,
            do="Name another column in one of these options.",
        )


def _list_columns(table: TidyTable, arguments: argparse.Namespace) -> int:
    columns = [
        {
            "name": name,
            "kind": "numbers" if name in table.numeric() else "text",
            "different": len(set(table.texts(name))),
            "first": table.texts(name)[0],
        }
        for name in table.names
    ]
    if arguments.json:
        print_json({"rows": len(table.cells), "columns": columns})
        return 0
    print(f"{table.path}: {len(table.cells)} rows, {len(columns)} columns")
    for column in columns:
        print(f"  {column['name']:<20} {column['kind']:<8} {column['different']:>6} different, e.g. {column['first']}")
    print("Choose with --value (numbers), --group and perhaps --block.")
    return 0


def _print(found: TidyTests, arguments: argparse.Namespace) -> None:
    from emg2vsa.report.tidy_text import text

    blocks = f" in {found.blocks.size} blocks ({arguments.block})" if found.blocks.size else ""
    print(
        f"{arguments.table}: {arguments.value} by {arguments.group}, {found.n} rows of {found.groups.size} groups"
        f"{blocks}, alpha = {found.alpha:g}"
    )
    for count, why in ((found.without_number, "without a number"), (found.without_name, "without a group or block")):
        if count:
            print(f"note: {count} row{'s' if count != 1 else ''} {why} left out")
    for names in found.alike():
        print(f"note: {names} differ in capitals or spaces only and are kept apart; write them alike if they are one")
    print()
    print(text(found, arguments.style, details=arguments.details))


def _as_json(found: TidyTests, arguments: argparse.Namespace) -> dict[str, object]:
    from emg2vsa.report.outcome_text import STYLES, said
    from emg2vsa.report.tidy_text import hypotheses, outcomes

    over = found.by_block.blocks if found.by_block else None
    return {
        "table": str(arguments.table),
        "value": arguments.value,
        "group": arguments.group,
        "block": arguments.block,
        "alpha": found.alpha,
        "rows": found.n,
        "alike": list(found.alike()),
        "left_out": {"without_number": found.without_number, "without_name": found.without_name},
        "groups": [
            {"name": name, "n": int(n), "mean": float(mean), "sd": float(sd)}
            for name, n, mean, sd in zip(found.groups.tolist(), found.count, found.mean, found.sd, strict=True)
        ],
        "hypotheses": [dataclasses.asdict(each) for each in hypotheses(found, arguments.style)],
        "outcomes": [
            {"of": of, **dataclasses.asdict(outcome), "text": {style: said(outcome, style) for style in STYLES}}
            for of, outcome in outcomes(found)
        ],
        "residuals": _residuals(over.residuals) if over else None,
    }


def _residuals(found: MixedResiduals | None) -> dict[str, list[float]] | None:
    """Of the mixed model, for a QQ plot and for residuals against fitted values."""
    return None if found is None else {name: values.tolist() for name, values in dataclasses.asdict(found).items()}

"""``emg2vsa stats``: every test of the study and its companions on any tidy table, without a study."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import TYPE_CHECKING

from casr.command_line import JSON, Commands, add_command, answer

if TYPE_CHECKING:
    from emg2vsa.readers.tidy_table import TidyTable

SUMMARY = "Compare groups of a tidy table (one row an observation): each usual test beside its companions."
EPILOG = """
For every hypothesis one table: the test of the palpation paper, its companions, and their effects. No verdict is drawn
from them: each test stands for itself. Numbers are read exactly as they are written. Rows without a number, group or
block are left out and counted. Without --value and --group the columns are listed. Statistics of other installed
packages (plugins) follow ours; the status is 1 where one of them fails. Example: emg2vsa stats slopes.csv --value b
--group specimen --block participant
"""
OPTIONS = f"""
table TABLE  CSV, TSV or semicolon-separated text with a header
--value COLUMN  the number that is compared
--group COLUMN  what tells the groups apart
--block COLUMN  who or what was measured repeatedly (participant); adds tests over blocks
--alpha P = 0.05  significance level (default 0.05)
--margin X  means closer than this count as equal (TOST), unit of the value
--protected  Fisher's LSD only where the F test is significant (default: always)
--details  add every result of every group, pair and block
--style {{apa,ieee,latex,plain}} = apa  how results are written (default apa; plain: full digits)
{JSON}
"""


def add_to(commands: Commands) -> None:
    add_command(commands, "stats", run, SUMMARY, EPILOG, OPTIONS, {"TABLE": Path, "P": float})


def run(arguments: argparse.Namespace) -> int:
    """Test a table or a study. SettingError : a level, a margin or columns that cannot be."""
    from emg2vsa.companions.tidy import BROKEN, tidy_tests
    from emg2vsa.readers.tidy_table import read_tidy_table
    from emg2vsa.report.tidy_text import as_json, lines

    _check(arguments)
    table, value, group, block = read_tidy_table(arguments.table), arguments.value, arguments.group, arguments.block
    if value is None or group is None:
        return _list_columns(table, arguments.json)
    blocks = table.texts(block) if block else None
    limits = (arguments.alpha, arguments.margin)
    found = tidy_tests(table.numbers(value), table.texts(group), blocks, *limits, protected=arguments.protected)
    of = {"table": str(arguments.table), "value": value, "group": group, "block": block}
    told = of | as_json(found, arguments.style) if arguments.json else of
    answer(arguments.json, told, lines(found, of, arguments.style, details=arguments.details))
    return 1 if any(note.startswith(BROKEN) for _, outcome in found.of_plugins for note in outcome.notes) else 0


def _check(arguments: argparse.Namespace) -> None:
    from emg2vsa.errors import SettingError

    for name, good, wanted in (
        ("alpha", 0 < arguments.alpha < 0.5, "a level between 0 and 0.5"),
        ("margin", arguments.margin is None or 0 < arguments.margin < float("inf"), "a number above 0"),
    ):
        if not good:
            found, do = str(getattr(arguments, name)), f"Give --{name} such a value."
            raise SettingError(f"--{name}", wanted=wanted, found=found, do=do)
    columns = [c for c in (arguments.value, arguments.group, arguments.block) if c]
    if len(set(columns)) < len(columns):
        found, do = ", ".join(map(repr, columns)), "Name another column in one of these options."
        raise SettingError("--value, --group, --block", wanted="different columns", found=found, do=do)


def _list_columns(table: TidyTable, as_json: bool) -> int:
    columns = table.described()
    rows = (f"  {c['name']:<20} {c['kind']:<8} {c['different']:>6} different, e.g. {c['first']}" for c in columns)
    last = "Choose with --value (numbers), --group and perhaps --block."
    head = f"{table.path}: {len(table.cells)} rows, {len(columns)} columns"
    answer(as_json, {"rows": len(table.cells), "columns": columns}, [head, *rows, last])
    return 0

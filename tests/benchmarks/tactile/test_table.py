"""Tables as text and as CSV."""

from __future__ import annotations

from pathlib import Path

from benchmarks.tactile.table import Table

TABLE = Table(
    "t",
    "Title",
    (("method", ""), ("ms", ".2f"), ("%", "+.1f")),
    [["a", 1.234, None], ["long name", 10, -2e6]],
    ("note",),
)


def test_text_has_equal_columns_a_dash_for_nothing_and_short_numbers() -> None:
    assert TABLE.text().split("\n") == [
        "Title",
        "method        ms         %",
        "a           1.23         -",
        "long name  10.00  -2.0e+06",
        "note",
    ]


def test_csv_keeps_all_digits(tmp_path: Path) -> None:
    TABLE.write(tmp_path / "new")
    assert (tmp_path / "new" / "t.csv").read_text() == "method,ms,%\na,1.234,\nlong name,10,-2000000.0\n"

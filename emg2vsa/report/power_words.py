"""The power of a design: for programs, and in lines for people."""

from __future__ import annotations

from typing import Any

from emg2vsa.statistics.power import MEANING, PairPower, PowerTable

Words = tuple[dict[str, Any], list[str]]


def pair_words(found: PairPower, design: str, n: int, target: float) -> Words:
    """Of two treatments; n : people, of each group for "equal-groups". target : the wanted power."""
    each = " in each group" if design == "equal-groups" else ""
    who = f"two groups of {n} participants" if each else f"{n} participants"
    if design == "paired":
        name, of = "smallest_effect", f"to find a mean difference of {found.effect:g} SD of the differences"
        least = f"smallest difference found with power {target:g}: {found.least:.3f} SD of the differences"
    else:
        name = "smallest_margin"
        of = f"to find equality within {found.margin:g} SD where the true difference is {found.effect:g} SD"
        least = f"smallest margin shown with power {target:g}: {found.least:.3f} SD"
    lines = [
        f"power {found.power:.4f} with {who} {of}",
        f"participants needed{each} for power {target:g}: {found.needed or 'more than a million'}",
        least,
    ]
    told = {"design": design, "power": found.power, "participants_needed": found.needed or None, name: found.least}
    return told, lines


def repeated_words(
    power: float, needed: int, table: PowerTable, n: int, m: int, target: float, *, sensitivity: bool
) -> Words:
    """Of n people measured m times each. needed : people, 0 where more than a million. sensitivity : lines of the
    table too."""
    lines = [
        f"power {power:.4f} with {n} participants measured {m} times each",
        f"participants needed for power {target:g}: {needed or 'more than a million'}",
    ]
    if sensitivity:
        lines.append("power (participants needed) over rho (down) and epsilon (across)")
        lines.append("rho    " + "".join(f"{epsilon:>16.2f}" for epsilon in table.epsilon))
        for rho, powers, people in zip(table.rho, table.power, table.people, strict=True):
            cells = (f"{p:.4f} ({k or '>1e6'})" for p, k in zip(powers, people, strict=True))
            lines.append(f"{rho:<7.2f}" + "".join(f"{cell:>16}" for cell in cells))
    over = {
        "rho": table.rho.tolist(), "epsilon": table.epsilon.tolist(), "power": table.power.tolist(),
        "participants_needed": table.people.tolist(),
    }  # fmt: skip
    told = {"power": power, "participants_needed": needed or None, "sensitivity": over}
    return told, [*lines, f"The paper's design: {MEANING}"]

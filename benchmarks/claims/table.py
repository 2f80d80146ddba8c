"""The page of the benchmark, and the table that the report shows: false rates and power of every claim."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any

from benchmarks.claims.verdicts import Rate, Truth, any_false, false_rates, powers
from benchmarks.claims.worlds import WORLDS

OF_PAPER = "paper"
"The world whose power the report shows: the paper's effects, all as on this bench."
Verdicts = Mapping[str, Mapping[str, str]]
"World to claim to a letter of each study."
Truths = Mapping[str, Mapping[str, Truth]]


def calibration(verdicts: Verdicts, truths: Truths) -> dict[str, Any]:
    """What the report shows: claim to its worst false rate with the upper bound, its world, and its power."""
    power = powers(verdicts[OF_PAPER], truths[OF_PAPER])
    claims = {}
    for key, (world, rate) in _worst(verdicts, truths).items():
        own = truths[OF_PAPER][key].right if key in truths[OF_PAPER] else ""
        claims[key] = {
            "false": rate.share, "bound": rate.bound, "world": world,
            "right": {"h": "holds", "r": "refuted"}.get(own, ""),
            "power": power[key].share if key in power else None,
        }  # fmt: skip
    world, worst = max(_any(verdicts, truths).items(), key=lambda item: item[1].bound)
    studies = min(len(letters) for own in verdicts.values() for letters in own.values())
    return {
        "worlds": len(verdicts), "studies": studies,
        "any": {"false": worst.share, "bound": worst.bound, "world": world}, "claims": claims,
    }  # fmt: skip


def _any(verdicts: Verdicts, truths: Truths) -> dict[str, Rate]:
    return {name: any_false(own, truths[name]) for name, own in verdicts.items()}


def _worst(verdicts: Verdicts, truths: Truths) -> dict[str, tuple[str, Rate]]:
    """Claim to the world in which it is false most often."""
    worst: dict[str, tuple[str, Rate]] = {}
    for name, own in verdicts.items():
        for key, rate in false_rates(own, truths[name]).items():
            if key not in worst or rate.share > worst[key][1].share:
                worst[key] = name, rate
    return worst


def page(verdicts: Verdicts, truths: Truths) -> Iterator[str]:
    """Markdown, line by line."""
    worlds = [world for world in WORLDS if world.name in verdicts]
    studies = min(len(letters) for own in verdicts.values() for letters in own.values())
    yield "# How often the claims are right\n"
    yield (
        f"`python -m benchmarks.claims RUNS`: {studies} whole studies or more in each of {len(worlds)} worlds, all "
        "claims of a study judged together as in the report. Percent; false: a verdict that the world contradicts, "
        "with the upper 95 % bound; right: the verdict that a study without end would come to."
    )
    yield "\n## Any false verdict in a report\n"
    yield "| world | what is true and what scatters | studies | any false | at most |\n|---|---|---:|---:|---:|"
    for world in worlds:
        rate = any_false(verdicts[world.name], truths[world.name])
        yield f"| {world.name} | {world.says} | {rate.n} | {_percent(rate.share)} | {_percent(rate.bound)} |"
    effects = [world for world in worlds if world.effect]
    yield "\n## Every claim: the worst of all worlds, and its power\n"
    yield (
        "| claim | worst false | at most | in the world | "
        + " | ".join(f"right, {world.name}" for world in effects)
        + " |\n|---|---:|---:|---|" + "---:|" * len(effects)
    )  # fmt: skip
    found = {world.name: powers(verdicts[world.name], truths[world.name]) for world in effects}
    for key, (name, rate) in _worst(verdicts, truths).items():
        cells = " | ".join(_power(found[w.name].get(key), truths[w.name].get(key)) for w in effects)
        yield f"| {key} | {_percent(rate.share)} | {_percent(rate.bound)} | {name} | {cells} |"
    yield "\n## Every claim that was false in any study of a world\n"
    yield "| world | claim | false | at most |\n|---|---|---:|---:|"
    for world in worlds:
        for key, rate in false_rates(verdicts[world.name], truths[world.name]).items():
            if rate.count:
                yield f"| {world.name} | {key} | {_percent(rate.share)} | {_percent(rate.bound)} |"


def _percent(share: float) -> str:
    return f"{100 * share:.1f}"


def _power(rate: Rate | None, truth: Truth | None) -> str:
    if rate is None or truth is None:
        return "–"
    return f"{100 * rate.share:.0f} {'holds' if truth.right == 'h' else 'refuted'}"

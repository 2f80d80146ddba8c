"""The page of the benchmark, and the table that the report shows: false rates and power of every claim."""

from __future__ import annotations

from collections.abc import Iterator, Mapping

from benchmarks.claims.verdicts import Rate, Truth, any_false, false_rates, powers
from benchmarks.claims.worlds import WORLDS

OF_PAPER = "paper"
"The world whose power the report shows: the paper's effects, all as on this bench."
Verdicts = Mapping[str, Mapping[str, str]]
"World to claim to a letter of each study."
_RIGHT = {"h": "holds", "r": "refuted", "": ""}
Truths = Mapping[str, Mapping[str, Truth]]


_MODULE = '''"""How often each claim is right in worlds that are known.

``python -m benchmarks.claims RUNS --table --write`` wrote this. Studies of the design that it draws: 14 people,
three mountings of three presses (benchmarks/results/claims).
"""

from __future__ import annotations

from emg2vsa.claims.claim import Right

WORLDS, STUDIES = {worlds}, {studies}
"How many, and of each."
ANY = {any}
"Of any false verdict in a report."
CLAIMS = {{
{claims}
}}
'''


def module(verdicts: Verdicts, truths: Truths) -> str:
    """What the report shows: claim to its worst false rate, and its power at the paper's effects."""
    power = powers(verdicts[OF_PAPER], truths[OF_PAPER])
    claims = []
    for key, (world, rate) in _worst(verdicts, truths).items():
        own = _RIGHT[truths[OF_PAPER][key].right] if key in truths[OF_PAPER] else ""
        found = f"{power[key].share:.4g}" if key in power else "None"
        claims.append(f'    "{key}": Right({rate.share:.4g}, {rate.bound:.4g}, "{world}", "{own}", {found}),')
    world, worst = max(_any(verdicts, truths).items(), key=lambda item: item[1].bound)
    return _MODULE.format(
        worlds=len(_told(verdicts)), studies=_studies(verdicts), claims="\n".join(claims),
        any=f'Right({worst.share:.4g}, {worst.bound:.4g}, "{world}")',
    )  # fmt: skip


def _studies(verdicts: Verdicts) -> int:
    """Fewest of a world."""
    return min(len(letters) for own in verdicts.values() for letters in own.values())


def _any(verdicts: Verdicts, truths: Truths) -> dict[str, Rate]:
    return {name: any_false(own, truths[name]) for name, own in _told(verdicts).items()}


def _told(verdicts: Verdicts) -> Verdicts:
    """Of the worlds that data can tell."""
    return {world.name: verdicts[world.name] for world in WORLDS if world.name in verdicts and not world.beyond}


def _worst(verdicts: Verdicts, truths: Truths) -> dict[str, tuple[str, Rate]]:
    """Claim to the world in which it is false most often."""
    worst: dict[str, tuple[str, Rate]] = {}
    for name, own in _told(verdicts).items():
        for key, rate in false_rates(own, truths[name]).items():
            if key not in worst or rate.share > worst[key][1].share:
                worst[key] = name, rate
    return worst


def page(verdicts: Verdicts, truths: Truths) -> Iterator[str]:
    """Markdown, line by line."""
    worlds = [world for world in WORLDS if world.name in verdicts]
    yield "# How often the claims are right\n"
    yield (
        f"`python -m benchmarks.claims RUNS`: {_studies(verdicts)} whole studies or more in each of {len(worlds)} "
        "worlds, all claims of a study judged together as in the report. Percent; false: a verdict that the world "
        "contradicts, with the upper 95 % bound; right: the verdict that a study without end would come to."
    )
    yield "\n## Any false verdict in a report\n"
    yield "| world | what is true and what scatters | studies | any false | at most |\n|---|---|---:|---:|---:|"
    for world in sorted(worlds, key=lambda world: world.beyond):
        rate = any_false(verdicts[world.name], truths[world.name])
        yield f"| {world.name} | {world.says} | {rate.n} | {_percent(rate.share)} | {_percent(rate.bound)} |"
    if any(world.beyond for world in worlds):
        yield (
            "\nIn the last one drift comes between recordings alone and looks like a difference, which no data can "
            "tell: it does not count below, and the report says what its bound takes for granted."
        )
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
    return f"{100 * rate.share:.0f} {_RIGHT[truth.right]}"

"""The two documents that show an author the package: README.txt to read, proof.tex to compile."""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping
from pathlib import PurePosixPath
from textwrap import wrap

import emg2vsa
from emg2vsa.deposit.crate import description
from emg2vsa.report.latex import latex_text

_EXAMPLES = (
    r"\emgFitUsed{} of \emgTrialsTotal{} presses entered the tests.",
    r"The probe pressed \emgRunsPresses{} times in \emgRunsCount{} runs.",
)
_NAME = re.compile(r"\\(\w+)")
_MACRO = re.compile(r"^\\newcommand\{\\(\w+)\}.*% (.+)$", re.M)


def packages(files: Mapping[str, bytes]) -> list[str]:
    """LaTeX packages that the files name in their first lines, and amsmath, which statements take."""
    firsts = [data.decode().partition("\n")[0] for name, data in files.items() if name.endswith(".tex")]
    named = [line.partition(" package")[2].partition(" and text")[0] for line in firsts if line.startswith("% takes")]
    return sorted({"amsmath", *(word for line in named for word in re.findall(r"[a-z]{3,}", line))} - {"and"})


def readme(name: str, title: str, about: str, files: Mapping[str, bytes]) -> str:
    """How to put the package into a paper, and what each file is."""
    macros = {macro for macro, _ in _MACRO.findall(files["numbers.tex"].decode())}
    table, figure = (_first(files, folder) for folder in ("tables", "figures"))
    lines = [
        f"Authors' package of the study {name}: {title}",
        "",
        f"Written by emg2vsa {emg2vsa.__version__} (emg2vsa report STUDY --paper).",
        about,
        "The same results give the same files, byte for byte. Do not edit them: the next run writes them anew.",
        "",
        "In a paper whose folder holds this one under the name paper, in the preamble:",
        "",
        rf"  \usepackage{{{','.join(packages(files))}}}",
        r"  \newcommand{\emgfolder}{paper}",
        *(rf"  \input{{paper/{part}}}" for part in ("numbers", "statements") if f"{part}.tex" in files),
        "",
        "and in the text:",
        "",
        *(f"  {example}" for example in _EXAMPLES if set(_NAME.findall(example)) <= macros),
        *(rf"  \input{{paper/{part}}}" for part in (table, figure) if part),
        "",
        "numbers.tex names, after each macro, the key of its number; results.csv lists keys, values, units, macros and",
        "the steps behind each number; provenance.json says what those steps took. A number with a unit is set by",
        r"\emgquantity and a p by \emgp: define them before numbers.tex to set them your way.",
        r"Figures keep the numbers of the study; \newcommand{\emgfigure}[1]{} lets LaTeX count them.",
        "To see everything at once, compile proof.tex (twice, for long tables) in this folder.",
        "supplement.zip holds all of this folder as an RO-Crate 1.1, ready to deposit. Its date and licence are yours",
        "to say: --published 2026-01-31 --licence https://creativecommons.org/licenses/by/4.0/",
        "",
        "Files",
        "",
        *(f"  {path:<18} {description(path)}" for path in sorted(files) if "/" not in path),
        *(line for folder in _folders(files) for line in _inside(files, folder)),
    ]
    return "\n".join([*lines, ""])


def _folders(files: Iterable[str]) -> list[str]:
    return sorted({path.partition("/")[0] for path in files if "/" in path})


def _inside(files: Iterable[str], folder: str) -> list[str]:
    """The names in a folder, each once, and the forms they have."""
    paths = [PurePosixPath(path) for path in sorted(files) if path.startswith(f"{folder}/")]
    forms = ", ".join(sorted({path.suffix for path in paths}))
    names = ", ".join(dict.fromkeys(path.stem for path in paths))
    return ["", f"  {folder}/ ({forms})", *wrap(names, 110, initial_indent="    ", subsequent_indent="    ")]


def _first(files: Iterable[str], folder: str) -> str:
    found = sorted(name for name in files if name.startswith(f"{folder}/") and name.endswith(".tex"))
    return found[0].removesuffix(".tex") if found else ""


def _paragraphs(text: str) -> list[str]:
    """Plain text as LaTeX: a line alone above its paragraph is a heading."""
    made = []
    for block in filter(None, text.strip().split("\n\n")):
        heading, _, body = block.partition("\n")
        made += [rf"\subsection*{{{latex_text(heading)}}}", latex_text(body)] if body else [latex_text(heading)]
        made.append("")
    return made


def proof(title: str, files: Mapping[str, bytes]) -> str:
    """A document that begins with the methods, so that its first page has text; then every table and figure, tables
    over pages after the others, and every macro beside its key."""
    floats = [name for name in sorted(files) if name.endswith(".tex") and "/" in name]
    long = [name for name in floats if b"longtable" in files[name].partition(b"\n")[0]]
    macros = [name for name in ("numbers.tex", "statements.tex") if name in files]
    listed = [
        rf"\noindent\texttt{{{latex_text(key)}}}\hfill \{macro}\par"
        for name in macros
        for macro, key in _MACRO.findall(files[name].decode())
    ]
    return "\n".join(
        [
            "% Written by emg2vsa: everything in this package at one look.",
            r"\documentclass[10pt,twocolumn]{article}", r"\usepackage[margin=18mm]{geometry}",
            rf"\usepackage{{{','.join(packages(files))}}}", *(rf"\input{{{name}}}" for name in macros),
            r"\begin{document}", rf"\title{{{latex_text(title)}}}\author{{}}\date{{}}\maketitle",
            *_paragraphs(files.get("methods.txt", b"").decode()),
            # floats beyond a page's worth would be too many to hold back
            *(rf"\input{{{name}}}\clearpage" if i % 4 == 3 else rf"\input{{{name}}}"
              for i, name in enumerate(name for name in floats if name not in long)),
            r"\clearpage\onecolumn", *(rf"\input{{{name}}}" for name in long), r"\clearpage\footnotesize\raggedright",
            *listed, r"\end{document}", "",
        ]
    )  # fmt: skip

"""The report: pages, tables, ``results.json`` and ``numbers.tex``, made of results alone."""

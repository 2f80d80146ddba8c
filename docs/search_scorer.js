// Pages that say what to do stand before those that say why, how fast, or how it is written.
"use strict";

var Scorer = {
  score: ([page, title, anchor, description, score]) => {
    if (/^(how-to\/|tutorial|problems)/.test(page)) return score + 10;
    if (/^(decisions|benchmarks|_modules)/.test(page)) return score - 10;
    return score;
  },
  objNameMatch: 11,
  objPartialMatch: 6,
  objPrio: { 0: 15, 1: 5, 2: -5 },
  objPrioDefault: 0,
  title: 15,
  partialTitle: 7,
  term: 5,
  partialTerm: 2,
};

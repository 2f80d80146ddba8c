"""Works that the methods cite: one list for the page and for references.bib."""

from __future__ import annotations

import re
from collections.abc import Iterable
from typing import NamedTuple

from emg2vsa.report.latex import latex_text
from emg2vsa.report.wording import unwrapped

_CITED = re.compile(r"\[@(\w+)\]")


class Work(NamedTuple):
    """An article. authors : "Family, G." joined by " and ". doi : "" where it has none."""

    key: str
    authors: str
    year: str
    title: str
    journal: str
    volume: str
    pages: str
    doi: str = ""

    @property
    def label(self) -> str:
        """``Kruskal and Wallis, 1952``; from the third author on ``et al.``."""
        families = [author.partition(",")[0] for author in self.authors.split(" and ")]
        who = " and ".join(families) if len(families) < 3 else f"{families[0]} et al."
        return f"{who}, {self.year}"

    @property
    def text(self) -> str:
        """The reference as a list of references prints it, without the DOI."""
        authors = self.authors.replace(" and ", "; ")
        return f"{authors} ({self.year}). {self.title}. {self.journal} {self.volume}, {self.pages}."


_WORKS = [
    Work(*line.split(" | "))
    for line in unwrapped("""
benjamini | Benjamini, Y. and Hochberg, Y. | 1995 | Controlling the false discovery rate: a practical and powerful
  approach to multiple testing | Journal of the Royal Statistical Society B | 57 | 289–300 |
  10.1111/j.2517-6161.1995.tb02031.x
brown | Brown, M. B. and Forsythe, A. B. | 1974 | Robust tests for the equality of variances | Journal of the American
  Statistical Association | 69 | 364–367 | 10.1080/01621459.1974.10482955
dunn | Dunn, O. J. | 1964 | Multiple comparisons using rank sums | Technometrics | 6 | 241–252 |
  10.1080/00401706.1964.10490181
falconer | Falconer, K. and Winter, D. A. | 1985 | Quantitative assessment of co-contraction at the ankle joint in
  walking | Electromyography and Clinical Neurophysiology | 25 | 135–149
friedman | Friedman, M. | 1937 | The use of ranks to avoid the assumption of normality implicit in the analysis of
  variance | Journal of the American Statistical Association | 32 | 675–701 | 10.1080/01621459.1937.10503522
fritsch | Fritsch, F. N. and Carlson, R. E. | 1980 | Monotone piecewise cubic interpolation | SIAM Journal on
  Numerical Analysis | 17 | 238–246 | 10.1137/0717021
games | Games, P. A. and Howell, J. F. | 1976 | Pairwise multiple comparison procedures with unequal n's and/or
  variances | Journal of Educational Statistics | 1 | 113–125 | 10.3102/10769986001002113
greenhouse | Greenhouse, S. W. and Geisser, S. | 1959 | On methods in the analysis of profile data | Psychometrika |
  24 | 95–112 | 10.1007/BF02289823
hertz | Hertz, H. | 1882 | Ueber die Berührung fester elastischer Körper | Journal für die reine und angewandte
  Mathematik | 92 | 156–171 | 10.1515/crll.1882.92.156
holm | Holm, S. | 1979 | A simple sequentially rejective multiple test procedure | Scandinavian Journal of Statistics
  | 6 | 65–70
horn | Horn, B. K. P. and Schunck, B. G. | 1981 | Determining optical flow | Artificial Intelligence | 17 | 185–203 |
  10.1016/0004-3702(81)90024-2
hotelling | Hotelling, H. | 1931 | The generalization of Student's ratio | The Annals of Mathematical Statistics | 2 |
  360–378 | 10.1214/aoms/1177732979
huber | Huber, P. J. | 1964 | Robust estimation of a location parameter | The Annals of Mathematical Statistics | 35 |
  73–101 | 10.1214/aoms/1177703732
kennedy | Kennedy, M. C. and O'Hagan, A. | 2001 | Bayesian calibration of computer models | Journal of the Royal
  Statistical Society B | 63 | 425–464 | 10.1111/1467-9868.00294
kroeger | Kroeger, T. and Timofte, R. and Dai, D. and Van Gool, L. | 2016 | Fast optical flow using dense inverse
  search | Computer Vision – ECCV 2016, LNCS | 9908 | 471–488 | 10.1007/978-3-319-46493-0_29
kruskal | Kruskal, W. H. and Wallis, W. A. | 1952 | Use of ranks in one-criterion variance analysis | Journal of the
  American Statistical Association | 47 | 583–621 | 10.1080/01621459.1952.10483441
langsrud | Langsrud, Ø. | 2005 | Rotation tests | Statistics and Computing | 15 | 53–60 | 10.1007/s11222-005-4789-5
lilliefors | Lilliefors, H. W. | 1967 | On the Kolmogorov-Smirnov test for normality with mean and variance unknown |
  Journal of the American Statistical Association | 62 | 399–402 | 10.1080/01621459.1967.10482916
mann | Mann, H. B. and Whitney, D. R. | 1947 | On a test of whether one of two random variables is stochastically
  larger than the other | The Annals of Mathematical Statistics | 18 | 50–60 | 10.1214/aoms/1177730491
pataky | Pataky, T. C. | 2010 | Generalized n-dimensional biomechanical field analysis using statistical parametric
  mapping | Journal of Biomechanics | 43 | 1976–1982 | 10.1016/j.jbiomech.2010.03.008
patterson | Patterson, H. D. and Thompson, R. | 1971 | Recovery of inter-block information when block sizes are
  unequal | Biometrika | 58 | 545–554 | 10.1093/biomet/58.3.545
ramsay | Ramsay, J. O. | 1988 | Monotone regression splines in action | Statistical Science | 3 | 425–441 |
  10.1214/ss/1177012761
rouder | Rouder, J. N. and Morey, R. D. and Speckman, P. L. and Province, J. M. | 2012 | Default Bayes factors for
  ANOVA designs | Journal of Mathematical Psychology | 56 | 356–374 | 10.1016/j.jmp.2012.08.001
rudolph | Rudolph, K. S. and Axe, M. J. and Snyder-Mackler, L. | 2000 | Dynamic stability after ACL injury: who can
  hop? | Knee Surgery, Sports Traumatology, Arthroscopy | 8 | 262–269 | 10.1007/s001670000130
schuirmann | Schuirmann, D. J. | 1987 | A comparison of the two one-sided tests procedure and the power approach for
  assessing the equivalence of average bioavailability | Journal of Pharmacokinetics and Biopharmaceutics | 15 |
  657–680 | 10.1007/BF01068419
shapiro | Shapiro, S. S. and Wilk, M. B. | 1965 | An analysis of variance test for normality (complete samples) |
  Biometrika | 52 | 591–611 | 10.1093/biomet/52.3-4.591
smyth | Smyth, G. K. | 2004 | Linear models and empirical Bayes methods for assessing differential expression in
  microarray experiments | Statistical Applications in Genetics and Molecular Biology | 3 | 3 | 10.2202/1544-6115.1027
steiger | Steiger, J. H. | 2004 | Beyond the F test: effect size confidence intervals and tests of close fit in the
  analysis of variance and contrast analysis | Psychological Methods | 9 | 164–182 | 10.1037/1082-989X.9.2.164
welch | Welch, B. L. | 1951 | On the comparison of several mean values: an alternative approach | Biometrika | 38 |
  330–336 | 10.1093/biomet/38.3-4.330
yates | Yates, F. | 1934 | The analysis of multiple classifications with unequal numbers in the different classes |
  Journal of the American Statistical Association | 29 | 51–66 | 10.1080/01621459.1934.10502686
zou | Zou, G. Y. and Donner, A. | 2008 | Construction of confidence limits about effect measures: a general approach |
  Statistics in Medicine | 27 | 1693–1702 | 10.1002/sim.3095
""")
]
"""Key, authors, year, title, journal, volume, pages and DOI."""
_BY_KEY = {work.key: work for work in _WORKS}


def cited(text: str) -> str:
    """``text`` with each ``[@key]`` replaced by the work's label in brackets. KeyError : a work that is not listed."""
    return _CITED.sub(lambda found: f"({_BY_KEY[found[1]].label})", text)


def works_in(texts: Iterable[str]) -> list[Work]:
    """The works that the texts cite, by author."""
    keys = {key for text in texts for key in _CITED.findall(text)}
    return [work for work in _WORKS if work.key in keys]


def bibtex(works: Iterable[Work]) -> str:
    """References as BibTeX."""
    made = []
    for work in works:
        fields = {
            "author": latex_text(work.authors), "title": f"{{{latex_text(work.title)}}}",
            "journal": latex_text(work.journal), "year": work.year, "volume": work.volume,
            "pages": latex_text(work.pages), "doi": work.doi,
        }  # fmt: skip
        lines = [f"  {name} = {{{value}}}," for name, value in fields.items() if value]
        made += [f"@article{{{work.key},", *lines, "}", ""]
    return "\n".join(made)

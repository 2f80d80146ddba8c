"""Lilliefors' test of normality: Kolmogorov-Smirnov with mean and SD estimated, and the p that belongs to that.

The quantiles of D are simulated: ``python -m benchmarks.lilliefors_table`` made the numbers and says how.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike
from scipy import special

from emg2vsa.arrays import Floats
from emg2vsa.statistics.normality import largest_gap
from emg2vsa.statistics.outcome import Outcomes

LEVELS = np.array(
    [0.9999, 0.999, 0.99, 0.97, 0.95, 0.9, 0.85, 0.8, 0.7, 0.6, 0.5, 0.4, 0.3, 0.2, 0.15, 0.1]
    + [a * 10.0**b for b in range(-2, -9, -1) for a in (5, 2, 1)]
)
"""p of the quantiles."""
SMALLEST, LARGE = 4, 12
"""Fewest values tabulated, and the n from which the polynomials hold."""


SMALL = np.array([
    [0.3713, 0.3812, 0.4542, 0.5552, 0.6317, 0.7873, 0.9200, 1.0414, 1.2648, 1.4736, 1.6749, 1.8943, 2.1636, 2.5444,
     3.0219, 3.7822, 5.1245, 6.9430, 8.3288, 9.7165, 11.5526, 12.9371, 14.3227, 16.1558, 17.5408, 18.9298, 20.7659,
     22.1516, 23.5286, 25.3548, 26.7296, 28.1198, 29.9648, 31.3490, 32.7343, 34.5765, 35.9752],
    [0.2695, 0.3144, 0.4314, 0.5421, 0.6159, 0.7490, 0.8503, 0.9360, 1.0846, 1.2320, 1.3976, 1.6055, 1.9183, 2.3502,
     2.6396, 3.0379, 3.7410, 4.9813, 6.0930, 7.2249, 8.7386, 9.8927, 11.0482, 12.5804, 13.7357, 14.8948, 16.4217,
     17.5793, 18.7460, 20.3117, 21.4013, 22.5615, 24.0919, 25.2473, 26.4074, 27.9450, 29.0817],
    [0.2433, 0.3036, 0.4291, 0.5330, 0.5972, 0.7059, 0.7856, 0.8572, 0.9956, 1.1455, 1.3218, 1.5333, 1.7873, 2.1274,
     2.3703, 2.7266, 3.3979, 4.3093, 5.0284, 5.8281, 7.0914, 8.1063, 9.1251, 10.4856, 11.5207, 12.5519, 13.9264,
     14.9614, 16.0004, 17.3760, 18.4135, 19.4549, 20.8296, 21.8762, 22.9121, 24.2887, 25.3263],
    [0.2363, 0.3035, 0.4266, 0.5198, 0.5745, 0.6697, 0.7474, 0.8195, 0.9633, 1.1149, 1.2796, 1.4652, 1.6942, 2.0149,
     2.2475, 2.5832, 3.1624, 3.9663, 4.6250, 5.3082, 6.2426, 6.9954, 7.8161, 9.0156, 9.9583, 10.9078, 12.1776,
     13.1358, 14.0976, 15.3725, 16.3442, 17.3127, 18.5932, 19.5604, 20.5333, 21.8152, 22.7877],
    [0.2373, 0.3061, 0.4221, 0.5048, 0.5557, 0.6511, 0.7309, 0.8050, 0.9477, 1.0910, 1.2440, 1.4213, 1.6432, 1.9534,
     2.1737, 2.4844, 3.0252, 3.7750, 4.3644, 4.9739, 5.8268, 6.5009, 7.1912, 8.1459, 8.9094, 9.7246, 10.8730,
     11.7719, 12.6778, 13.8769, 14.7847, 15.6995, 16.9105, 17.8251, 18.7446, 19.9586, 20.8802],
    [0.2393, 0.3068, 0.4154, 0.4944, 0.5463, 0.6444, 0.7250, 0.7982, 0.9353, 1.0727, 1.2220, 1.3952, 1.6113, 1.9111,
     2.1224, 2.4201, 2.9383, 3.6469, 4.2010, 4.7738, 5.5567, 6.1690, 6.8050, 7.6787, 8.3606, 9.0581, 10.0118,
     10.7699, 11.5656, 12.6670, 13.5308, 14.4023, 15.5587, 16.4352, 17.3142, 18.4791, 19.3619],
    [0.2410, 0.3073, 0.4084, 0.4891, 0.5423, 0.6415, 0.7212, 0.7925, 0.9260, 1.0613, 1.2084, 1.3788, 1.5908, 1.8825,
     2.0872, 2.3766, 2.8774, 3.5547, 4.0825, 4.6267, 5.3655, 5.9440, 6.5353, 7.3408, 7.9663, 8.6127, 9.4925,
     10.1774, 10.8766, 11.8272, 12.5742, 13.3492, 14.4130, 15.2435, 16.0850, 17.2067, 18.0579],
    [0.2436, 0.3062, 0.4055, 0.4879, 0.5415, 0.6398, 0.7179, 0.7879, 0.9197, 1.0534, 1.1989, 1.3671, 1.5753, 1.8613,
     2.0622, 2.3459, 2.8350, 3.4934, 4.0048, 4.5283, 5.2389, 5.7888, 6.3523, 7.1185, 7.7117, 8.3154, 9.1346, 9.7712,
     10.4225, 11.3025, 11.9808, 12.6751, 13.6155, 14.3479, 15.1006, 16.1313, 16.9284],
])  # fmt: skip
"""Reach (n = 4, 5, ..., 11; levels)."""
LARGER = np.array([
    [0.3780, -2.2310, 22.7893, -138.2863, 412.0933, -461.2535],
    [0.4256, -0.7160, -4.2916, 58.0911, -226.5803, 308.6151],
    [0.5638, -1.2678, 3.0372, -1.1808, -3.8477, 4.2646],
    [0.6705, -1.5518, 5.4799, -17.8193, 53.8793, -68.1103],
    [0.7414, -1.8004, 7.1612, -24.6138, 67.5033, -76.5875],
    [0.8637, -2.0750, 8.1131, -25.1228, 61.7754, -63.4010],
    [0.9592, -2.2674, 8.8870, -27.6229, 69.1441, -72.6849],
    [1.0405, -2.2809, 7.3995, -15.9532, 34.1739, -33.6477],
    [1.1982, -2.5685, 8.4473, -18.5801, 40.5489, -39.6062],
    [1.3544, -2.7889, 8.4851, -14.5641, 28.0940, -26.1614],
    [1.5200, -2.9600, 7.7651, -5.7944, 2.1417, 2.2634],
    [1.7136, -3.4053, 10.4391, -15.9692, 24.8840, -15.0256],
    [1.9456, -3.7394, 11.0218, -14.0618, 19.6656, -9.2664],
    [2.2782, -4.9355, 21.8783, -72.6164, 186.2362, -188.0501],
    [2.4983, -5.4393, 25.3664, -89.3637, 235.7680, -242.0628],
    [2.7956, -5.8193, 25.9249, -85.1152, 221.2990, -221.1522],
    [3.3231, -7.4076, 39.3978, -154.2741, 417.7216, -427.2878],
    [3.9803, -8.3499, 42.8080, -158.2062, 425.8959, -420.8554],
    [4.4946, -9.4175, 47.8212, -166.8692, 434.4600, -409.6424],
    [5.0165, -10.9423, 61.2666, -237.6078, 643.3738, -630.5279],
    [5.6992, -13.0463, 83.2416, -369.0337, 1060.2239, -1105.6831],
    [6.1651, -12.5812, 70.0488, -268.0060, 749.9547, -729.5731],
    [6.6739, -13.8517, 80.7686, -314.4569, 859.5289, -796.6158],
    [7.3221, -14.0718, 72.2281, -226.8250, 571.0324, -420.6505],
    [7.7812, -13.5075, 59.4853, -134.0496, 299.9518, -93.6224],
    [8.3526, -16.9813, 98.5070, -344.7122, 861.0269, -627.9555],
    [9.0196, -18.2401, 106.6080, -357.3582, 826.0603, -452.5817],
    [9.5165, -19.4860, 123.9736, -473.9279, 1205.4175, -856.6525],
    [10.0632, -21.8846, 147.0829, -569.9859, 1381.8655, -895.4178],
    [10.8015, -25.4575, 185.9644, -776.7713, 1938.8191, -1398.7266],
    [11.3050, -26.0444, 183.8994, -711.2903, 1628.4421, -867.6832],
    [11.7690, -25.2435, 164.9850, -551.8373, 1076.7965, -104.3744],
    [12.4109, -25.1718, 151.6465, -401.2415, 490.8691, 781.9733],
    [12.8607, -23.8876, 128.0758, -224.7025, -71.4323, 1521.0601],
    [13.3688, -24.2607, 119.9337, -102.9297, -581.5162, 2309.6232],
    [14.0136, -23.6217, 91.8996, 184.7098, -1690.4977, 3916.7427],
    [14.4837, -22.4507, 61.4246, 459.5490, -2695.5335, 5324.4008],
])  # fmt: skip
"""Reach as a polynomial in 1 / sqrt(n), lowest power first (levels, 6)."""
_LOG_LEVELS = np.log(LEVELS)


def lilliefors(values: ArrayLike) -> Outcomes:
    """Test each row of ``values`` (k, n), or one row (n,); NaN marks a value that is not there.

    D is that of the standardised Kolmogorov-Smirnov test, p comes from ``lilliefors_survival``. A row of fewer than
    four values, or without spread, has no test (NaN).
    """
    d, n = largest_gap(values, standardise=True)
    p, few = lilliefors_survival(d, n), n < SMALLEST
    return Outcomes(
        method="Lilliefors",
        statistic_name="D",
        statistic=d,
        p=p,
        n=n,
        notes=(
            (f"undefined: {{n}} values, needs {SMALLEST}", few),
            ("undefined: all values are equal", ~few & np.isnan(d)),
            ("p below the simulated range, extrapolated", ~few & (p < LEVELS[-1])),
        ),
    )


def lilliefors_survival(d: ArrayLike, n: ArrayLike) -> Floats:
    """P(D >= d) for normal samples of n, mean and SD estimated (Lilliefors 1967); d, n : (k,). NaN for d NaN or n < 4.

    From tables of up to 1e7 simulated samples a size: p within 1.5 % down to .001, about 3 % down to 1e-6, 5 % to 1e-8;
    1 where it is above .9999. Beyond the tables log p goes on straight, beyond n = 1000 in 1 / sqrt(n).
    """
    d, n = np.broadcast_arrays(np.asarray(d, dtype=np.float64), np.asarray(n, dtype=np.int64))
    p = np.full(d.shape, np.nan)
    for size in np.unique(n[n >= SMALLEST]):
        same = (n == size) & ~np.isnan(d)
        at, most = np.clip(d[same], 0.0, 1.0), largest_d(size)
        inside = at < most
        p[same] = np.where(inside, _survival(reach(np.where(inside, at, 0.0), size), _row(int(size))), 0.0)
    return p


def _row(n: int) -> Floats:
    """Reach of D (levels,) for samples of n."""
    return SMALL[n - SMALLEST] if n < LARGE else np.asarray(np.polynomial.polynomial.polyval(n**-0.5, LARGER.T))


def _survival(at: Floats, row: Floats) -> Floats:
    """p at reach ``at`` (j,): log p by monotone cubics (Hyman 1983) through the row, straight beyond it."""
    step, rise = np.diff(row), np.diff(_LOG_LEVELS)
    slope = rise / step
    # that of the parabola through three levels, kept small enough for p to fall everywhere
    parabola = (step[:-1] * slope[1:] + step[1:] * slope[:-1]) / (step[:-1] + step[1:])
    inner = np.maximum(parabola, 3 * np.maximum(slope[:-1], slope[1:]))
    ends = np.concatenate([slope[:1], inner, slope[-1:]])
    i = np.clip(np.searchsorted(row, at, side="right") - 1, 0, step.size - 1)
    t = np.maximum((at - row[i]) / step[i], 0.0)
    cubic = _LOG_LEVELS[i] + step[i] * t * (
        ends[i] + t * (3 * slope[i] - 2 * ends[i] - ends[i + 1] + t * (ends[i] + ends[i + 1] - 2 * slope[i]))
    )
    beyond = _LOG_LEVELS[-1] + ends[-1] * (at - row[-1])
    log_p = np.where(at > row[-1], beyond, cubic)
    return np.asarray(np.exp(np.where(at < row[0], 0.0, log_p)))


def largest_d(n: int) -> float:
    """D of a sample with all values equal but one: no standardised sample of n has a larger one."""
    return float(1 - 1 / n - special.ndtr(-(n**-0.5)))


def reach(d: Floats, n: int) -> Floats:
    """-n log(1 - (D / largest D)^2) for D (d,) below the largest: about proportional to -log p in the tail,
    whatever n."""
    return np.asarray(-n * np.log1p(-((d / largest_d(n)) ** 2)))

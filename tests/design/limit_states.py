"""Ten limit states, and what OpenTURNS 1.27.post1 and Pystra 1.6.0 say of them.

`BETAS` are those of OpenTURNS' FORM by SQP and of Pystra's by HL-RF, where both are asked for
residuals of 1e-6; they agree within 2e-6 of beta. `benchmarks/reliability.py` prints them anew.

Sources: the cantilever and the bar of OpenTURNS' examples; cubic and exponential surfaces of
S. K. Choi, R. V. Grandhi and R. A. Canfield, *Reliability-based structural design*, Springer
(2007); roof truss and oscillator of the usual collections (C. Bucher and U. Bourgund,
*Struct. Saf.* 7 (1990) 57-66); frame of Pystra's documentation (A. Der Kiureghian, H.-Z. Lin and
S.-J. Hwang, *J. Eng. Mech.* 113 (1987) 1208-1225); convex and concave functions of B. D. Youn,
K. K. Choi and Y. H. Park, *J. Mech. Des.* 125 (2003) 221-232.
"""

from __future__ import annotations

import numpy as np
from scipy.stats import norm

from jousto.design.reliability.inputs.random import Random
from jousto.design.studies.parameters.distributions import distribution_from_moments


def normal(name, mean, deviation):
    return Random(name, norm(mean, deviation))


def lognormal(name, mean, deviation):
    return Random(name, distribution_from_moments("lognormal", mean, deviation))


def cantilever(x):
    return 3.0 - x["F"] * x["L"] ** 3 / (3.0 * x["E"] * x["I"])


def bar(x):
    return x["R"] - x["F"] / (100.0 * np.pi)


def cubic(x):
    return x["a"] ** 3 + x["b"] ** 3 - 18.0


def skew_cubic(x):
    return x["a"] ** 3 + x["a"] ** 2 * x["b"] + x["b"] ** 3 - 18.0


def exponential(x):
    return np.exp(0.2 * x["a"] + 1.4) - x["b"]


def roof(x):
    concrete, steel = 3.81 / (x["Ac"] * x["Ec"]), 1.13 / (x["As"] * x["Es"])
    return 0.03 - x["q"] * x["l"] ** 2 / 2.0 * (concrete + steel)


def oscillator(x):
    k = x["c1"] + x["c2"]
    swing = np.sin(np.sqrt(k / x["m"]) * x["t1"] / 2.0)
    return 3.0 * x["r"] - np.sqrt((2.0 * x["F1"] / k * swing) ** 2)  # the magnitude, analytic


def frame(x):
    moments = x["m1"] + 2.0 * x["m2"] + 2.0 * x["m3"] + x["m4"]
    return moments - 5.0 * x["h"] - 5.0 * x["v"]


def convex(x):
    return 10.0 - np.exp(x["a"] - 7.0) - x["b"]


def concave(x):
    return (np.exp(0.8 * x["a"] - 1.2) + np.exp(0.7 * x["b"] - 0.6) - 5.0) / 10.0


def slopes(function, variables):
    """Return the gradient of a limit state by complex steps, exact to round-off."""
    names = [one.name for one in variables]

    def gradient(x):
        point = {name: x[name] for name in names}
        moved = ({**point, name: complex(point[name], 1e-30)} for name in names)
        return [function(place).imag / 1e-30 for place in moved]

    return gradient


TEN = {
    "cantilever": (
        cantilever,
        [normal("E", 50, 1), normal("F", 1, 1), normal("L", 10, 1), normal("I", 5, 1)],
    ),
    "bar": (bar, [lognormal("R", 300, 30), normal("F", 75e3, 5e3)]),
    "cubic": (cubic, [normal("a", 10, 5), normal("b", 9.9, 5)]),
    "skew cubic": (skew_cubic, [normal("a", 10, 5), normal("b", 9.9, 5)]),
    "exponential": (exponential, [normal("a", 0, 1), normal("b", 0, 1)]),
    "roof": (
        roof,
        [
            normal("q", 20e3, 1400),
            normal("l", 12, 0.12),
            normal("As", 9.82e-4, 5.892e-5),
            normal("Ac", 0.04, 0.0048),
            normal("Es", 1e11, 6e9),
            normal("Ec", 2e10, 1.2e9),
        ],
    ),
    "oscillator": (
        oscillator,
        [
            normal("m", 1, 0.05),
            normal("c1", 1, 0.1),
            normal("c2", 0.1, 0.01),
            normal("r", 0.5, 0.05),
            normal("F1", 1, 0.2),
            normal("t1", 1, 0.2),
        ],
    ),
    "frame": (
        frame,
        [
            *(lognormal(name, 120, 12) for name in ("m1", "m2", "m3", "m4")),
            lognormal("h", 50, 15),
            lognormal("v", 40, 12),
        ],
    ),
    "convex": (convex, [normal("a", 6, 0.8), normal("b", 6, 0.8)]),
    "concave": (concave, [normal("a", 4, 0.8), normal("b", 5, 0.8)]),
}
BETAS = {
    "cantilever": 1.00925494,
    "bar": 1.88104652,
    "cubic": 2.22598812,
    "skew cubic": 2.29825190,
    "exponential": 3.34969458,
    "roof": 2.42872898,
    "oscillator": 1.86510843,
    "frame": 2.34816574,
    "convex": 2.87823378,
    "concave": 3.80466074,
}
CALLS = {
    "cantilever": (48, 60),
    "bar": (18, 30),
    "cubic": (96, 300),
    "skew cubic": (140, 399),
    "exponential": (35, 57),
    "roof": (594, 111),
    "oscillator": (89, 59),
    "frame": (107, 98),
    "convex": (48, 66),
    "concave": (71, 138),
}
"""Calls of OpenTURNS and Pystra with their own tolerances, which are looser than 1e-6.

Of OpenTURNS' algorithms that one counts which takes the fewest and is right within 1e-4 of beta.
"""

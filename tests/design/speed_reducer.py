"""The speed reducer of J. Golinski (*J. Mechanisms* 5 (1970) 287-309) with eleven constraints.

Statement with the multipliers of later authors (S. Azarm and W.-C. Li, *Struct. Optim.* 1 (1989)
1-9). Lengths are in cm, forces and stresses in the units of that time. G is positive where all is
well. With scattered dimensions (deviation 0.005, beta 3) it is a usual case of RBDO.
"""

from __future__ import annotations

import numpy as np

BOUNDS = {
    "x1": (2.6, 3.6),  # width of the face
    "x2": (0.7, 0.8),  # module
    "x3": (17.0, 28.0),  # teeth of the pinion
    "x4": (7.3, 8.3),  # shaft 1 between bearings
    "x5": (7.3, 8.3),  # shaft 2 between bearings
    "x6": (2.9, 3.9),  # diameter of shaft 1
    "x7": (5.0, 5.5),  # diameter of shaft 2
}


def weight(x):
    x1, x2, x3, x4, x5, x6, x7 = x
    gears = 0.7854 * x1 * x2**2 * (3.3333 * x3**2 + 14.9334 * x3 - 43.0934)
    holes = 1.508 * x1 * (x6**2 + x7**2)
    return gears - holes + 7.477 * (x6**3 + x7**3) + 0.7854 * (x4 * x6**2 + x5 * x7**2)


def bending(x):
    return 1.0 - 27.0 / (x["x1"] * x["x2"] ** 2 * x["x3"])


def contact(x):
    return 1.0 - 397.5 / (x["x1"] * x["x2"] ** 2 * x["x3"] ** 2)


def deflection_1(x):
    return 1.0 - 1.93 * x["x4"] ** 3 / (x["x2"] * x["x3"] * x["x6"] ** 4)


def deflection_2(x):
    return 1.0 - 1.93 * x["x5"] ** 3 / (x["x2"] * x["x3"] * x["x7"] ** 4)


def stress_1(x):
    moment = np.sqrt((745.0 * x["x4"] / (x["x2"] * x["x3"])) ** 2 + 16.9e6)
    return 1.0 - moment / (0.1 * x["x6"] ** 3) / 1100.0


def stress_2(x):
    moment = np.sqrt((745.0 * x["x5"] / (x["x2"] * x["x3"])) ** 2 + 157.5e6)
    return 1.0 - moment / (0.1 * x["x7"] ** 3) / 850.0


LIMITS = {
    "bending": bending,
    "contact": contact,
    "deflection 1": deflection_1,
    "deflection 2": deflection_2,
    "stress 1": stress_1,
    "stress 2": stress_2,
    "size": lambda x: 1.0 - x["x2"] * x["x3"] / 40.0,
    "width": lambda x: x["x1"] / x["x2"] - 5.0,
    "narrow": lambda x: 12.0 - x["x1"] / x["x2"],
    "shaft 1": lambda x: 1.0 - (1.5 * x["x6"] + 1.9) / x["x4"],
    "shaft 2": lambda x: 1.0 - (1.1 * x["x7"] + 1.9) / x["x5"],
}

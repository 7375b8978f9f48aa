"""Rainflow counting straight from the text of ASTM E1049-85, 5.4.4, in plain Python."""

import numpy as np


def reversals(series):
    """Return peaks and valleys, the first and the last point among them."""
    points = []
    for x in series:
        if points and x == points[-1]:
            continue
        if len(points) > 1 and (points[-1] - points[-2]) * (x - points[-1]) > 0:
            points[-1] = x
        else:
            points.append(x)
    return points


def astm(series):
    """Return (range, mean, count) of cycles: rules (1) to (6) of 5.4.4."""
    counted, points = [], []
    for x in reversals(series):
        points.append(x)  # (1) read next peak or valley
        while len(points) >= 3:  # (2) X, Y from the three most recent ones not yet discarded
            X, Y = abs(points[-1] - points[-2]), abs(points[-2] - points[-3])
            if X < Y:  # (3a)
                break
            if len(points) == 3:  # (5) Y contains the starting point S: half a cycle
                counted.append((Y, 0.5 * (points[0] + points[1]), 0.5))
                del points[0]
            else:  # (4) one cycle; discard the peak and valley of Y
                counted.append((Y, 0.5 * (points[-2] + points[-3]), 1.0))
                del points[-3:-1]
    for a, b in zip(points, points[1:], strict=False):  # (6)
        counted.append((abs(b - a), 0.5 * (a + b), 0.5))
    return counted


def simplified(series):
    """Return (range, mean, count) of a repeating history, 5.4.5: from the largest peak, all whole.

    The history that begins and ends with its largest magnitude leaves its half cycles in pairs.
    """
    points = reversals(series)
    top = max(range(len(points)), key=lambda i: abs(points[i]))
    counted = astm(reversals(points[top:] + points[: top + 1]))
    halves = sorted((r, m) for r, m, c in counted if c == 0.5)
    return [x for x in counted if x[2] == 1.0] + [(r, m, 1.0) for r, m in halves[::2]]


def pairs(S, residue):
    """Return first and last turning point of every cycle, and how often it counts (four points)."""
    stack: list[int] = []
    found: list[tuple[int, int, float]] = []
    for k in range(len(S)):
        stack.append(k)
        while len(stack) >= 4:
            a, b, c, d = S[stack[-4:]]
            if min(a, d) <= min(b, c) and max(b, c) <= max(a, d):
                found.append((stack[-3], stack[-2], 1.0))
                del stack[-3:-1]
            else:
                break
    ends = [(a, b) for a, b in zip(stack, stack[1:], strict=False) if S[a] != S[b]]
    if residue == "half":
        found += [(a, b, 0.5) for a, b in ends]
    elif residue == "repeat" and len(ends) >= 2:
        # between the two equal ends only the largest loop is left
        found.append((stack[0], stack[1], 1.0))
    if not found:
        none = np.zeros(0, dtype=np.intp)
        return none, none, np.zeros(0)
    i, j, count = zip(*found, strict=True)
    return np.array(i, dtype=np.intp), np.array(j, dtype=np.intp), np.array(count)

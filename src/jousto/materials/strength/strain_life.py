"""Strain-life curves and cyclic stress-strain curves of materials."""

from __future__ import annotations

from typing import Literal

import numpy as np
from numpy.typing import ArrayLike

from jousto.base.arrays import Array
from jousto.base.declare import Declared
from jousto.base.errors import InputError, Problem, Problems, suggest, warn
from jousto.base.fields import Label, field
from jousto.base.numbers import Number, OptionalNumber, OptionalPositive, Positive

Form = Literal["coffin-manson", "morrow", "swt"]
NEGATIVE = "a negative number above -2"
FORMS = ("coffin-manson", "morrow", "swt")


class StrainLife(Declared, section="curves", tag="strain-life", by_value=True):
    """Coffin-Manson-Basquin curve with the Ramberg-Osgood curve of stabilised cycles.

    ``e_a = sf/E (2N)^b + ef (2N)^c`` and ``e_a = s_a/E + (s_a/K_)^(1/n_)`` with strain and stress
    amplitudes and N cycles to a crack of about 1 mm.

    Raises
    ------
    InputError
        With all constants that are not finite or outside of their physical range.

    Warns
    -----
    JoustoWarning
        If E, sf or ``K_`` is probably in MPa instead of Pa.

    Examples
    --------
    >>> steel = strain_life("sae-1045")
    >>> round(float(steel.cycles(0.005)))
    10367
    >>> round(float(steel.stress(0.005)) / 1e6, 1)
    378.9
    """

    kind = "strain life"
    E: Positive = field("Young's modulus", unit="Pa", label="Young's modulus E")
    sf: Positive = field(
        "Fatigue strength coefficient", unit="Pa", label="fatigue strength coefficient sf"
    )
    b: Number = field(
        "Fatigue strength exponent, negative",
        above=-2,
        below=0,
        label="fatigue strength exponent b",
        wanted=NEGATIVE,
    )
    ef: Positive = field(
        "Fatigue ductility coefficient", unit="m/m", label="fatigue ductility coefficient ef"
    )
    c: Number = field(
        "Fatigue ductility exponent, negative, steeper than b",
        above=-2,
        below=0,
        label="fatigue ductility exponent c",
        wanted=NEGATIVE,
    )
    K_: OptionalPositive = field(
        "Cyclic strength coefficient K'; None for ``sf / ef^(b/c)``, with which both curves are"
        " consistent",
        unit="Pa",
        label="cyclic strength coefficient K_",
        default=None,
    )
    n_: OptionalNumber = field(
        "Cyclic hardening exponent n'; None for ``b / c``",
        above=0,
        below=1,
        label="hardening exponent n_",
        wanted="in (0, 1)",
        default=None,
    )
    name: Label = field("Name, for messages", default="")
    source: Label = field("Source of the constants", default="", compare=False)

    def consistent(self, problems: Problems, where: str) -> None:
        """Store K' and n'; report swapped exponents, warn about units."""
        if self.c >= self.b:
            problems.add(
                where, f"c = {self.c:g} must be below b = {self.b:g}; are they swapped?", "c"
            )
            return
        if self.n_ is None:
            object.__setattr__(self, "n_", self.b / self.c)
        if self.K_ is None:
            object.__setattr__(self, "K_", self.sf / self.ef ** (self.b / self.c))
        for name, value in (("E", self.E), ("sf", self.sf), ("K_", self.K_)):
            limit = 1e9 if name == "E" else 1e6
            if value is not None and value < limit:
                warn(where, f"{name} = {value:g} Pa is tiny; was it given in MPa?", name)
        if self.ef > 10.0:
            warn(where, f"ef = {self.ef:g}; was it given in percent?", "ef")

    @property
    def hardening(self) -> tuple[float, float]:
        """K' (Pa) and n'."""
        assert self.K_ is not None and self.n_ is not None
        return self.K_, self.n_

    @property
    def transition(self) -> float:
        """Number of cycles at which elastic and plastic strain amplitude are equal."""
        return float(0.5 * (self.ef * self.E / self.sf) ** (1.0 / (self.b - self.c)))

    def strain(self, stress: ArrayLike) -> Array:
        """Return the strain amplitude (m/m) for a stress amplitude (Pa); an odd function."""
        s = np.asarray(stress, dtype=np.float64)
        K, n = self.hardening
        return np.asarray(s / self.E + np.sign(s) * (np.abs(s) / K) ** (1.0 / n))

    def stress(self, strain: ArrayLike) -> Array:
        """Return the stress amplitude (Pa) for a strain amplitude (m/m), inverse of `strain`."""
        e = np.asarray(strain, dtype=np.float64)
        K, n = self.hardening
        # starting above the root: the curve is convex in s, so Newton's method cannot overshoot
        size = np.abs(e)
        s = np.minimum(self.E * size, K * size**n)
        for _ in range(60):
            plastic = (s / K) ** (1.0 / n)
            slope = 1.0 / self.E + plastic / (n * np.where(s > 0.0, s, 1.0))
            step = (s / self.E + plastic - size) / slope
            s = np.maximum(s - step, 0.0)
            if np.all(np.abs(step) <= 1e-14 * np.maximum(s, 1e-300)):
                break
        return np.asarray(np.sign(e) * s)

    def amplitude(self, cycles: ArrayLike, mean: ArrayLike = 0.0) -> Array:
        """Return the strain amplitude (m/m) for N cycles at a mean stress (Pa), after Morrow."""
        x = 2.0 * np.asarray(cycles, dtype=np.float64)
        sm = np.asarray(mean, dtype=np.float64)
        return np.asarray((self.sf - sm) / self.E * x**self.b + self.ef * x**self.c)

    def cycles(
        self, strain: ArrayLike, *, mean: ArrayLike = 0.0, form: Form = "coffin-manson"
    ) -> Array:
        """Return the number of cycles to failure for a strain amplitude.

        * ``coffin-manson``: no effect of the mean stress;
        * ``morrow``: ``e_a = (sf - s_m)/E (2N)^b + ef (2N)^c``;
        * ``swt``: ``s_max e_a = sf^2/E (2N)^2b + sf ef (2N)^(b+c)``, s_max from the mean and the
          cyclic curve (Smith, Watson, Topper 1970).

        Parameters
        ----------
        strain : array_like
            Strain amplitude, m/m.
        mean : array_like
            Mean stress of the cycle, Pa.
        form : {"coffin-manson", "morrow", "swt"}
            Mean stress correction.

        Returns
        -------
        array
            Cycles; inf for zero strain or, with ``swt``, for cycles fully in compression.

        Raises
        ------
        InputError
            If the form is unknown, or a strain is negative or not finite.
        """
        e, sm = np.broadcast_arrays(
            np.asarray(strain, dtype=np.float64), np.asarray(mean, dtype=np.float64)
        )
        problems = Problems()
        where = f"strain life '{self.name}'" if self.name else "strain life"
        if form not in FORMS:
            problems.add(where, f"form is {form!r}{suggest(form, FORMS)}")
        if e.size and not (np.all(np.isfinite(e)) and e.min() >= 0.0):
            problems.add(where, "strain amplitudes must be finite and not negative")
        if not np.all(np.isfinite(sm)):
            problems.add(where, "mean stresses must be finite", "mean")
        problems.raise_if_any()
        if e.size and e.max() > 1.0:
            warn(
                where,
                f"a strain amplitude is {e.max():g}; were strains given in percent or um/m?",
            )
        if form == "swt":
            top = np.maximum(sm + self.stress(e), 0.0)
            return self._life(top * e, self.sf**2 / self.E, 2 * self.b, self.sf * self.ef)
        strength = self.sf - (sm if form == "morrow" else 0.0 * sm)
        return self._life(e, strength / self.E, self.b, np.asarray(self.ef))

    def _life(self, y: Array, A: ArrayLike, p: float, B: ArrayLike) -> Array:
        """Solve ``A x^p + B x^q = y`` for x = 2N, with q = p - b + c, by Newton steps in log x."""
        q = p - self.b + self.c
        y, A, B = np.broadcast_arrays(y, np.asarray(A, dtype=float), np.asarray(B, dtype=float))
        out = np.full(y.shape, np.inf)
        # a mean stress above sf causes failure at once
        out[(A <= 0.0) & (y > 0.0)] = 0.0
        live = (y > 0.0) & (A > 0.0)
        if not live.any():
            return out
        y, A, B = y[live], A[live], B[live]
        # start left of the root, where the convex log-log curve lies above y
        z = np.maximum(np.log(A / y) / -p, np.log(B / y) / -q)
        for _ in range(100):
            elastic, plastic = A * np.exp(p * z), B * np.exp(q * z)
            total = elastic + plastic
            step = np.log(total / y) * total / (p * elastic + q * plastic)
            z = z - step
            if np.all(np.abs(step) <= 1e-14 * np.maximum(np.abs(z), 1.0)):
                break
        with np.errstate(over="ignore"):
            out[live] = 0.5 * np.exp(z)
        return out

    @classmethod
    def uniform(
        cls, S_u: float, E: float, *, metal: Literal["steel", "light"] = "steel"
    ) -> StrainLife:
        """Return constants estimated from the tensile strength (uniform material law).

        Parameters
        ----------
        S_u : float
            Tensile strength, Pa.
        E : float
            Young's modulus, Pa.
        metal : {"steel", "light"}
            Steel without or with little alloying, or aluminium and titanium alloys.

        Notes
        -----
        Baeumel and Seeger, *Materials Data for Cyclic Loading*, Supplement 1, Elsevier 1990.
        """
        problems = Problems()
        problems.positive("uniform material law", "tensile strength S_u", S_u, "Pa")
        problems.positive("uniform material law", "Young's modulus E", E, "Pa")
        if metal not in ("steel", "light"):
            problems.add("uniform material law", f"metal is {metal!r}, must be 'steel' or 'light'")
        problems.raise_if_any()
        source = "estimated by the uniform material law (Baeumel, Seeger 1990)"
        if metal == "light":
            return cls(
                E, 1.67 * S_u, -0.095, 0.35, -0.69, 1.61 * S_u, 0.11, "uniform light metal", source
            )
        ratio = S_u / E
        psi = 1.0 if ratio <= 3e-3 else 1.375 - 125.0 * ratio
        if psi <= 0.0:
            raise InputError(
                Problem(
                    "uniform material law",
                    f"S_u / E is {ratio:g}; the law applies up to 0.011; check the units of S_u",
                    path=("S_u",),
                )
            )
        return cls(
            E, 1.5 * S_u, -0.087, 0.59 * psi, -0.58, 1.65 * S_u, 0.15, "uniform steel", source
        )


_DOWLING = "N. E. Dowling, Mechanical Behavior of Materials, 4th ed., table 14.1"
# MPa: E, sf', b, ef', c, K', n'
_TABLE: dict[str, tuple[float, float, float, float, float, float, float]] = {
    "sae-1015": (207e3, 1020.0, -0.138, 0.439, -0.513, 1349.0, 0.282),
    "man-ten": (203e3, 1089.0, -0.115, 0.912, -0.606, 1096.0, 0.187),
    "rqc-100": (200e3, 938.0, -0.0648, 1.38, -0.704, 903.0, 0.0905),
    "sae-1045": (202e3, 948.0, -0.092, 0.260, -0.445, 1258.0, 0.208),
    "sae-4142-670hb": (200e3, 2550.0, -0.0778, 0.0032, -0.436, 2810.0, 0.040),
    "sae-4142-560hb": (207e3, 3410.0, -0.121, 0.0732, -0.805, 4140.0, 0.126),
    "sae-4142-450hb": (207e3, 1937.0, -0.0762, 0.706, -0.869, 2080.0, 0.093),
    "sae-4142-380hb": (207e3, 2140.0, -0.0944, 0.637, -0.761, 2210.0, 0.133),
    "aisi-4340": (207e3, 1758.0, -0.0977, 2.12, -0.774, 1655.0, 0.131),
}
_KEYHOLE = "SAE Fatigue Design and Evaluation Committee, keyhole programme, SAE AE-6 (1977)"
_COMMITTEE: dict[str, tuple[float, float, float, float, float]] = {
    "man-ten-sae": (203e3, 915.0, -0.095, 0.26, -0.47),
    "rqc-100-sae": (203e3, 1160.0, -0.075, 1.06, -0.75),
}


def strain_lives() -> tuple[str, ...]:
    """Return the names of the materials of `strain_life`."""
    return (*_TABLE, *_COMMITTEE)


def strain_life(name: str) -> StrainLife:
    """Return the strain-life curve of a published material.

    Parameters
    ----------
    name : str
        One of `strain_lives`: steels of N. E. Dowling, *Mechanical Behavior of Materials*, table
        14.1, and the two steels of the SAE keyhole programme. Mean curves of polished specimens.

    Raises
    ------
    InputError
        If there is no material of that name; the message suggests the most similar one.
    """
    key = str(name).strip().lower().replace(" ", "-")
    if key in _TABLE:
        E, sf, b, ef, c, K, n = _TABLE[key]
        return StrainLife(E * 1e6, sf * 1e6, b, ef, c, K * 1e6, n, key, _DOWLING)
    if key in _COMMITTEE:
        E, sf, b, ef, c = _COMMITTEE[key]
        return StrainLife(E * 1e6, sf * 1e6, b, ef, c, name=key, source=_KEYHOLE)
    raise InputError(Problem("strain life", f"no material '{name}'{suggest(name, strain_lives())}"))

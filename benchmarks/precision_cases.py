"""Eight machines and the programs, methods and settings that move them, for precision.py."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

import jousto as jo
import machines
import strips
import trees
from cases import Case, beam, mechanism
from machines import RigidChain
from precision_ours import INSTANTS, Run, stepper

Settings = list[dict[str, Any]]
MS = 1e-3  # s
STEPS = (4, 2, 1, 0.5, 0.25, 0.125)  # ms, of methods of fixed steps
TOLERANCES = (1e-3, 1e-5, 1e-7, 1e-9)  # of DormandPrince
NEWTON = (1e-4, 1e-5, 1e-6)  # EXUDYN's relative tolerance
DEFAULT, DEFAULT_STEP = 1e-8, 1.0  # its own choice, measured at this step, ms, and its reference


@dataclass
class Curve:
    """A method of a program: what makes a run of a setting, and the settings."""

    program: str
    method: str
    make: Callable[[], Callable[[dict[str, Any]], Run]]
    settings: Settings
    fine: Settings  # of the reference: the first two that run are extrapolated


@dataclass
class Contest:
    """A machine that moves for `end` seconds from rest."""

    end: float
    model: Callable[[], jo.Model]
    curves: list[Curve] = field(default_factory=list)


def steps(*ms: float) -> Settings:
    return [{"step": h * MS} for h in ms]


def ours(contest: Contest, methods: dict[str, Settings], fine: tuple[str, Settings]) -> None:
    """Add jousto's methods; `fine`: the method and settings of the reference."""
    compiled: list[jo.Model] = []

    def make(method: str) -> Callable[[dict[str, Any]], Run]:
        if not compiled:
            compiled.append(contest.model())
        return stepper(compiled[0], contest.end, method)

    for method, settings in methods.items():
        reference = fine[1] if method == fine[0] else []
        contest.curves.append(
            Curve("jousto", method, lambda m=method: make(m), settings, reference)
        )


def explicit(*ms: float) -> dict[str, Settings]:
    """RK4, ROS2, ROS3A, generalised alpha with steps, DormandPrince with tolerances."""
    made = {name: steps(*ms) for name in ("RK4", "ROS2", "ROS3A", "GeneralizedAlpha")}
    return made | {"DormandPrince": [{"tolerance": x} for x in TOLERANCES]}


def exudyn(
    contest: Contest,
    build: Callable[[], Any],
    ms: tuple[float, ...],
    fine: tuple[float, ...],
    *,
    dense: bool = False,
    tight: float = DEFAULT,
    fine_tolerance: float | None = None,
) -> None:
    """Add EXUDYN's generalised alpha; modified Newton was faster than full Newton everywhere."""
    from precision_peers import exudyn as make

    wanted = [(h, x) for h in ms for x in NEWTON] + [(DEFAULT_STEP, tight)] * (tight not in NEWTON)
    settings, reference = (
        [{"step": h * MS, "tolerance": x, "modified": True} for h, x in pairs]
        for pairs in (wanted, [(h, fine_tolerance or tight) for h in fine])
    )
    contest.curves.append(
        Curve(
            "EXUDYN",
            "generalised alpha",
            lambda: make(build, contest.end, dense),
            settings,
            reference,
        )
    )


def hinged(contest: Contest, links: list[Any], ms: tuple[float, ...], kinematic: Any) -> None:
    """Add the programs that work in joint angles."""
    import precision_peers as peers

    def tree() -> Any:
        import exudyn_tree

        return exudyn_tree.tree(links)

    for solver in ("RK44", "RK67"):
        settings = [{"step": h * MS, "solver": solver} for h in kinematic]
        fine = [{"step": kinematic[-1] / 2 * MS, "solver": solver}] if solver == "RK67" else []
        run = lambda: peers.exudyn(tree, contest.end, True)  # noqa: E731
        contest.curves.append(Curve("EXUDYN tree", solver, run, settings, fine))
    for name in ("RK4", "Euler", "implicitfast"):
        fine = steps(1 / 16) if name == "RK4" else []
        run = lambda n=name: peers.mujoco(links, contest.end, n)  # noqa: E731
        contest.curves.append(Curve("MuJoCo", name, run, steps(*ms), fine))
    run = lambda: peers.pinocchio(links, contest.end)  # noqa: E731
    contest.curves.append(Curve("Pinocchio", "RK4 around aba", run, steps(*ms), steps(1 / 16)))


def flexible(joint: str, bodies: int, end: float) -> tuple[Contest, Callable[[], Any]]:
    """Contest and EXUDYN's model of a row of beams of ten modes."""
    case = Case(joint, bodies, 10, end)

    def build() -> Any:
        import exudyn_peer

        return exudyn_peer.model(case, beam(10))

    return Contest(end, lambda: jo.compile(mechanism(case, beam(10)))), build


def rod() -> jo.ReducedPart:
    """The beam of cases.py of steel with thirty modes, the highest of about 8 kHz."""
    return beam(30, 2.07e11)


def pendulum() -> Contest:
    contest, build = flexible("spherical", 1, 1.0)
    ours(contest, explicit(*STEPS), ("RK4", steps(1 / 32)))
    exudyn(contest, build, STEPS[1:5], (1 / 16, 1 / 8), dense=True)
    return contest


def chain() -> Contest:
    contest, build = flexible("revolute", 100, 0.1)
    ours(contest, explicit(*STEPS[:5]), ("RK4", steps(1 / 32)))
    exudyn(contest, build, (2, 1, 0.5), (0.25, 0.5))
    return contest


def loop(name: str) -> Contest:
    """Slider-crank or four-bar with flexible links."""
    contest = Contest(1.0, lambda: jo.compile(getattr(machines, name)()))

    def build() -> Any:
        import exudyn_machines

        return getattr(exudyn_machines, name)()

    ours(contest, explicit(*STEPS), ("RK4", steps(1 / 32)))
    exudyn(contest, build, STEPS[1:5], (1 / 8, 1 / 4), dense=True)
    return contest


def rigid_chain() -> Contest:
    case = RigidChain("revolute", 100, 0.1)
    contest = Contest(case.t_end, lambda: jo.compile(machines.rigid_chain(case)))

    def build() -> Any:
        import exudyn_machines

        return exudyn_machines.rigid_chain(case)

    ours(contest, explicit(*STEPS[:5]), ("RK4", steps(1 / 32)))
    exudyn(contest, build, STEPS[1:4], (0.125, 0.25), fine_tolerance=1e-6)  # 1e-8 fails there
    hinged(contest, trees.chain("hinge", 100), STEPS[:5], (4, 2, 1))
    return contest


def arm() -> Contest:
    links = trees.arm()
    contest = Contest(0.5, lambda: jo.compile(trees.mechanism(links, tip=True)))
    ours(contest, explicit(*STEPS), ("RK4", steps(1 / 32)))
    hinged(contest, links, STEPS, STEPS)
    return contest


def exact_beam() -> Contest:
    contest = Contest(0.3, lambda: jo.compile(strips.mechanism(100, strips.LEANING)))

    def build() -> Any:
        import beams
        import exudyn_beams

        return exudyn_beams.spatial(beams.strip(strips.LEANING), 100)

    methods = {name: steps(4, 2, 1, 0.5, 0.25) for name in ("ROS2", "GeneralizedAlpha")}
    ours(contest, methods, ("GeneralizedAlpha", steps(1 / 32, 1 / 16)))
    exudyn(contest, build, (2, 1, 0.5), (0.125, 0.25), tight=1e-6)
    return contest


def stiff_rod() -> Contest:
    case = Case("spherical", 1, 30, 0.5)
    contest = Contest(case.t_end, lambda: jo.compile(mechanism(case, rod())))

    def build() -> Any:
        import exudyn_peer

        return exudyn_peer.model(case, rod())

    methods = explicit(*STEPS) | {"RK4": steps(1 / 32, 1 / 64)}
    ours(contest, methods, ("RK4", steps(1 / 128)))
    exudyn(contest, build, STEPS[1:5], (1 / 8, 1 / 4), dense=True)
    return contest


CONTESTS: dict[str, Callable[[], Contest]] = {
    "flexible pendulum, spherical, 10 modes": pendulum,
    "chain of 100 flexible links, revolute": chain,
    "slider-crank, flexible rod": lambda: loop("slider_crank"),
    "four-bar, flexible links": lambda: loop("four_bar"),
    "rigid chain of 100 links, revolute": rigid_chain,
    "six-axis arm": arm,
    "exact beam of 100 elements": exact_beam,
    "stiff rod, 30 modes": stiff_rod,
}


def shorten(contest: Contest) -> None:
    """Leave one coarse setting of each curve and a fifth of the time: that everything runs."""
    contest.end /= 5
    between = contest.end / INSTANTS

    def fits(setting: dict[str, Any]) -> bool:
        count = between / setting.get("step", between)
        return abs(count - round(count)) < 1e-6 * count

    for curve in contest.curves:
        curve.settings = list(filter(fits, curve.settings))[:1]
        curve.fine = []

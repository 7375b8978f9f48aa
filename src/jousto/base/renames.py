"""Renamed public names, with which errors about an old name suggest the new one."""

from typing import Any, NoReturn

RENAMED = {
    "jousto.model.Diagnosis": "jo.certificate.Diagnosis",
    "jousto.reduction.Advice": "jo.certificate.Advice",
    "jousto.reduction.Certificate": "jo.certificate.Certificate",
    "jousto.reduction.Check": "jo.certificate.Check",
    "jousto.reduction.advise": "jo.certificate.advise",
    "jousto.reduction.certify": "jo.certificate.certify",
    "jousto.mesh_step": "jo.mesh_cad",
    "jousto.design.Joint": "jo.design.JointDistribution",
    "jousto.design.by_moments": "jo.design.distribution_from_moments",
    "jousto.measurement.twin.Observed": "jo.twin.Estimates",
    "jousto.measurement.twin.draw": "jo.twin.sample_posterior",
    "jousto.planar.Arms": "jo.planar.ArmCoupling",
    "jousto.planar.Blocks": "jo.planar.BlockCoupling",
    "jousto.planar.Chain": "jo.planar.ChainCoupling",
    "jousto.planar.Function": "jo.planar.FunctionCoupling",
    "jousto.planar.Linear": "jo.planar.LinearCoupling",
    "jousto.planar.Map": "jo.planar.PlanarCoupling",
    "jousto.planar.Slaves": "jo.planar.CoupledMotion",
    "jousto.planar.rest": "jo.planar.planar_rest",
    "jousto.planar.spinning": "jo.planar.planar_spinning",
    "jousto.robots.Mounted": "jo.robots.RobotInMechanism",
    "jousto.robots.Reached": "jo.robots.IKResult",
    "jousto.robots.posed": "jo.robots.state_at",
    "jousto.simulation.settled": "jo.simulation.vibration_free_state",
}
"""Old name with its package, and new name as users write it."""

ARGUMENTS = {
    "plane_damage": {"curve": "sn"},
    "rolling_life": {"curve": "sn"},
    "Spin": {"centre": "center"},
}
"""Renamed arguments by function or class: old and new name."""

ATTRIBUTES = {
    "jousto.parts.MeshError": {"centres": "centers"},
    "jousto.Part": {"centre": "center"},
    "jousto.parts.Spin": {"centre": "center"},
}
"""Renamed attributes by class: old and new name."""


def missing_attribute(thing: Any, name: str) -> NoReturn:
    """Raise the error of an attribute that an object does not have.

    Parameters
    ----------
    thing : object
        Object of a class in `ATTRIBUTES`.
    name : str
        Attribute that was read.

    Raises
    ------
    AttributeError
        With the new name if the attribute was renamed.
    """
    kind = type(thing).__name__
    for place, names in ATTRIBUTES.items():
        if place.endswith(f".{kind}") and name in names:
            message = f"{kind}.{name} is now {kind}.{names[name]}"
            raise AttributeError(message, name=name, obj=thing)
    message = f"{kind!r} object has no attribute {name!r}"
    raise AttributeError(message, name=name, obj=thing)

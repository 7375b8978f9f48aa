"""SHOW: plots, pictures and films of a run. matplotlib is imported with this package only."""

from jousto.output.animate import animate, still
from jousto.output.bands import plot_band
from jousto.output.beams import plot_beam, plot_section_forces, write_beam
from jousto.output.campbell import plot_campbell, plot_root_locus
from jousto.output.certificate import write_certificate
from jousto.output.contour import write_contour
from jousto.output.cycles import plot_cycles, plot_sn
from jousto.output.damage import plot_damage, write_damage
from jousto.output.draw import draw
from jousto.output.friction import plot_friction_stress
from jousto.output.gauges import plot_gauges
from jousto.output.hotspots import plot_hotspots, write_hotspots
from jousto.output.hysteresis import plot_hysteresis, plot_spectrum
from jousto.output.load_path import plot_load_path, write_load_path
from jousto.output.mbdyn import write_fem
from jousto.output.meshes import write_mesh
from jousto.output.monitor import plot_monitor
from jousto.output.planar import plot_planar
from jousto.output.plot import plot
from jousto.output.sid import write_sid
from jousto.output.stress import plot_stress, write_stress
from jousto.output.style import COLORS, STYLE
from jousto.output.table import write_csv
from jousto.output.view import View
from jousto.output.vtu import write_vtu

__all__ = [
    "plot_beam",
    "plot_section_forces",
    "write_beam",
    "plot_gauges",
    "plot_cycles",
    "plot_damage",
    "plot_sn",
    "write_damage",
    "COLORS",
    "STYLE",
    "View",
    "animate",
    "draw",
    "plot",
    "plot_campbell",
    "plot_load_path",
    "plot_hotspots",
    "plot_band",
    "plot_hysteresis",
    "plot_friction_stress",
    "plot_monitor",
    "plot_planar",
    "plot_root_locus",
    "plot_spectrum",
    "plot_stress",
    "still",
    "write_fem",
    "write_hotspots",
    "write_sid",
    "write_vtu",
    "write_certificate",
    "write_contour",
    "write_csv",
    "write_load_path",
    "write_mesh",
    "write_stress",
]

"""Pictures: functions of a result and the axes to draw in, and whole figures."""

from mol_compactons.figures.animation import animate
from mol_compactons.figures.chain import chain_beside_continuum, side_by_side
from mol_compactons.figures.orbits import orbit_overview
from mol_compactons.figures.results import drifts, overview, profiles, waterfall
from mol_compactons.figures.stability import stability_overview
from mol_compactons.figures.studies import convergence_overview, scheme_errors, schemes_overview
from mol_compactons.figures.sweeps import sweep_overview, sweep_panel
from mol_compactons.figures.views import paths, picture, portrait, snapshots, spacetime, spectrum, window

__all__ = [
    "animate",
    "chain_beside_continuum",
    "convergence_overview",
    "drifts",
    "orbit_overview",
    "overview",
    "paths",
    "picture",
    "portrait",
    "profiles",
    "scheme_errors",
    "schemes_overview",
    "side_by_side",
    "snapshots",
    "spacetime",
    "spectrum",
    "stability_overview",
    "sweep_overview",
    "sweep_panel",
    "waterfall",
    "window",
]

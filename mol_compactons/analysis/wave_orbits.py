"""The orbit of a travelling wave on the grid, or of the wave of a chain, and its Floquet multipliers as a Dataset."""

from __future__ import annotations

import json
from typing import TYPE_CHECKING, Literal

import numpy as np
from numpy.typing import NDArray

from mol_compactons.analysis.floquet import Spectrum, changes, spectrum, verdict
from mol_compactons.analysis.orbits import Orbit, Period, close
from mol_compactons.configuration import encode
from mol_compactons.errors import require
from mol_compactons.simulation import Simulation
from mol_compactons.waves.base import LocalizedWave

if TYPE_CHECKING:
    import xarray as xr

Array = NDArray[np.float64]

SHOWN = 6
"""How many multipliers are shown, and stored with their modes."""

WINDOW = 0.6
"""How far from its centre the window of a wave on a grid reaches, in widths of the wave."""

NARROWER = 0.93
"""The window is made narrower by this factor to see what it does."""

CHAIN_WINDOW = 1.0
"""The same for a chain, whose waves have tails."""


def orbit(
    simulation: Simulation,
    *,
    steps: int = 10,
    order: Literal[4, 6] = 4,
    around: Literal["ring", "window"] | None = None,
    speed: float | None = None,
) -> xr.Dataset:
    r"""The numerical travelling wave nearest to the one wave of a simulation, and its Floquet multipliers.

    A wave of speed c moves by one cell h in the time h / |c|. It is found as a fixed point of the map "advance by that time,
    shift back by one cell", by Newton's method from the exact wave; multipliers are eigenvalues of the derivative of the map.

    Parameters
    ----------
    simulation : Simulation
        One wave, on a grid or on a chain, without viscosity; its t_end, frames and integrator do not matter.
    steps : int
        Steps of Gauss-Legendre collocation for each cell.
    order : {4, 6}
        Its order.
    around : {"ring", "window"}, optional
        Whether small changes go round the periodic grid, so that what the wave has left behind comes to meet it again, or
        only those about the wave are followed, and what it leaves behind is gone. By default the window for a chain and the
        ring for a grid; see the notes.
    speed : float, optional
        c, for initial data that do not know their speed.

    Returns
    -------
    xarray.Dataset
        The wave, by the names of the equation's variables (x or k); ``multiplier_real``, ``multiplier_imag``, ``modulus``,
        ``error``, ``step_error`` and ``window_error`` (multiplier), the largest first, with the bar from rounding, and the
        change of the modulus when the steps are halved and when the window is made narrower; ``mode_real`` and ``mode_imag``
        (shown, component, x), the unit eigenvectors of the largest. Among its attributes are the verdict, the residual of the
        fixed point, and the simulation.

    Raises
    ------
    InputError
        If there is not one wave, it is damped, or no travelling wave is found near it.

    Notes
    -----
    Where nothing moves in a wave's wake, as behind the wave of an unloaded chain, a change that the wave has left stands where
    it is until the wave comes round the ring and amplifies it again: a factor g for each round makes N multipliers of modulus
    g^(1/N), which say something of the ring (1.08 for a Hertz chain of 40 sites, 1.05 for 80). On an endless chain the wave
    meets a change once. There the multipliers of the wave are those of the window, where what falls behind is forgotten: they
    do not depend on the length, and the largest is 1, double, that of the translation and of the speed.

    Examples
    --------
    >>> from mol_compactons import Compacton, ConservativeScheme, GranularCompacton, Grid
    >>> simulation = Simulation(
    ...     GranularCompacton(n=3), Grid(10, 60), [Compacton(1, 5)], t_end=1, scheme=ConservativeScheme(order=2)
    ... )
    >>> orbit(simulation).attrs["verdict"]
    'stable'
    """
    around = around or ("ring" if simulation.scheme.refines else "window")
    require(around in ("ring", "window"), f"around = {around!r} must be 'ring' or 'window'.")
    require(
        simulation.scheme.viscosities == (0.0, 0.0),
        "A wave that is damped does not come back to itself; set scheme.viscosity=0 and scheme.grid_viscosity=0.",
    )
    speed = speed_of_wave(simulation) if speed is None else speed
    require(np.isfinite(speed) and speed != 0, f"speed = {speed:g} must not be 0: the period is a cell over it.")
    period = Period(simulation.grid.spacing / abs(speed), 1 if speed > 0 else -1, steps, order)
    cells, fewer = (None, None) if around == "ring" else (window(simulation), window(simulation, NARROWER))
    system, guess = simulation.discretize(), simulation.initial_state()
    found = close(system, guess, period)
    multipliers = spectrum(found, cells, SHOWN)
    finer = spectrum(close(system, found.state, period.halved), cells, SHOWN)
    narrower = multipliers if fewer is None else spectrum(found, fewer, SHOWN)
    by_steps, by_window = (changes(multipliers.values, other.values) for other in (finer, narrower))
    return _dataset(simulation, period, around, found, multipliers, by_steps, by_window)


def speed_of_wave(simulation: Simulation) -> float:
    """The speed of the one wave of a simulation.

    Raises
    ------
    InputError
        If there are several, or it does not know its speed.
    """
    waves = simulation.initial
    require(len(waves) == 1, f"initial holds {len(waves)} waves; an orbit is that of one.")
    speed = getattr(waves[0], "speed", None)
    require(
        isinstance(speed, float | int),
        f"{type(waves[0]).__name__} does not know the speed at which it travels; give the speed.",
    )
    return float(speed or 0.0)


def window(simulation: Simulation, share: float = 1.0) -> NDArray[np.bool_]:
    """The cells of a share of the window about a localized wave, shape (N,).

    Raises
    ------
    InputError
        If there is no such wave, or the window does not fit in the ring.
    """
    waves = [wave for wave in simulation.initial if isinstance(wave, LocalizedWave)]
    require(
        len(waves) == 1,
        "around='window' is for one wave with a place and a width, such as a Compacton or a SolitaryWave; choose "
        "around='ring'.",
    )
    width = waves[0].outline(simulation.equation)[1]
    reach = share * (WINDOW if simulation.scheme.refines else CHAIN_WINDOW)
    cells = np.abs(simulation.grid.offset(waves[0].center)) <= reach * width
    gap = 2 * (simulation.discretize().reach + 1)
    require(
        int((~cells).sum()) >= gap,
        f"The window of the wave, {2 * reach * width:.4g} long, does not fit in the ring of length "
        f"{simulation.grid.length:g}; choose a longer one.",
    )
    return np.asarray(cells)


def _dataset(
    simulation: Simulation, period: Period, around: str, found: Orbit, multipliers: Spectrum, by_steps: Array, by_window: Array
) -> xr.Dataset:
    import xarray as xr

    grid, names = simulation.grid, simulation.equation.variables
    values, shown = multipliers.values, min(SHOWN, multipliers.values.size)
    errors = multipliers.errors + by_steps + by_window
    modes = multipliers.modes[:shown].reshape(shown, *found.state.shape)
    shape = ("shown", "component", grid.dimension)
    return xr.Dataset(
        {
            **{name: (grid.dimension, part) for name, part in zip(names, found.state, strict=True)},
            "multiplier_real": ("multiplier", values.real),
            "multiplier_imag": ("multiplier", values.imag),
            "modulus": ("multiplier", np.abs(values)),
            "error": ("multiplier", multipliers.errors),
            "step_error": ("multiplier", by_steps),
            "window_error": ("multiplier", by_window),
            "mode_real": (shape, modes.real),
            "mode_imag": (shape, modes.imag),
        },
        {grid.dimension: grid.coordinates, "component": list(names)},
        {
            "title": f"Floquet multipliers: {simulation.headline}",
            "status": "complete",
            "verdict": verdict(values, errors),
            "residual": found.residual,
            "correction": found.correction,
            "around": around,
            "period": json.dumps(encode(period)),
            "simulation": simulation.to_json(),
        },
    )


def report_orbit(dataset: xr.Dataset) -> list[str]:
    """What the Dataset of an orbit says, a line each."""
    period = json.loads(dataset.attrs["period"])
    lines = [
        str(dataset.attrs["title"]),
        f"one cell in {period['time']:.6g} by {period['steps']} Gauss-Legendre steps of order {period['order']}",
        f"the wave misses itself by {dataset.attrs['residual']:.1e} of its height, and differs from the initial one by "
        f"{dataset.attrs['correction']:.1e}",
        f"largest multipliers, followed around the {dataset.attrs['around']} (modulus, its bars from rounding, from halved "
        "steps and from a narrower window, angle):",
    ]
    for index in range(dataset.sizes["shown"]):
        one = dataset.isel(multiplier=index)
        angle = float(np.angle(complex(one["multiplier_real"], one["multiplier_imag"])))
        bars = [float(one[name]) for name in ("error", "step_error", "window_error")]
        lines.append(f"  {float(one['modulus']):.8f} {' '.join(f'+- {bar:.0e}' for bar in bars)}, {angle:+.4f}")
    meaning = {
        "stable": "stable: none lies outside the unit circle by more than its bars, at this size and these steps",
        "unstable": "unstable: the largest lies outside the unit circle by more than its bars",
        "undecided": "undecided: the bars are too wide",
    }
    return [*lines, "verdict: " + meaning[str(dataset.attrs["verdict"])]]

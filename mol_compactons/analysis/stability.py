r"""Stability of the compactons of the granular compacton equation: the paper's test, and the step beyond it.

With phi = |W|^((n-1)/2) W the functional Lambda = nu H + c Q of the paper is, for bright and dark waves alike,

    Lambda = 1/(n+1) Int (phi_x^2 - phi^2) dx + (c/2) Int |phi|^(4/(n+1)) dx

and its formal second variation at the compacton, for perturbations eta of phi on the support |y| < pi / 2 with y = K z, is
2/(n+1) Int eta A eta dx with the Poeschl-Teller operator

    A = K^2 [-d^2/dy^2 + s (s-1) sec^2 y] - 1,   s = gamma = 2/(n-1),

whose eigenvalues in the L2 norm of eta are ((2 + k (n-1)) / (n+1))^2 - 1, k = 0, 1, 2, ...: one negative, one zero (the
shift), all others positive, for every n in 1 < n < 5. Their signs do not depend on the norm. On perturbations v of W with
<W_c, v> = 0 the negative direction is lost, since dQ/dc > 0. It is formal because eta falls off more slowly towards the
edge than phi does. Derived here; the spectrum of the operator is that of Poeschl and Teller, Z. Phys. 83 (1933) 143,
doi:10.1007/BF01331132.
"""

from __future__ import annotations

import json
from collections.abc import Sequence
from dataclasses import dataclass, field
from itertools import pairwise
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from mol_compactons.configuration import Settings, encode
from mol_compactons.equations.granular import GranularCompacton
from mol_compactons.errors import require
from mol_compactons.grid import Grid
from mol_compactons.schemes.base import Scheme
from mol_compactons.schemes.compact import CompactScheme
from mol_compactons.waves.compacton import Compacton

if TYPE_CHECKING:
    import xarray as xr

Array = NDArray[np.float64]

MODES = 5
"""How many of the lowest eigenvalues are given."""

CONSTRAINTS = ("free", "constrained")
"""Whether the perturbations must keep <W_c, v> = 0."""

LARGEST_SIZE = 3200
"""The finest resolution that a report takes."""

PLACEMENTS = (0.0, 0.25, 0.5)
"""Where the centre of the compacton lies between two grid points."""


def integrals(n: float, speed: float = 1.0) -> dict[str, float]:
    """The integrals of the paper's test over the support of a compacton, in closed form.

    Parameters
    ----------
    n, speed : float
        n > 1 and c > 0.

    Returns
    -------
    dict
        I = (n+1)/4 Int W^(n-1) W_z^2, J = 1/(n+1) Int W^(n+1), mass = Int W, momentum = 1/2 Int W^2, energy = I - J. They obey
        I = (n-1)/(n+3) J.

    Notes
    -----
    Vladimirov and Skurativskyi (2015), section 2; the limits of integration are +-pi/(2K), misprinted there as +-pi/2.
    """
    from scipy.special import beta

    shape = GranularCompacton(n).compacton(speed)
    height, wavenumber, power = shape.amplitude, shape.wavenumber, shape.exponent

    def moment(exponent: float) -> float:
        return float(beta((exponent + 1) / 2, 0.5)) / wavenumber

    stretch = (n + 1) / 4 * height ** (n + 1) * power**2 * wavenumber * float(beta(power + 0.5, 1.5))
    pull = height ** (n + 1) / (n + 1) * moment(power * (n + 1))
    return {
        "I": stretch,
        "J": pull,
        "mass": height * moment(power),
        "momentum": height**2 / 2 * moment(2 * power),
        "energy": stretch - pull,
    }


def scaled_functional(n: float, factor: Array, speed: float = 1.0) -> Array:
    """Lambda(lambda) = lambda^((n+3)/2) I - lambda^((n-1)/2) J + c Q, on the family lambda^(1/2) W_c(lambda z) of equal Q.

    Parameters
    ----------
    n, speed : float
        n > 1 and c > 0.
    factor : array
        The factors lambda > 0.

    Returns
    -------
    array
        Same shape; it has its minimum at lambda = 1, where the second derivative is (n-1) J (the paper prints half of that).
    """
    terms = integrals(n, speed)
    factor = np.asarray(factor, dtype=float)
    return np.asarray(factor ** ((n + 3) / 2) * terms["I"] - factor ** ((n - 1) / 2) * terms["J"] + speed * terms["momentum"])


def exact_spectrum(n: float, modes: int = MODES) -> Array:
    """The lowest eigenvalues ((2 + k (n-1)) / (n+1))^2 - 1 of A, shape (modes,), for 1 < n < 5."""
    _check_exponent(n)
    return ((2 + np.arange(modes, dtype=np.float64) * (n - 1)) / (n + 1)) ** 2 - 1


def _check_exponent(n: float) -> None:
    GranularCompacton(n)
    require(n < 5, f"n = {n:g} must be less than 5: from there on the shift of a compacton has infinite energy.")


def second_variation(n: float, size: int) -> dict[str, Array]:
    """The second variation on the support by second-order finite differences, independent of the closed form.

    Parameters
    ----------
    n : float
        1 < n < 5.
    size : int
        Number of points inside the support.

    Returns
    -------
    dict of arrays, shape (MODES,)
        The lowest eigenvalues of A, "free" and "constrained" to perturbations v with <W_c, v> = 0.

    Raises
    ------
    InputError
        If n is out of range.
    """
    from scipy.linalg import eigh, eigh_tridiagonal

    _check_exponent(n)
    shape = GranularCompacton(n).compacton(1.0)
    wavenumber, power = shape.wavenumber, shape.exponent
    step = np.pi / (size + 1)
    y = -np.pi / 2 + step * np.arange(1, size + 1)
    diagonal = wavenumber**2 * (2 / step**2 + power * (power - 1) / np.cos(y) ** 2) - 1
    off_diagonal = np.full(size - 1, -(wavenumber**2) / step**2)
    free = eigh_tridiagonal(diagonal, off_diagonal, eigvals_only=True, select="i", select_range=(0, MODES - 1))
    # In terms of eta, the perturbation of phi, <W_c, v> = 0 reads <cos^((3-n)/(n-1)) y, eta> = 0.
    normal = np.cos(y) ** ((3 - n) / (n - 1))
    normal /= np.linalg.norm(normal)
    matrix = np.diag(diagonal) + np.diag(off_diagonal, 1) + np.diag(off_diagonal, -1)
    reflector = normal.copy()
    reflector[0] += np.copysign(1.0, normal[0])
    reflector /= np.linalg.norm(reflector)
    # A Householder reflection takes the normal to the first axis; dropping that axis leaves the constrained operator.
    matrix -= 2 * np.outer(reflector, reflector @ matrix)
    matrix -= 2 * np.outer(matrix @ reflector, reflector)
    constrained = eigh(matrix[1:, 1:], eigvals_only=True, subset_by_index=(0, MODES - 1))
    return {"free": np.asarray(free), "constrained": np.asarray(constrained)}


def evolution_growth(scheme: Scheme, n: float, size: int, shift: float = 0.0, speed: float = 1.0, sign: int = 1) -> float:
    """The largest growth rate of the linearised evolution about a compacton in its moving frame, for a scheme on a grid.

    v_t = d/dz L'' v becomes v' = (M^-1 J + c D) v, J the scheme's own Jacobian and D Fourier's derivative. Where W = 0 the
    flux has no linear part for n > 1 but for the slope of b, which is infinite for n < 3 and is left out.

    Parameters
    ----------
    scheme : scheme
        For example ``CompactScheme()``.
    n : float
        The exponent.
    size : int
        Number of points on a box of twice the width of the compacton.
    shift : float
        Where the centre lies between two grid points, 0 to 1.
    speed, sign
        Those of the compacton.

    Returns
    -------
    float
        max Re of the eigenvalues, nondimensional rate; round-off where the scheme is neutral.
    """
    equation = GranularCompacton(n)
    grid = Grid(2 * equation.compacton(speed).width, size)
    system = scheme.discretize(equation, grid)
    center = (size // 2 + shift) * grid.spacing
    state = Compacton(speed, center, sign).values(equation, grid)
    outside = np.abs(state[0]) < 1e-9 * np.abs(state).max()
    state[0, outside] = 0
    diagonals = np.empty_like(system.mass_diagonals)
    system.jacobian(0.0, state, diagonals)
    jacobian = system.dense(diagonals)
    jacobian[:, outside] = 0
    waves = 2j * np.pi * np.fft.fftfreq(size, grid.spacing)
    waves[size // 2] *= size % 2
    derivative = np.fft.ifft(waves[:, None] * np.fft.fft(np.eye(size), axis=0), axis=0).real
    operator = np.linalg.solve(system.dense(system.mass_diagonals), jacobian) + speed * derivative
    return float(np.linalg.eigvals(operator).real.max())


@dataclass(frozen=True)
class StabilityStudy(Settings):
    """What a stability report is about.

    Parameters
    ----------
    n : float
        The exponent, 1 < n < 5.
    speed : float
        The speed c > 0 of the compacton.
    sizes : sequence of int
        At least three resolutions, each twice the one before: points in the support for the second variation, and on the
        box for the evolution operator.
    scheme : scheme
        Whose linearised evolution is examined.

    Raises
    ------
    InputError
        If a value is out of range.
    """

    n: float = 3.0
    speed: float = 1.0
    sizes: Sequence[int] = (100, 200, 400)
    scheme: Scheme = field(default_factory=CompactScheme)

    def __post_init__(self) -> None:
        super().__post_init__()
        GranularCompacton(self.n).compacton(self.speed)
        shown = ", ".join(map(str, self.sizes))
        _check_exponent(self.n)
        require(len(self.sizes) >= 3, f"sizes = {shown} must hold at least three resolutions.")
        require(
            all(fine == 2 * coarse for coarse, fine in pairwise(self.sizes)),
            f"sizes = {shown} must double from one to the next, for example 100, 200, 400.",
        )
        require(
            self.sizes[0] >= 20 and self.sizes[-1] <= LARGEST_SIZE,
            f"sizes = {shown} must start at 20 or more and end at {LARGEST_SIZE} or less, since the matrices are dense.",
        )


def report(study: StabilityStudy) -> xr.Dataset:
    """The integrals, the paper's functional, the second variation and the linearised evolution of one compacton.

    Parameters
    ----------
    study : StabilityStudy
        What to report on.

    Returns
    -------
    xarray.Dataset
        ``eigenvalue(constraint, resolution, mode)`` with its extrapolation ``value(constraint, mode)``, the ``uncertainty``
        of that, and ``exact(mode)``; ``negative_directions(constraint)``; ``growth(wave, placement, resolution)``; the
        integrals; ``functional(factor)``.
    """
    import xarray as xr

    n, speed = study.n, study.speed
    spectra = [second_variation(n, size) for size in study.sizes]
    eigenvalue = np.array([[spectrum[name] for spectrum in spectra] for name in CONSTRAINTS])
    value, uncertainty = _extrapolate(eigenvalue)
    factor = np.linspace(0.5, 1.5, 101)
    growth = [
        [[evolution_growth(study.scheme, n, size, shift, speed, sign) for size in study.sizes] for shift in PLACEMENTS]
        for sign in (1, -1)
    ]
    return xr.Dataset(
        {
            "eigenvalue": (("constraint", "resolution", "mode"), eigenvalue),
            "value": (("constraint", "mode"), value),
            "uncertainty": (("constraint", "mode"), uncertainty),
            "exact": ("mode", exact_spectrum(n)),
            "negative_directions": ("constraint", (value < -uncertainty).sum(axis=1)),
            "growth": (("wave", "placement", "resolution"), np.array(growth)),
            "functional": ("factor", scaled_functional(n, factor, speed)),
            **{name: ((), number) for name, number in integrals(n, speed).items()},
        },
        {
            "constraint": list(CONSTRAINTS),
            "resolution": list(study.sizes),
            "mode": np.arange(MODES),
            "wave": ["bright", "dark"],
            "placement": list(PLACEMENTS),
            "factor": factor,
        },
        {"title": f"Stability of the compacton, n = {n:g}", "n": n, "study": json.dumps(encode(study))},
    )


def _extrapolate(eigenvalue: Array) -> tuple[Array, Array]:
    """Aitken's limit along the resolutions, axis 1, and its uncertainty.

    The uncertainty is the last change or three times the correction, whichever is larger, where the changes shrink at the
    second order of the differences, and five times the whole change, or the correction, where they shrink more slowly or
    not at all.
    """
    coarse, middle, fine = eigenvalue[:, -3], eigenvalue[:, -2], eigenvalue[:, -1]
    ratio = (middle - coarse) / (fine - middle)
    shrinking = ratio > 1.1
    correction = (fine - middle) / (np.where(shrinking, ratio, 2.0) - 1)
    regular = (ratio > 3) & (ratio < 5)
    narrow = np.maximum(np.abs(fine - middle), 3 * np.abs(correction))
    wide = 5 * np.maximum(np.ptp(eigenvalue, axis=1), np.abs(correction))
    uncertainty = np.where(regular, narrow, wide)
    return fine + np.where(shrinking, correction, 0.0), uncertainty


def verdict(dataset: xr.Dataset) -> str:
    """One of "stable", "unstable" and "undecided": the constrained second variation, beyond its error bars."""
    constrained = dataset.sel(constraint="constrained")
    value, uncertainty = constrained["value"].values, constrained["uncertainty"].values
    if (value < -uncertainty).any():
        return "unstable"
    zero = np.abs(value) <= uncertainty
    return "stable" if zero[0] and not zero[1:].any() and uncertainty[0] < 0.1 * value[1] else "undecided"


def verdicts(dataset: xr.Dataset) -> list[str]:
    """What a report says, a line each."""
    n = float(dataset.attrs["n"])
    terms = {name: float(dataset[name]) for name in ("I", "J", "mass", "momentum", "energy")}
    functional, factor = dataset["functional"].values, dataset["factor"].values
    middle, step = factor.size // 2, factor[1] - factor[0]
    curvature = (functional[middle - 1] - 2 * functional[middle] + functional[middle + 1]) / step**2
    slope = (functional[middle + 1] - functional[middle - 1]) / (2 * step)
    lines = [
        f"I = {terms['I']:.10g}, J = {terms['J']:.10g}, mass = {terms['mass']:.10g}, Q = {terms['momentum']:.10g}, "
        f"H = {terms['energy']:.10g}",
        f"scaling test: at lambda = 1 Lambda' = {slope:.1e} and Lambda'' = {curvature:.5g} by differences; "
        f"(n-1) J = {(n - 1) * terms['J']:.5g}",
    ]
    for name in CONSTRAINTS:
        part = dataset.sel(constraint=name)
        shown = ", ".join(
            f"{float(value):.6g} +- {float(error):.0e}"
            for value, error in zip(part["value"][:3], part["uncertainty"][:3], strict=True)
        )
        lines.append(f"second variation, {name}: {int(part['negative_directions'])} negative; lowest {shown}")
    lines.append("exact, free: " + ", ".join(f"{float(value):.6g}" for value in dataset["exact"][:3]))
    sizes = ", ".join(str(size) for size in dataset["resolution"].values)
    for wave in ("bright", "dark"):
        rates = dataset["growth"].sel(wave=wave).max("placement").values
        shown = ", ".join(f"{rate:.1e}" for rate in rates)
        lines.append(f"linearised evolution on the grid, {wave}: largest growth rate {shown} at {sizes} points")
    lines.append("(growth that vanishes on finer grids is that of the grid, and counts for nothing in the verdict)")
    meaning = {
        "stable": "stable: to perturbations of its support that keep Q the second variation is not negative",
        "unstable": "unstable: there are negative directions that keep Q",
        "undecided": "undecided at these sizes: the error bars reach across zero; choose larger ones",
    }
    lines.append("verdict: " + meaning[verdict(dataset)])
    return lines

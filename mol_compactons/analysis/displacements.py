"""The displacements behind a solution of Nesterenko's equation."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from mol_compactons.errors import require
from mol_compactons.results.reading import arranged, grid_of

if TYPE_CHECKING:
    import xarray as xr


def displacements(dataset: xr.Dataset) -> xr.DataArray:
    r"""The displacements u(t, x) with u_x = -S and u_t = v, which solve Nesterenko's equation in displacements.

    .. math::  u_{tt} = -\{ F[-u_x] \}_x,   F[S] = C \{ S^n + \beta S^{(n-1)/2} (S^{(n+1)/2})_{xx} \} + c_0^2 S.

    The stress S is integrated along x by Fourier series. Its mean is conserved and gives the slope of u, which is periodic
    but for that; the mean of the velocity v is conserved too and moves u as a whole.

    Parameters
    ----------
    dataset : xarray.Dataset
        A result with S(t, x) and v(t, x).

    Returns
    -------
    xarray.DataArray
        u(t, x), nondimensional; at t = 0 its mean over the grid, less its slope, is zero.

    Raises
    ------
    InputError
        If the result has no stress and velocity, or not the whole period.

    Notes
    -----
    Source: Vladimirov and Skurativskyi (2015), equation (PDE2), whose linear term is printed with the opposite sign.
    """
    import xarray as xr

    require({"S", "v"} <= set(dataset.data_vars), "Displacements need a result with S and v: one of Nesterenko's equation.")
    dataset, grid = arranged(dataset), grid_of(dataset)
    stress, size, spacing = dataset["S"].values, grid.size, grid.spacing
    transform = np.fft.rfft(stress, axis=1)
    transform[:, 0] = 0
    wavenumbers = 2 * np.pi * np.fft.rfftfreq(size, spacing)
    transform[:, 1:] /= 1j * wavenumbers[1:]
    if size % 2 == 0:
        transform[:, -1] = 0
    wavy = np.fft.irfft(transform, n=size, axis=1)
    slope = stress.mean(axis=1, keepdims=True) * spacing * np.arange(size)
    drift = dataset["v"].values[:1].mean() * dataset["t"].values[:, None]
    attributes = {"long_name": "displacement", "units": "1"}
    return xr.DataArray(drift - slope - wavy, dataset["S"].coords, dataset["S"].dims, "u", attributes)

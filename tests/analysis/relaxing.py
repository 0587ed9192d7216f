"""Tracks made by hand: two waves that meet on a ring, with a known shift in the end and a speed that goes on changing."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import xarray as xr

SPEEDS = (1.0, 0.25)
CENTERS = (8.0, 20.0)
MOMENT = 16.0
"""When free flight makes them meet, at x = 24."""

SUPPORT = 3 * np.pi
"""The length of the support of a compacton for n = 2, whose height is 3/2 of its speed."""


@dataclass(frozen=True)
class Relaxing:
    """Waves that are not seen from 6 before to 6 after they meet, and then lie ahead by shift + size (t - 16)^-power.

    Parameters
    ----------
    shifts : tuple of float
        What the phase shifts tend to.
    size : float
        Of the change of the slow wave that is still to come, at one unit of time after the moment.
    power : float
        How it dies.
    t_end, length : float
        Of the run.
    belonging : bool
        Whether the height belongs to the speed at each time; else it is the final one throughout.
    """

    shifts: tuple[float, float] = (1.5, -4.5)
    size: float = 0.0
    power: float = 1.0
    t_end: float = 90.0
    length: float = 200.0
    belonging: bool = True

    def tracks(self, simulation: str | None = None) -> xr.Dataset:
        """Along t and wave what `track` gives."""
        times = np.linspace(0, self.t_end, int(4 * self.t_end) + 1)
        gone = np.where(times > MOMENT, times - MOMENT, 1.0)
        position = np.array([center + speed * times for center, speed in zip(CENTERS, SPEEDS, strict=True)]).T
        speed = np.array(SPEEDS) * np.ones((times.size, 1))
        late = times > MOMENT
        position[late] += self.shifts
        position[late, 1] += self.size * gone[late] ** -self.power
        speed[late, 1] -= self.size * self.power * gone[late] ** (-self.power - 1)
        height = 1.5 * (speed if self.belonging else np.array(SPEEDS) * np.ones_like(speed))
        apart = np.abs((position[:, 0] - position[:, 1] + self.length / 2) % self.length - self.length / 2)
        isolated = np.repeat(apart > 4.5, 2).reshape(times.size, 2)
        along = ("t", "wave")
        return xr.Dataset(
            {
                "position": (along, np.where(isolated, position, np.nan), {"period": self.length}),
                "height": (along, np.where(isolated, height, np.nan)),
                "speed": (along, speed),
                "width": (along, np.where(isolated, SUPPORT / 2, np.nan)),
                "isolated": (along, isolated),
                **{
                    name: ("t", np.where(isolated[:, 0], 0.01, np.nan))
                    for name in ("mass_left", "momentum_left", "height_left")
                },
            },
            {"t": times, "wave": np.arange(2)},
            {} if simulation is None else {"simulation": simulation},
        )


def with_a_third(start: float, tracks: xr.Dataset) -> xr.Dataset:
    """A third wave of the speed 2 that meets nobody."""
    third = tracks.isel(wave=[0]).assign_coords(wave=[2]).copy(deep=True)
    third["position"] = third.position.copy(data=(start + 2 * tracks.t.values)[:, None])
    third["isolated"] = third.isolated.copy(data=np.ones((tracks.sizes["t"], 1), dtype=bool))
    third["width"] = third.width.copy(data=np.full((tracks.sizes["t"], 1), SUPPORT / 2))
    third["height"] = third.height.copy(data=np.full((tracks.sizes["t"], 1), 3.0))
    joined = xr.concat([tracks, third], "wave", data_vars="minimal")
    joined["position"].attrs = tracks["position"].attrs
    return joined

"""What a user would pick instead, for the paper's compact scheme with corrected L_j, written as such a user would write it."""

from __future__ import annotations

from collections.abc import Callable
from importlib import import_module
from typing import Any

import numpy as np
from numba import njit
from numpy.typing import NDArray
from scipy import sparse
from scipy.integrate import solve_ivp
from scipy.sparse.linalg import splu

Array = NDArray[np.float64]
Result = tuple[Array, str]
"""The frames, shape (frames, N), and what they took in words."""


class CompactSystem:
    """M W' = f(W) for n = 3 in plain numpy and scipy.sparse: nothing of this is shared with the package."""

    def __init__(self, length: float, size: int, viscosity: float) -> None:
        h = length / size
        self.size = size

        def circulant(stencil: tuple[float, ...], scale: float) -> sparse.csr_array:
            reach = len(stencil) // 2
            parts = [scale * c * np.ones(size) for c in stencil]
            rows = np.tile(np.arange(size), len(stencil))
            columns = np.concatenate([(np.arange(size) + k) % size for k in range(-reach, reach + 1)])
            return sparse.csr_array((np.concatenate(parts), (rows, columns)), shape=(size, size))

        self.mass = circulant((1, 26, 66, 26, 1), 1 / 120)
        self.first = circulant((-1, -10, 0, 10, 1), 1 / (24 * h))
        self.second = circulant((1, 0, -2, 0, 1), 1 / (4 * h**2))
        self.damping = circulant((1, -4, 6, -4, 1), viscosity / h**4)
        theta = 2 * np.pi * np.fft.rfftfreq(size)
        mass = (66 + 52 * np.cos(theta) + 2 * np.cos(2 * theta)) / 120
        self._advection = 1j * (20 * np.sin(theta) + 2 * np.sin(2 * theta)) / (24 * h) / mass
        self._decay = viscosity * (2 - 2 * np.cos(theta)) ** 2 / h**4 / mass
        self._h = h

    def flux(self, w: Array) -> Array:
        """W^3 + W S W^2."""
        g = w * w
        second = (np.roll(g, -2) - 2 * g + np.roll(g, 2)) / (4 * self._h**2)
        return np.asarray(w * (g + second))

    def rate(self, w: Array) -> Array:
        """W', by FFT."""
        transform = -self._advection * np.fft.rfft(self.flux(w)) - self._decay * np.fft.rfft(w)
        return np.asarray(np.fft.irfft(transform, n=self.size))

    def right_hand_side(self, w: Array) -> Array:
        """f, by sparse products."""
        return np.asarray(-(self.first @ (w**3 + w * (self.second @ w**2))) - self.damping @ w)

    def jacobian(self, w: Array) -> sparse.csc_array:
        """df/dW, sparse."""
        local = sparse.diags_array(3 * w**2 + self.second @ w**2)
        bent = sparse.diags_array(w) @ self.second @ sparse.diags_array(2 * w)
        return sparse.csc_array(-(self.first @ (local + bent)) - self.damping)


Solver = Callable[[CompactSystem, Array, Array, float], Result]
"""From the system, the initial state, the times of the frames, and a tolerance or a step."""


def reference(system: CompactSystem, start: Array, times: Array) -> Array:
    """The semi-discrete solution by the explicit DOP853 with rtol 1e-11, shape (frames, N)."""
    solution = solve_ivp(lambda t, w: system.rate(w), (0, times[-1]), start, "DOP853", t_eval=times, rtol=1e-11, atol=1e-13)
    return np.asarray(solution.y.T)


def by_solve_ivp(method: str) -> Solver:
    """scipy.integrate.solve_ivp with one of its implicit methods and the Jacobian, dense for the sake of M^-1."""

    def run(system: CompactSystem, start: Array, times: Array, rtol: float) -> Result:
        inverse = np.linalg.inv(system.mass.toarray())
        solution = solve_ivp(
            lambda t, w: system.rate(w),
            (0, times[-1]),
            start,
            method,
            t_eval=times,
            rtol=rtol,
            atol=rtol / 100,
            jac=lambda t, w: inverse @ system.jacobian(w).toarray(),
        )
        return np.asarray(solution.y.T), f"{solution.nfev} f"

    return run


def by_midpoint(system: CompactSystem, start: Array, times: Array, step: float) -> Result:
    """The paper's implicit midpoint rule, Newton with scipy's splu of one Jacobian for each step."""
    w, frames, evaluations = start.copy(), [start], 0
    steps = round((times[1] - times[0]) / step)
    for _ in times[1:]:
        for _ in range(steps):
            factors = splu(sparse.csc_array(system.mass - 0.5 * step * system.jacobian(w)))
            change = np.zeros_like(w)
            for _ in range(10):
                residual = system.mass @ change - step * system.right_hand_side(w + 0.5 * change)
                correction = factors.solve(residual)
                change -= correction
                evaluations += 1
                if np.abs(correction).max() < 1e-10:
                    break
            w = w + change
        frames.append(w)
    return np.array(frames), f"{steps * (len(times) - 1)} steps, {evaluations} f"


def by_casadi(system: CompactSystem, start: Array, times: Array, rtol: float) -> Result:
    """CasADi's IDAS on x' = z, 0 = M z - f(x), with its symbolic sparse Jacobian."""
    import casadi as ca

    x, z = ca.SX.sym("x", system.size), ca.SX.sym("z", system.size)

    def matrix(m: sparse.csr_array) -> ca.DM:
        return ca.DM(sparse.csc_matrix(m))

    f = -ca.mtimes(matrix(system.first), x**3 + x * ca.mtimes(matrix(system.second), x**2)) - ca.mtimes(
        matrix(system.damping), x
    )
    problem = {"x": x, "z": z, "ode": z, "alg": ca.mtimes(matrix(system.mass), z) - f}
    options: dict[str, Any] = {"reltol": rtol, "abstol": rtol / 100, "max_num_steps": 10**6, "linear_solver": "csparse"}
    integrate = ca.integrator("F", "idas", problem, 0.0, list(times[1:]), options)
    result = np.array(integrate(x0=start, z0=system.rate(start))["xf"]).T
    counts = integrate.stats()
    return np.vstack([start, result]), f"{counts['nsteps']} steps, {counts['nfevals']} f"


def by_scikit_sundae(system: CompactSystem, start: Array, times: Array, rtol: float) -> Result:
    """scikit-sundae's IDA as it comes: a dense Jacobian by differences."""
    from sksundae.ida import IDA

    def residual(t: float, y: Array, yp: Array, res: Array) -> None:
        res[:] = system.mass @ yp - system.right_hand_side(y)

    solver = IDA(residual, rtol=rtol, atol=rtol / 100, max_num_steps=10**6)
    solution = solver.solve(times, start, system.rate(start))
    return np.asarray(solution.y), f"{solution.nfev} f"


def by_py_pde(system: CompactSystem, start: Array, times: Array, tolerance: float) -> Result:
    """py-pde's adaptive Runge-Kutta method, the only kind of its own that gets through, for W' by FFT."""
    pde: Any = import_module("pde")

    class OwnEquation(pde.PDEBase):  # type: ignore[misc]
        def evolution_rate(self, state: Any, t: float = 0) -> Any:
            return pde.ScalarField(state.grid, system.rate(state.data))

    frames = pde.MemoryStorage()
    state = pde.ScalarField(pde.CartesianGrid([(0, 1)], system.size, periodic=True), start)
    options: dict[str, Any] = {
        "solver": "runge-kutta",
        "adaptive": True,
        "tolerance": tolerance,
        "dt": 1e-4,
        "backend": "numpy",
    }
    tracker = [frames.tracker(times[1] - times[0])]
    final, info = OwnEquation().solve(state, times[-1], tracker=tracker, ret_info=True, **options)
    return np.array([*frames.data[:-1], final.data]), f"{info['solver']['steps']} steps"


@njit(cache=True)
def _verlet(stress: Array, rate: Array, force: Array, n: float, step: float, steps: int) -> None:
    size = stress.size
    for index in range(steps + 1):
        for k in range(size):
            force[k] = abs(stress[k]) ** (n - 1) * stress[k]
        kick = 0.5 * step if index in (0, steps) else step
        for k in range(size):
            rate[k] += kick * (force[k - 1] - 2 * force[k] + force[(k + 1) % size])
        if index < steps:
            for k in range(size):
                stress[k] += step * rate[k]


def by_verlet(n: float, start: Array, t_end: float, step: float) -> tuple[Array, str]:
    """Verlet's method for the chain, as one writes it with numba in ten lines."""
    size = start.size // 2
    stress, rate = start[:size].copy(), start[size:].copy()
    _verlet(stress, rate, np.empty(size), n, step, round(t_end / step))
    return stress, f"{round(t_end / step)} f"

"""What the Fourier scheme costs beside the conservative one on a collision: `python -m benchmarks.fourier`.

Two bright compactons of the speeds 1 and 1/4, n = 3, N = 600, until t = 40, with the same viscosity, 0.3 h^3. Takes
about three minutes.
"""

from __future__ import annotations

from mol_compactons import CVODE, Compacton, ConservativeScheme, FourierScheme, GranularCompacton, Grid, Simulation, run

GRID = Grid(length=60, size=600)
VISCOSITY = 0.3 * GRID.spacing**3


def main() -> None:
    """Print the evaluations, the processor time and the heights of three runs in Markdown."""
    print("| scheme | evaluations | seconds | largest and smallest W |\n|---|---|---|---|")
    for scheme in (
        ConservativeScheme(order=4, viscosity=VISCOSITY),
        FourierScheme(dealias=True, viscosity=VISCOSITY),
        FourierScheme(dealias=False, viscosity=VISCOSITY),
    ):
        solver = CVODE(rtol=1e-4, linear_solver="krylov" if isinstance(scheme, FourierScheme) else "band")
        simulation = Simulation(
            equation=GranularCompacton(n=3),
            grid=GRID,
            scheme=scheme,
            initial=[Compacton(speed=1, center=8), Compacton(speed=1 / 4, center=18)],
            t_end=40,
            frames=41,
            integrator=solver,
        )
        dataset = run(simulation)
        cost = f"{dataset.attrs['solver_evaluations']} | {dataset.attrs['cpu_seconds']:.1f}"
        last = dataset.W.values[-1]
        print(f"| {scheme} | {cost} | {last.max():.4f}, {last.min():.4f} |", flush=True)


if __name__ == "__main__":
    main()

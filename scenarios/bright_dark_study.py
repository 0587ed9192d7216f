"""What becomes of a bright and a dark compacton that meet, n = 2 and 3: two limits, each with error bars.

Where the sign changes the solution loses smoothness, and the equation alone no longer says how it goes on. With a viscosity
nu h^5 that vanishes with the grid Q is kept, the conservative continuation; with a fixed viscosity eps, h -> 0 and then
eps -> 0, a good part of Q is lost, the viscous one. Both are computed by two independent schemes each, as in
`collision_study`. The paper's scheme with its viscosity of 1e-3 on N = 1200 points stands beside them: it computes neither.
Takes about three quarters of an hour; docs/schemes.md has the numbers.
"""

import runpy
from dataclasses import replace
from pathlib import Path

from mol_compactons import IDA, CompactScheme, run
from mol_compactons.analysis.collisions import first_collision
from mol_compactons.analysis.drift import drift
from mol_compactons.analysis.tracking import track

bright_bright = runpy.run_path(str(Path(__file__).with_name("collision_study.py")))
collision, study = bright_bright["collision"], bright_bright["study"]
families = {2: bright_bright["CONSERVATIVE"], 3: replace(bright_bright["CONSERVATIVE"], sizes=(300, 600, 1200))}

simulation = collision(n=3, sign=-1)

if __name__ == "__main__":
    for n, family in families.items():
        study(collision(n, sign=-1), f"bright_dark_study_n{n}", family)
        paper = replace(
            collision(n, sign=-1),
            grid=replace(simulation.grid, size=1200),
            scheme=CompactScheme(second_difference="wide", viscosity=1e-3),
            integrator=IDA(rtol=1e-6),
        )
        dataset = run(paper)
        outcome = first_collision(track(dataset, newborn=False))
        print(f"the paper's scheme: Q changes by {float(drift(dataset).momentum[-1]):.3f}")
        for name in ("height_after", "speed_after", "phase_shift"):
            print(f"  {name} {outcome[name].values}")

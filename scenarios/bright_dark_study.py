"""What becomes of a bright and a dark compacton that meet, n = 2 and 3: two limits, each with error bars.

Where the sign changes the solution loses smoothness, and the equation alone no longer says how it goes on. With a viscosity
nu h^5 that vanishes with the grid Q is kept, the conservative continuation; with a fixed viscosity eps, h -> 0 and then
eps -> 0, a good part of Q is lost, the viscous one. Both are computed by two independent schemes each, in the boxes and times
of `collision_study`, which let the waves settle. Besides the conservative scheme only the Fourier scheme keeps Q, and the
compact one blows up in the conservative limit. The Jacobian of the Fourier scheme is dense: it is taken with --fourier alone,
on coarser grids, and for hours. The paper's scheme with its viscosity of 1e-3 and its spacing of 1/20 stands beside them: it
computes neither. docs/schemes.md has the numbers.
"""

import runpy
import sys
from dataclasses import replace
from pathlib import Path

from mol_compactons import IDA, CompactScheme, FourierScheme, run
from mol_compactons.analysis.collisions import first_collision
from mol_compactons.analysis.drift import drift
from mol_compactons.analysis.tracking import track

bright_bright = runpy.run_path(str(Path(__file__).with_name("collision_study.py")))
collision, study = bright_bright["collision"], bright_bright["study"]
conservative, viscous = bright_bright["conservative"], bright_bright["viscous"]
finest = {2: 660, 3: 600}

fourier = FourierScheme(dealias=False, viscosity_order=6)

simulation = collision(n=3, sign=-1)

if __name__ == "__main__":
    for n, size in finest.items():
        pair = collision(n, sign=-1)
        kept = conservative(n, size, fourier) if "--fourier" in sys.argv else conservative(n)
        study(pair, f"bright_dark_study_n{n}", {"conservative": kept, "viscous": viscous(n)})
        paper = replace(
            pair,
            grid=replace(pair.grid, size=int(20 * pair.grid.length)),
            scheme=CompactScheme(second_difference="wide", viscosity=1e-3),
            integrator=IDA(rtol=1e-6),
        )
        dataset = run(paper)
        outcome = first_collision(track(dataset, newborn=False))
        print(f"the paper's scheme: Q changes by {float(drift(dataset).momentum[-1]):.3f}")
        for name in ("height", "speed", "phase_shift"):
            value = name if name == "phase_shift" else f"{name}_after"
            bar = (outcome[f"{name}_settling"] + outcome[f"{name}_reading"]).values
            print(f"  {value} {outcome[value].values} +- {bar} by settling and reading alone")

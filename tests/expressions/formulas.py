"""Formulas of every kind, and what their functions mean in numpy."""

from __future__ import annotations

from typing import Any

import numpy as np
from hypothesis import strategies as st

from mol_compactons.expressions import FUNCTIONS

NUMPY: dict[str, Any] = {
    **{name: getattr(np, name) for name in FUNCTIONS if hasattr(np, name)},
    "abs": np.abs,
    "max": np.maximum,
    "min": np.minimum,
    "sech": lambda value: 1 / np.cosh(value),
    "heaviside": lambda value: np.heaviside(value, 0.5),
}
"""What the functions of a formula mean."""

leaves = st.sampled_from(["x", "y", "a", "2", "0.5", "1.25e-1", "pi", "e"])


def larger(inner: st.SearchStrategy[str]) -> st.SearchStrategy[str]:
    return st.one_of(
        st.builds("({} {} {})".format, inner, st.sampled_from("+-*"), inner),
        st.builds("({}) / (1.5 + ({})**2)".format, inner, inner),
        st.builds("(-{})".format, inner),
        st.builds("({})**{}".format, inner, st.sampled_from([0, 1, 2, 3, 5])),
        st.builds("(1 + ({})**2)**{}".format, inner, st.sampled_from(["-1", "(-2)", "0.5", "1.5", "(1/3)", "-0.75"])),
        st.builds("{}({})".format, st.sampled_from(["sin", "cos", "tanh", "abs", "sech", "sign"]), inner),
        st.builds("{}({}, {})".format, st.sampled_from(["max", "min"]), inner, inner),
    )


formulas = st.recursive(leaves, larger, max_leaves=8)

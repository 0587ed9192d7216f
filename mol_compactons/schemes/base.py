"""What a spatial discretisation is to the rest of the program, and how the default one is found."""

from __future__ import annotations

from abc import abstractmethod
from dataclasses import MISSING, fields
from typing import Any, TypeVar, cast

from mol_compactons.configuration import Settings
from mol_compactons.equations.base import Equation
from mol_compactons.errors import InputError, require
from mol_compactons.grid import Grid, Lattice
from mol_compactons.open_set import loaded, name_of
from mol_compactons.semidiscrete import SemiDiscretization

Own = TypeVar("Own", bound="Scheme")


class Scheme(Settings):
    """A discretisation in space: it turns an equation on a grid into a semi-discretisation M y' = f(t, y).

    A subclass is a frozen dataclass; it has to give `discretize` and `suits`.
    """

    @abstractmethod
    def discretize(self, equation: Equation, grid: Grid | Lattice) -> SemiDiscretization:
        """The semi-discretisation of an equation on a grid.

        Raises
        ------
        InputError
            If they do not go together.
        """

    @abstractmethod
    def suits(self, equation: Equation) -> float:
        """How well the scheme suits an equation: 0 not at all, up to 1; the best of all loaded schemes is the default."""

    @classmethod
    def default_for(cls: type[Own], equation: Equation, grid: Grid | Lattice, speed: float) -> Own | None:
        """The scheme with the settings that it should have where nothing else is said; None if it is no default for this.

        Parameters
        ----------
        equation, grid
            What is solved, and where.
        speed : float
            The scale of the speeds in the initial data; a viscosity is proportional to it.
        """
        needed = [one for one in fields(cast(Any, cls)) if one.default is MISSING and one.default_factory is MISSING]
        return None if needed else cls()

    @property
    def formal_order(self) -> float:
        """The power of h at which the error falls on smooth waves; 2 where the scheme does not say."""
        return 2.0

    @property
    def refines(self) -> bool:
        """Whether the solution depends on the size of the grid by an error only: not so for a chain, whose sites are real."""
        return True

    @classmethod
    def as_check_of(cls, scheme: Scheme, equation: Equation, grid: Grid | Lattice) -> tuple[float, Scheme] | None:
        """How well a scheme of this class serves as a check of another, and with which settings; None for not at all."""
        own = cls.default_for(equation, grid, 0.0)
        return None if own is None else (own.suits(equation), own)

    def independent_alternative(self, equation: Equation, grid: Grid | Lattice) -> Scheme | None:
        """A scheme of another class that shares nothing with this one but the equation, for a study to check with."""
        offers = [cls.as_check_of(self, equation, grid) for cls in loaded(Scheme).values() if not isinstance(self, cls)]
        known = [offer for offer in offers if offer is not None and offer[0] > 0]
        return max(known, key=lambda offer: offer[0])[1] if known else None

    def is_independent_of(self, other: Scheme) -> bool:
        """Whether agreement with the other is evidence: it is of another kind, neither a special case of it nor the reverse.

        A scheme that is another's in disguise overrides this.
        """
        return not isinstance(self, type(other)) and not isinstance(other, type(self))

    def with_viscosity(self: Own, viscosity: float, grid_viscosity: float) -> Own:
        """The same scheme with other coefficients of artificial viscosity, absolute and in grid units.

        Raises
        ------
        InputError
            If it has none.
        """
        require(
            viscosity == grid_viscosity == 0,
            f"{type(self).__name__} has no viscosity; choose no viscosities, or another scheme.",
        )
        return self

    @property
    def viscosities(self) -> tuple[float, float]:
        """The coefficients of artificial viscosity, absolute and in grid units."""
        return (0.0, 0.0)

    @property
    def label(self) -> str:
        """The scheme in one word and its discrete choices, without its viscosity: "ConservativeScheme(order=4)"."""
        names = [field.name for field in fields(cast(Any, self)) if field.name not in self._unsaid]
        choices = [f"{name}={getattr(self, name)}" for name in names]
        return f"{name_of(type(self))}({', '.join(choices)})"

    @property
    def _unsaid(self) -> set[str]:
        return set()


def best_scheme(equation: Equation, grid: Grid | Lattice, speed: float) -> Scheme:
    """The loaded scheme that suits an equation best, with its default settings.

    Raises
    ------
    InputError
        If none suits it.
    """
    schemes = [cls.default_for(equation, grid, speed) for cls in loaded(Scheme).values()]
    suitable = [scheme for scheme in schemes if scheme is not None and scheme.suits(equation) > 0]
    if not suitable:
        raise InputError(
            f"No scheme that is loaded suits {type(equation).__name__}; give the equation a local_flux, or the simulation a "
            "scheme of your own."
        )
    return max(suitable, key=lambda scheme: scheme.suits(equation))

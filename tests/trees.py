"""Frozen dataclasses of several kinds of fields, on which configuration and assignment are tested."""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence
from typing import Literal

from mol_compactons.configuration import check


@dataclasses.dataclass(frozen=True)
class Leaf:
    number: float
    count: int = 1
    mode: Literal["fast", "slow"] = "fast"

    def __post_init__(self) -> None:
        check(self)


@dataclasses.dataclass(frozen=True)
class Other:
    flag: bool = False
    text: str = ""

    def __post_init__(self) -> None:
        check(self)


@dataclasses.dataclass(frozen=True)
class Tree:
    leaves: Sequence[Leaf | Other]
    best: Leaf | Other | None = None
    numbers: tuple[float, ...] = ()

    def __post_init__(self) -> None:
        check(self)

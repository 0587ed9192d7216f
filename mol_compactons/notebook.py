"""How settings and tables look in a notebook, in light and in dark, and how long lists look in a line."""

from __future__ import annotations

import dataclasses
import inspect
from collections.abc import Iterable, Sequence
from typing import Any
from xml.etree import ElementTree

STYLE = (
    ".mol-compactons{font-size:13px;max-width:60em;line-height:1.5}"
    ".mol-compactons summary{cursor:pointer;overflow-wrap:anywhere}"
    ".mol-compactons .about{opacity:.8;margin-left:.6em}"
    ".mol-compactons .default{opacity:.75}"
    ".mol-compactons details details{margin-left:1.2em}"
    ".mol-compactons table{border-collapse:collapse;margin:.2em 0 .4em 1.2em;font-variant-numeric:tabular-nums}"
    ".mol-compactons td,.mol-compactons th{text-align:left;padding:.1em 1.2em .1em 0;border:none;background:none;"
    "vertical-align:top}"
    ".mol-compactons caption{text-align:left;font-weight:bold}"
)
"""Colours are those of the notebook, fainter where less matters."""

MOST_SHOWN = 8
"""Of a longer list the first two and the last are shown."""

LONGEST_ABOUT = 160
"""What a class says of itself is cut to this length."""


def short(value: Any) -> str:
    """A value in a line, of a long list the first two and the last.

    Examples
    --------
    >>> short((0.5, 1.0)), short(tuple(range(100)))
    ('(0.5, 1.0)', '(0, 1, ..., 99; 100 values)')
    """
    if isinstance(value, tuple) and len(value) > MOST_SHOWN:
        return f"({value[0]!r}, {value[1]!r}, ..., {value[-1]!r}; {len(value)} values)"
    return repr(value)


def short_repr(settings: Any) -> str:
    """A dataclass as Python writes it, with long lists cut short."""
    told = (f"{one.name}={short(getattr(settings, one.name))}" for one in dataclasses.fields(settings) if one.repr)
    return f"{type(settings).__qualname__}({', '.join(told)})"


def html_of_settings(settings: Any, heading: str = "") -> str:
    """A dataclass of settings as HTML: its fields, those that are defaults fainter, and its parts to be unfolded.

    Parameters
    ----------
    settings : dataclass
        What is shown.
    heading : str, optional
        What stands beside its name; by default what its class says of itself.
    """
    part = _part(settings, "", is_open=True)
    if heading:
        about = part.find("summary/span")
        assert about is not None
        about.text = heading
    return _whole(part)


def html_of_tables(tables: Iterable[tuple[str, Sequence[str], Iterable[Sequence[str]]]], after: Sequence[str] = ()) -> str:
    """Tables as HTML, each with its caption, its headings and its rows, and lines below them."""
    parts = []
    for caption, headings, rows in tables:
        table = ElementTree.Element("table")
        ElementTree.SubElement(table, "caption").text = caption
        for cells, kind in [(headings, "th"), *((row, "td") for row in rows)]:
            across = ElementTree.SubElement(table, "tr")
            for cell in cells:
                ElementTree.SubElement(across, kind, {"scope": "col"} if kind == "th" else {}).text = cell
        parts.append(table)
    for line in after:
        paragraph = ElementTree.Element("div")
        paragraph.text = line
        parts.append(paragraph)
    return _whole(*parts)


def _whole(*parts: ElementTree.Element) -> str:
    root = ElementTree.Element("div", {"class": "mol-compactons"})
    root.extend(parts)
    return f"<style>{STYLE}</style>" + ElementTree.tostring(root, encoding="unicode", method="html")


def _part(settings: Any, name: str, is_open: bool = False) -> ElementTree.Element:
    """A dataclass as something to be unfolded."""
    part = ElementTree.Element("details", {"open": "open"} if is_open else {})
    summary = ElementTree.SubElement(part, "summary")
    label = ElementTree.SubElement(summary, "b")
    label.text = f"{name}: {type(settings).__name__}" if name else type(settings).__name__
    ElementTree.SubElement(summary, "span", {"class": "about"}).text = _about(settings)
    table, inner = ElementTree.Element("table"), []
    for one in dataclasses.fields(settings):
        value = getattr(settings, one.name)
        items = value if isinstance(value, tuple) else (value,)
        if items and all(dataclasses.is_dataclass(item) for item in items) and len(items) <= MOST_SHOWN:
            several = len(items) > 1
            inner += [_part(item, f"{one.name}[{index}]" if several else one.name) for index, item in enumerate(items)]
        else:
            row = ElementTree.SubElement(table, "tr", {"class": "default"} if _is_default(one, value) else {})
            ElementTree.SubElement(row, "td").text = one.name
            ElementTree.SubElement(row, "td").text = short(value)
    part.extend([*([table] if len(table) else []), *inner])
    return part


def _is_default(field: dataclasses.Field[Any], value: Any) -> bool:
    made = field.default_factory() if field.default_factory is not dataclasses.MISSING else field.default
    return made is not dataclasses.MISSING and bool(made == value)


def _about(settings: Any) -> str:
    """What the class of a part says of itself, in its first paragraph."""
    first = " ".join((inspect.getdoc(type(settings)) or "").split("\n\n")[0].split())
    return first if len(first) <= LONGEST_ABOUT else f"{first[:LONGEST_ABOUT].rstrip()}..."

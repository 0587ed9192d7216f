"""What the pictures share: colours, markers and dashes, which tell lines apart in grey too."""

from typing import Any

LINE = "#1f4e79"
"""The colour of a single run."""

MARKERS = "osd^v<>pP*Xh"

DASHES = ("-", "--", "-.", ":")


def told_apart(number: int) -> dict[str, Any]:
    """How the line of a number is drawn with marks: arguments of matplotlib, another colour, mark and dash for each."""
    return {
        "marker": MARKERS[number % len(MARKERS)],
        "linestyle": DASHES[number % len(DASHES)],
        "color": f"C{number % 10}",
        "markersize": 4,
        "linewidth": 1,
    }

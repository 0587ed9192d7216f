"""What the pictures share: colours, markers and dashes, which tell lines apart in grey too."""

LINE = "#1f4e79"
"""The colour of a single run."""

MARKERS = "osd^v<>pP*Xh"

DASHES = ("-", "--", "-.", ":")

"""Measurements behind the figures in the documentation; each module is a command."""

import os

# Processor time adds up all threads; with one each, the dense peers are not charged for the others' waiting.
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

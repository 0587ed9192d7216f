"""Pages: a result, a study or a sweep as one HTML file that needs no network."""

from mol_compactons.pages.writing import write_report

__all__ = ["write_report"]

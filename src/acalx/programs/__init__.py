"""Given programs: published ones by name, those of files, regular sequences."""

from acalx.programs.catalog import find_program, published, published_for
from acalx.programs.program import Program
from acalx.programs.reading import read_program

__all__ = ["Program", "find_program", "published", "published_for", "read_program"]

"""The version of this package: that of curvd, as the project's CMakeLists.txt has it."""

__version__ = "0.1.0"

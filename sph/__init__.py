"""Earthquake-induced slope failure with solid-fluid coupled smoothed particle hydrodynamics."""

__version__ = "0.1.0"

"""Clouds of analytic surfaces."""

import numpy as np


def sphere(point_count, radius, dtype=np.float32):
    """Positions and outward normals, evenly spread along a spiral."""
    height = 1 - (2 * np.arange(point_count) + 1) / point_count
    angle = np.pi * (3 - np.sqrt(5)) * np.arange(point_count)
    ring = np.sqrt(1 - height**2)
    normals = np.stack([ring * np.cos(angle), ring * np.sin(angle), height], axis=1)
    return (radius * normals).astype(dtype), normals.astype(dtype)

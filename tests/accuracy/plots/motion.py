"""Scenes whose energy must stay what it is: 20 x 20 vertices, 1 m x 1 m, E 1 MPa, 0.5 mm."""

import math
import sys

import studies

sys.path.insert(0, str(studies.SCENES))
import generate  # noqa: E402

RATE = 240  # Hz, of ticks
TICKS_A_ROW = 4
SIDE = 20
MATERIAL = {"youngs_modulus_pa": 1e6, "poissons_ratio": 0.3, "thickness_m": 5e-4, "density_kgpm3": 1000, "bending_scale": 1,
            "mass_damping_per_s": 0, "stiffness_damping_s": 0}


def sheet(position):
    """An inline mesh whose vertices start at position(x, y)."""
    generate.FINENESS = 1.0
    mesh = generate.mapped(SIDE - 1, SIDE - 1, lambda x, y: (x, y))
    at = mesh["material_positions"]
    mesh["positions"] = [c for x, y in zip(at[::2], at[1::2]) for c in position(x, y)]
    return {"inline": mesh, "material": MATERIAL, "tick_rate_hz": RATE, "ticks": RATE, "analysis": {"dynamic": {}}}


def free():
    """Thrown and spun; drawn out by 2 % along x, drawn in by 1 % along y and waved, so that it vibrates. Nothing pushes."""
    def position(x, y):
        return 1.02 * x, 0.99 * y, 0.03 * math.sin(2 * math.pi * x) * math.cos(math.pi * y)
    return {**sheet(position), "sheet_id": "free", "gravity_mps2": {},
            "initial_velocity": {"linear_mps": {"x": 0.5, "y": 0.2, "z": 1}, "angular_radps": {"x": 1, "y": 0.5, "z": 6}},
            "probes": [generate.probe("energy", "ENERGY"), generate.probe("momentum", "MOMENTUM"),
                       generate.probe("spin", "ANGULAR_MOMENTUM")]}


def swinging():
    """Held at its upper edge, let go 60 degrees from where it would hang."""
    angle = math.radians(60)

    def position(x, y):
        return x, (1 - y) * math.sin(angle), -(1 - y) * math.cos(angle)
    return {**sheet(position), "sheet_id": "swinging", "gravity_mps2": {"z": -9.81},
            "constraints": [generate.hold(generate.edge("TOP"))], "probes": [generate.probe("energy", "ENERGY")]}


SCENES = {"free": free, "swinging": swinging}

#!/usr/bin/env python3
"""Writes the scene files of this folder, one or more for each case of tests/data/reference.

    generate.py            writes <case>.json
    generate.py --check    exits 1 and names them where files differ from what would be written

What each scene's numbers are compared with stands in <case>.expect.json, written by hand; tests/accuracy/README.md
says how. Meshes are grids wherever a grid will do: Kerf's cutter makes slits and holes.
"""

import json
import math
import pathlib
import sys

HERE = pathlib.Path(__file__).parent
REFERENCES = HERE.parent.parent / "reference"
UNDAMPED = {"kind": "EXPLICIT_LEAPFROG", "highest_mode_damping": 0}
IN_PLANE = {"origin": {}, "x_axis": {"x": 1}, "y_axis": {"y": 1}}
FINENESS = 1.0  # of the meshes being made: cells a length, over those of the files


def reference(case):
    return json.loads((REFERENCES / f"{case}.json").read_text())


def tidy(value):
    """Numbers with at most 12 digits, whole ones as such."""
    if isinstance(value, dict):
        return {key: tidy(inner) for key, inner in value.items()}
    if isinstance(value, (list, tuple)):
        return [tidy(inner) for inner in value]
    if isinstance(value, float):
        value = float(f"{value:.12g}")
        return int(value) if value == int(value) and abs(value) < 1e9 else value
    return value


def xy(x, y):
    return {"x": x, "y": y}


def material(case, **other):
    """The reference's, undamped."""
    given = reference(case)["material"]
    return {"youngs_modulus_pa": given["E"], "poissons_ratio": given["nu"], "shear_modulus_pa": given["G"],
            "thickness_m": given["thickness"], "density_kgpm3": given["density"], "bending_scale": 1,
            "mass_damping_per_s": 0, "stiffness_damping_s": 0, **other}


def cells(count):
    return max(1, round(FINENESS * count))


def grid(columns, rows, width, height):
    """Of so many cells."""
    return {"columns": cells(columns) + 1, "rows": cells(rows) + 1, "width_m": width, "height_m": height}


def mapped(num_x, num_y, at):
    """An inline mesh of num_x by num_y cells of the unit square, halved from lower right to upper left, at(a, b)."""
    num_x, num_y = cells(num_x), cells(num_y)
    points = [at(i / num_x, j / num_y) for j in range(num_y + 1) for i in range(num_x + 1)]
    triangles = []
    for j in range(num_y):
        for i in range(num_x):
            a = j * (num_x + 1) + i
            triangles += [a, a + 1, a + num_x + 1, a + 1, a + num_x + 2, a + num_x + 1]
    return {"material_positions": [c for point in points for c in point], "triangles": triangles}


def probe(name, quantity, region=None, points=None, **other):
    where = {} if region is None else {"region": region}
    if points is not None:
        where["points"] = [xy(*point) for point in points]
    return {"name": name, "quantity": quantity, **where, **other}


def edge(name):
    return {"edge": name}


def line(a, b, **other):
    return {"line": {"a": xy(*a), "b": xy(*b), **other}}


def hold(region, components="xyz", **other):
    return {"region": region, **{component: True for component in components}, **other}


def cut(curve, **other):
    return {"tick": 1, "command": {"cut": {"curve": curve, **other}}}


def graded(edge_length, grading):
    """Towards the tips of a cut."""
    return {"tip_edge_length_m": edge_length / FINENESS, "tip_grading": 1 + (grading - 1) / FINENESS}


def polyline(*points):
    return {"polyline": {"points": [xy(*point) for point in points]}}


def static(*loads):
    return {"static": {"loads": list(loads)}} if loads else {"static": {}}


SCENES = {}


def scene(name, about, mesh, of, analysis, **other):
    """`of`: the material. No gravity unless there is some in `other`; in the plane z = 0 unless there is a placement."""
    whole = {"sheet_id": name.lower().replace("_", "-").replace(".", "-")[4:], "description": about, **mesh,
             "placement": IN_PLANE, "material": of, "gravity_mps2": {}, **other, "analysis": analysis}
    probes = whole.pop("probes", [])
    if probes:
        whole["probes"] = probes
    SCENES[name] = tidy(whole)


def patch():
    case = "01a_patch_macneal_harder"
    shape = reference(case)["geometry"]
    mesh = {"material_positions": [c for point in shape["vertices"] for c in point],
            "triangles": [v for triangle in shape["triangles"] for v in triangle]}
    scene(case, "Linear displacements of the border of an irregular mesh; the stress is the same everywhere.",
          {"inline": mesh}, material(case), static(), planar=True,
          constraints=[hold({"vertices": {"vertices": shape["boundary_vertices"]}}, "xy",
                            stretch_x=xy(0.001, 0.0005), stretch_y=xy(0.0005, 0.001))],
          probes=[probe("least", "STRESS", {"all": True}, reduce="MIN"),
                  probe("largest", "STRESS", {"all": True}, reduce="MAX"),
                  probe("inside", "DISPLACEMENT", points=shape["vertices"][4:])])


def uniaxial():
    case = "02a_uniaxial_biot"
    held = [hold(edge("BOTTOM"), "y"), hold({"nearest": xy(0, 0)}, "x")]
    mesh = {"grid": grid(2, 4, 0.1, 0.2)}
    scene(case, "A strip pulled to 1 %, 20 % and 50 %, free to contract.", mesh, material(case),
          static(0.02, 0.4, 1.0), planar=True,
          constraints=[*held, hold(edge("TOP"), "y", displacement_m={"y": 0.1})],
          probes=[probe("top", "REACTION", edge("TOP")), probe("size", "EXTENT"), probe("energy", "ENERGY")])
    scene(case + ".rotation", "The same strip turned by 90 degrees at its lower edge: no forces anywhere.", mesh,
          material(case), {"static": {"steps": 4}}, planar=True,
          constraints=[hold(edge("BOTTOM"), "xy", axis={"z": 1}, angle_rad=0.5 * math.pi)],
          probes=[probe("least", "REACTION", edge("BOTTOM"), reduce="MIN"),
                  probe("largest", "REACTION", edge("BOTTOM"), reduce="MAX"),
                  probe("top", "POSITION", edge("TOP")), probe("stress", "STRESS", {"all": True}, reduce="MAX")])


def clamped_strip():
    case = "02b_clamped_strip"
    scene(case, "A strip held at both ends, which cannot contract, pulled to 20 % and 50 %.",
          {"grid": grid(32, 64, 0.1, 0.2)}, material(case), static(0.4, 1.0), planar=True,
          constraints=[hold(edge("BOTTOM")), hold(edge("TOP"), displacement_m={"y": 0.1})],
          probes=[probe("top", "REACTION", edge("TOP")), probe("energy", "ENERGY"),
                  probe("side", "DISPLACEMENT", points=[(0, 0.1)])])


def cook():
    case = "03a_cook_membrane"
    p = reference(case)["geometry"]["corners"]

    def at(a, b):
        return tuple((1 - b) * ((1 - a) * p[0][k] + a * p[1][k]) + b * ((1 - a) * p[3][k] + a * p[2][k])
                     for k in range(2))
    scene(case, "A tapered panel held on the left and pushed up on the right; under 1e-4 of the load.",
          {"inline": mapped(32, 32, at)}, material(case), static(), planar=True,
          constraints=[hold(edge("LEFT"))],
          loads=[{"edge": {"region": edge("RIGHT"), "force_n": {"y": 1e-4}}}],
          probes=[probe("middle", "DISPLACEMENT", points=[(48, 52)]), probe("energy", "ENERGY")])


def kirsch():
    case = "04a_kirsch"
    shape = reference(case)["geometry"]
    a, half = shape["hole_radius"], shape["half_side"]
    young, nu = reference(case)["material"]["E"], reference(case)["material"]["nu"]
    mu, k = young / (2 * (1 + nu)), (3 - nu) / (1 + nu)

    def exact(x, y, s=1000.0):
        r, t = math.hypot(x, y), math.atan2(y, x)
        ux = r / a * (k + 1) * math.cos(t) + 2 * a / r * ((1 + k) * math.cos(t) + math.cos(3 * t)) \
            - 2 * a ** 3 / r ** 3 * math.cos(3 * t)
        uy = r / a * (k - 3) * math.sin(t) + 2 * a / r * ((1 - k) * math.sin(t) + math.sin(3 * t)) \
            - 2 * a ** 3 / r ** 3 * math.sin(3 * t)
        return s * a / (8 * mu) * ux, s * a / (8 * mu) * uy
    n = cells(80)
    border = [j * (n + 1) + i for j in range(n + 1) for i in range(n + 1) if i in (0, n) or j in (0, n)]
    given = [exact(2 * half * (v % (n + 1)) / n - half, 2 * half * (v // (n + 1)) / n - half) for v in border]
    # At the angles of the table, where the border is, on the way from the middle of the sheet.
    rim = [(half + a * math.cos(math.radians(d)), half + a * math.sin(math.radians(d))) for d in range(0, 91, 15)]
    scene(case, "A round hole punched by the cutter in a plate that is pulled along x, far away.",
          {"grid": grid(80, 80, 2 * half, 2 * half)}, material(case), static(), planar=True,
          commands=[cut({"circle": {"center": xy(half, half), "radius_m": 0.5 * a}}, width_m=a, tolerance_m=a / 6400)],
          constraints=[hold({"vertices": {"vertices": border}}, "xy",
                            displacements_m=[xy(*u) for u in given])],
          probes=[probe("rim", "DISPLACEMENT", points=rim), probe("peak", "STRESS", {"all": True}, reduce="MAX"),
                  probe("side", "STRESS", points=[rim[0]])])


def rounded_square(half, radius):
    """Round the origin."""
    corner = {"semi_axis_x_m": radius, "semi_axis_y_m": radius, "counter_clockwise": True}
    e = half - radius
    arcs = [(e, half), (-half, e), (-e, -half), (half, -e)]
    lines = [(-e, half), (-half, -e), (e, -half)]
    segments = []
    for i, end in enumerate(arcs):
        segments.append({"arc": {**corner, "end": xy(*end)}})
        if i < 3:
            segments.append({"line": xy(*lines[i])})
    return {"path": {"subpaths": [{"start": xy(half, e), "segments": segments, "closed": True}]}}


def ellipse(a, b):
    """Round the origin."""
    return {"ellipse": {"center": xy(0, 0), "semi_axis_x_m": a, "semi_axis_y_m": b}}


def window(case, cells, curve, tolerance, rim):
    """A quarter of a strip with a hole, symmetric about x = 0 and y = 0. What the cutter cuts off the corner stays
    there, held by the symmetry alone."""
    shape = reference(case)["geometry"]
    width, height = 0.5 * shape["width"], 0.5 * shape["length"]
    (a, b) = rim
    scene(case, "A quarter of a strip with a hole under tension; the cutter makes the hole.",
          {"grid": grid(*cells, width, height)}, material(case), static(), planar=True,
          commands=[cut(curve, tolerance_m=tolerance)],
          constraints=[hold(edge("LEFT"), "x"), hold(edge("BOTTOM"), "y")],
          loads=[{"edge": {"region": edge("TOP"), "force_npm": {"y": 1000 * shape_thickness(case)}}}],
          probes=[probe("top", "DISPLACEMENT", edge("TOP")),
                  probe("right", "DISPLACEMENT", points=[(a, 0)], side=xy(width, 0)),
                  probe("upper", "DISPLACEMENT", points=[(0, b)], side=xy(0, height)),
                  probe("peak", "STRESS", {"all": True}, reduce="MAX"),
                  probe("beside", "STRESS", points=[(a, 0)], side=xy(width, 0))])


def shape_thickness(case):
    return reference(case)["material"]["thickness"]


def large_window(case, cells, curve, tolerance, rim):
    """All of it, clamped and pulled; what is punched out is held at its middle."""
    shape = reference(case)["geometry"]
    width, height = 0.5 * shape["width"], 0.5 * shape["length"]
    scene(case, "A quarter of a strip with a hole, clamped at the end and pulled to large stretch.",
          {"grid": grid(*cells, width, height)}, material(case), static(0.5, 1.0), planar=True,
          commands=[cut(curve, tolerance_m=tolerance)],
          constraints=[hold(edge("LEFT"), "x"), hold(edge("BOTTOM"), "y"),
                       hold(edge("TOP"), "xy", displacement_m={"y": 0.1 * shape["length"]})],
          probes=[probe("top", "REACTION", edge("TOP")), probe("energy", "ENERGY"),
                  probe("right", "DISPLACEMENT", points=[(rim[0], 0)], side=xy(width, 0)),
                  probe("upper", "DISPLACEMENT", points=[(0, rim[1])], side=xy(0, height)),
                  probe("outside", "DISPLACEMENT", points=[(width, 0)])])


def holes():
    window("04b_howland_d_over_w_05", (20, 80), ellipse(0.025, 0.025), 0.025 / 3200, (0.025, 0.025))
    window("04d_elliptic_hole", (40, 120), ellipse(0.03, 0.015), 2e-6, (0.03, 0.015))
    window("12a_square_window", (24, 72), rounded_square(0.024, 0.006), 0.006 / 3200, (0.024, 0.024))
    large_window("12b_circle_window_large", (24, 40), ellipse(0.03, 0.03), 0.03 / 3200, (0.03, 0.03))
    large_window("12d_square_window_large", (24, 40), rounded_square(0.024, 0.006), 0.006 / 3200, (0.024, 0.024))


def slits():
    for case in ("05a_centre_slit_025", "05b_centre_slit_050", "05c_edge_slit_030", "05d_inclined_slit_45",
                 "05e_arc_slit_50"):
        shape = reference(case)["geometry"]
        slit = shape["slit"]
        width, height = shape["width"], shape["length"]
        middle = (0.5 * width, 0.5 * height)
        profile = next(q for q in reference(case)["quantities"] if q["name"] == "slit opening profile")
        arcs = [row[0] for row in profile["table"]["rows"]]
        if slit["kind"] == "line":
            p0 = [slit["p0"][k] + middle[k] for k in range(2)]
            p1 = [slit["p1"][k] + middle[k] for k in range(2)]
            size = math.dist(p0, p1)
            start = 0.0 if "mouth0" in slit else 0.5 * size
            half = size if "mouth0" in slit else 0.5 * size

            def at(s, p0=p0, p1=p1, start=start, size=size):
                return tuple(p0[k] + (s + start) / size * (p1[k] - p0[k]) for k in range(2))
            # The mouth of an edge slit: from outside the sheet.
            curve = polyline((p0[0] - 0.01, p0[1]) if "mouth0" in slit else p0, p1)
        else:
            radius = slit["radius"]
            centre = [slit["centre"][k] + middle[k] for k in range(2)]
            half = 0.05

            def at(s, centre=centre, radius=radius):
                angle = math.radians(90) - s / radius
                return centre[0] + radius * math.cos(angle), centre[1] + radius * math.sin(angle)
            ends = [at(radius * math.radians(angle)) for angle in (-50, 50)]
            curve = {"path": {"subpaths": [{"start": xy(*ends[0]), "segments": [
                {"arc": {"semi_axis_x_m": radius, "semi_axis_y_m": radius, "end": xy(*ends[1])}}]}]}}
            size = 2 * radius * math.radians(50)
            start = 0.5 * size
        columns = 2 * math.ceil(0.5 * width / (0.2 * half))
        # Towards each tip, for the stress intensity.
        near = []
        if "mouth0" not in slit:
            near = [at(-start + share * half) for share in (0.05, 0.15)]
        near += [at(size - start - share * half) for share in (0.05, 0.15)]
        scene(case, "A strip under tension, slit by the cutter, its mesh graded to the tips.",
              {"grid": grid(columns, round(columns * height / width), width, height)}, material(case), static(),
              planar=True,
              commands=[cut(curve, **graded(0.005 * half, 1.1), tolerance_m=1e-4 * half)],
              constraints=[hold(edge("BOTTOM"), "y"), hold({"nearest": xy(0.5 * width, 0)}, "xy")],
              loads=[{"edge": {"region": edge("TOP"), "force_n": {"y": 0.2}}}],
              probes=[probe("top", "DISPLACEMENT", edge("TOP")),
                      probe("slit", "OPENING", points=[at(s) for s in arcs]),
                      probe("tip", "OPENING", points=near)])
    case = "05f_slit_large_stretch"
    a = 0.025
    scene(case, "A slit in a strip that is clamped and pulled to 20 %.",
          {"grid": grid(20, 40, 0.1, 0.2)}, material(case), static(0.5, 1.0), planar=True,
          commands=[cut(polyline((0.025, 0.1), (0.075, 0.1)), **graded(0.01 * a, 1.1))],
          constraints=[hold(edge("BOTTOM")), hold(edge("TOP"), displacement_m={"y": 0.04})],
          probes=[probe("top", "REACTION", edge("TOP")), probe("energy", "ENERGY"),
                  probe("slit", "OPENING", points=[(0.05 + share * a, 0.1) for share in (0, 0.25, 0.5, 0.75, 0.9)])])


def catenaries():
    for case in ("06a_catenary", "06b_stretchy_catenary"):
        shape = reference(case)["geometry"]
        length, width = shape["L0"], shape["width"]
        scene(case, "A strip hinged at both ends hangs by its weight; the right end comes in from where it is flat.",
              {"grid": grid(40, 2, length, width)}, material(case), {"static": {"steps": 4}},
              gravity_mps2={"z": -9.81},
              constraints=[hold(edge("LEFT")),
                           hold(edge("RIGHT"), displacement_m={"x": shape["span"] - length})],
              probes=[probe("line", "POSITION", points=[(0.125 * i * length, 0.5 * width) for i in range(9)]),
                      probe("left", "REACTION", edge("LEFT"))])


def cantilevers():
    case = "07a_cantilever_end_shear"
    scene(case, "A strip clamped at one end and lifted at the other.", {"grid": grid(40, 4, 10, 1)}, material(case),
          static(0.001, *[0.05 * i for i in range(1, 21)]), constraints=[hold(edge("LEFT"), slope=True)],
          loads=[{"edge": {"region": edge("RIGHT"), "force_n": {"z": 4}}}],
          probes=[probe("tip", "DISPLACEMENT", edge("RIGHT"))])
    case = "07b_cantilever_end_moment"
    rows = reference(case)["quantities"][0]["table"]["rows"]
    full = 2 * math.pi * 1.2e6 * 0.1 ** 3 / 12 / 12  # N m, 2 pi E I / L: once around
    scene(case, "A strip clamped at one end; a moment at the other bends it into a circle.",
          {"grid": grid(48, 4, 12, 1)}, material(case), static(*[row[0] for row in rows]),
          constraints=[hold(edge("LEFT"), slope=True)],
          loads=[{"moment": {"region": edge("RIGHT"), "moment_nm": full}}],
          probes=[probe("tip", "DISPLACEMENT", edge("RIGHT")), probe("energy", "ENERGY")])
    for case in ("07f_heavy_elastica", "07g_heavy_elastica"):
        shape = reference(case)["geometry"]
        rows = reference(case)["quantities"][0]["table"]["rows"]
        length, width = shape["L"], shape["b"]
        scene(case, "A strip clamped at one end sags by its weight.", {"grid": grid(40, 5, length, width)},
              material(case), static(rows[0][0] / rows[1][0], 1.0), gravity_mps2={"z": -rows[1][1]},
              gravity_history={"times": [0, 1], "factors": [0, 1]},
              constraints=[hold(edge("LEFT"), slope=True)],
              probes=[probe("tip", "DISPLACEMENT", edge("RIGHT")),
                      probe("end", "POSITION", points=[(length, 0.5 * width), (0.975 * length, 0.5 * width)])])


def plate():
    case = "07h_supported_square_plate"
    side = reference(case)["geometry"]["a"]
    borders = [hold(edge(name), "z") for name in ("LEFT", "RIGHT", "BOTTOM", "TOP")]
    scene(case, "A square plate that lies on its border sags a little under a pressure from above.",
          {"grid": grid(32, 32, side, side)}, material(case), static(),
          constraints=[*borders, hold({"nearest": xy(0.5 * side, 0.5 * side)}, "xy"), hold({"nearest": xy(side, 0.5 * side)}, "y")],
          loads=[{"pressure": {"region": {"all": True}, "pressure_pa": -2}}],
          probes=[probe("middle", "DISPLACEMENT", points=[(0.5 * side, 0.5 * side)]), probe("energy", "ENERGY")])


def annulus():
    case = "07c_slit_annular_plate"
    radial, around = cells(10), cells(80)
    material_positions, triangles = [], []
    for j in range(around):
        for i in range(radial + 1):
            r, t = 6 + 4 * i / radial, 2 * math.pi * j / around
            material_positions += [r * math.cos(t), r * math.sin(t)]
            if i == radial:
                continue
            a, b = j * (radial + 1) + i, (j + 1) % around * (radial + 1) + i
            triangles += [a, a + 1, b + 1, a, b + 1, b]
    inner, outer = (6, 0), (10, 0)
    scene(case, "A ring that the cutter slits along a radius; one lip is clamped, the other lifted.",
          {"inline": {"material_positions": material_positions, "triangles": triangles}}, material(case),
          static(*[row[0] for row in reference(case)["quantities"][0]["table"]["rows"]]),
          commands=[cut(polyline((5, 0), (11, 0)))],
          constraints=[hold(line(inner, outer, side="LEFT_OF_LINE"), slope=True)],
          loads=[{"edge": {"region": line(inner, outer, side="RIGHT_OF_LINE"), "force_n": {"z": 3.2}}}],
          probes=[probe("lip", "DISPLACEMENT", points=[inner, outer], side=xy(8, -1))])


def vibrations():
    def modes(count, **about):
        return {"modes": {"count": count, **about}}
    case = "08a_membrane_square"
    borders = [hold(edge(name), stretch_x={"x": 0.01}, stretch_y={"y": 0.01})
               for name in ("LEFT", "RIGHT", "BOTTOM", "TOP")]
    scene(case, "A stretched membrane.", {"grid": grid(32, 32, 0.5, 0.5)}, material(case),
          modes(6, about={}), constraints=borders)
    case = "08b_inplane_free_square"
    scene(case, "A free plate that moves in its plane.", {"grid": grid(24, 24, 0.2, 0.2)}, material(case),
          modes(9), planar=True)
    case = "08c_free_square_plate"
    scene(case, "A free plate.", {"grid": grid(32, 32, 0.2, 0.2)}, material(case), modes(12))
    for case in ("08d_cantilever_square_plate", "08h_cantilever_plate_2_1"):
        shape = reference(case)["geometry"]
        scene(case, "A plate clamped at one edge.", {"grid": grid(32, 32, shape["a"], shape["b"])}, material(case),
              modes(6), constraints=[hold(edge("LEFT"), slope=True)])


def motion():
    case = "09a_free_fall_momentum"
    scene(case, "A sheet thrown up and spun falls freely.", {"grid": grid(6, 6, 0.2, 0.2)}, material(case),
          {"dynamic": {}}, placement={**IN_PLANE, "origin": xy(-0.1, -0.1)}, gravity_mps2={"z": -9.81},
          tick_rate_hz=1000, ticks=1000, integrator=UNDAMPED,
          initial_velocity={"linear_mps": {"x": 1, "z": 2}, "angular_radps": {"z": 5}},
          probes=[probe("centre", "CENTRE_OF_MASS"), probe("momentum", "MOMENTUM"), probe("spin", "ANGULAR_MOMENTUM")])
    case = "09b_pendulum"
    length, angle = 0.5, math.radians(60)
    down = {"x": math.sin(angle), "z": -math.cos(angle)}
    scene(case, "A stiff sheet swings about its upper edge.", {"grid": grid(6, 20, 0.3, length)}, material(case),
          {"dynamic": {}},
          placement={"origin": {"x": length * down["x"], "z": length * down["z"]}, "x_axis": {"y": 1},
                     "y_axis": {"x": -down["x"], "z": -down["z"]}},
          gravity_mps2={"z": -9.81}, tick_rate_hz=805, ticks=2100, integrator=UNDAMPED,
          constraints=[hold(edge("TOP"))],
          probes=[probe("end", "POSITION", edge("BOTTOM")), probe("speed", "VELOCITY", edge("BOTTOM")),
                  probe("energy", "ENERGY")])
    for case in ("09c_inplane_wave", "09f_inplane_wave"):
        shape = reference(case)["geometry"]
        length, width, amplitude = shape["L"], shape["width"], shape["A"]
        period = next(q for q in reference(case)["quantities"] if q["name"] == "period")["value"]
        mesh = mapped(40, 2, lambda a, b, length=length, width=width: (a * length, b * width))
        at = mesh["material_positions"]
        mesh["positions"] = [c for x, y in zip(at[::2], at[1::2])
                             for c in (x + amplitude * math.sin(0.5 * math.pi * x / length), y, 0)]
        per_eighth = max(1, math.floor(1000 * period / 8))
        scene(case, "A strip held at one end rings along its length.", {"inline": mesh}, material(case),
              {"dynamic": {}}, planar=True, tick_rate_hz=8 * per_eighth / period, ticks=8 * per_eighth + 2,
              integrator=UNDAMPED, constraints=[hold(edge("LEFT"), "x")],
              probes=[probe("tip", "DISPLACEMENT", edge("RIGHT")), probe("energy", "ENERGY")])
    case = "09g_spinning_strip"
    shape, given = reference(case)["geometry"], reference(case)["material"]
    half, width, omega = shape["half_length"], shape["width"], shape["omega"]
    k = omega * math.sqrt(given["density"] / given["E"])

    def stretched(s, free_end):
        return math.sin(k * s) / (k * math.cos(k * free_end))
    mesh = mapped(64, 4, lambda a, b: ((2 * a - 1) * half, (b - 0.5) * width))
    at = mesh["material_positions"]
    mesh["positions"] = [c for x, y in zip(at[::2], at[1::2])
                         for c in (stretched(x, half), stretched(y, 0.5 * width), 0)]
    h = half / cells(32)
    scene(case, "A strip spins in its plane, stretched by that.", {"inline": mesh}, material(case), {"dynamic": {}},
          planar=True, tick_rate_hz=1000, ticks=210, integrator=UNDAMPED,
          initial_velocity={"angular_radps": {"z": omega}, "center": {}},
          probes=[probe("point", "POSITION", points=[(share * half, 0) for share in (0.25, 0.5, 0.75, 1.0)]),
                  probe("middle", "STRESS", {"box": {"min": xy(-1.1 * h, -width), "max": xy(1.1 * h, width)}},
                        reduce="MEAN")])


def off_axis():
    case = "10a_thesis_material_45"
    for name, angle in ((case, 45), (case + ".along", 0)):
        scene(name, f"A strip of wool pulled at {angle} degrees to its threads.", {"grid": grid(10, 2, 0.1, 0.02)},
              material(case, direction_rad=math.radians(angle)), static(0.02, 0.2, 1.0), planar=True,
              constraints=[hold(edge("LEFT"), "x"), hold({"nearest": xy(0, 0)}, "y"),
                           hold(edge("RIGHT"), "x", displacement_m={"x": 0.005})],
              probes=[probe("right", "REACTION", edge("RIGHT")),
                      probe("strain", "STRAIN", {"all": True}, reduce="MEAN"),
                      probe("stress", "STRESS", {"all": True}, reduce="MEAN")])


def curtain():
    case = "11a_curtain"
    places = [(0.5, 1.0), (0.5, 0.5), (0.5, 0.0), (0.0, 0.0), (0.0, 0.5), (0.25, 0.75)]
    scene(case, "A sheet hangs from two corners that are moved together; a breath from behind, gone at the end, decides "
          "that it bulges forward.",
          {"grid": grid(24, 24, 1, 1)}, material(case), {"static": {"steps": 10}},
          placement={**IN_PLANE, "origin": xy(-0.5, -1)}, gravity_mps2={"y": -9.81},
          constraints=[hold({"nearest": xy(0, 1)}, displacement_m={"x": 0.1}),
                       hold({"nearest": xy(1, 1)}, displacement_m={"x": -0.1})],
          loads=[{"area": {"region": {"all": True}, "traction_pa": {"z": 1}},
                  "history": {"times": [0, 0.5, 0.9], "factors": [1, 1, 0]}}],
          probes=[probe("point", "DISPLACEMENT", points=places)])


def kirigami():
    case = "13a_kirigami_ECE"
    shape = reference(case)["geometry"]
    width, height, spacing, end = shape["W"], shape["L"], shape["row_spacing"], shape["end"]
    slits_at = []
    for i, kind in enumerate(shape["rows"]):
        y = end + i * spacing
        if kind == "C":
            w = shape["centre_slit"]
            slits_at.append(((0.5 * (width - w), y), (0.5 * (width + w), y)))
        else:
            w = shape["edge_slit"]
            slits_at += [((-0.001, y), (w, y)), ((width + 0.001, y), (width - w, y))]
    # The reference's imperfection, up between the first two rows of slits, down between the others, more to the right,
    # as a push: a weak one while the strip is flat, then a firm one that is gone before the next load of the table.
    push = []
    for y, sign in ((end, 1), (end + spacing, -1)):
        for x, share in ((0, 0.85), (0.5 * width, 1.15)):
            box = {"min": xy(x - 1e-6, y - 1e-6), "max": xy(x + 0.5 * width + 1e-6, y + spacing + 1e-6)}
            push.append({"area": {"region": {"box": box}, "traction_pa": {"z": 500 * sign * share}},
                         "history": {"times": [0.02, 0.025, 0.0275, 0.03], "factors": [0.003, 1, 1, 0]}})
    rows = reference(case)["quantities"][0]["table"]["rows"]
    loads = sorted([row[0] / 0.002 for row in rows] + [0.025, 0.0275])
    cuts = [{"curve": polyline(*ends), **graded(5e-5, 1.3)} for ends in slits_at]
    scene(case, "A strip with rows of slits, pulled: in its plane at first, then it opens out of it.",
          {"grid": grid(20, 20, width, height)}, material(case), static(*loads),
          commands=[{"tick": 1, "command": {"cut_batch": {"cuts": cuts}}}],
          constraints=[hold(edge("BOTTOM"), slope=True), hold(edge("TOP"), slope=True, displacement_m={"y": 0.002})],
          loads=push, probes=[probe("top", "REACTION", edge("TOP")), probe("size", "EXTENT")])


def flap():
    case = "14a_half_slit_flap"
    shape = reference(case)["geometry"]
    length, width, start = shape["L"], shape["W"], shape["slit_start_x"]
    middle = 0.5 * width
    corner, lip = (length, width), (length, middle)
    scene(case, "A plate clamped at one edge, slit from its middle to the other; one flap is lifted.",
          {"grid": grid(48, 32, length, width)}, material(case), static(0.25, 0.5, 0.75, 1.0),
          commands=[cut(polyline((start, middle), (length + 0.01, middle)))],
          constraints=[hold(edge("LEFT"), slope=True)],
          loads=[{"edge": {"region": line(lip, corner), "force_n": {"z": 0.4}}}],
          probes=[probe("upper", "DISPLACEMENT", points=[lip, corner], side=xy(length, width)),
                  probe("lower", "DISPLACEMENT", points=[lip, (length, 0)], side=xy(length, 0))])


def part(case, x0, y0, x1, y1):
    """The reference's other material, in a box."""
    given = reference(case)["other_material"]
    return {"region": {"box": {"min": xy(x0, y0), "max": xy(x1, y1)}},
            "material": material(case, youngs_modulus_pa=given["E"], shear_modulus_pa=given["G"])}


def several_materials():
    held = [hold(edge("BOTTOM"), "y"), hold({"nearest": xy(0, 0)}, "x"),
            hold(edge("TOP"), "y", displacement_m={"y": 0.05})]
    everywhere = [probe("top", "REACTION", edge("TOP")), probe("energy", "ENERGY"),
                  probe("least", "STRESS", {"all": True}, reduce="MIN"),
                  probe("largest", "STRESS", {"all": True}, reduce="MAX")]
    case = "15a_two_materials_in_series"
    scene(case, "A strip of two materials end to end, pulled.", {"grid": grid(4, 8, 0.1, 0.2)}, material(case),
          static(), planar=True, materials=[part(case, 0, 0.1, 0.1, 0.2)], constraints=held,
          probes=[*everywhere, probe("border", "DISPLACEMENT", points=[(0.05, 0.1)]),
                  probe("lower", "STRAIN", points=[(0.03, 0.03)]), probe("upper", "STRAIN", points=[(0.03, 0.17)])])
    case = "15b_two_materials_side_by_side"
    scene(case, "A strip of two materials side by side, pulled.", {"grid": grid(4, 8, 0.1, 0.2)}, material(case),
          static(), planar=True, materials=[part(case, 0.05, 0, 0.1, 0.2)], constraints=held, probes=everywhere)
    case = "15c_stepped_cantilever"
    scene(case, "A strip clamped at one end, its other half a quarter as stiff, lifted there.",
          {"grid": grid(80, 4, 10, 1)}, material(case), static(), materials=[part(case, 5, 0, 10, 1)],
          constraints=[hold(edge("LEFT"), slope=True)], loads=[{"edge": {"region": edge("RIGHT"),
                                                                         "force_n": {"z": 0.004}}}],
          probes=[probe("tip", "DISPLACEMENT", edge("RIGHT")),
                  probe("border", "DISPLACEMENT", points=[(5, 0.5)])])


def circle(radius):
    return {"circle": {"center": {}, "radius_m": radius}}


def quarters(radius):
    """A circle with a vertex on each axis."""
    ends = [(0, radius), (-radius, 0), (0, -radius), (radius, 0)]
    arcs = [{"arc": {"semi_axis_x_m": radius, "semi_axis_y_m": radius, "counter_clockwise": True, "end": xy(*end)}}
            for end in ends]
    return {"path": {"subpaths": [{"start": xy(radius, 0), "segments": arcs, "closed": True}]}}


def ring():
    case = "16a_thick_ring"
    shape = reference(case)["geometry"]
    a, b, thickness = shape["a"], shape["b"], reference(case)["material"]["thickness"]
    mesh = {"boundary": quarters(b), "holes": [quarters(a)], "edge_length_m": (b - a) / cells(20)}
    scene(case, "A ring with a pressure in its hole.", {"outline": mesh}, material(case), static(), planar=True,
          constraints=[hold({"nearest": xy(b, 0)}, "y"), hold({"nearest": xy(-b, 0)}, "y"),
                       hold({"nearest": xy(0, b)}, "x")],
          loads=[{"edge": {"region": {"border": xy(a, 0)}, "normal_npm": -shape["p"] * thickness}}],
          probes=[probe("inner", "DISPLACEMENT", points=[(a, 0), (-a, 0)]),
                  probe("outer", "DISPLACEMENT", points=[(b, 0), (-b, 0)]),
                  probe("stress", "STRESS", points=[(0.15, 0), (-0.15, 0)], reduce="MEAN"),
                  probe("energy", "ENERGY")])


def in_plane_bending():
    case = "16b_in_plane_bending"
    shape = reference(case)["geometry"]
    length, height = shape["L"], shape["H"]
    scene(case, "A strip bent in its plane by a linear traction.", {"grid": grid(160, 16, length, height)},
          material(case), static(), planar=True,
          constraints=[hold(edge("LEFT"), "x"), hold({"nearest": xy(0, 0.5 * height)}, "y")],
          loads=[{"edge": {"region": edge("RIGHT"), "force_npm": {"x": shape["q"]},
                           "factor": {"zero": xy(length, 0.5 * height), "by_y": 2 / height}}}],
          probes=[probe("end", "DISPLACEMENT", points=[(length, 0.5 * height), (length, height)]),
                  probe("energy", "ENERGY")])


def clamped_disc():
    case = "16c_clamped_circular_plate"
    radius = reference(case)["geometry"]["R"]
    scene(case, "A round plate clamped all around its border sags a little under a pressure from above.",
          {"outline": {"boundary": circle(radius), "edge_length_m": radius / cells(32)}}, material(case), static(),
          constraints=[hold({"curve": {"curve": circle(radius)}}, slope=True)],
          loads=[{"pressure": {"region": {"all": True}, "pressure_pa": -4}}],
          probes=[probe("line", "DISPLACEMENT", points=[(0, 0), (0.5 * radius, 0)]), probe("energy", "ENERGY")])


def text_of(whole):
    """One line a member, and of the lists of members."""
    lines = []
    for key, value in whole.items():
        if key in ("commands", "constraints", "loads", "materials", "probes"):
            inner = ",\n  ".join(json.dumps(item) for item in value)
            lines.append(f'{json.dumps(key)}: [\n  {inner}]')
        else:
            lines.append(f"{json.dumps(key)}: {json.dumps(value)}")
    return "{" + ",\n ".join(lines) + "}\n"


def scenes(fineness=1.0):
    """All of them by name, on meshes of so many times as many cells a length; borders stay as fine as they are."""
    global FINENESS
    FINENESS = fineness
    SCENES.clear()
    for make in (patch, uniaxial, clamped_strip, cook, kirsch, holes, slits, catenaries, cantilevers, plate, annulus,
                 vibrations, motion, off_axis, curtain, kirigami, flap, several_materials,
                 ring, in_plane_bending, clamped_disc):
        make()
    return dict(SCENES)


def main():
    stale = []
    for name, whole in scenes().items():
        path = HERE / f"{name}.json"
        if path.exists() and path.read_text() == text_of(whole):
            continue
        stale.append(path.name)
        if sys.argv[1:] != ["--check"]:
            path.write_text(text_of(whole))
    if sys.argv[1:] == ["--check"] and stale:
        sys.exit("not as generate.py writes them: " + ", ".join(stale))


if __name__ == "__main__":
    main()

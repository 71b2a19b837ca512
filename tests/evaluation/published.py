"""Numbers that chapter 5 of the thesis prints, in its tables or in its text alone.

Its machine: a laptop with an Intel Core i7-6700HQ and a GTX 970M. Its frame rates include drawing.
"""

PATTERNS = {  # Tables 5.1 and 5.2, 2,500 vertices, without its optimisation
    "a": {"crossed": (151, 3), "edge_ratio": (4.26, 1.16), "area_ratio": (0.16, 0.17), "condition": (1.37e5, 0.18e5),
          "cg_ms": 68.21, "fps_during": 13.39},
    "b": {"crossed": (152, 6), "edge_ratio": (4.64, 1.38), "area_ratio": (0.37, 0.23), "condition": (5.08e5, 0.70e5),
          "cg_ms": 74.27, "fps_during": 12.48},
    "c": {"crossed": (151, 4), "edge_ratio": (14.08, 7.12), "area_ratio": (0.06, 0.04), "condition": (5.65e5, 0.38e5),
          "cg_ms": 114.04, "fps_during": 8.30},
    "d": {"crossed": (152, 2), "edge_ratio": (14.90, 6.44), "area_ratio": (0.33, 0.26), "condition": (1.42e6, 0.32e6),
          "cg_ms": 193.50, "fps_during": 4.99},
}

LEVELS = {"fps_during": (20.66, 30.35), "crossed": 100, "new": 522}  # section 5.2

DETAILED = {  # Table 5.3
    "single": {"thesis": {"vertices": (225, 302), "fps": (80.09, 60.89, 77.98)},
               "manteaux": {"drawn": (81, 2111), "fps": (60.0, 14.4, 60.0)}},
    "intersecting": {"thesis": {"vertices": (225, 358), "fps": (80.10, 50.64, 57.63)},
                     "manteaux": {"drawn": (4225, 4889), "fps": (45.0, 7.2, 35.7)}},
    "punch": {"thesis": {"vertices": (225, 338), "fps": (80.10, 46.74, 47.56)},
              "manteaux": {"drawn": (4225, 8253), "fps": (60.0, 6.8, 45.0)}},
}

ROOTS = {  # Table 5.4, 6,400 vertices
    "cg": {"condition": (1.87e4, 0.91e5), "cg_ms": (66.26, 71.64)},
    "es-cgm log": {"condition": "infinite", "cg_ms": "infinite"},
    "es-cgm p = 1/2": {"condition": (82.3, 112.0), "cg_ms": (41.67, 50.86)},
}

KIRIGAMI = {"dimension": (7557, 10687), "after_least_fps": 30, "after_baseline_fps": 30.9, "after_as_cgm_fps": 41.2}

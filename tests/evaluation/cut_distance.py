"""Measures how far the lips of a cut lie from the curve that was asked for."""

import numpy


def to_segments(points, segments):
    """Distance of each point from the nearest of some segments, m. Points are n x 2, segments m x 4."""
    start, along = segments[:, :2], segments[:, 2:] - segments[:, :2]
    from_start = points[:, None] - start
    share = numpy.clip((from_start * along).sum(-1) / (along ** 2).sum(-1), 0.0, 1.0)
    return numpy.linalg.norm(from_start - share[..., None] * along, axis=-1).min(1)


def distances(curve, lips):
    """From points of the curve inside the sheet to the lips, and from points of the lips to the curve, m."""
    curve, lips = numpy.asarray(curve, float), numpy.asarray(lips, float).reshape(-1, 4)
    inside = curve[((curve >= 0.0) & (curve <= 1.0)).all(1)]
    if not len(lips):
        return numpy.full(len(inside), numpy.inf), numpy.zeros(0)
    points = numpy.concatenate([lips[:, :2] + share * (lips[:, 2:] - lips[:, :2]) for share in (0.0, 0.25, 0.5, 0.75, 1.0)])
    return to_segments(inside, lips), to_segments(points, numpy.hstack([curve[:-1], curve[1:]]))


def means(rows):
    """Over curves: mean and largest distance of a curve from its cut, and of a cut from its curve; vertices and time."""
    found = [distances(row["curve"], row["lips"]) for row in rows]
    result = {"curve_mean_mm": 1e3 * float(numpy.mean([there.mean() for there, _ in found])),
              "curve_largest_mm": 1e3 * float(max(there.max() for there, _ in found)),
              "lips_largest_mm": 1e3 * float(max(back.max(initial=0.0) for _, back in found)),
              "new_vertices": float(numpy.mean([row["new_vertices"] for row in rows]))}
    if "ms" in rows[0]:
        result["cut_ms"] = float(numpy.mean([row["ms"] for row in rows]))
    return result

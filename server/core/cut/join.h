#pragma once

#include <cstdint>
#include <vector>

#include "server/core/cut/curve.h"
#include "server/core/cut/cut_types.h"
#include "server/core/cut/path_scale.h"
#include "server/core/mesh/triangle_mesh.h"

namespace kerf::cut {

struct JoinOptions {
  double distance = 0.0;  // m; ends closer than this are led on; 0: none is
  double covered = 0.0;   // m; ends closer than this meet anyway, since the cut has a width
  // Ends at exactly these points stay as they are and do not count, as ends of dashes.
  std::vector<Eigen::Vector2d> kept_ends;
};

// Leads open ends of strokes on to the nearest place of another line, a lip or the border, by a straight piece. Only
// ends that lie on the sheet count. An end leads to another open end if that is not much farther. An end whose line
// meets another one within that distance is not open: it only runs over it. No end is led on by more than half the
// length of its own line. The work for each end is bounded: lips and border are looked for among at most
// kMaxTrianglesPerCut triangles in all. The first and the last point of a stroke that was led on to its own other end
// are the same.
JoinReport join_ends(const mesh::TriangleMesh& mesh, const PathScale& scale, const JoinOptions& options,
                     std::vector<Stroke>& strokes);

inline constexpr std::int32_t kMaxTrianglesPerCut = 500'000;

// Counts the ends of strokes that are closer than `distance` (m) to another line and meet none, without a sheet.
// `kept_ends`: as of JoinOptions. Ends within a thousandth of that distance meet.
JoinReport near_ends(std::vector<Stroke> strokes, double distance, std::vector<Eigen::Vector2d> kept_ends);

// Returns the ends of a path's lines that have a straight piece of no length.
std::vector<Eigen::Vector2d> kept_ends(const Curve& curve);

}  // namespace kerf::cut

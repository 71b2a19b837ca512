#pragma once

#include <string>
#include <vector>

#include "server/base/result.h"
#include "server/core/cut/curve.h"
#include "server/service/drawing/drawing.h"
#include "server/service/drawing/placing.h"

namespace kerf::drawing {

inline constexpr std::size_t kMaxReportedGroups = 256;
inline constexpr std::size_t kMaxPreviewPoints = 4'096;
// Ends closer to another line than this share of the drawing's size are near.  -
inline constexpr double kNearEnds = 1.0e-3;

// Shapes that one selector names.
struct GroupReport {
  std::string selector;
  int shapes = 0;         // Shapes that paint something.
  int hidden_shapes = 0;  // Shapes that are hidden or paint nothing.
  double length = 0.0;    // m, of all their lines.
};

// Says what is in a drawing, at true size. The origin is the lower left corner of its page, or what stands for it.
struct Report {
  std::string format;
  Eigen::Vector2d page{0.0, 0.0};  // m; (0, 0): the drawing has none.
  cut::Box box;                    // m, of the lines to cut.
  int lines = 0;                   // Lines to cut.
  int closed_lines = 0;            // Those that end where they begin.
  double length = 0.0;             // m, of all lines to cut.
  // Colours, layers, classes and ids of all shapes, also of those that are not cut: layers first, ids last; at most
  // kMaxReportedGroups.
  std::vector<GroupReport> groups;
  std::vector<std::string> warnings;
  std::vector<cut::Stroke> preview;  // Lines to cut; empty if they need more than kMaxPreviewPoints.
  int near_ends = 0;                 // Ends that nearly meet another line and stay open.
  double nearest_end = 0.0;          // m, shortest distance of these.
};

// Describes a drawing, and what `reading` chooses of it. A drawing of which nothing can be cut has no lines, and a
// warning says why. Errors: those of Selection.
Result<Report> report_on(const Drawing& drawing, const Reading& reading, const std::string& kind,
                         const std::string& field);

}  // namespace kerf::drawing

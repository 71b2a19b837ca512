#pragma once

#include <optional>
#include <string>
#include <vector>

#include "server/base/result.h"
#include "server/core/cut/curve.h"
#include "server/service/drawing/drawing.h"

namespace kerf::drawing {

inline constexpr double kMinUnitM = 1.0e-9;
inline constexpr double kMaxUnitM = 1.0e3;

// Chooses what of a drawing is cut, and how large.
struct Reading {
  std::vector<std::string> only;      // Selectors; see Selection. None: all shapes.
  bool all_shapes = false;            // Shapes that are hidden or paint nothing are cut, too.
  bool true_size = false;             // The drawing keeps its size, and the lower left corner of its page lies at `at`.
  std::optional<Eigen::Vector2d> at;  // m; only with true_size; default (0, 0)
  bool fit_page = false;              // The page is fitted, rather than the outlines.
  double unit = 0.0;                  // m of a unit of the drawing; 0: its own.
  bool dashes = true;                 // Dashed strokes become dashes.
};

// Errors, all kInvalidArgument with the field below `field`: OPTIONS_CONFLICT, UNIT_OUT_OF_RANGE, and those of
// Selection::parse().
Status validate(const Reading& reading, const std::string& field);

struct Placed {
  cut::Path path;                  // Valid.
  std::vector<std::string> notes;  // Parts of the drawing that are not in the path, as text for users.
};

// Returns the lines to cut. With true_size they are in material coordinates. With fit_page the path begins with two
// points, the corners of the page, which cut::fit_into() takes as its extent. Otherwise they are in the drawing's
// frame. `kind`: "SVG" or "DXF", with which reasons begin.
//
// Errors, all kInvalidArgument: SELECTOR_UNMATCHED; PAGE_MISSING; SVG_EMPTY or DXF_EMPTY, if there is nothing to cut;
// those of cut::validate() with the field `field`.
Result<Placed> place(const Drawing& drawing, const Reading& reading, const std::string& kind, const std::string& field);

}  // namespace kerf::drawing

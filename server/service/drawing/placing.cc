#include "server/service/drawing/placing.h"

#include <string>
#include <utility>
#include <variant>

#include "server/core/cut/fit.h"
#include "server/service/drawing/selector.h"

namespace kerf::drawing {
namespace {

using Eigen::Vector2d;

Error conflict(const std::string& what, const std::string& field) {
  return invalid_argument("OPTIONS_CONFLICT", what + "; leave one of them out", field);
}

// A line that is only a point. It is part of a path's extent, and is not cut.
cut::Subpath mark(const Vector2d& at) {
  return {at, {cut::QuadraticTo{at, at}}, false};
}

Error empty(const Drawing& drawing, const std::string& kind, const std::string& field, std::size_t unpainted) {
  std::string why = "there is no outline to cut in the drawing";
  if (unpainted != 0) {
    why += "; " + std::to_string(unpainted) + (unpainted == 1 ? " shape is" : " shapes are") +
           " hidden or paint nothing: all_shapes cuts them, too";
  }
  for (const std::string& line : drawing.not_cut) why += "; " + line;
  return invalid_argument(kind + "_EMPTY", why, field);
}

// Refuses lines that no sheet can hold, and names the shape.
Status check_range(const cut::Subpath& line, const std::string& name, const std::string& field) {
  const cut::Curve alone = cut::Path{{line}};
  const Status status = cut::validate(alone);
  if (status.ok() || (status.error().reason != "CURVE_OUT_OF_RANGE" && status.error().reason != "CURVE_NOT_FINITE")) {
    return Nothing{};
  }
  return invalid_argument(status.error().reason,
                          name + " reaches beyond 10 km: a number of it is too large, or the unit is another", field);
}

std::size_t num_segments(const Shape& shape) {
  std::size_t count = 0;
  for (const cut::Subpath& line : shape.lines) count += line.segments.size();
  return count;
}

}  // namespace

Status validate(const Reading& reading, const std::string& field) {
  if (reading.at && !reading.true_size) {
    return invalid_argument("OPTIONS_CONFLICT", field + ".at needs true_size", field + ".at");
  }
  if (reading.true_size && reading.fit_page) {
    return conflict("true_size and fit_page both place the drawing", field + ".fit_page");
  }
  if (reading.unit != 0.0 && !(reading.unit >= kMinUnitM && reading.unit <= kMaxUnitM)) {
    return invalid_argument("UNIT_OUT_OF_RANGE", field + ".unit_m must be in 1e-9..1e3 m", field + ".unit_m");
  }
  const Result<Selection> selection = Selection::parse(reading.only, field);
  return selection.ok() ? Status(Nothing{}) : Status(selection.error());
}

Result<Placed> place(const Drawing& drawing, const Reading& reading, const std::string& kind,
                     const std::string& field) {
  KERF_TRY_ASSIGN(const Selection selection, Selection::parse(reading.only, field + ".reading"));
  KERF_TRY_ASSIGN(const std::vector<bool> chosen, selection.choose(drawing));
  Placed placed;
  placed.notes = drawing.not_cut;
  if (reading.fit_page) {
    if (!drawing.page) {
      return invalid_argument("PAGE_MISSING", "the drawing has no page that could be fitted; leave fit_page out",
                              field + ".reading.fit_page");
    }
    placed.path.subpaths = {mark(drawing.page->low), mark(drawing.page->high)};
  }
  const std::size_t num_marks = placed.path.subpaths.size();
  std::size_t segments = num_marks;
  std::size_t unpainted = 0;
  for (std::size_t i = 0; i < drawing.shapes.size(); ++i) {
    const Shape& shape = drawing.shapes[i];
    if (!chosen[i] || shape.lines.empty()) continue;
    if (!shape.is_painted && !reading.all_shapes) {
      ++unpainted;
      continue;
    }
    segments += num_segments(shape);
    if (segments > cut::kMaxPathSegments) {
      return invalid_argument("CURVE_TOO_LONG",
                              "the drawing has more than " + std::to_string(cut::kMaxPathSegments) +
                                  " segments to cut; simplify it or cut parts of it",
                              field);
    }
    for (const cut::Subpath& line : shape.lines) KERF_TRY(check_range(line, shape.name, field));
    placed.path.subpaths.insert(placed.path.subpaths.end(), shape.lines.begin(), shape.lines.end());
  }
  if (placed.path.subpaths.size() == num_marks) return empty(drawing, kind, field, unpainted);
  if (unpainted != 0) {
    placed.notes.push_back(kind + ": " + std::to_string(unpainted) +
                           " x shape that is hidden or paints nothing: not cut");
  }
  cut::Curve curve(std::move(placed.path));
  if (const Status status = cut::validate(curve); !status.ok()) {
    Error error = status.error();
    error.field = field;
    return error;
  }
  if (reading.true_size) {
    Vector2d corner = Vector2d::Zero();
    if (drawing.page) {
      corner = drawing.page->low;
    } else if (!drawing.has_origin) {
      corner = cut::extent(curve).low;
    }
    cut::shift(reading.at.value_or(Vector2d::Zero()) - corner, curve);
    if (const Status status = cut::validate(curve); !status.ok()) {
      Error error = status.error();
      error.field = field;
      return error;
    }
  }
  placed.path = std::get<cut::Path>(std::move(curve));
  return placed;
}

}  // namespace kerf::drawing

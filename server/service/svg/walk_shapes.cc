#include <algorithm>
#include <array>
#include <optional>
#include <utility>

#include "server/base/text_encoding.h"
#include "server/service/drawing/arc_length.h"
#include "server/service/drawing/dash.h"
#include "server/service/svg/scanner.h"
#include "server/service/svg/shapes.h"
#include "server/service/svg/walk.h"

// Adds the outlines of shapes, with their dashes, and reports what is left out.
namespace kerf::svg {

namespace {

constexpr const char* kUnreadLength = "length that cannot be read";

// Lengths of shapes that are attributes alone, and no properties.
constexpr std::array<std::string_view, 4> kLengths{"x1", "y1", "x2", "y2"};

}  // namespace

void Walk::report_lengths(const pugi::xml_node& node, const Declared& declared) {
  const auto check = [this](std::string_view name, std::string_view value) {
    if (value == "auto" || value.empty() || value == "inherit" || value == "initial" || value == "unset") return;
    if (parse_length(value, 1.0)) return;
    report(kUnreadLength);
    if (!first_length_error_.empty()) return;
    first_length_error_ = std::string(name) + "=\"" + shortened(value, 40) + "\"";
  };
  for (const std::string_view name : kLengths) check(name, trimmed(node.attribute(name.data()).value()));
  for (auto each = static_cast<std::size_t>(Property::kX); each <= static_cast<std::size_t>(Property::kRy); ++each) {
    check(kPropertyNames[each], trimmed(declared.values[each]));
  }
  check("stroke-width", trimmed(declared[Property::kStrokeWidth]));
}

void Walk::note_extent(const cut::Subpath& line) {
  if (canvas_.isEmpty()) return;
  beyond_ = beyond_ || !canvas_.contains(line.start);
  for (const cut::Segment& segment : line.segments) beyond_ = beyond_ || !canvas_.contains(drawing::end_of(segment));
}

Status Walk::add_shape(const pugi::xml_node& node, std::string_view name, const Declared& declared,
                       const Context& context) {
  const PathData outline = outline_of(node, name, declared, context.viewport, drawing::kMaxSegments);
  const Seen what = seen(context.style, context.viewport);
  if (!outline.error.empty() && what.is_painted) {
    report(std::string(name) + " with an error in its data, cut up to it");
    if (first_path_error_.empty()) first_path_error_ = outline.error;
  }
  if (context.to_sheet.linear.determinant() == 0.0) return Nothing{};  // A singular map shows nothing.
  drawing::Shape shape;
  const std::string id = node.attribute("id").value();
  shape.name = std::string(name) + (id.empty() ? "" : " #" + shortened(id, 60));
  shape.is_painted = what.is_painted;
  shape.stroke = what.stroke;
  if (name != "line") shape.fill = what.fill;
  shape.group = context.group;
  const bool fixed_stroke = declared[Property::kVectorEffect].find("non-scaling-stroke") != std::string::npos;
  KERF_TRY(add_lines(outline, node, fixed_stroke, context, shape));
  if (!shape.lines.empty()) drawing_.shapes.push_back(std::move(shape));
  return Nothing{};
}

Status Walk::add_lines(const PathData& outline, const pugi::xml_node& node, bool fixed_stroke, const Context& context,
                       drawing::Shape& shape) {
  std::vector<cut::Subpath> lines;
  double length = 0.0;
  const double path_length = length_of(node, "pathLength", 0.0, 0.0);
  std::optional<drawing::Dashes> dashes;
  if (with_dashes_) dashes = dashes_of(context.style, context.viewport);
  const Affine before = fixed_stroke ? context.to_sheet : Affine();
  const Affine after = fixed_stroke ? Affine() : context.to_sheet;
  for (const cut::Subpath& subpath : outline.subpaths) {
    cut::Subpath line = transformed(subpath, dashes ? before : context.to_sheet);
    if (line.segments.empty()) continue;
    if (dashes && path_length > 0.0) length += drawing::length_of(line);
    lines.push_back(std::move(line));
  }
  if (dashes) {
    const double unit = path_length > 0.0 ? length / path_length : fixed_stroke ? pixel_ : 1.0;
    for (double& each : dashes->lengths) each *= unit;
    dashes->offset *= unit;
    if (!(drawing::total_length(*dashes) > 0.0)) dashes.reset();
  }
  for (const cut::Subpath& line : lines) {
    std::vector<cut::Subpath> parts;
    if (dashes) parts = drawing::dashed(line, *dashes, drawing::kMaxSegments - num_segments_);
    if (!dashes) parts.push_back(line);
    for (cut::Subpath& part : parts) {
      if (dashes) part = transformed(part, after);
      num_segments_ += part.segments.size();
      if (num_segments_ > drawing::kMaxSegments) {
        return resource_exhausted("SVG_TOO_COMPLEX",
                                  "the drawing has more than " + std::to_string(drawing::kMaxSegments) +
                                      " segments, with those of its dashes; simplify it",
                                  "cut.curve.svg");
      }
      if (shape.is_painted) note_extent(part);
      shape.lines.push_back(std::move(part));
    }
  }
  return Nothing{};
}

std::vector<std::string> Walk::not_cut() const {
  std::vector<std::string> lines;
  for (const auto& [kind, count] : kinds_) {
    std::string line = "SVG: " + std::to_string(count) + " x " + kind;
    if (kind.find("in its data") != std::string::npos) {
      line += " (the first at " + first_path_error_ + ")";
    } else if (kind == kUnreadLength) {
      line += " (the first: " + first_length_error_ + "): not applied";
    } else {
      const bool is_applied = kind.find("reference") == 0 || kind.find("encoding") == 0 || kind.find("property") == 0 ||
                              kind.find("colour") == 0 || kind.find("style sheet") != std::string::npos ||
                              kind.find("viewBox") == 0;
      line += is_applied ? ": not applied" : ": not cut";
    }
    lines.push_back(std::move(line));
  }
  if (beyond_) lines.emplace_back("SVG: it reaches beyond its viewport; nothing was clipped");
  return lines;
}

}  // namespace kerf::svg

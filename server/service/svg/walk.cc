#include "server/service/svg/walk.h"

#include <algorithm>
#include <array>
#include <utility>

#include "server/service/svg/scanner.h"
#include "server/service/svg/shapes.h"
#include "server/service/svg/svg.h"

namespace kerf::svg {
namespace {

using Eigen::Vector2d;

template <std::size_t count>
bool contains(const std::array<std::string_view, count>& names, std::string_view name) {
  return std::find(names.begin(), names.end(), name) != names.end();
}

// Elements that are neither drawn nor reported: they hold references, descriptions or paint.
constexpr std::array<std::string_view, 15> kSilent{
    "defs",   "title",  "desc", "metadata", "linearGradient", "radialGradient", "stop",   "symbol",
    "marker", "cursor", "view", "pattern",  "clipPath",       "mask",           "filter",
};
// Elements that a viewer draws, or that change its drawing, but without an outline; they are reported.
constexpr std::array<std::string_view, 13> kReported{
    "text",         "image",    "foreignObject", "script",           "style",
    "switch",       "flowRoot", "animate",       "animateTransform", "animateMotion",
    "animateColor", "textPath", "set",
};
// Properties that hide part of an outline or add to it.
constexpr std::array<std::string_view, 7> kReferences{
    "clip-path", "mask", "filter", "marker", "marker-start", "marker-mid", "marker-end",
};

Error too_complex(const std::string& what) {
  return resource_exhausted("SVG_TOO_COMPLEX", "the drawing has " + what + "; simplify it", "cut.curve.svg");
}

Error too_deep() {
  return too_complex("elements nested more than " + std::to_string(kMaxDepth) + " deep");
}

// Returns the reference in "url(#id)", that is "#id"; empty if the value is no reference.
std::string reference_in(const std::string& value) {
  if (value.compare(0, 4, "url(") != 0) return {};
  std::string_view inside = trimmed(std::string_view(value).substr(4, value.find(')') - 4));
  if (!inside.empty() && (inside.front() == '"' || inside.front() == '\'')) {
    inside = inside.substr(1, inside.size() - 2);
  }
  return std::string(inside);
}

}  // namespace

Walk::Walk(const pugi::xml_node& root, const Affine& to_sheet) : root_(root), to_sheet_(to_sheet) {
  const std::string_view name = root.name();
  const std::size_t colon = name.find(':');
  if (colon != std::string_view::npos) prefix_ = std::string(name.substr(0, colon + 1));
}

Status Walk::run() {
  KERF_TRY(index_ids());
  Context context;
  context.to_sheet = to_sheet_;
  // Without width and height the outermost viewport is as large as the view box, or 300 x 150 as in HTML.
  const std::optional<Rectangle> view_box = parse_view_box(root_.attribute("viewBox").value());
  const Vector2d natural = view_box && view_box->size.minCoeff() > 0.0 ? view_box->size : Vector2d(300.0, 150.0);
  context.viewport.size = natural;
  const Vector2d size(length_of(root_, "width", natural.x(), natural.x()),
                      length_of(root_, "height", natural.y(), natural.y()));
  if (view_box || (root_.attribute("width") && root_.attribute("height"))) {
    const double slack = 1.0e-6 * size.maxCoeff();
    canvas_.extend(to_sheet_(Vector2d(-slack, -slack)));
    canvas_.extend(to_sheet_(Vector2d(size + Vector2d::Constant(slack))));
  }
  return visit(root_, context);
}

std::string_view Walk::name_of(const pugi::xml_node& node) const {
  const std::string_view name = node.name();
  const std::size_t colon = name.find(':');
  if (colon == std::string_view::npos) return prefix_.empty() ? name : std::string_view();
  const std::string_view prefix = name.substr(0, colon + 1);
  return prefix == prefix_ || prefix == "svg:" ? name.substr(colon + 1) : std::string_view();
}

pugi::xml_node Walk::target_of(const std::string& reference) const {
  if (reference.empty() || reference.front() != '#') return {};
  const auto found = ids_.find(reference.substr(1));
  return found == ids_.end() ? pugi::xml_node() : found->second;
}

// Avoids recursion, because nothing has bounded the depth yet.
Status Walk::index_ids() {
  int count = 0;
  int depth = 0;
  for (pugi::xml_node node = root_; node;) {
    if (++count > kMaxElements) return too_complex("more than " + std::to_string(kMaxElements) + " elements");
    if (const pugi::xml_attribute id = node.attribute("id")) ids_.emplace(id.value(), node);
    if (node.first_child()) {
      node = node.first_child();
      if (++depth > kMaxDepth) return too_deep();
      continue;
    }
    while (node != root_ && !node.next_sibling()) {
      node = node.parent();
      --depth;
    }
    if (node == root_) break;
    node = node.next_sibling();
  }
  return Nothing{};
}

// Counts every visit, so elements repeated by `use` count each time.
Status Walk::count_visit(const pugi::xml_node& node) {
  for (const pugi::xml_attribute& attribute : node.attributes()) {
    num_bytes_ += std::string_view(attribute.value()).size();
  }
  if (num_bytes_ > kMaxAttributeBytes) return too_complex("too much in attributes that `use` repeats");
  if (++num_visited_ <= kMaxElements) return Nothing{};
  return too_complex("more than " + std::to_string(kMaxElements) + " elements, with what `use` repeats");
}

Status Walk::visit(const pugi::xml_node& node, const Context& inherited) {
  KERF_TRY(count_visit(node));
  if (inherited.depth > kMaxDepth) return too_deep();
  const std::string_view name = name_of(node);
  if (name.empty() || contains(kSilent, name)) return Nothing{};
  Context context = inherited;
  ++context.depth;
  if (property(node, "display") == "none") return Nothing{};
  const std::string visibility = property(node, "visibility");
  if (!visibility.empty() && visibility != "inherit") context.visible = visibility == "visible";
  if (!enter(node, context)) return Nothing{};
  report_references(node);
  open_.push_back(node);
  const Status status = visit_shown(node, name, context);
  open_.pop_back();
  return status;
}

bool Walk::enter(const pugi::xml_node& node, Context& context) {
  if (property(node, "transform") != trimmed(node.attribute("transform").value())) {
    report("element with a transform in its style");
    return false;
  }
  const pugi::xml_attribute attribute = node.attribute("transform");
  if (!attribute) return true;
  const std::optional<Affine> map =
      trimmed(attribute.value()) == "none" ? Affine() : parse_transform(attribute.value());
  if (!map) {
    report("element with a transform that cannot be read");
    return false;
  }
  context.to_sheet = context.to_sheet * *map;
  return true;
}

Status Walk::visit_shown(const pugi::xml_node& node, std::string_view name, const Context& context) {
  if (name == "g" || name == "a") return visit_children(node, context);
  if (name == "svg") return visit_viewport(node, node, context);
  if (name == "use") return visit_use(node, context);
  if (name == "switch") return visit_switch(node, context);
  if (is_shape(name)) return context.visible ? add_shape(node, name, context) : Nothing{};
  if (name == "style") {
    if (!trimmed(node.child_value()).empty()) report("style sheet");
  } else if (contains(kReported, name)) {
    report(std::string(name) + " element");
  } else {
    report("unknown element");
  }
  return Nothing{};
}

Status Walk::visit_children(const pugi::xml_node& node, const Context& context) {
  for (const pugi::xml_node& child : node.children()) {
    if (child.type() != pugi::node_element) continue;
    KERF_TRY(visit(child, context));
  }
  return Nothing{};
}

// Visits the first child that needs no extension and no language other than English.
Status Walk::visit_switch(const pugi::xml_node& node, const Context& context) {
  for (const pugi::xml_node& child : node.children()) {
    KERF_TRY(count_visit(child));
    if (child.type() != pugi::node_element || name_of(child).empty()) continue;
    const std::string_view language = child.attribute("systemLanguage").value();
    const bool english = language.empty() || language.substr(0, 2) == "en";
    if (child.attribute("requiredExtensions") || !english) continue;
    return visit(child, context);
  }
  return Nothing{};
}

Status Walk::visit_viewport(const pugi::xml_node& node, const pugi::xml_node& sized_by, const Context& context) {
  const Vector2d outer = context.viewport.size;
  const auto side = [&](const char* name, double whole) {
    return length_of(sized_by, name, whole, length_of(node, name, whole, whole));
  };
  Rectangle viewport{{0.0, 0.0}, {side("width", outer.x()), side("height", outer.y())}};
  if (node != root_) {
    viewport.corner = {length_of(node, "x", outer.x(), 0.0), length_of(node, "y", outer.y(), 0.0)};
  }
  if (!(viewport.size.minCoeff() > 0.0)) return Nothing{};  // An empty viewport shows nothing.
  Context inner = context;
  const pugi::xml_attribute attribute = node.attribute("viewBox");
  const std::optional<Rectangle> view_box = parse_view_box(attribute.value());
  if (attribute && !view_box) report("viewBox that cannot be read");
  if (view_box) {
    if (!(view_box->size.minCoeff() > 0.0)) return Nothing{};  // An empty view box shows nothing.
    inner.to_sheet =
        inner.to_sheet * view_box_transform(*view_box, viewport, node.attribute("preserveAspectRatio").value());
    inner.viewport.size = view_box->size;
  } else {
    inner.to_sheet = inner.to_sheet * translation(viewport.corner);
    inner.viewport.size = viewport.size;
  }
  return visit_children(node, inner);
}

Status Walk::visit_use(const pugi::xml_node& node, const Context& context) {
  const pugi::xml_attribute plain = node.attribute("href");
  const std::string reference(trimmed((plain ? plain : node.attribute("xlink:href")).value()));
  const pugi::xml_node target = target_of(reference);
  if (!target) {
    const bool outside = !reference.empty() && reference.front() != '#';
    report(outside ? "external reference" : "use of a missing element");
    return Nothing{};
  }
  if (std::find(open_.begin(), open_.end(), target) != open_.end()) {
    report("use of an element that contains it");
    return Nothing{};
  }
  Context inner = context;
  inner.to_sheet = inner.to_sheet * translation({length_of(node, "x", context.viewport.width(), 0.0),
                                                 length_of(node, "y", context.viewport.height(), 0.0)});
  const std::string_view name = name_of(target);
  if (name != "symbol" && name != "svg") return visit(target, inner);
  if (inner.depth > kMaxDepth) return too_deep();
  if (property(target, "display") == "none") return Nothing{};
  ++inner.depth;
  open_.push_back(target);
  const Status status = visit_viewport(target, node, inner);
  open_.pop_back();
  return status;
}

void Walk::report_references(const pugi::xml_node& node) {
  for (const std::string_view name : kReferences) {
    const std::string value = property(node, name);
    if (!value.empty() && value != "none" && value != "inherit") report("reference to a " + std::string(name));
  }
  for (const char* paint : {"fill", "stroke"}) {
    const pugi::xml_node painted = target_of(reference_in(property(node, paint)));
    if (painted && name_of(painted) == "pattern") report("reference to a pattern");
  }
}

Status Walk::add_shape(const pugi::xml_node& node, std::string_view name, const Context& context) {
  PathData outline = outline_of(node, name, context.viewport, cut::kMaxPathSegments);
  if (!outline.error.empty()) {
    report(std::string(name) + " with an error in its data, cut up to it");
    if (first_path_error_.empty()) first_path_error_ = outline.error;
  }
  const Affine& map = context.to_sheet;
  if (map.linear.determinant() == 0.0) return Nothing{};  // A singular map shows nothing.
  for (const cut::Subpath& subpath : outline.subpaths) {
    cut::Subpath placed = transformed(subpath, map);
    if (placed.segments.empty()) continue;
    num_segments_ += placed.segments.size();
    if (num_segments_ > cut::kMaxPathSegments) {
      return invalid_argument("CURVE_TOO_LONG",
                              "the drawing has more than " + std::to_string(cut::kMaxPathSegments) +
                                  " segments; simplify it or cut parts of it",
                              "cut.curve.svg");
    }
    if (!canvas_.isEmpty()) {
      beyond_ = beyond_ || !canvas_.contains(placed.start);
      for (const cut::Segment& segment : placed.segments) {
        const Vector2d end = std::visit([](const auto& each) { return each.end; }, segment);
        beyond_ = beyond_ || !canvas_.contains(end);
      }
    }
    path_.subpaths.push_back(std::move(placed));
  }
  return Nothing{};
}

std::vector<std::string> Walk::not_cut() const {
  std::vector<std::string> lines;
  for (const auto& [kind, count] : kinds_) {
    std::string line = "SVG: " + std::to_string(count) + " x " + kind;
    if (kind.find("in its data") != std::string::npos) {
      line += " (the first at " + first_path_error_ + ")";
    } else {
      line += kind.find("reference") == 0 || kind == "style sheet" || kind.find("viewBox") == 0 ? ": not applied"
                                                                                                : ": not cut";
    }
    lines.push_back(std::move(line));
  }
  if (beyond_) lines.emplace_back("SVG: it reaches beyond its viewport; nothing was clipped");
  return lines;
}

}  // namespace kerf::svg

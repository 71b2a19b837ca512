#include "server/service/svg/walk.h"

#include <algorithm>
#include <array>
#include <utility>

#include "server/service/svg/css_scanner.h"
#include "server/service/svg/layer_names.h"
#include "server/service/svg/scanner.h"
#include "server/service/svg/shapes.h"

namespace kerf::svg {
namespace {

using Eigen::Vector2d;

template <std::size_t count>
bool contains(const std::array<std::string_view, count>& names, std::string_view name) {
  return std::find(names.begin(), names.end(), name) != names.end();
}

// Elements that are neither drawn nor reported: they hold references, descriptions or paint.
constexpr std::array<std::string_view, 16> kSilent{
    "defs",   "title",  "desc", "metadata", "linearGradient", "radialGradient", "stop",   "symbol",
    "marker", "cursor", "view", "pattern",  "clipPath",       "mask",           "filter", "style",
};
// Elements that a viewer draws, or that change its drawing, but without an outline; they are reported.
constexpr std::array<std::string_view, 11> kReported{
    "text",          "image",        "foreignObject", "script", "flowRoot", "animate", "animateTransform",
    "animateMotion", "animateColor", "textPath",      "set",
};
// Properties that hide part of an outline or add to it.
constexpr std::array<Property, 7> kReferences{
    Property::kClipPath,    Property::kMask,      Property::kFilter,    Property::kMarker,
    Property::kMarkerStart, Property::kMarkerMid, Property::kMarkerEnd,
};
constexpr std::string_view kSvgNamespace = "http://www.w3.org/2000/svg";
constexpr double kPixelM = 0.0254 / 96.0;
constexpr int kMaxGroupDepth = 256;  // Layers, classes and ids around a shape that can choose it.

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

// Returns the transform with the properties translate, rotate and scale before it, as one list of functions.
std::string transform_of(const Declared& declared) {
  std::string all;
  for (const Property property : {Property::kTranslate, Property::kRotate, Property::kScale}) {
    const std::string& value = declared[property];
    if (value.empty() || value == "none") continue;
    all += std::string(kPropertyNames[static_cast<std::size_t>(property)]) + "(" + value + ") ";
  }
  const std::string& transform = declared[Property::kTransform];
  return transform == "none" ? all : all + transform;
}

// Returns the attribute href, with whatever prefix it has.
pugi::xml_attribute href_of(const pugi::xml_node& node) {
  if (const pugi::xml_attribute plain = node.attribute("href")) return plain;
  for (const pugi::xml_attribute& attribute : node.attributes()) {
    if (std::string_view(attribute.name()).ends_with(":href")) return attribute;
  }
  return {};
}

}  // namespace

Walk::Walk(const pugi::xml_node& root, const ReadOptions& options) : root_(root), with_dashes_(options.dashes) {
  const std::string_view name = root.name();
  const std::size_t colon = name.find(':');
  if (colon != std::string_view::npos) prefix_ = std::string(name.substr(0, colon + 1));
  has_plain_names_ = prefix_.empty() || std::string_view(root.attribute("xmlns").value()) == kSvgNamespace;
  drawing_.format = "SVG";
  lay_out(options);
}

void Walk::lay_out(const ReadOptions& options) {
  // Without width and height the outermost viewport is as large as the view box, or 300 x 150 as in HTML.
  const std::optional<Rectangle> view_box = parse_view_box(root_.attribute("viewBox").value());
  const bool has_box = view_box && view_box->size.minCoeff() > 0.0;
  const Vector2d natural = has_box ? view_box->size : Vector2d(300.0, 150.0);
  const std::optional<double> width = parse_length(root_.attribute("width").value(), natural.x());
  const std::optional<double> height = parse_length(root_.attribute("height").value(), natural.y());
  root_size_ = {width.value_or(natural.x()), height.value_or(natural.y())};
  // A single side keeps the proportions of the view box.
  if (has_box && width && !height) root_size_.y() = *width * natural.y() / natural.x();
  if (has_box && height && !width) root_size_.x() = *height * natural.x() / natural.y();
  pixel_ = kPixelM;
  if (options.unit > 0.0) {
    pixel_ = options.unit;
    if (has_box && root_size_.minCoeff() > 0.0) {
      const Affine map =
          view_box_transform(*view_box, {{0.0, 0.0}, root_size_}, root_.attribute("preserveAspectRatio").value());
      pixel_ = options.unit / map.linear(0, 0);
    }
  }
  to_sheet_.linear = Vector2d(pixel_, -pixel_).asDiagonal();
  if (!(has_box || (width && height)) || !(root_size_.minCoeff() > 0.0)) return;
  drawing_.page = cut::Box{to_sheet_(Vector2d(0.0, root_size_.y())), to_sheet_(Vector2d(root_size_.x(), 0.0))};
  const double slack = 1.0e-6 * root_size_.maxCoeff();
  canvas_.extend(to_sheet_(Vector2d(-slack, -slack)));
  canvas_.extend(to_sheet_(Vector2d(root_size_ + Vector2d::Constant(slack))));
}

Status Walk::run() {
  KERF_TRY(index());
  cascade_.emplace(rules_);
  Context context;
  context.to_sheet = to_sheet_;
  context.viewport.size = root_size_;
  return visit(root_, context);
}

drawing::Drawing Walk::take_drawing() {
  drawing_.not_cut = not_cut();
  return std::move(drawing_);
}

std::string_view Walk::name_of(const pugi::xml_node& node) const {
  const std::string_view name = node.name();
  const std::size_t colon = name.find(':');
  if (colon == std::string_view::npos) return has_plain_names_ ? name : std::string_view();
  const std::string_view prefix = name.substr(0, colon + 1);
  return prefix == prefix_ || prefix == "svg:" ? name.substr(colon + 1) : std::string_view();
}

pugi::xml_node Walk::target_of(const std::string& reference) const {
  if (reference.empty() || reference.front() != '#') return {};
  const auto found = ids_.find(reference.substr(1));
  return found == ids_.end() ? pugi::xml_node() : found->second;
}

// Avoids recursion, because nothing has bounded the depth yet.
Status Walk::index() {
  int count = 0;
  int depth = 0;
  for (pugi::xml_node node = root_; node;) {
    if (++count > kMaxElements) return too_complex("more than " + std::to_string(kMaxElements) + " elements");
    if (const pugi::xml_attribute id = node.attribute("id")) ids_.emplace(id.value(), node);
    if (name_of(node) == "style") index_style(node);
    has_inkscape_layers_ = has_inkscape_layers_ || is_inkscape_layer(node);
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
  if (rules_.too_many) return too_complex("more than " + std::to_string(kMaxCssSelectors) + " selectors in its style");
  for (int i = 0; i < rules_.imports; ++i) report("external style sheet");
  for (int i = 0; i < rules_.unread; ++i) report("rule of a style sheet that is not understood");
  return Nothing{};
}

void Walk::index_style(const pugi::xml_node& node) {
  const std::string type = lower(trimmed(node.attribute("type").value()));
  std::string text;
  for (const pugi::xml_node& child : node.children()) text += child.value();
  if (trimmed(text).empty() || !applies_to_screen(node.attribute("media").value())) return;
  if (!type.empty() && type != "text/css") return report("style sheet");
  parse_style_sheet(text, rules_);
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
  KERF_TRY_ASSIGN(Declared declared, cascade_->declared(node, context.variables));
  for (const Property paint : {Property::kFill, Property::kStroke}) take_fallback(declared, paint);
  apply(declared, context.style);
  KERF_TRY(enter_groups(node, context));
  if (!enter(declared, context)) return Nothing{};
  if (context.style.is_shown) report_references(declared);
  open_.push_back(node);
  const Status status = visit_content(node, name, declared, context);
  open_.pop_back();
  return status;
}

Status Walk::enter_groups(const pugi::xml_node& node, Context& context) {
  const auto add = [&](std::string selector) {
    if (context.group_depth >= kMaxGroupDepth) return;
    drawing_.groups.push_back({std::move(selector), context.group});
    context.group = static_cast<int>(drawing_.groups.size()) - 1;
    ++context.group_depth;
  };
  for (const std::string& layer : layer_names(node, root_, has_inkscape_layers_)) add("layer=" + layer);
  const std::string_view id = node.attribute("id").value();
  if (!id.empty()) add("#" + std::string(id));
  for_each_word(node.attribute("class").value(), [&](std::string_view word) { add("." + std::string(word)); });
  if (drawing_.groups.size() <= kMaxGroups) return Nothing{};
  return too_complex("more than " + std::to_string(kMaxGroups) + " classes and ids");
}

bool Walk::enter(const Declared& declared, Context& context) {
  const std::string transform = transform_of(declared);
  if (transform.empty()) return true;
  const std::optional<Affine> map = parse_transform(transform);
  if (!map) {
    if (context.style.is_shown) report("element with a transform that cannot be read");
    return false;
  }
  const std::string& origin = declared[Property::kTransformOrigin];
  if (origin.empty()) {
    context.to_sheet = context.to_sheet * *map;
    return true;
  }
  const std::optional<Vector2d> about = parse_origin(origin, context.viewport);
  const std::string& box = declared[Property::kTransformBox];
  if (!about || (!box.empty() && box != "view-box")) {
    if (context.style.is_shown) report("element with a transform about a point that cannot be read");
    return false;
  }
  context.to_sheet = context.to_sheet * (translation(*about) * *map * translation(-*about));
  return true;
}

Status Walk::visit_content(const pugi::xml_node& node, std::string_view name, const Declared& declared,
                           const Context& context) {
  if (context.style.is_shown && (name == "svg" || name == "use" || is_shape(name))) report_lengths(node, declared);
  if (name == "g" || name == "a") return visit_children(node, context);
  if (name == "svg") return visit_viewport(node, node, context);
  if (name == "use") return visit_use(node, context);
  if (name == "switch") return visit_switch(node, context);
  if (is_shape(name)) return add_shape(node, name, declared, context);
  if (!context.style.is_shown) return Nothing{};
  report(contains(kReported, name) ? std::string(name) + " element" : "unknown element");
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
  Rectangle viewport{{0.0, 0.0}, root_size_};
  if (node != root_) {
    viewport.size = {side("width", outer.x()), side("height", outer.y())};
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
  const Eigen::AlignedBox2d around = canvas_;
  if (node != root_) narrow_canvas(node, viewport, context);
  const Status status = visit_children(node, inner);
  canvas_ = around;
  return status;
}

void Walk::narrow_canvas(const pugi::xml_node& node, const Rectangle& viewport, const Context& context) {
  const std::string_view style = node.attribute("style").value();
  const bool is_open = std::string_view(node.attribute("overflow").value()) == "visible" ||
                       style.find("overflow:visible") != std::string_view::npos ||
                       style.find("overflow: visible") != std::string_view::npos;
  if (is_open) return;
  Eigen::AlignedBox2d box;
  const double slack = 1.0e-6 * viewport.size.maxCoeff();
  for (const Vector2d& corner :
       {Vector2d(-slack, -slack), Vector2d(viewport.size.x() + slack, -slack),
        Vector2d(-slack, viewport.size.y() + slack), Vector2d(viewport.size.array() + slack)}) {
    box.extend(context.to_sheet(Vector2d(viewport.corner + corner)));
  }
  canvas_ = canvas_.isEmpty() ? box : canvas_.intersection(box);
}

Status Walk::visit_use(const pugi::xml_node& node, const Context& context) {
  const std::string reference(trimmed(href_of(node).value()));
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
  KERF_TRY_ASSIGN(const Declared declared, cascade_->declared(target, inner.variables));
  apply(declared, inner.style);
  KERF_TRY(enter_groups(target, inner));
  ++inner.depth;
  open_.push_back(target);
  const Status status = visit_viewport(target, node, inner);
  open_.pop_back();
  return status;
}

// Replaces a reference to a paint that is missing by what stands after it, if anything does.
void Walk::take_fallback(Declared& declared, Property paint) const {
  std::string& value = declared.values[static_cast<std::size_t>(paint)];
  if (value.compare(0, 4, "url(") != 0 || target_of(reference_in(value))) return;
  const std::size_t close = value.find(')');
  const std::string fallback(close == std::string::npos ? "" : trimmed(std::string_view(value).substr(close + 1)));
  if (!fallback.empty()) value = fallback;
}

void Walk::report_references(const Declared& declared) {
  for (int i = 0; i < declared.unresolved; ++i) report("reference to a variable of a style sheet that is not there");
  for (const Property property : kReferences) {
    const std::string& value = declared[property];
    if (value.empty() || value == "none" || value == "inherit") continue;
    report("reference to a " + std::string(kPropertyNames[static_cast<std::size_t>(property)]));
  }
  for (const Property property : {Property::kOffsetPath, Property::kMaskImage, Property::kZoom}) {
    const std::string& value = declared[property];
    if (value.empty() || value == "none" || value == "normal" || value == "1") continue;
    report("property " + std::string(kPropertyNames[static_cast<std::size_t>(property)]));
  }
  if (is_unread_dashes(declared[Property::kDashArray])) report("property stroke-dasharray that cannot be read");
  for (const Property paint : {Property::kFill, Property::kStroke}) {
    if (is_unread_colour(declared[paint])) report("colour that cannot be read, of a shape or group");
    const pugi::xml_node painted = target_of(reference_in(declared[paint]));
    if (painted && name_of(painted) == "pattern") report("reference to a pattern");
  }
}

}  // namespace kerf::svg

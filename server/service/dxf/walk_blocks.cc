#include "server/service/dxf/walk_blocks.h"

#include <algorithm>
#include <array>
#include <optional>
#include <utility>

#include "server/core/cut/arc.h"
#include "server/service/dxf/colours.h"
#include "server/service/dxf/dxf.h"
#include "server/service/dxf/shapes_of.h"

namespace kerf::dxf {
namespace {

using drawing::Affine;
using Eigen::Vector2d;

constexpr int kByBlock = 0;
constexpr int kByLayer = 256;

// Entities that are no part of a drawing's lines, and are not missed.
constexpr std::array<std::string_view, 5> kUnseen{"ATTDEF", "SEQEND", "VIEWPORT", "VERTEX", "ACAD_PROXY_ENTITY"};

Error dxf_too_complex(const std::string& what) {
  return resource_exhausted("DXF_TOO_COMPLEX", "the drawing has " + what + "; simplify it", "cut.curve.dxf");
}

Affine mirrored() {
  Affine map;
  map.linear(0, 0) = -1.0;
  return map;
}

}  // namespace

BlockWalk::BlockWalk(const File& file, double scale) : file_(file), scale_(scale) {
  drawing_.format = file.version.empty() ? "DXF" : "DXF " + file.version;
  drawing_.has_origin = true;
}

Status BlockWalk::run() {
  Context context;
  context.map.linear *= scale_;
  return visit_all(file_.entities, context);
}

drawing::Drawing BlockWalk::take_drawing() {
  for (const auto& [kind, count] : kinds_) {
    const bool is_applied = kind.find("line type") != std::string::npos;
    drawing_.not_cut.push_back("DXF: " + std::to_string(count) + " x " + kind +
                               (is_applied ? ": not applied" : ": not cut"));
  }
  return std::move(drawing_);
}

Status BlockWalk::visit_all(const std::vector<Entity>& entities, const Context& context) {
  for (std::size_t i = 0; i < entities.size(); ++i) {
    std::vector<Entity> vertices;
    const Entity& entity = entities[i];
    // Vertices and attributes follow the entity that they belong to.
    if (entity.type == "POLYLINE" || entity.integer(66, 0) == 1) {
      while (i + 1 < entities.size() && (entities[i + 1].type == "VERTEX" || entities[i + 1].type == "ATTRIB")) {
        if (entities[++i].type == "VERTEX") vertices.push_back(entities[i]);
      }
    }
    KERF_TRY(visit(entity, vertices, context));
  }
  return Nothing{};
}

BlockWalk::Context BlockWalk::entered(const Entity& entity, const Context& context) const {
  Context placed = context;
  const std::string layer = name_of(entity.text(8));
  if (placed.layer.empty() || layer != "0") placed.layer = layer;
  const auto found = file_.layers.find(key_of(placed.layer));
  const bool is_known = found != file_.layers.end();
  placed.is_hidden = context.is_hidden || entity.integer(60, 0) == 1 || (is_known && found->second.is_frozen);
  placed.is_off = is_known && found->second.is_off;
  const int index = entity.integer(62, kByLayer);
  if (entity.has(420)) {
    placed.colour = static_cast<std::uint32_t>(entity.integer(420, 0)) & 0xffffffU;
  } else if (index == kByLayer) {
    placed.colour = is_known ? found->second.colour : 0;
  } else if (index != kByBlock) {
    placed.colour = indexed_colour(std::abs(index));
  }
  return placed;
}

bool BlockWalk::is_dashed(const Entity& entity, const std::string& layer) const {
  const std::string type = key_of(entity.text(6));
  if (type.empty() || type == "BYLAYER") {
    const auto found = file_.layers.find(key_of(layer));
    return found != file_.layers.end() && found->second.is_dashed;
  }
  return type != "CONTINUOUS" && type != "BYBLOCK";
}

int BlockWalk::group_of(const std::string& layer) {
  const auto [found, is_new] = group_of_layer_.try_emplace(layer, static_cast<int>(drawing_.groups.size()));
  if (is_new) drawing_.groups.push_back({"layer=" + layer, drawing::kNoGroup});
  return found->second;
}

Status BlockWalk::visit(const Entity& entity, const std::vector<Entity>& vertices, const Context& context) {
  if (++num_visited_ > kMaxEntities) {
    return dxf_too_complex("more than " + std::to_string(kMaxEntities) + " entities, with those of its blocks");
  }
  if (std::find(kUnseen.begin(), kUnseen.end(), entity.type) != kUnseen.end()) return Nothing{};
  if (entity.integer(67, 0) == 1) {
    report("entity of a paper layout");
    return Nothing{};
  }
  Context placed = entered(entity, context);
  if (has_own_plane(entity.type) || entity.type == "ELLIPSE") {
    const Plane plane = plane_of(entity);
    if (plane == Plane::kOther) {
      report("entity that is not parallel to the plane of the drawing");
      return Nothing{};
    }
    if (plane == Plane::kMirrored && has_own_plane(entity.type)) placed.map = placed.map * mirrored();
  }
  if (entity.type == "INSERT") return insert(entity, placed);
  const std::optional<std::vector<cut::Subpath>> outline = outline_of(entity, vertices);
  const bool is_seen = !placed.is_hidden && !placed.is_off;
  if (outline && outline->empty() && is_seen) report(name_of(entity.type) + " that has no length or is faulty");
  if (outline) return add_shape(entity, *outline, placed);
  if (is_seen) report(name_of(entity.type));
  return Nothing{};
}

Status BlockWalk::add_shape(const Entity& entity, const std::vector<cut::Subpath>& outline, const Context& placed) {
  drawing::Shape shape;
  shape.name = name_of(entity.type) + " at line " + std::to_string(entity.line);
  shape.is_painted = !placed.is_hidden && !placed.is_off;
  shape.stroke = placed.colour;
  shape.group = group_of(placed.layer);
  for (const cut::Subpath& subpath : outline) {
    cut::Subpath line = drawing::transformed(subpath, placed.map);
    if (line.segments.empty()) continue;
    num_segments_ += line.segments.size();
    shape.lines.push_back(std::move(line));
  }
  if (num_segments_ > drawing::kMaxSegments) {
    return dxf_too_complex("more than " + std::to_string(drawing::kMaxSegments) + " segments");
  }
  if (shape.lines.empty()) return Nothing{};
  if (shape.is_painted && is_dashed(entity, placed.layer)) report("line type with dashes");
  drawing_.shapes.push_back(std::move(shape));
  return Nothing{};
}

Status BlockWalk::insert(const Entity& entity, const Context& placed) {
  const auto found = file_.blocks.find(key_of(entity.text(2)));
  if (found == file_.blocks.end()) {
    report("insertion of a block that is missing");
    return Nothing{};
  }
  if (placed.depth >= kMaxDepth)
    return dxf_too_complex("blocks nested more than " + std::to_string(kMaxDepth) + " deep");
  const std::string_view name = found->first;
  if (std::find(open_.begin(), open_.end(), name) != open_.end()) {
    report("insertion of a block into itself");
    return Nothing{};
  }
  Affine turned;
  const Vector2d direction = cut::unit_vector_of_degrees(entity.number(50, 0.0));
  turned.linear << direction.x(), -direction.y(), direction.y(), direction.x();
  turned.shift = entity.point(10);
  Affine scaled;
  scaled.linear = Vector2d(entity.number(41, 1.0), entity.number(42, 1.0)).asDiagonal();
  const int columns = std::clamp(entity.integer(70, 1), 1, kMaxEntities);
  const int rows = std::clamp(entity.integer(71, 1), 1, kMaxEntities);
  Context inner = placed;
  ++inner.depth;
  open_.push_back(name);
  Status status = Nothing{};
  for (int row = 0; row < rows && status.ok(); ++row) {
    for (int column = 0; column < columns && status.ok(); ++column) {
      if (++num_visited_ > kMaxEntities) {
        status = dxf_too_complex("more than " + std::to_string(kMaxEntities) + " entities, with those of its blocks");
        break;
      }
      const Vector2d step(column * entity.number(44, 0.0), row * entity.number(45, 0.0));
      inner.map =
          placed.map * (turned * drawing::translation(step) * scaled * drawing::translation(-found->second.base));
      status = visit_all(found->second.entities, inner);
    }
  }
  open_.pop_back();
  return status;
}

}  // namespace kerf::dxf

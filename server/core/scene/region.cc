#include "server/core/scene/region.h"

#include <algorithm>
#include <array>
#include <limits>

#include <Eigen/Geometry>

#include "server/base/overloaded.h"
#include "server/base/sort_unique.h"
#include "server/core/scene/curve_region.h"

namespace kerf::scene {

namespace {

double size_of(const mesh::TriangleMesh& mesh) {
  return mesh.bounding_box().sizes().maxCoeff();
}

bool is_within(const ComponentPlace* component, const Eigen::Vector2d& at) {
  return component == nullptr || component->room.contains(at);
}

mesh::VertexId nearest_vertex(const mesh::TriangleMesh& mesh, const ComponentPlace* component,
                              const Eigen::Vector2d& corner) {
  mesh::VertexId nearest = mesh::kNone;
  double smallest = std::numeric_limits<double>::infinity();
  for (mesh::VertexId v = 0; v < mesh.num_vertices(); ++v) {
    if (!mesh.has_material(v) || !is_within(component, mesh.rest_position(v))) continue;
    const double distance = (mesh.rest_position(v) - corner).squaredNorm();
    if (distance < smallest) {
      smallest = distance;
      nearest = v;
    }
  }
  return nearest;
}

void add_in_box(const mesh::TriangleMesh& mesh, const Eigen::AlignedBox2d& box, std::vector<mesh::VertexId>& found) {
  for (mesh::VertexId v = 0; v < mesh.num_vertices(); ++v) {
    if (mesh.has_material(v) && box.contains(mesh.rest_position(v))) found.push_back(v);
  }
}

void add_nearest(const mesh::TriangleMesh& mesh, const ComponentPlace* component, const Eigen::Vector2d& point,
                 std::vector<mesh::VertexId>& found) {
  const mesh::VertexId nearest = nearest_vertex(mesh, component, point);
  if (nearest != mesh::kNone) found.push_back(nearest);
}

void add_edge(const mesh::TriangleMesh& mesh, const ComponentPlace* component, RegionEdge edge,
              std::vector<mesh::VertexId>& found) {
  Eigen::AlignedBox2d bounds = mesh.bounding_box();
  if (component != nullptr) {
    bounds = {component->extent.min() + component->offset, component->extent.max() + component->offset};
  }
  if (edge == RegionEdge::kCorners || edge == RegionEdge::kTopCorners) {
    using Corner = Eigen::AlignedBox2d::CornerType;
    add_nearest(mesh, component, bounds.corner(Corner::TopLeft), found);
    add_nearest(mesh, component, bounds.corner(Corner::TopRight), found);
    if (edge == RegionEdge::kTopCorners) return;
    add_nearest(mesh, component, bounds.corner(Corner::BottomLeft), found);
    add_nearest(mesh, component, bounds.corner(Corner::BottomRight), found);
    return;
  }
  const double slack = kRegionTolerance * size_of(mesh);
  Eigen::AlignedBox2d strip(bounds.min().array() - slack, bounds.max().array() + slack);
  if (edge == RegionEdge::kTop) strip.min().y() = bounds.max().y() - slack;
  if (edge == RegionEdge::kBottom) strip.max().y() = bounds.min().y() + slack;
  if (edge == RegionEdge::kLeft) strip.max().x() = bounds.min().x() + slack;
  if (edge == RegionEdge::kRight) strip.min().x() = bounds.max().x() - slack;
  add_in_box(mesh, strip, found);
}

Status add_listed(const mesh::TriangleMesh& mesh, const std::vector<mesh::VertexId>& ids, const std::string& field,
                  std::vector<mesh::VertexId>& found) {
  for (std::size_t k = 0; k < ids.size(); ++k) {
    if (ids[k] < 0 || ids[k] >= mesh.num_vertices()) {
      const std::string path = field + ".vertices.vertices[" + std::to_string(k) + "]";
      return invalid_argument("UNKNOWN_VERTEX",
                              path + " is " + std::to_string(ids[k]) + "; the sheet has vertices 0.." +
                                  std::to_string(mesh.num_vertices() - 1),
                              path);
    }
    if (!mesh.has_material(ids[k])) {
      const std::string path = field + ".vertices.vertices[" + std::to_string(k) + "]";
      return invalid_argument("UNKNOWN_VERTEX",
                              path + " is " + std::to_string(ids[k]) + ", whose material a cut removed", path);
    }
    found.push_back(ids[k]);
  }
  return Nothing{};
}

// Returns true if the material around v lies on the side of v to which the vector `left` points.
bool is_on_left(const mesh::TriangleMesh& mesh, mesh::VertexId v, const Eigen::Vector2d& left,
                std::vector<mesh::TriangleId>& fan) {
  double sum = 0.0;
  mesh.triangles_around(v, fan);
  for (const mesh::TriangleId t : fan) {
    for (const mesh::VertexId w : mesh.vertices(t)) {
      sum += left.dot(mesh.rest_position(w) - mesh.rest_position(v));
    }
  }
  return sum > 0.0;
}

double reach_of(const MaterialLine& line, double size) {
  return line.within > 0.0 ? line.within : kRegionTolerance * size;
}

double distance_to(const MaterialLine& line, const Eigen::Vector2d& at) {
  const Eigen::Vector2d along = line.b - line.a;
  const double squared = along.squaredNorm();
  const Eigen::Vector2d from_a = at - line.a;
  const double t = squared > 0.0 ? std::clamp(along.dot(from_a) / squared, 0.0, 1.0) : 0.0;
  return (from_a - t * along).norm();
}

void add_along(const mesh::TriangleMesh& mesh, const MaterialLine& line, std::vector<mesh::VertexId>& found) {
  const double within = reach_of(line, size_of(mesh));
  std::vector<mesh::TriangleId> fan;
  for (mesh::VertexId v = 0; v < mesh.num_vertices(); ++v) {
    if (!mesh.has_material(v)) continue;
    if (distance_to(line, mesh.rest_position(v)) > within) continue;
    const bool wants_left = line.side == MaterialLine::Side::kLeft;
    const Eigen::Vector2d along = line.b - line.a;
    const Eigen::Vector2d left(-along.y(), along.x());
    if (line.side != MaterialLine::Side::kBoth && is_on_left(mesh, v, left, fan) != wants_left) continue;
    found.push_back(v);
  }
}

void add_along(const mesh::TriangleMesh& mesh, const MaterialCurve& curve, std::vector<mesh::VertexId>& found) {
  const CurveRegion region(curve, mesh);
  const bool wants_left = curve.side == MaterialLine::Side::kLeft;
  std::vector<mesh::TriangleId> fan;
  for (mesh::VertexId v = 0; v < mesh.num_vertices(); ++v) {
    if (!mesh.has_material(v)) continue;
    const Eigen::Vector2d at = mesh.rest_position(v);
    if (!region.reaches(at)) continue;
    if (curve.side != MaterialLine::Side::kBoth && is_on_left(mesh, v, region.left_at(at), fan) != wants_left) continue;
    found.push_back(v);
  }
}

Eigen::Vector2d centroid(const mesh::TriangleMesh& mesh, mesh::TriangleId slot) {
  const std::array<mesh::VertexId, 3> corner = mesh.vertices(slot);
  return (mesh.rest_position(corner[0]) + mesh.rest_position(corner[1]) + mesh.rest_position(corner[2])) / 3.0;
}

// Returns true if a place is within reach of a line and on its wanted side. `size`: larger side of the sheet, m.
bool holds(const MaterialLine& line, const Eigen::Vector2d& at, double size) {
  if (distance_to(line, at) > reach_of(line, size)) return false;
  const Eigen::Vector2d along = line.b - line.a;
  const double left = Eigen::Vector2d(-along.y(), along.x()).dot(at - line.a);
  return line.side == MaterialLine::Side::kBoth || (line.side == MaterialLine::Side::kLeft) == (left > 0.0);
}

// Returns the solid slots for whose centroid holds() is true, ascending.
template <typename Holds>
std::vector<mesh::TriangleId> triangles_where(const mesh::TriangleMesh& mesh, const Holds& holds) {
  std::vector<mesh::TriangleId> found;
  for (mesh::TriangleId t = 0; t < mesh.num_triangle_slots(); ++t) {
    if (mesh.is_solid(t) && holds(centroid(mesh, t))) found.push_back(t);
  }
  return found;
}

std::vector<mesh::TriangleId> triangles_along(const mesh::TriangleMesh& mesh, const MaterialCurve& curve) {
  const CurveRegion region(curve, mesh);
  const bool wants_left = curve.side == MaterialLine::Side::kLeft;
  return triangles_where(mesh, [&](const Eigen::Vector2d& at) {
    if (!region.reaches(at)) return false;
    return curve.side == MaterialLine::Side::kBoth || (region.offset(at) > 0.0) == wants_left;
  });
}

// Appends the vertices of a region, with repeats. `path`: the path of the region.
Status add_region(const mesh::TriangleMesh& mesh, const PlacedRegion& region, const std::string& path,
                  std::vector<mesh::VertexId>& found) {
  const auto add_all = [&found](const std::vector<mesh::VertexId>& vertices) {
    found.insert(found.end(), vertices.begin(), vertices.end());
  };
  const auto add_whole = [&] {
    for (mesh::VertexId v = 0; v < mesh.num_vertices(); ++v) {
      if (mesh.has_material(v)) found.push_back(v);
    }
  };
  const ComponentPlace* const within = region.within;
  const std::size_t num_before = found.size();
  Status done = Nothing{};
  std::visit(Overloaded{
                 [&](RegionEdge edge) { add_edge(mesh, within, edge, found); },
                 [&](const MaterialBox& box) { add_in_box(mesh, Eigen::AlignedBox2d(box.min, box.max), found); },
                 [&](const MaterialLine& line) { add_along(mesh, line, found); },
                 [&](const NearestVertex& nearest) { add_nearest(mesh, within, nearest.point, found); },
                 [&](const MaterialCurve& curve) { add_along(mesh, curve, found); },
                 [&](const NearestBorder& border) { add_all(border_vertices(mesh, border.point, within)); },
                 [&](const std::vector<mesh::VertexId>& ids) { done = add_listed(mesh, ids, path, found); },
                 [&](const WholeSheet& /*whole*/) { add_whole(); },
             },
             region.shape);
  const auto is_elsewhere = [&](mesh::VertexId v) { return !is_within(within, mesh.rest_position(v)); };
  const auto first = found.begin() + static_cast<std::ptrdiff_t>(num_before);
  if (within != nullptr) found.erase(std::remove_if(first, found.end(), is_elsewhere), found.end());
  return done;
}

bool has(const std::vector<mesh::VertexId>& sorted, mesh::VertexId v) {
  return std::binary_search(sorted.begin(), sorted.end(), v);
}

}  // namespace

Result<std::vector<mesh::VertexId>> find_vertices(const mesh::TriangleMesh& mesh, const PlacedRegion& region,
                                                  const std::string& field) {
  std::vector<mesh::VertexId> found;
  KERF_TRY(add_region(mesh, region, field, found));
  sort_unique(found);
  return found;
}

Error no_vertex_in(const std::string& field) {
  return invalid_argument("REGION_EMPTY",
                          field +
                              " contains no vertex of the sheet; move it onto the sheet, give a line or a curve a "
                              "larger within_m, or leave it out",
                          field);
}

Result<std::vector<mesh::VertexId>> find_pins(const mesh::TriangleMesh& mesh,
                                              std::span<const ComponentPlace> components,
                                              const std::vector<Region>& regions, const std::string& field) {
  std::vector<mesh::VertexId> found;
  for (std::size_t i = 0; i < regions.size(); ++i) {
    const std::string path = field + "[" + std::to_string(i) + "]";
    const std::size_t before = found.size();
    KERF_TRY_ASSIGN(const PlacedRegion placed, place(regions[i], components, path));
    KERF_TRY(add_region(mesh, placed, path, found));
    if (found.size() == before) return no_vertex_in(path);
  }
  sort_unique(found);
  return found;
}

void forget_removed(const mesh::TriangleMesh& mesh, PlacedRegion& region) {
  if (auto* listed = std::get_if<std::vector<mesh::VertexId>>(&region.shape)) {
    std::erase_if(*listed, [&](mesh::VertexId v) { return v >= mesh.num_vertices() || !mesh.has_material(v); });
  }
}

std::vector<BorderEdge> edges_in(const mesh::TriangleMesh& mesh, const std::vector<mesh::VertexId>& region) {
  std::vector<BorderEdge> edges;
  for (mesh::TriangleId t = 0; t < mesh.num_triangle_slots(); ++t) {
    if (!mesh.is_solid(t)) continue;
    const std::array<mesh::VertexId, 3> corner = mesh.vertices(t);
    for (std::size_t k = 0; k < 3; ++k) {
      const mesh::VertexId a = corner[(k + 1) % 3];
      const mesh::VertexId b = corner[(k + 2) % 3];
      const int edge = static_cast<int>(k);
      if (!has(region, a) || !has(region, b) || mesh.neighbour(t, edge) != mesh::kNone) continue;
      edges.push_back({t, edge, {a, b}, (mesh.rest_position(a) - mesh.rest_position(b)).norm()});
    }
  }
  return edges;
}

std::vector<mesh::TriangleId> triangles_in(const mesh::TriangleMesh& mesh, const std::vector<mesh::VertexId>& region) {
  std::vector<mesh::TriangleId> triangles;
  for (mesh::TriangleId t = 0; t < mesh.num_triangle_slots(); ++t) {
    if (!mesh.is_solid(t)) continue;
    const std::array<mesh::VertexId, 3> corner = mesh.vertices(t);
    if (has(region, corner[0]) && has(region, corner[1]) && has(region, corner[2])) triangles.push_back(t);
  }
  return triangles;
}

Result<std::vector<mesh::TriangleId>> find_triangles(const mesh::TriangleMesh& mesh, const PlacedRegion& region,
                                                     const std::string& field) {
  using Triangles = Result<std::vector<mesh::TriangleId>>;
  const auto refuse = [&field]() -> Triangles {
    return invalid_argument("REGION_WITHOUT_TRIANGLES",
                            field + " names vertices, not triangles; give a box, a line, a curve, vertices or all",
                            field);
  };
  const auto within = [&mesh](const auto& holds) -> Triangles { return triangles_where(mesh, holds); };
  const auto listed = [&]() -> Triangles {
    KERF_TRY_ASSIGN(std::vector<mesh::VertexId> vertices, find_vertices(mesh, region, field));
    return triangles_in(mesh, vertices);
  };
  Triangles found = std::visit(
      Overloaded{
          [&](RegionEdge /*edge*/) { return refuse(); },
          [&](const MaterialBox& box) {
            return within([closed = Eigen::AlignedBox2d(box.min, box.max)](const Eigen::Vector2d& at) {
              return closed.contains(at);
            });
          },
          [&](const std::vector<mesh::VertexId>& /*ids*/) { return listed(); },
          [&](const MaterialLine& line) {
            return within([&, size = size_of(mesh)](const Eigen::Vector2d& at) { return holds(line, at, size); });
          },
          [&](const NearestVertex& /*nearest*/) { return refuse(); },
          [&](const WholeSheet& /*whole*/) { return within([](const Eigen::Vector2d& /*at*/) { return true; }); },
          [&](const MaterialCurve& curve) -> Triangles { return triangles_along(mesh, curve); },
          [&](const NearestBorder& /*border*/) { return refuse(); },
      },
      region.shape);
  if (found.ok()) {
    std::erase_if(*found, [&](mesh::TriangleId t) { return !is_within(region.within, centroid(mesh, t)); });
  }
  return found;
}

double rest_area(const mesh::TriangleMesh& mesh, mesh::TriangleId slot) {
  const std::array<mesh::VertexId, 3> corner = mesh.vertices(slot);
  const Eigen::Vector2d a = mesh.rest_position(corner[1]) - mesh.rest_position(corner[0]);
  const Eigen::Vector2d b = mesh.rest_position(corner[2]) - mesh.rest_position(corner[0]);
  return 0.5 * (a.x() * b.y() - a.y() * b.x());
}

void inherit_pins(const mesh::MeshEdit& edit, std::vector<mesh::VertexId>& pinned) {
  const std::size_t num_before = pinned.size();
  const auto was_pinned = [&](mesh::VertexId v) {
    return std::binary_search(pinned.begin(), pinned.begin() + static_cast<std::ptrdiff_t>(num_before), v);
  };
  for (const mesh::VertexSource& added : edit.added_vertices) {
    bool all = true;
    for (int k = 0; k < 3; ++k) {
      if (added.weights[k] > 0.0 && !was_pinned(added.sources[static_cast<std::size_t>(k)])) all = false;
    }
    if (all) pinned.push_back(added.vertex);  // new ids are higher than all old ones, so the order is kept
  }
  std::erase_if(pinned, [&](mesh::VertexId v) {
    return std::binary_search(edit.removed_vertices.begin(), edit.removed_vertices.end(), v);
  });
}

}  // namespace kerf::scene

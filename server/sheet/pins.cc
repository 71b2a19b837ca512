#include "server/sheet/pins.h"

#include <algorithm>
#include <array>
#include <limits>

#include <Eigen/Geometry>

namespace kerf::sheet {

namespace {

constexpr double kEdgeTolerance = 1.0e-9;  // -, of the larger side of the bounding box

mesh::VertexId nearest_vertex(const mesh::TriangleMesh& mesh, const Eigen::Vector2d& corner) {
  mesh::VertexId nearest = mesh::kNone;
  double smallest = std::numeric_limits<double>::infinity();
  for (mesh::VertexId v = 0; v < mesh.num_vertices(); ++v) {
    if (!mesh.has_material(v)) continue;
    const double distance = (mesh.rest_position(v) - corner).squaredNorm();
    if (distance < smallest) {
      smallest = distance;
      nearest = v;
    }
  }
  return nearest;
}

void add_in_box(const mesh::TriangleMesh& mesh, const Eigen::AlignedBox2d& box, std::vector<mesh::VertexId>& pinned) {
  for (mesh::VertexId v = 0; v < mesh.num_vertices(); ++v) {
    if (mesh.has_material(v) && box.contains(mesh.rest_position(v))) pinned.push_back(v);
  }
}

void add_edge(const mesh::TriangleMesh& mesh, PinEdge edge, std::vector<mesh::VertexId>& pinned) {
  const Eigen::AlignedBox2d& bounds = mesh.bounding_box();
  if (edge == PinEdge::kCorners || edge == PinEdge::kTopCorners) {
    using Corner = Eigen::AlignedBox2d::CornerType;
    pinned.push_back(nearest_vertex(mesh, bounds.corner(Corner::TopLeft)));
    pinned.push_back(nearest_vertex(mesh, bounds.corner(Corner::TopRight)));
    if (edge == PinEdge::kTopCorners) return;
    pinned.push_back(nearest_vertex(mesh, bounds.corner(Corner::BottomLeft)));
    pinned.push_back(nearest_vertex(mesh, bounds.corner(Corner::BottomRight)));
    return;
  }
  const double slack = kEdgeTolerance * bounds.sizes().maxCoeff();
  Eigen::AlignedBox2d strip(bounds.min().array() - slack, bounds.max().array() + slack);
  if (edge == PinEdge::kTop) strip.min().y() = bounds.max().y() - slack;
  if (edge == PinEdge::kBottom) strip.max().y() = bounds.min().y() + slack;
  if (edge == PinEdge::kLeft) strip.max().x() = bounds.min().x() + slack;
  if (edge == PinEdge::kRight) strip.min().x() = bounds.max().x() - slack;
  add_in_box(mesh, strip, pinned);
}

Status add_listed(const mesh::TriangleMesh& mesh, const std::vector<mesh::VertexId>& ids, const std::string& field,
                  std::vector<mesh::VertexId>& pinned) {
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
                              path + " is " + std::to_string(ids[k]) + ", whose material a cut took away", path);
    }
    pinned.push_back(ids[k]);
  }
  return Nothing{};
}

}  // namespace

Result<std::vector<mesh::VertexId>> find_pinned(const mesh::TriangleMesh& mesh, const std::vector<PinRegion>& regions,
                                                const std::string& field) {
  std::vector<mesh::VertexId> pinned;
  for (std::size_t i = 0; i < regions.size(); ++i) {
    if (const auto* edge = std::get_if<PinEdge>(&regions[i])) {
      add_edge(mesh, *edge, pinned);
    } else if (const auto* box = std::get_if<MaterialBox>(&regions[i])) {
      add_in_box(mesh, Eigen::AlignedBox2d(box->min, box->max), pinned);
    } else {
      const auto& ids = std::get<std::vector<mesh::VertexId>>(regions[i]);
      if (Status s = add_listed(mesh, ids, field + "[" + std::to_string(i) + "]", pinned); !s) return s.error();
    }
  }
  std::sort(pinned.begin(), pinned.end());
  pinned.erase(std::unique(pinned.begin(), pinned.end()), pinned.end());
  return pinned;
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
    if (all) pinned.push_back(added.vertex);  // ids are consecutive beyond all old ones, so the order holds
  }
  std::erase_if(pinned, [&](mesh::VertexId v) {
    return std::binary_search(edit.removed_vertices.begin(), edit.removed_vertices.end(), v);
  });
}

}  // namespace kerf::sheet

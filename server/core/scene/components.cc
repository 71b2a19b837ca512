#include "server/core/scene/components.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <sstream>
#include <utility>

#include "server/base/overloaded.h"
#include "server/core/cut/fit.h"
#include "server/core/mesh/build/mesh_import.h"
#include "server/core/scene/field_checks.h"

namespace kerf::scene {

namespace {

// All over the largest side of all components.  -
constexpr double kGap = 0.1;          // gap between a component and those before, if no offset is given
constexpr double kLeastGap = 1.0e-3;  // least distance between two components
constexpr double kAlone = 1.0;        // room around a component that is the only one

constexpr double kShareOfGap = 0.4;  // -, part of the distance to the nearest component that belongs to the room

Eigen::AlignedBox2d moved(const Eigen::AlignedBox2d& box, const Eigen::Vector2d& by) {
  return {box.min() + by, box.max() + by};
}

// Returns the distance of two boxes along x or y, whichever is larger, m; negative if they overlap.
double distance_between(const Eigen::AlignedBox2d& a, const Eigen::AlignedBox2d& b) {
  return (b.min() - a.max()).cwiseMax(a.min() - b.max()).maxCoeff();
}

std::string metres_text(double value) {
  std::ostringstream out;
  out << value << " m";
  return out.str();
}

// Builds the components, gives each a place in the plane, and joins their meshes.
class ComponentJoin {
 public:
  explicit ComponentJoin(const SheetConfig& config) : config_(config) {}

  Result<BuiltMesh> run() {
    for (std::size_t i = 0; i < config_.components.size(); ++i) {
      if (const Status built = build(i); !built.ok()) {
        return in_component(built.error(), i, config_.components[i].name);
      }
    }
    for (const ComponentPlace& place : places_) largest_ = std::max(largest_, place.extent.sizes().maxCoeff());
    for (std::size_t i = 0; i < places_.size(); ++i) {
      if (const Status placed = move_apart(i); !placed.ok()) return in_component(placed.error(), i, places_[i].name);
    }
    make_rooms();
    return join();
  }

 private:
  Status build(std::size_t index) {
    const Component& component = config_.components[index];
    const auto too_many = [&](std::int64_t count) {
      return resource_exhausted("TOO_MANY_VERTICES", "with this component the sheet has at least " +
                                                         std::to_string(count) + " vertices; its limit is " +
                                                         std::to_string(config_.max_vertices));
    };
    constexpr std::int32_t kLeast = 3;
    if (num_vertices_ + kLeast > config_.max_vertices) return too_many(num_vertices_ + kLeast);
    KERF_TRY_ASSIGN(SourceMesh built, build_source(component.mesh, config_.max_vertices - num_vertices_));
    const std::int64_t count = std::int64_t{num_vertices_} + built.mesh.num_vertices();
    if (count > config_.max_vertices) return too_many(count);
    ComponentPlace place;
    place.name = component.name;
    place.extent = built.mesh.bounding_box();
    place.first_vertex = num_vertices_;
    place.num_vertices = built.mesh.num_vertices();
    num_vertices_ += place.num_vertices;
    num_triangles_ += built.mesh.num_solid_triangles();
    places_.push_back(std::move(place));
    for (const std::string& note : built.notes) notes_.push_back(component.name + ": " + note);
    parts_.push_back(std::move(built));
    return Nothing{};
  }

  [[nodiscard]] Eigen::AlignedBox2d box_of(std::size_t index) const {
    return moved(places_[index].extent, places_[index].offset);
  }

  // Sets the offset of a component, after those of all before.
  Status move_apart(std::size_t index) {
    ComponentPlace& place = places_[index];
    if (config_.components[index].offset) {
      place.offset = *config_.components[index].offset;
    } else if (index > 0) {
      double right = -std::numeric_limits<double>::infinity();
      for (std::size_t before = 0; before < index; ++before) right = std::max(right, box_of(before).max().x());
      place.offset.x() = right + kGap * largest_ - place.extent.min().x();
    }
    const Eigen::AlignedBox2d box = box_of(index);
    const double reach = std::max(box.min().cwiseAbs().maxCoeff(), box.max().cwiseAbs().maxCoeff());
    if (!(reach <= kMaxMaterialCoordinate)) {
      return invalid_argument("OUT_OF_RANGE",
                              "in the scene's plane it reaches " + metres_text(reach) +
                                  " from the origin; the limit is 10000 m: give it an offset nearer to the others",
                              "offset");
    }
    for (std::size_t before = 0; before < index; ++before) {
      const double distance = distance_between(box_of(before), box);
      if (distance >= kLeastGap * largest_) continue;
      return invalid_argument("COMPONENTS_OVERLAP",
                              "in the scene's plane its bounding box overlaps that of " + places_[before].name +
                                  ", or is closer to it than " + metres_text(kLeastGap * largest_) +
                                  ": change its offset, or leave out all offsets",
                              "offset");
    }
    return Nothing{};
  }

  void make_rooms() {
    for (std::size_t i = 0; i < places_.size(); ++i) {
      double nearest = kAlone * largest_ / kShareOfGap;
      for (std::size_t other = 0; other < places_.size(); ++other) {
        if (other != i) nearest = std::min(nearest, distance_between(box_of(i), box_of(other)));
      }
      const Eigen::Vector2d margin = Eigen::Vector2d::Constant(kShareOfGap * nearest);
      places_[i].room = {box_of(i).min() - margin, box_of(i).max() + margin};
    }
  }

  Result<BuiltMesh> join() {
    const bool is_curved =
        std::any_of(parts_.begin(), parts_.end(), [](const SourceMesh& part) { return part.surface.cols() > 0; });
    mesh::IndexedMesh joined;
    joined.rest.resize(2, num_vertices_);
    joined.triangles.resize(3, num_triangles_);
    if (is_curved) joined.surface.resize(3, num_vertices_);
    Eigen::Matrix3Xd positions(3, num_vertices_);
    mesh::TriangleId triangle = 0;
    for (std::size_t i = 0; i < parts_.size(); ++i) {
      const SourceMesh& part = parts_[i];
      const ComponentPlace& at = places_[i];
      for (mesh::TriangleId t = 0; t < part.mesh.num_solid_triangles(); ++t) {
        for (int k = 0; k < 3; ++k) {
          joined.triangles(k, triangle) = at.first_vertex + part.mesh.vertices(t)[static_cast<std::size_t>(k)];
        }
        ++triangle;
      }
      for (mesh::VertexId v = 0; v < at.num_vertices; ++v) {
        const Eigen::Vector2d own = part.mesh.rest_position(v);
        joined.rest.col(at.first_vertex + v) = own + at.offset;
        if (!is_curved) continue;
        joined.surface.col(at.first_vertex + v) =
            part.surface.cols() > 0 ? Eigen::Vector3d(part.surface.col(v)) : Eigen::Vector3d(own.x(), own.y(), 0.0);
      }
      positions.middleCols(at.first_vertex, at.num_vertices) =
          part.positions.cols() > 0 ? part.positions : place(part.mesh, placement_of(i));
    }
    Result<mesh::TriangleMesh> whole = mesh::import_mesh(joined);
    if (!whole.ok()) {
      Error error = whole.error();
      error.field = "components";
      error.message = "the components together: " + error.message;
      return error;
    }
    return BuiltMesh{std::move(whole).value(), std::move(positions), std::move(places_), std::move(notes_)};
  }

  [[nodiscard]] Placement placement_of(std::size_t index) const {
    if (config_.components[index].placement) return *config_.components[index].placement;
    Placement placement;
    placement.origin = places_[index].offset.x() * placement.x_axis + places_[index].offset.y() * placement.y_axis;
    return placement;
  }

  const SheetConfig& config_;
  std::vector<SourceMesh> parts_;
  std::vector<ComponentPlace> places_;
  std::vector<std::string> notes_;
  std::int32_t num_vertices_ = 0;
  std::int32_t num_triangles_ = 0;
  double largest_ = 0.0;  // m, largest side of all components
};

Result<const ComponentPlace*> find_component(const std::string& name, std::span<const ComponentPlace> places,
                                             const std::string& field) {
  std::vector<std::string> names;
  for (const ComponentPlace& place : places) {
    if (place.name == name) return &place;
    names.push_back(place.name);
  }
  return unknown_component(name, names, field);
}

// Moves the shape of a region by a vector (m).
class RegionShift {
 public:
  explicit RegionShift(const Eigen::Vector2d& by) : by_(by) {}

  void operator()(RegionEdge& /*edge*/) const {}
  void operator()(WholeSheet& /*whole*/) const {}
  void operator()(std::vector<mesh::VertexId>& /*ids*/) const {}
  void operator()(MaterialBox& box) const {
    box.min += by_;
    box.max += by_;
  }
  void operator()(MaterialLine& line) const {
    line.a += by_;
    line.b += by_;
  }
  void operator()(NearestVertex& nearest) const { nearest.point += by_; }
  void operator()(NearestBorder& border) const { border.point += by_; }
  void operator()(MaterialCurve& curve) const { cut::shift(by_, curve.curve); }

 private:
  Eigen::Vector2d by_;
};

}  // namespace

Error in_component(Error error, std::size_t index, const std::string& name) {
  const std::string path = indexed("components", index);
  error.field = error.field.empty() ? path : path + "." + error.field;
  error.message = path + (name.empty() ? "" : " (" + name + ")") + ": " + error.message;
  return error;
}

Error unknown_component(const std::string& name, const std::vector<std::string>& names, const std::string& field) {
  std::string list;
  for (const std::string& known : names) list += (list.empty() ? "" : ", ") + known;
  return invalid_argument(
      "COMPONENT_UNKNOWN",
      field + " is \"" + name + "\"; " +
          (names.empty() ? "the scene has no components: leave it out" : "the scene has the components " + list),
      field);
}

Result<BuiltMesh> build_components(const SheetConfig& config) {
  return ComponentJoin(config).run();
}

Result<PlacedRegion> place(const Region& region, std::span<const ComponentPlace> places, const std::string& field) {
  PlacedRegion placed{region.shape, nullptr};
  if (region.component.empty()) return placed;
  KERF_TRY_ASSIGN(placed.within, find_component(region.component, places, field + ".component"));
  std::visit(RegionShift(placed.within->offset), placed.shape);
  auto* ids = std::get_if<std::vector<mesh::VertexId>>(&placed.shape);
  for (std::size_t k = 0; ids != nullptr && k < ids->size(); ++k) {
    mesh::VertexId& id = (*ids)[k];
    if (id >= placed.within->num_vertices) {
      const std::string path = indexed(field + ".vertices.vertices", k);
      return invalid_argument("UNKNOWN_VERTEX",
                              path + " is " + std::to_string(id) + "; the component " + region.component +
                                  " has vertices 0.." + std::to_string(placed.within->num_vertices - 1),
                              path);
    }
    id += placed.within->first_vertex;
  }
  return placed;
}

Status place(const Cut& cut, std::span<const ComponentPlace> places, cut::CutRequest& request) {
  request.curve = cut.curve;
  request.options = cut.options;
  request.view = cut.view;
  if (cut.component.empty()) return Nothing{};
  KERF_TRY_ASSIGN(const ComponentPlace* const within, find_component(cut.component, places, "cut.component"));
  cut::shift(within->offset, request.curve);
  request.room = cut::Box{within->room.min(), within->room.max()};
  if (std::optional<cut::Fit>& fit = request.options.fit; fit) {
    const Eigen::Vector2d margin = cut::kFitMargin * within->extent.sizes();
    const cut::Box own = fit->box.value_or(cut::Box{within->extent.min() + margin, within->extent.max() - margin});
    fit->box = cut::Box{own.low + within->offset, own.high + within->offset};
  }
  return Nothing{};
}

}  // namespace kerf::scene

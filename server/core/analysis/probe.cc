#include "server/core/analysis/probe.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>
#include <utility>

#include <Eigen/Geometry>

#include "server/core/fem/element/loads.h"
#include "server/core/fem/element/state.h"
#include "server/core/fem/model/model.h"
#include "server/core/fem/statics/reactions.h"
#include "server/core/fem/statics/recovered_fields.h"
#include "server/core/scene/region.h"

namespace kerf::analysis {

namespace {

using scene::Probe;
using scene::Quantity;
using scene::Reduce;

// Distance by which the point of a probe is moved towards Probe::side, so that the lookup finds that side of a cut.
constexpr double kNudge = 1.0e-7;  // -, over the larger side of the bounding box in material coordinates
// A point counts as at a vertex if its weight there is above 1 minus this.  -
constexpr double kAtVertex = 1.0e-6;

std::vector<std::string> components_of(Quantity quantity) {
  switch (quantity) {
    case Quantity::kStrain:
    case Quantity::kStress:
      return {"xx", "yy", "xy"};
    case Quantity::kEnergy:
      return {"kinetic", "membrane", "bending", "gravity", "total"};
    case Quantity::kOpening:
      return {"normal", "sliding", "lateral"};
    case Quantity::kIntersections:
      return {"pairs"};
    default:
      return {"x", "y", "z"};
  }
}

// Returns the solid slot with the corners of `point`.
mesh::TriangleId slot_of(const fem::Model& model, const mesh::TriangleMesh& mesh, const scene::MaterialPoint& point) {
  for (const mesh::TriangleId slot : model.elements().incident_slots().row(point.vertices[0])) {
    const auto& corner = mesh.vertices(slot);
    const auto is_corner = [&](mesh::VertexId v) { return std::find(corner.begin(), corner.end(), v) != corner.end(); };
    if (is_corner(point.vertices[1]) && is_corner(point.vertices[2])) return slot;
  }
  return mesh::kNone;
}

// Returns the material coordinates of a point of the mesh, m.
Eigen::Vector2d rest_of(const mesh::TriangleMesh& mesh, const scene::MaterialPoint& point) {
  Eigen::Vector2d sum = Eigen::Vector2d::Zero();
  for (std::size_t k = 0; k < 3; ++k) {
    if (point.vertices[k] == mesh::kNone) continue;
    sum += point.weights[static_cast<Eigen::Index>(k)] * mesh.rest_position(point.vertices[k]);
  }
  return sum;
}

// Returns for each vertex of a region half the length of the border edges at it that have both ends in the region, m.
std::vector<double> border_lengths(const mesh::TriangleMesh& mesh, const std::vector<mesh::VertexId>& region) {
  std::vector<double> lengths(region.size(), 0.0);
  for (const scene::BorderEdge& edge : scene::edges_in(mesh, region)) {
    for (const mesh::VertexId v : edge.ends) {
      lengths[static_cast<std::size_t>(std::lower_bound(region.begin(), region.end(), v) - region.begin())] +=
          0.5 * edge.length;
    }
  }
  return lengths;
}

// Returns for each vertex of a region a third of the area of the triangles at it that have all corners in the region,
// m^2.
std::vector<double> areas_around(const mesh::TriangleMesh& mesh, const std::vector<mesh::VertexId>& region) {
  std::vector<double> areas(region.size(), 0.0);
  for (const mesh::TriangleId t : scene::triangles_in(mesh, region)) {
    for (const mesh::VertexId v : mesh.vertices(t)) {
      areas[static_cast<std::size_t>(std::lower_bound(region.begin(), region.end(), v) - region.begin())] +=
          scene::rest_area(mesh, t) / 3.0;
    }
  }
  return areas;
}

bool is_zero(const std::vector<double>& weights) {
  return std::all_of(weights.begin(), weights.end(), [](double weight) { return weight == 0.0; });
}

// Accumulates the sum, weighted mean, minimum or maximum of vectors of equal length.
class Reduction {
 public:
  Reduction(Reduce how, Eigen::Index size) : how_(how), sum_(Components::Zero(size)) {
    if (how == Reduce::kMin) sum_.setConstant(std::numeric_limits<double>::infinity());
    if (how == Reduce::kMax) sum_.setConstant(-std::numeric_limits<double>::infinity());
  }
  void add(const Components& value, double weight) {
    if (how_ == Reduce::kMin) {
      sum_ = sum_.cwiseMin(value);
    } else if (how_ == Reduce::kMax) {
      sum_ = sum_.cwiseMax(value);
    } else {
      sum_ += how_ == Reduce::kMean ? weight * value : value;
    }
    weight_ += weight;
    ++count_;
  }
  [[nodiscard]] Components result() const {
    if (count_ == 0) return Components::Constant(sum_.size(), std::numeric_limits<double>::quiet_NaN());
    return how_ == Reduce::kMean ? Components(sum_ / weight_) : sum_;
  }

 private:
  Reduce how_;
  Components sum_;
  double weight_ = 0.0;
  int count_ = 0;
};

// Returns the reactions of all vertices, N, 3 x V; see fem::find_reactions.
linear::VertexField reactions(const sheet::Sheet& sheet, const linear::VertexField& v_before, double dt) {
  linear::VertexField reaction(sheet.model().num_vertices());
  if (dt > 0.0) {
    const linear::VertexField acceleration((sheet.state().v - v_before) / dt);
    fem::find_reactions(sheet.model(), sheet.loads(), sheet.state(), acceleration, reaction);
  } else {
    fem::find_reactions(sheet.model(), sheet.loads(), sheet.state().x, reaction);
  }
  return reaction;
}

fem::Recovery recovery_of(scene::Recovery recovery) {
  return recovery == scene::Recovery::kPatch ? fem::Recovery::kPatch : fem::Recovery::kMean;
}

// Computes components xx, yy, xy of strain or stress along material x and y, in a triangle or at a vertex.
class InPlane {
 public:
  explicit InPlane(fem::MembraneField field) : field_(field) {}

  Components in(const sheet::Sheet& sheet, mesh::TriangleId slot) {
    if (of_slots_.empty()) {
      of_slots_ = fem::triangle_field(sheet.model(), sheet.state().x, field_, fem::FieldAxes::kRest);
    }
    return tensor(of_slots_[static_cast<std::size_t>(slot)]);
  }
  Components at(const sheet::Sheet& sheet, mesh::VertexId vertex, scene::Recovery recovery) {
    std::vector<Eigen::Vector3d>& recovered = recovery == scene::Recovery::kPatch ? by_patches_ : of_vertices_;
    if (recovered.empty()) {
      in(sheet, 0);
      recovered = fem::vertex_field(sheet.model(), of_slots_, recovery_of(recovery));
    }
    return tensor(recovered[static_cast<std::size_t>(vertex)]);
  }
  // Interpolates the values of patch recovery at the corners of a triangle.
  Components by_patches(const sheet::Sheet& sheet, const scene::MaterialPoint& point) {
    Components sum = Components::Zero(3);
    for (std::size_t k = 0; k < 3; ++k) {
      if (point.vertices[k] == mesh::kNone) continue;
      sum += point.weights[static_cast<Eigen::Index>(k)] * at(sheet, point.vertices[k], scene::Recovery::kPatch);
    }
    return sum;
  }

 private:
  // The third component of a strain in Voigt form is the shear angle, twice the tensor's component.
  [[nodiscard]] Components tensor(const Eigen::Vector3d& voigt) const {
    const double share = field_ == fem::MembraneField::kBiotStrain ? 0.5 : 1.0;
    return Eigen::Vector3d(voigt[0], voigt[1], share * voigt[2]);
  }

  fem::MembraneField field_;
  std::vector<Eigen::Vector3d> of_slots_, of_vertices_, by_patches_;  // each empty until it is needed
};

bool is_global(const Probe& probe) {
  return probe.points.empty() && !probe.region;
}

}  // namespace

// The inputs for measuring one row, shared by all probes.
struct Probes::Context {
  const sheet::Sheet& sheet;
  const linear::VertexField& v_before;
  double dt;
  linear::VertexField reaction{};  // empty until it is needed
  InPlane strain{fem::MembraneField::kBiotStrain};
  InPlane biot_stress{fem::MembraneField::kBiotStress};
  InPlane cauchy_stress{fem::MembraneField::kCauchyStress};

  [[nodiscard]] InPlane& field_of(const Probe& probe) {
    if (probe.quantity == Quantity::kStrain) return strain;
    return probe.measure == scene::StressMeasure::kCauchy ? cauchy_stress : biot_stress;
  }
  [[nodiscard]] Components value(const Probe& probe, const Place& place) {
    const fem::State& state = sheet.state();
    if (probe.quantity == Quantity::kOpening) return opening(*place.lips, state.x);
    if (probe.quantity == Quantity::kPosition) return place.point.of(state.x);
    if (probe.quantity == Quantity::kVelocity) return place.point.of(state.v);
    if (probe.quantity == Quantity::kDisplacement) return Eigen::Vector3d(place.point.of(state.x) - place.start);
    InPlane& field = field_of(probe);
    if (probe.recovery == scene::Recovery::kPatch) return field.by_patches(sheet, place.point);
    return place.vertex != mesh::kNone ? field.at(sheet, place.vertex, probe.recovery) : field.in(sheet, place.slot);
  }
  [[nodiscard]] Components value(const Probe& probe, const Member& member) {
    const fem::State& state = sheet.state();
    switch (probe.quantity) {
      case Quantity::kPosition:
        return state.x.col(member.id);
      case Quantity::kVelocity:
        return state.v.col(member.id);
      case Quantity::kDisplacement:
        return state.x.col(member.id) - member.start;
      case Quantity::kStrain:
      case Quantity::kStress:
        return probe.recovery == scene::Recovery::kPatch ? field_of(probe).at(sheet, member.id, probe.recovery)
                                                         : field_of(probe).in(sheet, member.id);
      default:
        if (reaction.cols() == 0) reaction = reactions(sheet, v_before, dt);
        return reaction.col(member.id);
    }
  }
};

Status Probes::check(const sheet::Sheet& sheet, const Probe& probe, const std::string& path, bool may_be_gone) {
  for (std::size_t p = 0; p < probe.points.size(); ++p) {
    if (may_be_gone || probe.quantity == Quantity::kOpening || place_at(sheet, probe, probe.points[p]).exists) continue;
    const std::string field = path + ".points[" + std::to_string(p) + "]";
    return invalid_argument("POINT_OUTSIDE", field + " is not a point of the sheet", field);
  }
  if (!probe.region) return Nothing{};
  const std::string field = path + ".region";
  KERF_TRY_ASSIGN(const scene::PlacedRegion region, scene::place(*probe.region, sheet.components(), field));
  if (may_be_gone) return Nothing{};
  KERF_TRY_ASSIGN(const std::vector<mesh::VertexId> found, find_vertices(sheet.mesh(), region, field));
  const bool may_fill = found.empty() && scene::schedules_cuts(sheet.config());
  if (may_fill || !members_of(sheet, probe).empty()) return Nothing{};
  return invalid_argument("REGION_EMPTY", field + " contains no part of the sheet", field);
}

std::vector<std::string> Probes::columns_of(const std::vector<Probe>& requests) {
  std::vector<std::string> columns;
  for (const Probe& probe : requests) {
    const bool is_each = !probe.points.empty() && probe.reduce == Reduce::kEach;
    for (std::size_t p = 0; p < (is_each ? probe.points.size() : 1); ++p) {
      const std::string number = is_each && probe.points.size() > 1 ? "[" + std::to_string(p) + "]" : "";
      for (const std::string& component : components_of(probe.quantity)) {
        columns.push_back(probe.name + number + "." + component);
      }
    }
  }
  return columns;
}

Result<Probes> Probes::create(std::vector<Probe> requests, const sheet::Sheet& sheet) {
  return create(std::move(requests), sheet, false);
}

Result<Probes> Probes::create_live(std::vector<Probe> requests, const sheet::Sheet& sheet) {
  return create(std::move(requests), sheet, sheet.topology_version() > 1);
}

Result<Probes> Probes::create(std::vector<Probe> requests, const sheet::Sheet& sheet, bool may_be_gone) {
  Probes probes;
  probes.requests_ = std::move(requests);
  for (std::size_t i = 0; i < probes.requests_.size(); ++i) {
    const Probe& probe = probes.requests_[i];
    KERF_TRY(check(sheet, probe, "probes[" + std::to_string(i) + "]", may_be_gone));
  }
  probes.columns_ = columns_of(probes.requests_);
  probes.locate(sheet);
  return probes;
}

Probes::Place Probes::place_at(const sheet::Sheet& sheet, const Probe& probe, const Eigen::Vector2d& at) {
  const mesh::TriangleMesh& mesh = sheet.mesh();
  Place place;
  if (probe.quantity == Quantity::kOpening) {
    place.lips = find_lips(mesh, at);
    place.exists = place.lips.has_value();
    return place;
  }
  Eigen::Vector2d lookup = at;
  if (probe.side && *probe.side != at) {
    lookup += kNudge * mesh.bounding_box().sizes().maxCoeff() * (*probe.side - at).normalized();
  }
  const double reach = 2.0 * kNudge * mesh.bounding_box().sizes().maxCoeff();
  // A point of the border may lie outside only by rounding.
  const std::optional<scene::MaterialPoint> found = scene::find_material_point(mesh, lookup);
  place.point = found ? *found : scene::nearest_material_point(mesh, lookup);
  const Eigen::Vector2d there = rest_of(mesh, place.point);
  if (!found && (there - at).norm() > reach) return place;
  place.exists = true;
  place.slot = slot_of(sheet.model(), mesh, place.point);
  place.start = sheet.start_of(there);
  for (std::size_t k = 0; k < 3; ++k) {
    const mesh::VertexId v = place.point.vertices[k];
    const bool is_there = place.point.weights[static_cast<Eigen::Index>(k)] > 1.0 - kAtVertex ||
                          (probe.side && v != mesh::kNone && (mesh.rest_position(v) - at).norm() <= reach);
    if (!is_there) continue;
    place.vertex = v;
    place.point.weights = Eigen::Vector3d::Unit(static_cast<Eigen::Index>(k));
    place.start = sheet.start_of(mesh.rest_position(v));
    break;
  }
  return place;
}

std::vector<Probes::Member> Probes::members_of(const sheet::Sheet& sheet, const Probe& probe) {
  const mesh::TriangleMesh& mesh = sheet.mesh();
  scene::PlacedRegion region = scene::place(*probe.region, sheet.components(), "").value();
  forget_removed(mesh, region);
  const std::vector<mesh::VertexId> vertices = find_vertices(mesh, region, "").value();
  std::vector<Member> members;
  const bool is_field = is_in_plane(probe.quantity);
  if (is_field && probe.recovery == scene::Recovery::kMean) {
    for (const mesh::TriangleId t : scene::triangles_in(mesh, vertices)) {
      members.push_back({t, scene::rest_area(mesh, t), Eigen::Vector3d::Zero()});
    }
    return members;
  }
  std::vector<double> weights(vertices.size(), 0.0);
  if (is_field) weights = areas_around(mesh, vertices);
  if (is_zero(weights)) weights = border_lengths(mesh, vertices);
  if (is_zero(weights)) weights.assign(vertices.size(), 1.0);
  for (std::size_t i = 0; i < vertices.size(); ++i) {
    members.push_back({vertices[i], weights[i], sheet.start_of(mesh.rest_position(vertices[i]))});
  }
  return members;
}

void Probes::locate(const sheet::Sheet& sheet) {
  located_.assign(requests_.size(), {});
  for (std::size_t i = 0; i < requests_.size(); ++i) {
    for (const Eigen::Vector2d& at : requests_[i].points) {
      located_[i].places.push_back(place_at(sheet, requests_[i], at));
    }
    if (requests_[i].region) located_[i].members = members_of(sheet, requests_[i]);
  }
  topology_version_ = sheet.topology_version();
}

void Probes::measure(const sheet::Sheet& sheet, std::vector<double>& row) {
  measure(sheet, sheet.state().v, 0.0, row);
}

void Probes::measure(const sheet::Sheet& sheet, const linear::VertexField& v_before, double dt,
                     std::vector<double>& row) {
  if (sheet.topology_version() != topology_version_) locate(sheet);
  Context context{sheet, v_before, dt};
  const auto append = [&row](const Components& value) { row.insert(row.end(), value.begin(), value.end()); };
  std::map<Quantity, Components> of_sheet;  // Each measured once, however many probes ask for it.
  for (std::size_t i = 0; i < requests_.size(); ++i) {
    const Probe& probe = requests_[i];
    if (is_global(probe)) {
      const auto [found, is_new] = of_sheet.try_emplace(probe.quantity);
      if (is_new) found->second = whole_sheet_.measure(sheet, probe.quantity);
      append(found->second);
      continue;
    }
    const auto size = static_cast<Eigen::Index>(components_of(probe.quantity).size());
    Reduction reduction(probe.reduce, size);
    for (const Place& place : located_[i].places) {
      if (probe.reduce == Reduce::kEach) {
        append(place.exists ? context.value(probe, place)
                            : Components(Components::Constant(size, std::numeric_limits<double>::quiet_NaN())));
      } else if (place.exists) {
        reduction.add(context.value(probe, place), 1.0);
      }
    }
    for (const Member& member : located_[i].members) reduction.add(context.value(probe, member), member.weight);
    if (probe.reduce != Reduce::kEach) append(reduction.result());
  }
}

}  // namespace kerf::analysis

#include "server/core/scene/conditions.h"

#include <algorithm>

#include "server/base/overloaded.h"
#include "server/core/scene/field_checks.h"

namespace kerf::scene {

namespace {

Status validate_box(const MaterialBox& box, const std::string& field) {
  KERF_TRY(check_vector(box.min, kMaxMaterialCoordinate, field + ".min"));
  KERF_TRY(check_vector(box.max, kMaxMaterialCoordinate, field + ".max"));
  if (box.min.x() <= box.max.x() && box.min.y() <= box.max.y()) return Nothing{};
  return invalid_argument("BOX_INVERTED", field + ".max must not be less than min", field + ".max");
}

Status validate_line(const MaterialLine& line, const std::string& field) {
  KERF_TRY(check_vector(line.a, kMaxMaterialCoordinate, field + ".a"));
  KERF_TRY(check_vector(line.b, kMaxMaterialCoordinate, field + ".b"));
  if (line.side != MaterialLine::Side::kBoth && line.a == line.b) {
    return invalid_argument("LINE_EMPTY", field + ".b must differ from a: a point has no sides", field + ".b");
  }
  return check_number(line.within, 0.0, kMaxMaterialCoordinate, field + ".within_m");
}

Status validate_curve(const MaterialCurve& curve, const std::string& field) {
  KERF_TRY(check_curve(curve.curve, field + ".curve"));
  return check_number(curve.within, 0.0, kMaxMaterialCoordinate, field + ".within_m");
}

Status validate_ids(const std::vector<mesh::VertexId>& ids, const std::string& field) {
  KERF_TRY(check_count(ids.size(), kMaxListedVertices, "vertex ids", field));
  for (std::size_t k = 0; k < ids.size(); ++k) {
    if (ids[k] < 0) return check_vertex_id(ids[k], field + "[" + std::to_string(k) + "]");
  }
  return Nothing{};
}

Status validate_displacements(const Constraint& constraint, const std::string& path) {
  const auto count = static_cast<std::size_t>(constraint.displacements.cols());
  if (count == 0) return Nothing{};
  const std::string field = path + ".displacements_m";
  const auto* ids = std::get_if<std::vector<mesh::VertexId>>(&constraint.region.shape);
  if (ids == nullptr || ids->size() != count) {
    return invalid_argument(
        "LENGTH_MISMATCH",
        field + " has " + std::to_string(count) + " displacements; must be as many as region.vertices has vertices",
        field);
  }
  for (std::size_t i = 0; i < count; ++i) {
    const Eigen::Vector3d value = constraint.displacements.col(static_cast<Eigen::Index>(i));
    KERF_TRY(check_vector(value, kMaxWorldCoordinate, indexed(field, i)));
  }
  return Nothing{};
}

Status validate_rotation(const Rotation& rotation, const std::string& path) {
  KERF_TRY(check_vector(rotation.axis, kMaxWorldCoordinate, path + ".axis"));
  if (rotation.axis.isZero(0.0)) {
    return invalid_argument("AXIS_ZERO", path + ".axis must not be zero", path + ".axis");
  }
  KERF_TRY(check_vector(rotation.centre, kMaxWorldCoordinate, path + ".center"));
  return check_number(rotation.angle, -kMaxAngle, kMaxAngle, path + ".angle_rad");
}

Status validate(const Constraint& constraint, const std::string& path) {
  KERF_TRY(validate(constraint.region, path + ".region"));
  KERF_TRY(check_vector(constraint.displacement, kMaxWorldCoordinate, path + ".displacement_m"));
  const Eigen::Vector3d stretch_x = constraint.stretch.col(0);
  const Eigen::Vector3d stretch_y = constraint.stretch.col(1);
  KERF_TRY(check_vector(stretch_x, kMaxWorldCoordinate, path + ".stretch_x"));
  KERF_TRY(check_vector(stretch_y, kMaxWorldCoordinate, path + ".stretch_y"));
  KERF_TRY(validate_displacements(constraint, path));
  if (constraint.rotation) {
    KERF_TRY(validate_rotation(*constraint.rotation, path));
  }
  KERF_TRY(validate(constraint.history, path + ".history"));
  KERF_TRY(check_number(constraint.until.value_or(0.0), -kMaxHistoryTime, kMaxHistoryTime, path + ".until"));
  const bool holds_all = constraint.held[0] && constraint.held[1] && constraint.held[2];
  if (!constraint.slope || holds_all) return Nothing{};
  return invalid_argument("SLOPE_ALONE", path + ".slope can be held only if x, y and z are all held", path + ".slope");
}

Status validate_factor(const LinearFactor& factor, const std::string& path) {
  KERF_TRY(check_vector(factor.zero, kMaxMaterialCoordinate, path + ".zero"));
  KERF_TRY(check_number(factor.slope.x(), -kMaxFactorSlope, kMaxFactorSlope, path + ".by_x"));
  KERF_TRY(check_number(factor.slope.y(), -kMaxFactorSlope, kMaxFactorSlope, path + ".by_y"));
  if (!factor.slope.isZero(0.0)) return Nothing{};
  return invalid_argument("FACTOR_ZERO", path + " is 0 everywhere; give by_x or by_y, or leave the factor out",
                          path + ".by_x");
}

struct ValidateLoad {
  const std::string& path;

  Status operator()(const PointForce& point) const {
    if (const auto* vertex = std::get_if<mesh::VertexId>(&point.point)) {
      KERF_TRY(check_vertex_id(*vertex, path + ".point.vertex"));
    } else {
      KERF_TRY(check_vector(std::get<Eigen::Vector2d>(point.point), kMaxMaterialCoordinate, path + ".point.material"));
    }
    return check_vector(point.force, kMaxForce, path + ".point.force_n");
  }
  Status operator()(const EdgeForce& edge) const {
    KERF_TRY(validate(edge.region, path + ".edge.region"));
    if (edge.factor) {
      KERF_TRY(validate_factor(*edge.factor, path + ".edge.factor"));
    }
    if (edge.normal) return check_number(*edge.normal, -kMaxForce, kMaxForce, path + ".edge.normal_npm");
    return check_vector(edge.force, kMaxForce, path + (edge.is_total ? ".edge.force_n" : ".edge.force_npm"));
  }
  Status operator()(const AreaForce& area) const {
    KERF_TRY(validate(area.region, path + ".area.region"));
    return check_vector(area.force, kMaxForce, path + (area.is_total ? ".area.force_n" : ".area.traction_pa"));
  }
  Status operator()(const Pressure& pressure) const {
    KERF_TRY(validate(pressure.region, path + ".pressure.region"));
    return check_number(pressure.pressure, -kMaxForce, kMaxForce, path + ".pressure.pressure_pa");
  }
  Status operator()(const EdgeMoment& edge) const {
    KERF_TRY(validate(edge.region, path + ".moment.region"));
    return check_number(edge.moment, -kMaxForce, kMaxForce,
                        path + (edge.is_total ? ".moment.moment_nm" : ".moment.moment_nm_per_m"));
  }
};

}  // namespace

double History::at(double time, double absent) const {
  if (times.empty()) return absent;
  const auto above = std::upper_bound(times.begin(), times.end(), time);
  if (above == times.begin()) return factors.front();
  if (above == times.end()) return factors.back();
  const auto i = static_cast<std::size_t>(above - times.begin());
  const double part = (time - times[i - 1]) / (times[i] - times[i - 1]);
  return factors[i - 1] + part * (factors[i] - factors[i - 1]);
}

Status validate(const Region& region, const std::string& field) {
  const auto check_point = [](const Eigen::Vector2d& point, const std::string& path) {
    return check_vector(point, kMaxMaterialCoordinate, path);
  };
  return std::visit(
      Overloaded{
          [](RegionEdge /*edge*/) -> Status { return Nothing{}; },
          [&](const MaterialBox& box) { return validate_box(box, field + ".box"); },
          [&](const std::vector<mesh::VertexId>& ids) { return validate_ids(ids, field + ".vertices.vertices"); },
          [&](const MaterialLine& line) { return validate_line(line, field + ".line"); },
          [&](const NearestVertex& nearest) { return check_point(nearest.point, field + ".nearest"); },
          [](const WholeSheet& /*whole*/) -> Status { return Nothing{}; },
          [&](const MaterialCurve& curve) { return validate_curve(curve, field + ".curve"); },
          [&](const NearestBorder& border) { return check_point(border.point, field + ".border"); },
      },
      region.shape);
}

Status validate(const std::vector<Region>& regions, const std::string& field) {
  KERF_TRY(check_count(regions.size(), kMaxRegions, "regions", field));
  std::size_t num_ids = 0;
  for (std::size_t i = 0; i < regions.size(); ++i) {
    KERF_TRY(validate(regions[i], field + "[" + std::to_string(i) + "]"));
    const auto* ids = std::get_if<std::vector<mesh::VertexId>>(&regions[i].shape);
    if (ids != nullptr) num_ids += ids->size();
  }
  return check_count(num_ids, kMaxListedVertices, "vertex ids", field);
}

Status validate(const History& history, const std::string& field) {
  if (history.times.size() != history.factors.size()) {
    return invalid_argument("LENGTH_MISMATCH",
                            field + " has " + std::to_string(history.times.size()) + " times and " +
                                std::to_string(history.factors.size()) + " factors; must be as many",
                            field + ".factors");
  }
  KERF_TRY(check_count(history.times.size(), kMaxHistoryPoints, "times", field + ".times"));
  for (std::size_t i = 0; i < history.times.size(); ++i) {
    const std::string time = indexed(field + ".times", i);
    KERF_TRY(check_number(history.times[i], -kMaxHistoryTime, kMaxHistoryTime, time));
    if (i > 0 && history.times[i] <= history.times[i - 1]) {
      return invalid_argument("NOT_ASCENDING", time + " must be greater than the previous time", time);
    }
    KERF_TRY(check_number(history.factors[i], -kMaxHistoryFactor, kMaxHistoryFactor, indexed(field + ".factors", i)));
  }
  return Nothing{};
}

Status validate(const std::vector<Constraint>& constraints) {
  KERF_TRY(check_count(constraints.size(), kMaxConstraints, "constraints", "constraints"));
  for (std::size_t i = 0; i < constraints.size(); ++i) {
    KERF_TRY(validate(constraints[i], indexed("constraints", i)));
  }
  return Nothing{};
}

Status validate(const std::vector<Load>& loads) {
  KERF_TRY(check_count(loads.size(), kMaxLoads, "loads", "loads"));
  for (std::size_t i = 0; i < loads.size(); ++i) {
    const std::string path = indexed("loads", i);
    KERF_TRY(std::visit(ValidateLoad{path}, loads[i].kind));
    KERF_TRY(validate(loads[i].history, path + ".history"));
  }
  return Nothing{};
}

Status validate(const InitialVelocity& velocity) {
  KERF_TRY(check_vector(velocity.linear, kMaxSpeed, "initial_velocity.linear_mps"));
  KERF_TRY(check_vector(velocity.angular, kMaxSpeed, "initial_velocity.angular_radps"));
  return check_vector(velocity.centre.value_or(Eigen::Vector3d::Zero()), kMaxWorldCoordinate,
                      "initial_velocity.center");
}

}  // namespace kerf::scene

#include "server/sheet/conditions.h"

#include <algorithm>

#include "server/sheet/field_checks.h"

namespace kerf::sheet {

namespace {

Status validate_displacements(const Constraint& constraint, const std::string& path) {
  const auto count = static_cast<std::size_t>(constraint.displacements.cols());
  if (count == 0) return Nothing{};
  const std::string field = path + ".displacements_m";
  const auto* ids = std::get_if<std::vector<mesh::VertexId>>(&constraint.region);
  if (ids == nullptr || ids->size() != count) {
    return invalid_argument(
        "LENGTH_MISMATCH",
        field + " has " + std::to_string(count) + " displacements; must be as many as region.vertices has vertices",
        field);
  }
  for (std::size_t i = 0; i < count; ++i) {
    const Eigen::Vector3d value = constraint.displacements.col(static_cast<Eigen::Index>(i));
    if (Status s = check_vector(value, kMaxWorldCoordinate, indexed(field, i)); !s) return s;
  }
  return Nothing{};
}

Status validate_rotation(const Rotation& rotation, const std::string& path) {
  if (Status s = check_vector(rotation.axis, kMaxWorldCoordinate, path + ".axis"); !s) return s;
  if (rotation.axis.isZero(0.0)) {
    return invalid_argument("AXIS_ZERO", path + ".axis must not be zero", path + ".axis");
  }
  if (Status s = check_vector(rotation.centre, kMaxWorldCoordinate, path + ".center"); !s) return s;
  return check_number(rotation.angle, -kMaxAngle, kMaxAngle, path + ".angle_rad");
}

Status validate(const Constraint& constraint, const std::string& path) {
  if (Status s = validate(constraint.region, path + ".region"); !s) return s;
  if (Status s = check_vector(constraint.displacement, kMaxWorldCoordinate, path + ".displacement_m"); !s) return s;
  const Eigen::Vector3d stretch_x = constraint.stretch.col(0);
  const Eigen::Vector3d stretch_y = constraint.stretch.col(1);
  if (Status s = check_vector(stretch_x, kMaxWorldCoordinate, path + ".stretch_x"); !s) return s;
  if (Status s = check_vector(stretch_y, kMaxWorldCoordinate, path + ".stretch_y"); !s) return s;
  if (Status s = validate_displacements(constraint, path); !s) return s;
  if (constraint.rotation) {
    if (Status s = validate_rotation(*constraint.rotation, path); !s) return s;
  }
  if (Status s = validate(constraint.history, path + ".history"); !s) return s;
  if (Status s = check_number(constraint.until.value_or(0.0), -kMaxHistoryTime, kMaxHistoryTime, path + ".until"); !s) {
    return s;
  }
  const bool holds_all = constraint.held[0] && constraint.held[1] && constraint.held[2];
  if (!constraint.slope || holds_all) return Nothing{};
  return invalid_argument("SLOPE_ALONE", path + ".slope can be held where all of x, y and z are", path + ".slope");
}

Status validate_factor(const LinearFactor& factor, const std::string& path) {
  if (Status s = check_vector(factor.zero, kMaxMaterialCoordinate, path + ".zero"); !s) return s;
  if (Status s = check_number(factor.slope.x(), -kMaxFactorSlope, kMaxFactorSlope, path + ".by_x"); !s) return s;
  if (Status s = check_number(factor.slope.y(), -kMaxFactorSlope, kMaxFactorSlope, path + ".by_y"); !s) return s;
  if (!factor.slope.isZero(0.0)) return Nothing{};
  return invalid_argument("FACTOR_ZERO", path + " is 0 everywhere; give by_x or by_y, or leave the factor out",
                          path + ".by_x");
}

struct ValidateLoad {
  const std::string& path;

  Status operator()(const PointForce& point) const {
    if (const auto* vertex = std::get_if<mesh::VertexId>(&point.point)) {
      if (Status s = check_vertex_id(*vertex, path + ".point.vertex"); !s) return s;
    } else if (Status s = check_vector(std::get<Eigen::Vector2d>(point.point), kMaxMaterialCoordinate,
                                       path + ".point.material");
               !s) {
      return s;
    }
    return check_vector(point.force, kMaxForce, path + ".point.force_n");
  }
  Status operator()(const EdgeForce& edge) const {
    if (Status s = validate(edge.region, path + ".edge.region"); !s) return s;
    if (edge.factor) {
      if (Status s = validate_factor(*edge.factor, path + ".edge.factor"); !s) return s;
    }
    if (edge.normal) return check_number(*edge.normal, -kMaxForce, kMaxForce, path + ".edge.normal_npm");
    return check_vector(edge.force, kMaxForce, path + (edge.is_total ? ".edge.force_n" : ".edge.force_npm"));
  }
  Status operator()(const AreaForce& area) const {
    if (Status s = validate(area.region, path + ".area.region"); !s) return s;
    return check_vector(area.force, kMaxForce, path + (area.is_total ? ".area.force_n" : ".area.traction_pa"));
  }
  Status operator()(const Pressure& pressure) const {
    if (Status s = validate(pressure.region, path + ".pressure.region"); !s) return s;
    return check_number(pressure.pressure, -kMaxForce, kMaxForce, path + ".pressure.pressure_pa");
  }
  Status operator()(const EdgeMoment& edge) const {
    if (Status s = validate(edge.region, path + ".moment.region"); !s) return s;
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

Status validate(const History& history, const std::string& field) {
  if (history.times.size() != history.factors.size()) {
    return invalid_argument("LENGTH_MISMATCH",
                            field + " has " + std::to_string(history.times.size()) + " times and " +
                                std::to_string(history.factors.size()) + " factors; must be as many",
                            field + ".factors");
  }
  if (Status s = check_count(history.times.size(), kMaxHistoryPoints, "times", field + ".times"); !s) return s;
  for (std::size_t i = 0; i < history.times.size(); ++i) {
    const std::string time = indexed(field + ".times", i);
    if (Status s = check_number(history.times[i], -kMaxHistoryTime, kMaxHistoryTime, time); !s) return s;
    if (i > 0 && history.times[i] <= history.times[i - 1]) {
      return invalid_argument("NOT_ASCENDING", time + " must be greater than the time before it", time);
    }
    if (Status s =
            check_number(history.factors[i], -kMaxHistoryFactor, kMaxHistoryFactor, indexed(field + ".factors", i));
        !s) {
      return s;
    }
  }
  return Nothing{};
}

Status validate(const std::vector<Constraint>& constraints) {
  if (Status s = check_count(constraints.size(), kMaxConstraints, "constraints", "constraints"); !s) return s;
  for (std::size_t i = 0; i < constraints.size(); ++i) {
    if (Status s = validate(constraints[i], indexed("constraints", i)); !s) return s;
  }
  return Nothing{};
}

Status validate(const std::vector<Load>& loads) {
  if (Status s = check_count(loads.size(), kMaxLoads, "loads", "loads"); !s) return s;
  for (std::size_t i = 0; i < loads.size(); ++i) {
    const std::string path = indexed("loads", i);
    if (Status s = std::visit(ValidateLoad{path}, loads[i].kind); !s) return s;
    if (Status s = validate(loads[i].history, path + ".history"); !s) return s;
  }
  return Nothing{};
}

Status validate(const InitialVelocity& velocity) {
  if (Status s = check_vector(velocity.linear, kMaxSpeed, "initial_velocity.linear_mps"); !s) return s;
  if (Status s = check_vector(velocity.angular, kMaxSpeed, "initial_velocity.angular_radps"); !s) return s;
  return check_vector(velocity.centre.value_or(Eigen::Vector3d::Zero()), kMaxWorldCoordinate,
                      "initial_velocity.center");
}

}  // namespace kerf::sheet

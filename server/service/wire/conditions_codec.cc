#include "server/service/wire/conditions_codec.h"

#include <utility>
#include <variant>

#include "server/service/wire/geometry_codec.h"
#include "server/service/wire/region_codec.h"

namespace kerf::wire {
namespace {

scene::History decode_history(const v1::History& message) {
  return {{message.times().begin(), message.times().end()}, {message.factors().begin(), message.factors().end()}};
}

void encode_history(const scene::History& history, v1::History& message) {
  message.mutable_times()->Assign(history.times.begin(), history.times.end());
  message.mutable_factors()->Assign(history.factors.begin(), history.factors.end());
}

Result<scene::Constraint> decode_constraint(const v1::Constraint& message, const std::string& path) {
  scene::Constraint constraint;
  KERF_TRY_ASSIGN(constraint.region, decode_region(message.region(), path + ".region"));
  if (message.x() || message.y() || message.z()) constraint.held = {message.x(), message.y(), message.z()};
  constraint.displacement = decode_vector(message.displacement_m());
  constraint.stretch.col(0) = decode_vector(message.stretch_x());
  constraint.stretch.col(1) = decode_vector(message.stretch_y());
  constraint.displacements.resize(3, message.displacements_m_size());
  for (int i = 0; i < message.displacements_m_size(); ++i) {
    constraint.displacements.col(i) = decode_vector(message.displacements_m(i));
  }
  if (message.has_axis()) {
    constraint.rotation =
        scene::Rotation{decode_vector(message.axis()), decode_vector(message.center()), message.angle_rad()};
  } else if (message.has_center() || message.angle_rad() != 0.0) {
    return missing(path + ".axis");
  }
  constraint.history = decode_history(message.history());
  if (message.has_until()) constraint.until = message.until();
  constraint.slope = message.slope();
  return constraint;
}

void encode_constraint(const scene::Constraint& constraint, v1::Constraint& message) {
  encode_region(constraint.region, *message.mutable_region());
  message.set_x(constraint.held[0]);
  message.set_y(constraint.held[1]);
  message.set_z(constraint.held[2]);
  encode_vector(constraint.displacement, *message.mutable_displacement_m());
  encode_vector(Eigen::Vector3d(constraint.stretch.col(0)), *message.mutable_stretch_x());
  encode_vector(Eigen::Vector3d(constraint.stretch.col(1)), *message.mutable_stretch_y());
  for (Eigen::Index i = 0; i < constraint.displacements.cols(); ++i) {
    encode_vector(Eigen::Vector3d(constraint.displacements.col(i)), *message.add_displacements_m());
  }
  if (constraint.rotation) {
    encode_vector(constraint.rotation->axis, *message.mutable_axis());
    encode_vector(constraint.rotation->centre, *message.mutable_center());
    message.set_angle_rad(constraint.rotation->angle);
  }
  if (!constraint.history.times.empty()) encode_history(constraint.history, *message.mutable_history());
  if (constraint.until) message.set_until(*constraint.until);
  message.set_slope(constraint.slope);
}

scene::EdgeForce decode_edge_force(const v1::EdgeForce& message, scene::Region region) {
  scene::EdgeForce edge;
  edge.region = std::move(region);
  edge.is_total = message.has_force_n();
  edge.force = decode_vector(edge.is_total ? message.force_n() : message.force_npm());
  if (message.amount_case() == v1::EdgeForce::kNormalNpm) edge.normal = message.normal_npm();
  if (message.has_factor()) {
    edge.factor =
        scene::LinearFactor{decode_vector(message.factor().zero()), {message.factor().by_x(), message.factor().by_y()}};
  }
  return edge;
}

void encode_edge_force(const scene::EdgeForce& edge, v1::EdgeForce& message) {
  encode_region(edge.region, *message.mutable_region());
  if (edge.normal) {
    message.set_normal_npm(*edge.normal);
  } else {
    encode_vector(edge.force, edge.is_total ? *message.mutable_force_n() : *message.mutable_force_npm());
  }
  if (!edge.factor) return;
  encode_vector(edge.factor->zero, *message.mutable_factor()->mutable_zero());
  message.mutable_factor()->set_by_x(edge.factor->slope.x());
  message.mutable_factor()->set_by_y(edge.factor->slope.y());
}

Result<scene::Load> decode_load(const v1::Load& message, const std::string& path) {
  scene::Load load;
  load.history = decode_history(message.history());
  switch (message.kind_case()) {
    case v1::Load::kPoint: {
      scene::PointForce force;
      if (message.point().has_vertex()) {
        force.point = message.point().vertex();
      } else if (message.point().has_material()) {
        force.point = decode_vector(message.point().material());
      } else {
        return choice_missing(path + ".point.point", "vertex or material");
      }
      force.force = decode_vector(message.point().force_n());
      load.kind = std::move(force);
      return load;
    }
    case v1::Load::kEdge: {
      KERF_TRY_ASSIGN(scene::Region region, decode_region(message.edge().region(), path + ".edge.region"));
      if (message.edge().amount_case() == v1::EdgeForce::AMOUNT_NOT_SET) {
        return choice_missing(path + ".edge.amount", "force_n, force_npm or normal_npm");
      }
      load.kind = decode_edge_force(message.edge(), std::move(region));
      return load;
    }
    case v1::Load::kArea: {
      KERF_TRY_ASSIGN(scene::Region region, decode_region(message.area().region(), path + ".area.region"));
      if (message.area().amount_case() == v1::AreaForce::AMOUNT_NOT_SET) {
        return choice_missing(path + ".area.amount", "force_n or traction_pa");
      }
      const bool is_total = !message.area().has_traction_pa();
      load.kind =
          scene::AreaForce{std::move(region),
                           decode_vector(is_total ? message.area().force_n() : message.area().traction_pa()), is_total};
      return load;
    }
    case v1::Load::kPressure: {
      KERF_TRY_ASSIGN(scene::Region region, decode_region(message.pressure().region(), path + ".pressure.region"));
      load.kind = scene::Pressure{std::move(region), message.pressure().pressure_pa()};
      return load;
    }
    case v1::Load::kMoment: {
      KERF_TRY_ASSIGN(scene::Region region, decode_region(message.moment().region(), path + ".moment.region"));
      if (message.moment().amount_case() == v1::EdgeMoment::AMOUNT_NOT_SET) {
        return choice_missing(path + ".moment.amount", "moment_nm or moment_nm_per_m");
      }
      const bool is_total = !message.moment().has_moment_nm_per_m();
      load.kind = scene::EdgeMoment{
          std::move(region), is_total ? message.moment().moment_nm() : message.moment().moment_nm_per_m(), is_total};
      return load;
    }
    case v1::Load::KIND_NOT_SET:
      break;
  }
  return choice_missing(path + ".kind", "point, edge, area, pressure or moment");
}

void encode(const scene::PointForce& point, v1::Load& message) {
  if (const auto* vertex = std::get_if<mesh::VertexId>(&point.point)) {
    message.mutable_point()->set_vertex(*vertex);
  } else {
    encode_vector(std::get<Eigen::Vector2d>(point.point), *message.mutable_point()->mutable_material());
  }
  encode_vector(point.force, *message.mutable_point()->mutable_force_n());
}

void encode(const scene::EdgeForce& edge, v1::Load& message) {
  encode_edge_force(edge, *message.mutable_edge());
}

void encode(const scene::AreaForce& area, v1::Load& message) {
  v1::AreaForce& to = *message.mutable_area();
  encode_region(area.region, *to.mutable_region());
  encode_vector(area.force, area.is_total ? *to.mutable_force_n() : *to.mutable_traction_pa());
}

void encode(const scene::Pressure& pressure, v1::Load& message) {
  encode_region(pressure.region, *message.mutable_pressure()->mutable_region());
  message.mutable_pressure()->set_pressure_pa(pressure.pressure);
}

void encode(const scene::EdgeMoment& moment, v1::Load& message) {
  v1::EdgeMoment& to = *message.mutable_moment();
  encode_region(moment.region, *to.mutable_region());
  if (moment.is_total) {
    to.set_moment_nm(moment.moment);
  } else {
    to.set_moment_nm_per_m(moment.moment);
  }
}

void encode_load(const scene::Load& load, v1::Load& message) {
  if (!load.history.times.empty()) encode_history(load.history, *message.mutable_history());
  std::visit([&message](const auto& kind) { encode(kind, message); }, load.kind);
}

}  // namespace

Status decode_conditions(const v1::Scene& scene, scene::SheetConfig& config) {
  for (int i = 0; i < scene.constraints_size(); ++i) {
    KERF_TRY_ASSIGN(scene::Constraint constraint,
                    decode_constraint(scene.constraints(i), "constraints[" + std::to_string(i) + "]"));
    config.constraints.push_back(std::move(constraint));
  }
  for (int i = 0; i < scene.loads_size(); ++i) {
    KERF_TRY_ASSIGN(scene::Load load, decode_load(scene.loads(i), "loads[" + std::to_string(i) + "]"));
    config.loads.push_back(std::move(load));
  }
  config.gravity_history = decode_history(scene.gravity_history());
  config.planar = scene.planar();
  if (scene.has_initial_velocity()) {
    const v1::InitialVelocity& given = scene.initial_velocity();
    scene::InitialVelocity velocity{decode_vector(given.linear_mps()), decode_vector(given.angular_radps()), {}};
    if (given.has_center()) velocity.centre = decode_vector(given.center());
    config.initial_velocity = velocity;
  }
  return Nothing{};
}

void encode_conditions(const scene::SheetConfig& config, v1::Scene& scene) {
  for (const scene::Constraint& constraint : config.constraints) {
    encode_constraint(constraint, *scene.add_constraints());
  }
  for (const scene::Load& load : config.loads) encode_load(load, *scene.add_loads());
  if (!config.gravity_history.times.empty()) encode_history(config.gravity_history, *scene.mutable_gravity_history());
  scene.set_planar(config.planar);
  if (!config.initial_velocity) return;
  v1::InitialVelocity& velocity = *scene.mutable_initial_velocity();
  encode_vector(config.initial_velocity->linear, *velocity.mutable_linear_mps());
  encode_vector(config.initial_velocity->angular, *velocity.mutable_angular_radps());
  if (config.initial_velocity->centre) encode_vector(*config.initial_velocity->centre, *velocity.mutable_center());
}

}  // namespace kerf::wire

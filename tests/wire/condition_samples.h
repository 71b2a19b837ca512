#pragma once

#include <limits>
#include <string>
#include <vector>

#include "kerf/v1/scene.pb.h"

// The parts of a full scene that are held, pushed, analysed and measured.
namespace kerf::testing {

inline v1::MaterialLine& set_line(v1::Region& region, double ax, double ay, double bx, double by) {
  v1::MaterialLine& line = *region.mutable_line();
  line.mutable_a()->set_x(ax);
  line.mutable_a()->set_y(ay);
  line.mutable_b()->set_x(bx);
  line.mutable_b()->set_y(by);
  return line;
}

inline void set(v1::Vec3* vector, double x, double y, double z) {
  vector->set_x(x);
  vector->set_y(y);
  vector->set_z(z);
}
inline void set(v1::Vec2* vector, double x, double y) {
  vector->set_x(x);
  vector->set_y(y);
}

// Complete, so that decoding and encoding give every field again.
inline v1::Constraint& add_constraint(v1::Scene& scene, bool x, bool y, bool z) {
  v1::Constraint& constraint = *scene.add_constraints();
  constraint.set_x(x);
  constraint.set_y(y);
  constraint.set_z(z);
  set(constraint.mutable_displacement_m(), 0.0, 0.1, 0.0);
  set(constraint.mutable_stretch_x(), 0.01, 0.0, 0.0);
  set(constraint.mutable_stretch_y(), 0.0, 0.02, -0.5);
  return constraint;
}

// Constraints on every kind of region, loads of every kind, probes.
inline void add_conditions(v1::Scene& scene) {
  v1::Constraint* constraint = &add_constraint(scene, true, false, true);
  v1::MaterialLine& line = set_line(*constraint->mutable_region(), 0.0, 0.1, 0.3, 0.1);
  line.set_within_m(0.01);
  line.set_side(v1::MaterialLine::LEFT_OF_LINE);
  for (const double time : {0.0, 0.5, 2.0}) constraint->mutable_history()->add_times(time);
  for (const double factor : {0.0, 1.0, -1.0}) constraint->mutable_history()->add_factors(factor);
  constraint->set_until(3.0);
  constraint = &add_constraint(scene, true, true, true);
  constraint->mutable_region()->mutable_nearest()->set_x(0.2);
  constraint->mutable_region()->mutable_nearest()->set_y(0.3);
  set(constraint->mutable_axis(), 0.0, 1.0, 1.0);
  set(constraint->mutable_center(), 0.1, 0.2, 0.3);
  constraint->set_angle_rad(-0.4);
  constraint->set_slope(true);
  constraint = &add_constraint(scene, false, true, false);
  for (const int v : {3, 4}) constraint->mutable_region()->mutable_vertices()->add_vertices(v);
  set(constraint->add_displacements_m(), 0.1, 0.2, 0.3);
  set(constraint->add_displacements_m(), 0.4, 0.5, 0.6);
  add_constraint(scene, false, false, true).mutable_region()->set_all(true);

  v1::Load* load = scene.add_loads();
  load->mutable_point()->set_vertex(5);
  set(load->mutable_point()->mutable_force_n(), 1.0, 2.0, 3.0);
  load->mutable_history()->add_times(1.0);
  load->mutable_history()->add_factors(2.0);
  load = scene.add_loads();
  load->mutable_point()->mutable_material()->set_x(0.1);
  load->mutable_point()->mutable_material()->set_y(0.2);
  set(load->mutable_point()->mutable_force_n(), 0.0, 0.0, -3.0);
  load = scene.add_loads();
  load->mutable_edge()->mutable_region()->set_edge(v1::Region::TOP);
  set(load->mutable_edge()->mutable_force_n(), 0.0, 1.0, 0.0);
  load = scene.add_loads();
  set_line(*load->mutable_edge()->mutable_region(), 0.0, 0.0, 0.0, 0.3).set_side(v1::MaterialLine::RIGHT_OF_LINE);
  set(load->mutable_edge()->mutable_force_npm(), 0.0, 1.0, 0.0);
  load = scene.add_loads();
  load->mutable_area()->mutable_region()->set_all(true);
  set(load->mutable_area()->mutable_force_n(), 0.0, 0.0, 0.5);
  load = scene.add_loads();
  load->mutable_area()->mutable_region()->set_all(true);
  set(load->mutable_area()->mutable_traction_pa(), 0.0, 0.0, 0.25);
  load = scene.add_loads();
  load->mutable_pressure()->mutable_region()->set_all(true);
  load->mutable_pressure()->set_pressure_pa(-3.0);
  load = scene.add_loads();
  load->mutable_moment()->mutable_region()->set_edge(v1::Region::LEFT);
  load->mutable_moment()->set_moment_nm(0.1);
  load = scene.add_loads();
  load->mutable_moment()->mutable_region()->set_edge(v1::Region::RIGHT);
  load->mutable_moment()->set_moment_nm_per_m(0.2);
  load = scene.add_loads();
  v1::MaterialCurve& lip = *load->mutable_edge()->mutable_region()->mutable_curve();
  set(lip.mutable_curve()->mutable_circle()->mutable_center(), 0.1, 0.2);
  lip.mutable_curve()->mutable_circle()->set_radius_m(0.05);
  lip.set_within_m(0.001);
  lip.set_side(v1::MaterialLine::RIGHT_OF_LINE);
  load->mutable_edge()->set_normal_npm(-0.5);
  set(load->mutable_edge()->mutable_factor()->mutable_zero(), 0.1, 0.0);
  load->mutable_edge()->mutable_factor()->set_by_x(3.0);
  load->mutable_edge()->mutable_factor()->set_by_y(-4.0);
  load = scene.add_loads();
  set(load->mutable_edge()->mutable_region()->mutable_border(), 0.1, 0.3);
  load->mutable_edge()->set_normal_npm(0.0);
  scene.mutable_gravity_history()->add_times(0.0);
  scene.mutable_gravity_history()->add_factors(0.5);
  v1::InitialVelocity& velocity = *scene.mutable_initial_velocity();
  set(velocity.mutable_linear_mps(), 1.0, 0.0, 0.0);
  set(velocity.mutable_angular_radps(), 0.0, 2.0, 0.0);
  set(velocity.mutable_center(), 0.0, 0.0, 3.0);

  v1::ModalAnalysis& modes = *scene.mutable_analysis()->mutable_modes();
  modes.set_count(7);
  for (const double step : {0.25, 1.0}) modes.mutable_about()->add_loads(step);
  modes.mutable_about()->set_tolerance(1e-7);
  modes.mutable_about()->set_max_iterations(99);
  const auto add_probe = [&scene](const std::string& name, v1::Probe::Quantity quantity, v1::Probe::Reduce reduce) {
    v1::Probe* probe = scene.add_probes();
    probe->set_name(name);
    probe->set_quantity(quantity);
    probe->set_reduce(reduce);
    return probe;
  };
  v1::Probe* probe = add_probe("tip", v1::Probe::DISPLACEMENT, v1::Probe::EACH);
  probe->add_points()->set_x(0.25);
  probe->mutable_points(0)->set_y(0.0);
  probe->mutable_side()->set_x(0.25);
  probe->mutable_side()->set_y(0.1);
  add_probe("top", v1::Probe::REACTION, v1::Probe::SUM)->mutable_region()->set_edge(v1::Region::TOP);
  add_probe("energy", v1::Probe::ENERGY, v1::Probe::EACH);
  probe = add_probe("peak", v1::Probe::STRESS, v1::Probe::MAX);
  probe->mutable_region()->set_all(true);
  probe->set_recovery(v1::Probe::PATCH);
  probe->set_stress_measure(v1::Probe::CAUCHY);
  probe = add_probe("strain", v1::Probe::STRAIN, v1::Probe::MEAN);
  probe->mutable_region()->set_edge(v1::Region::TOP);
  probe->set_recovery(v1::Probe::OF_TRIANGLES);
}

}  // namespace kerf::testing

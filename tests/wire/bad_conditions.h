#pragma once

#include <functional>
#include <limits>
#include <string>
#include <vector>

#include "kerf/v1/scene.pb.h"
#include "tests/wire/condition_samples.h"

namespace kerf::testing {

// A change to full_scene() that must be refused, and the field that the refusal names.
struct BadScene {
  std::string field;
  std::function<void(v1::Scene&)> spoil;
};

// Constraints on a line, a nearest vertex (with a rotation), two listed vertices and the whole sheet; see
// add_conditions.
inline std::vector<BadScene> bad_conditions() {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  return {
      {"constraints[0].region.region", [](v1::Scene& s) { s.mutable_constraints(0)->clear_region(); }},
      {"constraints[0].region.line.a.x",
       [=](v1::Scene& s) { s.mutable_constraints(0)->mutable_region()->mutable_line()->mutable_a()->set_x(nan); }},
      {"constraints[0].region.line.b",
       [](v1::Scene& s) { set(s.mutable_constraints(0)->mutable_region()->mutable_line()->mutable_b(), 0.0, 0.1); }},
      {"constraints[0].region.line.within_m",
       [](v1::Scene& s) { s.mutable_constraints(0)->mutable_region()->mutable_line()->set_within_m(-1.0); }},
      {"constraints[0].region.line.side",
       [](v1::Scene& s) {
         s.mutable_constraints(0)->mutable_region()->mutable_line()->set_side(static_cast<v1::MaterialLine::Side>(7));
       }},
      {"constraints[0].displacement_m.z",
       [](v1::Scene& s) { s.mutable_constraints(0)->mutable_displacement_m()->set_z(1.1e6); }},
      {"constraints[0].stretch_y.x", [=](v1::Scene& s) { s.mutable_constraints(0)->mutable_stretch_y()->set_x(nan); }},
      {"constraints[0].history.factors",
       [](v1::Scene& s) { s.mutable_constraints(0)->mutable_history()->add_times(9.0); }},
      {"constraints[0].history.times[2]",
       [](v1::Scene& s) { s.mutable_constraints(0)->mutable_history()->set_times(2, 0.5); }},
      {"constraints[0].history.factors[1]",
       [](v1::Scene& s) { s.mutable_constraints(0)->mutable_history()->set_factors(1, 1.1e6); }},
      {"constraints[0].history.times",
       [](v1::Scene& s) {
         for (int i = 0; i < 4094; ++i) {
           s.mutable_constraints(0)->mutable_history()->add_times(3.0 + i);
           s.mutable_constraints(0)->mutable_history()->add_factors(1.0);
         }
       }},
      {"constraints[0].until", [=](v1::Scene& s) { s.mutable_constraints(0)->set_until(nan); }},
      {"constraints[0].slope", [](v1::Scene& s) { s.mutable_constraints(0)->set_slope(true); }},
      {"constraints[0].axis", [](v1::Scene& s) { s.mutable_constraints(0)->set_angle_rad(1.0); }},
      {"constraints[1].region.nearest.y",
       [](v1::Scene& s) { s.mutable_constraints(1)->mutable_region()->mutable_nearest()->set_y(1.1e4); }},
      {"constraints[1].axis", [](v1::Scene& s) { set(s.mutable_constraints(1)->mutable_axis(), 0.0, 0.0, 0.0); }},
      {"constraints[1].angle_rad", [](v1::Scene& s) { s.mutable_constraints(1)->set_angle_rad(1.1e4); }},
      {"constraints[2].displacements_m", [](v1::Scene& s) { s.mutable_constraints(2)->add_displacements_m(); }},
      {"constraints[2].displacements_m[1].y",
       [=](v1::Scene& s) { s.mutable_constraints(2)->mutable_displacements_m(1)->set_y(nan); }},
      {"constraints[3].region.region",
       [](v1::Scene& s) { s.mutable_constraints(3)->mutable_region()->set_all(false); }},
      {"constraints",
       [](v1::Scene& s) {
         for (int i = 0; i < 61; ++i) *s.add_constraints() = s.constraints(3);
       }},
      {"loads[0].kind", [](v1::Scene& s) { s.mutable_loads(0)->clear_kind(); }},
      {"loads[0].point.point", [](v1::Scene& s) { s.mutable_loads(0)->mutable_point()->clear_point(); }},
      {"loads[0].point.vertex", [](v1::Scene& s) { s.mutable_loads(0)->mutable_point()->set_vertex(-1); }},
      {"loads[0].history.times[0]", [](v1::Scene& s) { s.mutable_loads(0)->mutable_history()->set_times(0, 1.1e7); }},
      {"loads[1].point.material.x",
       [=](v1::Scene& s) { s.mutable_loads(1)->mutable_point()->mutable_material()->set_x(nan); }},
      {"loads[1].point.force_n.x",
       [](v1::Scene& s) { s.mutable_loads(1)->mutable_point()->mutable_force_n()->set_x(1.1e12); }},
      {"loads[2].edge.amount", [](v1::Scene& s) { s.mutable_loads(2)->mutable_edge()->clear_amount(); }},
      {"loads[2].edge.region.region", [](v1::Scene& s) { s.mutable_loads(2)->mutable_edge()->clear_region(); }},
      {"loads[3].edge.force_npm.y",
       [=](v1::Scene& s) { s.mutable_loads(3)->mutable_edge()->mutable_force_npm()->set_y(nan); }},
      {"loads[4].area.amount", [](v1::Scene& s) { s.mutable_loads(4)->mutable_area()->clear_amount(); }},
      {"loads[5].area.traction_pa.z",
       [=](v1::Scene& s) { s.mutable_loads(5)->mutable_area()->mutable_traction_pa()->set_z(nan); }},
      {"loads[6].pressure.pressure_pa",
       [](v1::Scene& s) { s.mutable_loads(6)->mutable_pressure()->set_pressure_pa(1.1e12); }},
      {"loads[6].pressure.region.region", [](v1::Scene& s) { s.mutable_loads(6)->mutable_pressure()->clear_region(); }},
      {"loads[7].moment.amount", [](v1::Scene& s) { s.mutable_loads(7)->mutable_moment()->clear_amount(); }},
      {"loads[7].moment.moment_nm", [=](v1::Scene& s) { s.mutable_loads(7)->mutable_moment()->set_moment_nm(nan); }},
      {"loads[8].moment.moment_nm_per_m",
       [=](v1::Scene& s) { s.mutable_loads(8)->mutable_moment()->set_moment_nm_per_m(nan); }},
      {"loads[9].edge.region.curve.curve",
       [](v1::Scene& s) { s.mutable_loads(9)->mutable_edge()->mutable_region()->mutable_curve()->clear_curve(); }},
      {"loads[9].edge.region.curve.curve.circle.radius_m",
       [](v1::Scene& s) {
         v1::MaterialCurve& curve = *s.mutable_loads(9)->mutable_edge()->mutable_region()->mutable_curve();
         curve.mutable_curve()->mutable_circle()->set_radius_m(-1.0);
       }},
      {"loads[9].edge.region.curve.curve.svg.file",
       [](v1::Scene& s) {
         v1::MaterialCurve& curve = *s.mutable_loads(9)->mutable_edge()->mutable_region()->mutable_curve();
         curve.mutable_curve()->mutable_svg()->set_file("/etc/passwd");
       }},
      {"loads[9].edge.region.curve.within_m",
       [](v1::Scene& s) { s.mutable_loads(9)->mutable_edge()->mutable_region()->mutable_curve()->set_within_m(-1.0); }},
      {"loads[9].edge.region.curve.side",
       [](v1::Scene& s) {
         s.mutable_loads(9)->mutable_edge()->mutable_region()->mutable_curve()->set_side(
             static_cast<v1::MaterialLine::Side>(4));
       }},
      {"loads[9].edge.normal_npm", [=](v1::Scene& s) { s.mutable_loads(9)->mutable_edge()->set_normal_npm(nan); }},
      {"loads[9].edge.factor.by_x",
       [](v1::Scene& s) { s.mutable_loads(9)->mutable_edge()->mutable_factor()->set_by_x(1.1e6); }},
      {"loads[9].edge.factor.by_x",
       [](v1::Scene& s) {
         s.mutable_loads(9)->mutable_edge()->mutable_factor()->set_by_x(0.0);
         s.mutable_loads(9)->mutable_edge()->mutable_factor()->set_by_y(0.0);
       }},
      {"loads[9].edge.factor.zero.x",
       [=](v1::Scene& s) { s.mutable_loads(9)->mutable_edge()->mutable_factor()->mutable_zero()->set_x(nan); }},
      {"loads[10].edge.region.border.x",
       [=](v1::Scene& s) { s.mutable_loads(10)->mutable_edge()->mutable_region()->mutable_border()->set_x(nan); }},
      {"loads",
       [](v1::Scene& s) {
         for (int i = 0; i < 59; ++i) *s.add_loads() = s.loads(0);
       }},
      {"gravity_history.factors", [](v1::Scene& s) { s.mutable_gravity_history()->clear_factors(); }},
      {"initial_velocity.linear_mps.x",
       [](v1::Scene& s) { s.mutable_initial_velocity()->mutable_linear_mps()->set_x(1.1e6); }},
      {"initial_velocity.angular_radps.z",
       [=](v1::Scene& s) { s.mutable_initial_velocity()->mutable_angular_radps()->set_z(nan); }},
      {"initial_velocity.center.z", [=](v1::Scene& s) { s.mutable_initial_velocity()->mutable_center()->set_z(nan); }},
  };
}

inline std::vector<BadScene> bad_analyses() {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const auto about = [](v1::Scene& s) { return s.mutable_analysis()->mutable_modes()->mutable_about(); };
  return {
      {"analysis.modes.count", [](v1::Scene& s) { s.mutable_analysis()->mutable_modes()->set_count(201); }},
      {"analysis.modes.about.loads[1]", [=](v1::Scene& s) { about(s)->set_loads(1, 1.01); }},
      {"analysis.modes.about.loads[1]", [=](v1::Scene& s) { about(s)->set_loads(1, 0.25); }},
      {"analysis.modes.about.loads[0]", [=](v1::Scene& s) { about(s)->set_loads(0, 0.0); }},
      {"analysis.modes.about.steps", [=](v1::Scene& s) { about(s)->set_steps(4); }},
      {"analysis.modes.about.tolerance", [=](v1::Scene& s) { about(s)->set_tolerance(1e-14); }},
      {"analysis.modes.about.max_iterations", [=](v1::Scene& s) { about(s)->set_max_iterations(100001); }},
      {"analysis.static.steps", [](v1::Scene& s) { s.mutable_analysis()->mutable_static_()->set_steps(10001); }},
      {"analysis.static.steps", [](v1::Scene& s) { s.mutable_analysis()->mutable_static_()->set_steps(-1); }},
      {"probes[0].name", [](v1::Scene& s) { s.mutable_probes(0)->set_name("Tip"); }},
      {"probes[0].name", [](v1::Scene& s) { s.mutable_probes(0)->set_name(std::string(64, 'a')); }},
      {"probes[1].name", [](v1::Scene& s) { s.mutable_probes(1)->set_name("tip"); }},
      {"probes[0].quantity", [](v1::Scene& s) { s.mutable_probes(0)->clear_quantity(); }},
      {"probes[0].points", [](v1::Scene& s) { s.mutable_probes(0)->clear_points(); }},
      {"probes[0].points", [](v1::Scene& s) { s.mutable_probes(0)->mutable_region()->set_all(true); }},
      {"probes[0].points",
       [](v1::Scene& s) {
         for (int i = 0; i < 1024; ++i) s.mutable_probes(0)->add_points();
       }},
      {"probes[0].points[0].y", [=](v1::Scene& s) { s.mutable_probes(0)->mutable_points(0)->set_y(nan); }},
      {"probes[0].side.x", [=](v1::Scene& s) { s.mutable_probes(0)->mutable_side()->set_x(nan); }},
      {"probes[0].reduce", [](v1::Scene& s) { s.mutable_probes(0)->set_reduce(static_cast<v1::Probe::Reduce>(9)); }},
      {"probes[0].region", [](v1::Scene& s) { s.mutable_probes(0)->set_quantity(v1::Probe::REACTION); }},
      {"probes[0].recovery", [](v1::Scene& s) { s.mutable_probes(0)->set_recovery(v1::Probe::PATCH); }},
      {"probes[3].recovery",
       [](v1::Scene& s) { s.mutable_probes(3)->set_recovery(static_cast<v1::Probe::Recovery>(3)); }},
      {"probes[3].stress_measure",
       [](v1::Scene& s) { s.mutable_probes(3)->set_stress_measure(static_cast<v1::Probe::StressMeasure>(-1)); }},
      {"probes[4].stress_measure", [](v1::Scene& s) { s.mutable_probes(4)->set_stress_measure(v1::Probe::CAUCHY); }},
      {"analysis.dynamic.ticks", [](v1::Scene& s) { s.mutable_analysis()->mutable_dynamic()->set_ticks(1); }},
      {"analysis.dynamic.measure_every",
       [](v1::Scene& s) { s.mutable_analysis()->mutable_dynamic()->set_measure_every(-1); }},
      {"analysis.dynamic.measure_every",
       [](v1::Scene& s) { s.mutable_analysis()->mutable_dynamic()->set_measure_every(10'000'001); }},
      {"probes[1].reduce", [](v1::Scene& s) { s.mutable_probes(1)->set_reduce(v1::Probe::EACH); }},
      {"probes[1].points", [](v1::Scene& s) { s.mutable_probes(1)->set_quantity(v1::Probe::OPENING); }},
      {"probes[2].points", [](v1::Scene& s) { s.mutable_probes(2)->add_points(); }},
      {"probes[2].region", [](v1::Scene& s) { s.mutable_probes(2)->mutable_region()->set_all(true); }},
      {"probes",
       [](v1::Scene& s) {
         for (int i = 0; i < 62; ++i) *s.add_probes() = s.probes(2);
       }},
  };
}

}  // namespace kerf::testing

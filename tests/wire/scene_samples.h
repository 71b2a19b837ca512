#pragma once

#include <cstdint>

#include "kerf/v1/scene.pb.h"
#include "tests/wire/condition_samples.h"
#include "tests/wire/outline_samples.h"

namespace kerf::testing {

inline v1::Command& add_command(v1::Scene& scene, std::int64_t tick) {
  v1::ScheduledCommand& scheduled = *scene.add_commands();
  scheduled.set_tick(tick);
  return *scheduled.mutable_command();
}

// Cuts of the kinds and with the fields that the first three lack.
inline void add_placed_cuts(v1::Scene& scene) {
  v1::Cut* cut = add_command(scene, 10).mutable_cut();
  v1::Ellipse* ellipse = cut->mutable_curve()->mutable_ellipse();
  set(ellipse->mutable_center(), 0.5, 0.4);
  ellipse->set_semi_axis_x_m(0.2);
  ellipse->set_semi_axis_y_m(0.1);
  ellipse->set_rotation_rad(0.3);
  cut->set_tolerance(0.02);
  cut->set_min_angle_deg(20.0);
  cut->set_max_new_triangles(200000);
  cut->set_method(v1::Cut::NEIGHBOURHOOD);
  cut->set_tip_grading(1.5);
  cut->set_relax(true);
  set(cut->mutable_fit()->mutable_min(), 0.0, 0.1);
  set(cut->mutable_fit()->mutable_max(), 0.5, 0.6);
  cut->add_dash(0.03);
  cut->add_dash(0.01);
  cut->set_dash_offset(-0.005);
  cut = add_command(scene, 11).mutable_cut();
  v1::Path::Subpath* subpath = cut->mutable_curve()->mutable_path()->add_subpaths();
  set(subpath->mutable_start(), 0.1, 0.1);
  subpath->set_closed(true);
  set(subpath->add_segments()->mutable_line(), 0.2, 0.1);
  v1::Path::Quadratic* quadratic = subpath->add_segments()->mutable_quadratic();
  set(quadratic->mutable_control(), 0.3, 0.1);
  set(quadratic->mutable_end(), 0.3, 0.2);
  v1::Path::Cubic* cubic = subpath->add_segments()->mutable_cubic();
  set(cubic->mutable_control_1(), 0.3, 0.3);
  set(cubic->mutable_control_2(), 0.2, 0.4);
  set(cubic->mutable_end(), 0.1, 0.3);
  for (const double weight : {1.0, 2.0, 0.5, 1.0}) cubic->add_weights(weight);
  v1::Path::Arc* arc = subpath->add_segments()->mutable_arc();
  arc->set_semi_axis_x_m(0.3);
  arc->set_semi_axis_y_m(0.2);
  arc->set_rotation_rad(-0.1);
  arc->set_large(true);
  arc->set_counter_clockwise(true);
  set(arc->mutable_end(), 0.1, 0.2);
  cut->set_tolerance(0.02);
  cut->set_min_angle_deg(20.0);
  cut->set_max_new_triangles(200000);
  cut->set_method(v1::Cut::NEIGHBOURHOOD);
  cut->set_tip_grading(1.5);
  cut->set_relax(true);
  cut->mutable_fit();
}

// Every number of a material given.
inline v1::Material full_material() {
  v1::Material material;
  material.set_youngs_modulus_pa(4.0e5);
  material.set_youngs_modulus_2_pa(3.0e5);
  material.set_poissons_ratio(0.31);
  material.set_shear_modulus_pa(1.1e5);
  material.set_direction_rad(0.4);
  material.set_thickness_m(4.0e-4);
  material.set_density_kgpm3(410.0);
  material.set_bending_scale(0.7);
  material.set_mass_damping_per_s(0.1);
  material.set_stiffness_damping_s(0.001);
  material.set_strain_limit(0.25);
  material.set_bending_stiffness_1_nm(2.0e-6);
  material.set_bending_stiffness_2_nm(1.5e-6);
  material.set_bending_coupling_nm(-3.0e-7);
  material.set_twisting_stiffness_nm(5.0e-7);
  return material;
}

inline void add_commands(v1::Scene& scene) {
  v1::Cut* cut = add_command(scene, 1).mutable_cut();
  for (int i = 0; i < 4; ++i) set(cut->mutable_curve()->mutable_bezier()->add_points(), 0.1 * i, 0.3);
  cut->set_tolerance(0.01);
  cut->set_min_angle_deg(15.0);
  cut->set_max_new_triangles(1000);
  cut->set_method(v1::Cut::NEIGHBOURHOOD);
  cut->set_tip_edge_length_m(0.001);
  cut->set_tip_grading(1.25);
  cut->set_tolerance_m(2e-5);
  cut->set_width_m(0.004);
  cut->set_relax(false);
  cut = add_command(scene, 2).mutable_cut();
  set(cut->mutable_curve()->mutable_polyline()->add_points(), 0.1, 0.2);
  set(cut->mutable_curve()->mutable_polyline()->add_points(), 0.3, 0.4);
  cut->set_tolerance(0.02);
  cut->set_min_angle_deg(20.0);
  cut->set_max_new_triangles(200000);
  cut->set_method(v1::Cut::ELEMENT);
  cut->set_tip_grading(1.5);
  cut->set_relax(true);
  cut = add_command(scene, 3).mutable_cut();
  set(cut->mutable_curve()->mutable_circle()->mutable_center(), 0.5, 0.5);
  cut->mutable_curve()->mutable_circle()->set_radius_m(0.2);
  cut->set_tolerance(0.5);
  cut->set_min_angle_deg(5.0);
  cut->set_max_new_triangles(1);
  cut->set_method(v1::Cut::NEIGHBOURHOOD);
  cut->set_tip_grading(10.0);
  cut->set_relax(true);
  v1::Grab* grab = add_command(scene, 4).mutable_grab();
  grab->set_grab_id("hand");
  grab->set_vertex(0);
  set(grab->mutable_target(), 1.0 / 3.0, 2.0, 3.0);
  grab->set_stiffness_npm(12.5);
  grab = add_command(scene, 4).mutable_grab();
  grab->set_grab_id("finger");
  set(grab->mutable_material(), 0.5, 0.25);
  grab->set_stiffness_npm(0.0);
  v1::Drag* drag = add_command(scene, 5).mutable_drag();
  drag->set_grab_id("hand");
  set(drag->mutable_target(), 0.0, 1.0, 0.0);
  add_command(scene, 6).mutable_release()->set_grab_id("hand");
  add_command(scene, 7).mutable_set_pins()->add_pins()->set_edge(v1::Region::BOTTOM);
  set(add_command(scene, 8).mutable_set_gravity()->mutable_gravity_mps2(), 0.0, 0.0, -1.62);
  v1::Wind* wind = add_command(scene, 9).mutable_set_wind()->mutable_wind();
  set(wind->mutable_velocity_mps(), 3.0, 0.0, 0.0);
  wind->set_air_density_kgpm3(1.0);
  wind->set_drag_coefficient(2.0);
  add_placed_cuts(scene);
  v1::CutBatch* batch = add_command(scene, 12).mutable_cut_batch();
  *batch->add_cuts() = scene.commands(0).command().cut();
  *batch->add_cuts() = scene.commands(2).command().cut();
  add_command(scene, 13).mutable_undo_cut();
  add_command(scene, 14).mutable_redo_cut();
  v1::SetMaterial* set_material = add_command(scene, 15).mutable_set_material();
  *set_material->mutable_material() = full_material();
  set_material->set_part(-1);
  *add_command(scene, 16).mutable_set_material()->mutable_material() = full_material();
  v1::SetSelfContact* set_self_contact = add_command(scene, 17).mutable_set_self_contact();
  set_self_contact->set_mode(v1::SelfContact::ON);
  set_self_contact->set_friction(0.0);
  set_self_contact->set_thickness_m(0.002);
  add_command(scene, 18).mutable_set_self_contact()->set_mode(v1::SelfContact::OFF);
  add_command(scene, 19).mutable_set_self_contact();
  add_command(scene, 20).mutable_set_self_contact()->set_material_thickness(true);
}

// Every field given that an encoder writes; the kinds of commands, pins and colliders all there.
inline v1::Scene full_scene() {
  v1::Scene scene;
  scene.set_sheet_id("flag-1");
  scene.set_max_vertices(12'345);
  v1::GridMesh* grid = scene.mutable_grid();
  grid->set_columns(7);
  grid->set_rows(5);
  grid->set_width_m(1.2);
  grid->set_height_m(0.8);
  grid->set_pattern(v1::GridMesh::JITTERED_DELAUNAY);
  grid->set_seed(42);
  const v1::Material material = full_material();
  *scene.mutable_material() = material;
  for (const double density : {500.0, 600.0}) {
    v1::RegionMaterial* part = scene.add_materials();
    set(part->mutable_region()->mutable_box()->mutable_min(), 0.0, 0.0);
    set(part->mutable_region()->mutable_box()->mutable_max(), 0.5, 0.001 * density);
    *part->mutable_material() = material;
    part->mutable_material()->set_density_kgpm3(density);
  }
  set(scene.mutable_placement()->mutable_origin(), 0.1, 0.2, 0.3);
  set(scene.mutable_placement()->mutable_x_axis(), 0.0, 1.0, 0.0);
  set(scene.mutable_placement()->mutable_y_axis(), 1.0, 0.0, 0.0);
  for (const auto edge : {v1::Region::TOP, v1::Region::BOTTOM, v1::Region::LEFT, v1::Region::RIGHT, v1::Region::CORNERS,
                          v1::Region::TOP_CORNERS}) {
    scene.add_pins()->set_edge(edge);
  }
  v1::MaterialBox* box = scene.add_pins()->mutable_box();
  set(box->mutable_min(), 0.0, 0.1);
  set(box->mutable_max(), 0.2, 0.3);
  scene.add_pins()->mutable_vertices()->add_vertices(3);
  set(scene.mutable_gravity_mps2(), 0.0, 0.0, -3.7);
  set(scene.mutable_wind()->mutable_velocity_mps(), 1.0, 2.0, 3.0);
  scene.mutable_wind()->set_air_density_kgpm3(1.3);
  scene.mutable_wind()->set_drag_coefficient(0.9);
  v1::Collider* collider = scene.add_colliders();
  set(collider->mutable_plane()->mutable_point(), 0.0, 0.0, -1.0);
  set(collider->mutable_plane()->mutable_normal(), 0.0, 0.0, 1.0);
  collider->set_friction(0.4);
  collider = scene.add_colliders();
  set(collider->mutable_sphere()->mutable_center(), 0.5, 0.0, 0.0);
  collider->mutable_sphere()->set_radius_m(0.25);
  collider = scene.add_colliders();
  set(collider->mutable_box()->mutable_center(), 1.0, 1.0, 1.0);
  set(collider->mutable_box()->mutable_half_extents_m(), 0.1, 0.2, 0.3);
  set(collider->mutable_box()->mutable_axis(), 0.0, 1.0, 0.0);
  collider->mutable_box()->set_angle_rad(0.5);
  collider = scene.add_colliders();
  set(collider->mutable_capsule()->mutable_a(), 0.0, 0.0, 0.0);
  set(collider->mutable_capsule()->mutable_b(), 0.0, 0.0, 1.0);
  collider->mutable_capsule()->set_radius_m(0.05);
  scene.mutable_self_contact()->set_mode(v1::SelfContact::OFF);
  scene.mutable_self_contact()->set_friction(0.7);
  scene.mutable_self_contact()->set_thickness_m(0.004);
  scene.set_tick_rate_hz(120.0);
  v1::Integrator* integrator = scene.mutable_integrator();
  integrator->set_kind(v1::Integrator::IMPLICIT_EULER);
  integrator->set_solver(v1::Integrator::DIRECT);
  integrator->set_max_substeps(77);
  integrator->set_newton_iterations(3);
  integrator->set_solver_tolerance(1e-6);
  integrator->set_max_linear_iterations(123);
  integrator->mutable_covariance_root()->set_norm(v1::CovarianceRoot::LOG_NORM);
  integrator->mutable_covariance_root()->set_p(0.25);
  integrator->mutable_covariance_root()->set_newton_schulz_iterations(7);
  integrator->set_highest_mode_damping(0.25);
  integrator->set_precision(v1::Integrator::MIXED);
  scene.set_membrane_law(v1::GREEN);
  scene.set_fidelity(v1::REAL_TIME);
  add_commands(scene);
  add_conditions(scene);
  scene.set_ticks(900);
  scene.set_description("a flag");
  return scene;
}

}  // namespace kerf::testing

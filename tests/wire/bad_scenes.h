#pragma once

#include <limits>
#include <string>
#include <utility>
#include <vector>

#include "kerf/v1/scene.pb.h"
#include "tests/wire/bad_conditions.h"
#include "tests/wire/scene_samples.h"

// Changes of full_scene() that make it invalid, each with the field that the error names.
namespace kerf::testing {

inline std::vector<BadScene> bad_shapes() {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const double infinity = std::numeric_limits<double>::infinity();
  return {
      {"sheet_id", [](v1::Scene& s) { s.set_sheet_id("Flag"); }},
      {"mesh", [](v1::Scene& s) { s.clear_mesh(); }},
      {"grid.columns", [](v1::Scene& s) { s.mutable_grid()->set_columns(1); }},
      {"grid.columns", [](v1::Scene& s) { s.mutable_grid()->set_columns(1001); }},
      {"grid.rows", [](v1::Scene& s) { s.mutable_grid()->set_rows(-5); }},
      {"grid.rows",
       [](v1::Scene& s) {
         s.mutable_grid()->set_columns(1000);
         s.mutable_grid()->set_rows(501);
       }},
      {"grid.width_m", [=](v1::Scene& s) { s.mutable_grid()->set_width_m(nan); }},
      {"grid.width_m", [](v1::Scene& s) { s.mutable_grid()->set_width_m(0.0); }},
      {"grid.height_m", [=](v1::Scene& s) { s.mutable_grid()->set_height_m(infinity); }},
      {"grid.height_m", [](v1::Scene& s) { s.mutable_grid()->set_height_m(1.0001e4); }},
      {"grid.pattern", [](v1::Scene& s) { s.mutable_grid()->set_pattern(static_cast<v1::GridMesh::Pattern>(9)); }},
      {"obj.text", [](v1::Scene& s) { s.mutable_obj(); }},
      {"obj.file", [](v1::Scene& s) { s.mutable_obj()->set_file("/etc/passwd"); }},
      {"ply.data", [](v1::Scene& s) { s.mutable_ply(); }},
      {"ply.file", [](v1::Scene& s) { s.mutable_ply()->set_file("/etc/passwd"); }},
      {"inline.material_positions", [](v1::Scene& s) { s.mutable_inline_()->add_material_positions(1.0); }},
      {"inline.material_positions", [](v1::Scene& s) { s.mutable_inline_(); }},
      {"inline.triangles", [](v1::Scene& s) { s.mutable_inline_()->add_triangles(0); }},
      {"inline.positions", [](v1::Scene& s) { s.mutable_inline_()->add_positions(0.0); }},
      {"placement.origin.y", [=](v1::Scene& s) { s.mutable_placement()->mutable_origin()->set_y(nan); }},
      {"placement.origin.z", [](v1::Scene& s) { s.mutable_placement()->mutable_origin()->set_z(1.1e6); }},
      {"placement.x_axis", [](v1::Scene& s) { set(s.mutable_placement()->mutable_x_axis(), 0.0, 0.0, 0.0); }},
      {"placement.y_axis", [](v1::Scene& s) { set(s.mutable_placement()->mutable_y_axis(), 0.0, 1.0, 0.0); }},
      {"colliders[0].plane.normal", [](v1::Scene& s) { s.mutable_colliders(0)->mutable_plane()->clear_normal(); }},
      {"colliders[0].friction", [](v1::Scene& s) { s.mutable_colliders(0)->set_friction(-0.1); }},
      {"colliders[1].sphere.radius_m", [](v1::Scene& s) { s.mutable_colliders(1)->mutable_sphere()->set_radius_m(0); }},
      {"colliders[1].sphere.center.x",
       [=](v1::Scene& s) { s.mutable_colliders(1)->mutable_sphere()->mutable_center()->set_x(infinity); }},
      {"colliders[2].box.half_extents_m.y",
       [](v1::Scene& s) { s.mutable_colliders(2)->mutable_box()->mutable_half_extents_m()->set_y(0.0); }},
      {"colliders[2].box.angle_rad", [=](v1::Scene& s) { s.mutable_colliders(2)->mutable_box()->set_angle_rad(nan); }},
      {"colliders[3].capsule.radius_m",
       [](v1::Scene& s) { s.mutable_colliders(3)->mutable_capsule()->set_radius_m(2e4); }},
      {"colliders[3].shape", [](v1::Scene& s) { s.mutable_colliders(3)->clear_shape(); }},
      {"colliders",
       [](v1::Scene& s) {
         for (int i = 0; i < 61; ++i) *s.add_colliders() = s.colliders(1);
       }},
  };
}

inline std::vector<BadScene> bad_self_contact() {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  return {
      {"self_contact.mode",
       [](v1::Scene& s) { s.mutable_self_contact()->set_mode(static_cast<v1::SelfContact::Mode>(3)); }},
      {"self_contact.mode",
       [](v1::Scene& s) {
         s.mutable_self_contact()->set_mode(v1::SelfContact::ON);
         s.set_planar(true);
       }},
      {"self_contact.friction", [](v1::Scene& s) { s.mutable_self_contact()->set_friction(-1e-9); }},
      {"self_contact.friction", [](v1::Scene& s) { s.mutable_self_contact()->set_friction(10.001); }},
      {"self_contact.friction", [=](v1::Scene& s) { s.mutable_self_contact()->set_friction(nan); }},
      {"self_contact.thickness_m", [](v1::Scene& s) { s.mutable_self_contact()->set_thickness_m(0.0); }},
      {"self_contact.thickness_m", [](v1::Scene& s) { s.mutable_self_contact()->set_thickness_m(0.1001); }},
      {"self_contact.thickness_m", [=](v1::Scene& s) { s.mutable_self_contact()->set_thickness_m(nan); }},
  };
}

inline std::vector<BadScene> bad_numbers() {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const double infinity = std::numeric_limits<double>::infinity();
  return {
      {"material.preset", [](v1::Scene& s) { s.mutable_material()->set_preset("adamantium"); }},
      {"material.youngs_modulus_pa", [](v1::Scene& s) { s.mutable_material()->set_youngs_modulus_pa(0.0); }},
      {"material.youngs_modulus_pa", [](v1::Scene& s) { s.mutable_material()->set_youngs_modulus_pa(1.1e12); }},
      {"material.youngs_modulus_2_pa", [=](v1::Scene& s) { s.mutable_material()->set_youngs_modulus_2_pa(nan); }},
      {"material.poissons_ratio", [](v1::Scene& s) { s.mutable_material()->set_poissons_ratio(1.0); }},
      {"material.poissons_ratio",
       [](v1::Scene& s) {
         s.mutable_material()->set_poissons_ratio(0.9);
         s.mutable_material()->set_youngs_modulus_2_pa(8.0e5);
       }},
      {"material.shear_modulus_pa", [](v1::Scene& s) { s.mutable_material()->set_shear_modulus_pa(-1.0); }},
      {"material.direction_rad", [](v1::Scene& s) { s.mutable_material()->set_direction_rad(7.0); }},
      {"material.thickness_m", [](v1::Scene& s) { s.mutable_material()->set_thickness_m(1.01); }},
      {"material.density_kgpm3", [=](v1::Scene& s) { s.mutable_material()->set_density_kgpm3(infinity); }},
      {"material.bending_scale", [](v1::Scene& s) { s.mutable_material()->set_bending_scale(-1e-9); }},
      {"material.mass_damping_per_s", [](v1::Scene& s) { s.mutable_material()->set_mass_damping_per_s(1001.0); }},
      {"material.stiffness_damping_s", [](v1::Scene& s) { s.mutable_material()->set_stiffness_damping_s(1.1); }},
      {"material.strain_limit", [](v1::Scene& s) { s.mutable_material()->set_strain_limit(0.0); }},
      {"material.bending_stiffness_1_nm", [](v1::Scene& s) { s.mutable_material()->set_bending_stiffness_1_nm(0.0); }},
      {"material.bending_stiffness_1_nm", [=](v1::Scene& s) { s.mutable_material()->set_bending_stiffness_1_nm(nan); }},
      {"material.bending_stiffness_2_nm",
       [](v1::Scene& s) { s.mutable_material()->set_bending_stiffness_2_nm(1.1e14); }},
      {"material.bending_coupling_nm", [](v1::Scene& s) { s.mutable_material()->set_bending_coupling_nm(1.8e-6); }},
      {"material.bending_coupling_nm", [](v1::Scene& s) { s.mutable_material()->set_bending_coupling_nm(-1.1e14); }},
      {"material.twisting_stiffness_nm", [](v1::Scene& s) { s.mutable_material()->set_twisting_stiffness_nm(9e-26); }},
      {"material.twisting_stiffness_nm",
       [](v1::Scene& s) {
         s.mutable_material()->set_bending_scale(0.0);
         s.mutable_material()->clear_twisting_stiffness_nm();
       }},
      {"materials[0].material.bending_stiffness_1_nm",
       [](v1::Scene& s) { s.mutable_materials(0)->mutable_material()->set_bending_stiffness_1_nm(-1.0); }},
      {"materials[0].region.region", [](v1::Scene& s) { s.mutable_materials(0)->clear_region(); }},
      {"materials[1].region.box.max",
       [](v1::Scene& s) { s.mutable_materials(1)->mutable_region()->mutable_box()->mutable_max()->set_y(-1.0); }},
      {"materials[1].material.preset",
       [](v1::Scene& s) { s.mutable_materials(1)->mutable_material()->set_preset("adamantium"); }},
      {"materials[1].material.thickness_m",
       [](v1::Scene& s) { s.mutable_materials(1)->mutable_material()->set_thickness_m(0.0); }},
      {"materials",
       [](v1::Scene& s) {
         for (int i = 0; i < 14; ++i) {
           *s.add_materials() = s.materials(0);
           s.mutable_materials(i + 2)->mutable_material()->set_density_kgpm3(1000.0 + i);
         }
       }},
      {"pins[0].region", [](v1::Scene& s) { s.mutable_pins(0)->clear_region(); }},
      {"pins[1].edge", [](v1::Scene& s) { s.mutable_pins(1)->set_edge(v1::Region::EDGE_UNSPECIFIED); }},
      {"pins[6].box.min.x", [=](v1::Scene& s) { s.mutable_pins(6)->mutable_box()->mutable_min()->set_x(nan); }},
      {"pins[6].box.max", [](v1::Scene& s) { s.mutable_pins(6)->mutable_box()->mutable_max()->set_y(0.0); }},
      {"pins[7].vertices.vertices[0]",
       [](v1::Scene& s) { s.mutable_pins(7)->mutable_vertices()->set_vertices(0, -1); }},
      {"pins",
       [](v1::Scene& s) {
         for (int i = 0; i < 57; ++i) s.add_pins()->set_edge(v1::Region::TOP);
       }},
      {"gravity_mps2.x", [=](v1::Scene& s) { s.mutable_gravity_mps2()->set_x(nan); }},
      {"gravity_mps2", [](v1::Scene& s) { set(s.mutable_gravity_mps2(), 9e3, 9e3, 0.0); }},
      {"wind.velocity_mps", [](v1::Scene& s) { set(s.mutable_wind()->mutable_velocity_mps(), 900.0, 900.0, 0.0); }},
      {"wind.air_density_kgpm3", [](v1::Scene& s) { s.mutable_wind()->set_air_density_kgpm3(-1.0); }},
      {"wind.drag_coefficient", [](v1::Scene& s) { s.mutable_wind()->set_drag_coefficient(10.1); }},
      {"tick_rate_hz", [](v1::Scene& s) { s.set_tick_rate_hz(0.0); }},
      {"tick_rate_hz", [](v1::Scene& s) { s.set_tick_rate_hz(1000.1); }},
      {"integrator.kind", [](v1::Scene& s) { s.mutable_integrator()->set_kind(static_cast<v1::Integrator::Kind>(7)); }},
      {"integrator.solver",
       [](v1::Scene& s) { s.mutable_integrator()->set_solver(static_cast<v1::Integrator::Solver>(-1)); }},
      {"membrane_law", [](v1::Scene& s) { s.set_membrane_law(static_cast<v1::MembraneLaw>(3)); }},
      {"fidelity", [](v1::Scene& s) { s.set_fidelity(static_cast<v1::Fidelity>(3)); }},
      {"integrator.precision",
       [](v1::Scene& s) { s.mutable_integrator()->set_precision(static_cast<v1::Integrator::Precision>(3)); }},
      {"integrator.max_substeps", [](v1::Scene& s) { s.mutable_integrator()->set_max_substeps(100001); }},
      {"integrator.newton_iterations", [](v1::Scene& s) { s.mutable_integrator()->set_newton_iterations(-1); }},
      {"integrator.solver_tolerance", [](v1::Scene& s) { s.mutable_integrator()->set_solver_tolerance(0.2); }},
      {"integrator.max_linear_iterations", [](v1::Scene& s) { s.mutable_integrator()->set_max_linear_iterations(-1); }},
      {"integrator.covariance_root.norm",
       [](v1::Scene& s) {
         s.mutable_integrator()->mutable_covariance_root()->set_norm(static_cast<v1::CovarianceRoot::Norm>(3));
       }},
      {"integrator.covariance_root.p",
       [](v1::Scene& s) { s.mutable_integrator()->mutable_covariance_root()->set_p(-0.5); }},
      {"integrator.covariance_root.newton_schulz_iterations",
       [](v1::Scene& s) { s.mutable_integrator()->mutable_covariance_root()->set_newton_schulz_iterations(51); }},
      {"integrator.highest_mode_damping", [](v1::Scene& s) { s.mutable_integrator()->set_highest_mode_damping(0.51); }},
      {"max_vertices", [](v1::Scene& s) { s.set_max_vertices(2); }},
      {"max_vertices", [](v1::Scene& s) { s.set_max_vertices(500'001); }},
      {"ticks", [](v1::Scene& s) { s.set_ticks(10'000'001); }},
      {"description", [](v1::Scene& s) { s.set_description(std::string(1001, 'x')); }},
  };
}

// The first cut of the scene is a Bezier, the second a polyline, the third a circle; then grabs, drag, release, pins,
// gravity, wind; a dashed ellipse in a box, a path fitted into the sheet; a batch of a Bezier and a circle, undo, redo;
// materials.
inline std::vector<BadScene> bad_commands() {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const auto command = [](v1::Scene& s, int i) { return s.mutable_commands(i)->mutable_command(); };
  const auto first_subpath = [](v1::Command* c) {
    return c->mutable_cut()->mutable_curve()->mutable_path()->mutable_subpaths(0);
  };
  return {
      {"commands[0].tick", [](v1::Scene& s) { s.mutable_commands(0)->set_tick(0); }},
      {"commands[12].command.cut_batch.cuts", [=](v1::Scene& s) { command(s, 12)->mutable_cut_batch()->clear_cuts(); }},
      {"commands[12].command.cut_batch.cuts[1].curve",
       [=](v1::Scene& s) { command(s, 12)->mutable_cut_batch()->mutable_cuts(1)->clear_curve(); }},
      {"commands[12].command.cut_batch.cuts[1].curve.circle.radius_m",
       [=](v1::Scene& s) {
         command(s, 12)->mutable_cut_batch()->mutable_cuts(1)->mutable_curve()->mutable_circle()->set_radius_m(nan);
       }},
      {"commands[0].command.kind", [=](v1::Scene& s) { command(s, 0)->clear_kind(); }},
      {"commands[0].command.cut.curve", [=](v1::Scene& s) { command(s, 0)->mutable_cut()->clear_curve(); }},
      {"commands[0].command.cut.curve.bezier.points",
       [=](v1::Scene& s) {
         set(command(s, 0)->mutable_cut()->mutable_curve()->mutable_bezier()->add_points(), 9.0, 9.0);
       }},
      {"commands[0].command.cut.curve.bezier.points[2].x",
       [=](v1::Scene& s) {
         command(s, 0)->mutable_cut()->mutable_curve()->mutable_bezier()->mutable_points(2)->set_x(nan);
       }},
      {"commands[0].command.cut.tolerance", [=](v1::Scene& s) { command(s, 0)->mutable_cut()->set_tolerance(-1.0); }},
      {"commands[0].command.cut.tolerance", [=](v1::Scene& s) { command(s, 0)->mutable_cut()->set_tolerance(nan); }},
      {"commands[0].command.cut.min_angle_deg",
       [=](v1::Scene& s) { command(s, 0)->mutable_cut()->set_min_angle_deg(29.0); }},
      {"commands[0].command.cut.max_new_triangles",
       [=](v1::Scene& s) { command(s, 0)->mutable_cut()->set_max_new_triangles(-1); }},
      {"commands[0].command.cut.method",
       [=](v1::Scene& s) { command(s, 0)->mutable_cut()->set_method(static_cast<v1::Cut::Method>(3)); }},
      {"commands[0].command.cut.quality",
       [=](v1::Scene& s) { command(s, 0)->mutable_cut()->set_quality(static_cast<v1::Cut::Quality>(3)); }},
      {"commands[0].command.cut.quality",
       [=](v1::Scene& s) { command(s, 0)->mutable_cut()->set_quality(v1::Cut::FINE); }},
      {"commands[0].command.cut.tip_edge_length_m",
       [=](v1::Scene& s) { command(s, 0)->mutable_cut()->set_tip_edge_length_m(-1.0); }},
      {"commands[1].command.cut.tip_edge_length_m",
       [=](v1::Scene& s) { command(s, 1)->mutable_cut()->set_tip_edge_length_m(0.01); }},
      {"commands[0].command.cut.width_m", [=](v1::Scene& s) { command(s, 0)->mutable_cut()->set_width_m(9e-10); }},
      {"commands[0].command.cut.width_m", [=](v1::Scene& s) { command(s, 0)->mutable_cut()->set_width_m(1.1e4); }},
      {"commands[1].command.cut.width_m", [=](v1::Scene& s) { command(s, 1)->mutable_cut()->set_width_m(0.01); }},
      {"commands[0].command.cut.tip_grading",
       [=](v1::Scene& s) { command(s, 0)->mutable_cut()->set_tip_grading(1.0); }},
      {"commands[0].command.cut.tolerance_m",
       [=](v1::Scene& s) { command(s, 0)->mutable_cut()->set_tolerance_m(1e-10); }},
      {"commands[1].command.cut.curve.polyline.points",
       [=](v1::Scene& s) {
         command(s, 1)->mutable_cut()->mutable_curve()->mutable_polyline()->mutable_points()->RemoveLast();
       }},
      {"commands[1].command.cut.curve.polyline.points[1].y",
       [=](v1::Scene& s) {
         command(s, 1)->mutable_cut()->mutable_curve()->mutable_polyline()->mutable_points(1)->set_y(-1.1e4);
       }},
      {"commands[2].command.cut.curve.circle.radius_m",
       [=](v1::Scene& s) { command(s, 2)->mutable_cut()->mutable_curve()->mutable_circle()->set_radius_m(0.0); }},
      {"commands[3].command.grab.grab_id", [=](v1::Scene& s) { command(s, 3)->mutable_grab()->clear_grab_id(); }},
      {"commands[3].command.grab.grab_id",
       [=](v1::Scene& s) { command(s, 3)->mutable_grab()->set_grab_id(std::string(64, 'g')); }},
      {"commands[3].command.grab.point", [=](v1::Scene& s) { command(s, 3)->mutable_grab()->clear_point(); }},
      {"commands[3].command.grab.vertex", [=](v1::Scene& s) { command(s, 3)->mutable_grab()->set_vertex(-1); }},
      {"commands[3].command.grab.target.z",
       [=](v1::Scene& s) { command(s, 3)->mutable_grab()->mutable_target()->set_z(nan); }},
      {"commands[3].command.grab.stiffness_npm",
       [=](v1::Scene& s) { command(s, 3)->mutable_grab()->set_stiffness_npm(1.1e6); }},
      {"commands[4].command.grab.material.x",
       [=](v1::Scene& s) { command(s, 4)->mutable_grab()->mutable_material()->set_x(nan); }},
      {"commands[5].command.drag.target", [=](v1::Scene& s) { command(s, 5)->mutable_drag()->clear_target(); }},
      {"commands[5].command.drag.target.x",
       [=](v1::Scene& s) { command(s, 5)->mutable_drag()->mutable_target()->set_x(2e6); }},
      {"commands[6].command.release.grab_id", [=](v1::Scene& s) { command(s, 6)->mutable_release()->clear_grab_id(); }},
      {"commands[7].command.set_pins.pins[0].region",
       [=](v1::Scene& s) { command(s, 7)->mutable_set_pins()->mutable_pins(0)->clear_region(); }},
      {"commands[8].command.set_gravity.gravity_mps2",
       [=](v1::Scene& s) { command(s, 8)->mutable_set_gravity()->clear_gravity_mps2(); }},
      {"commands[8].command.set_gravity.gravity_mps2.z",
       [=](v1::Scene& s) { command(s, 8)->mutable_set_gravity()->mutable_gravity_mps2()->set_z(nan); }},
      {"commands[9].command.set_wind.wind.drag_coefficient",
       [=](v1::Scene& s) { command(s, 9)->mutable_set_wind()->mutable_wind()->set_drag_coefficient(-2.0); }},
      {"commands[10].command.cut.curve.ellipse.semi_axis_y_m",
       [=](v1::Scene& s) {
         command(s, 10)->mutable_cut()->mutable_curve()->mutable_ellipse()->set_semi_axis_y_m(0.0);
       }},
      {"commands[10].command.cut.fit.max.y",
       [=](v1::Scene& s) { command(s, 10)->mutable_cut()->mutable_fit()->mutable_max()->set_y(0.1); }},
      {"commands[10].command.cut.fit.min",
       [=](v1::Scene& s) { command(s, 10)->mutable_cut()->mutable_fit()->clear_min(); }},
      {"commands[10].command.cut.fit.max",
       [=](v1::Scene& s) { command(s, 10)->mutable_cut()->mutable_fit()->clear_max(); }},
      {"commands[10].command.cut.dash[1]", [=](v1::Scene& s) { command(s, 10)->mutable_cut()->set_dash(1, 0.0); }},
      {"commands[10].command.cut.dash_offset",
       [=](v1::Scene& s) { command(s, 10)->mutable_cut()->set_dash_offset(nan); }},
      {"commands[11].command.cut.curve.path.subpaths[0].segments[0]",
       [=](v1::Scene& s) { first_subpath(command(s, 11))->mutable_segments(0)->clear_kind(); }},
      {"commands[11].command.cut.curve.path.subpaths[0].segments[2].cubic.weights",
       [=](v1::Scene& s) { first_subpath(command(s, 11))->mutable_segments(2)->mutable_cubic()->add_weights(1.0); }},
      {"commands[11].command.cut.curve.path.subpaths[0].segments[2].cubic.weights[2]",
       [=](v1::Scene& s) { first_subpath(command(s, 11))->mutable_segments(2)->mutable_cubic()->set_weights(2, 0.0); }},
      {"commands[11].command.cut.curve.path.subpaths[0].segments[3].arc.semi_axis_x_m",
       [=](v1::Scene& s) { first_subpath(command(s, 11))->mutable_segments(3)->mutable_arc()->clear_semi_axis_x_m(); }},
      {"commands[11].command.cut.curve.path.subpaths[0].start.y",
       [=](v1::Scene& s) { first_subpath(command(s, 11))->mutable_start()->set_y(nan); }},
      {"commands[11].command.cut.curve.path.subpaths",
       [=](v1::Scene& s) { command(s, 11)->mutable_cut()->mutable_curve()->mutable_path()->clear_subpaths(); }},
      {"commands[11].command.cut.curve.svg",
       [=](v1::Scene& s) { command(s, 11)->mutable_cut()->mutable_curve()->mutable_svg()->set_text("<svg"); }},
      {"commands[11].command.cut.curve.svg.file",
       [=](v1::Scene& s) { command(s, 11)->mutable_cut()->mutable_curve()->mutable_svg()->set_file("leaf.svg"); }},
      {"commands[15].command.set_material.material",
       [=](v1::Scene& s) { command(s, 15)->mutable_set_material()->clear_material(); }},
      {"commands[15].command.set_material.material.preset",
       [=](v1::Scene& s) { command(s, 15)->mutable_set_material()->mutable_material()->set_preset("wood"); }},
      {"commands[15].command.set_material.material.density_kgpm3",
       [=](v1::Scene& s) { command(s, 15)->mutable_set_material()->mutable_material()->set_density_kgpm3(nan); }},
      {"commands[15].command.set_material.part",
       [=](v1::Scene& s) { command(s, 15)->mutable_set_material()->set_part(-2); }},
      {"commands[15].command.set_material.part",
       [=](v1::Scene& s) { command(s, 15)->mutable_set_material()->set_part(64); }},
      {"commands[17].command.set_self_contact.mode",
       [=](v1::Scene& s) {
         command(s, 17)->mutable_set_self_contact()->set_mode(static_cast<v1::SelfContact::Mode>(3));
       }},
      {"commands[17].command.set_self_contact.friction",
       [=](v1::Scene& s) { command(s, 17)->mutable_set_self_contact()->set_friction(-1.0); }},
      {"commands[18].command.set_self_contact.thickness_m",
       [=](v1::Scene& s) { command(s, 18)->mutable_set_self_contact()->set_thickness_m(0.0); }},
      {"commands[18].command.set_self_contact.thickness_m",
       [=](v1::Scene& s) { command(s, 18)->mutable_set_self_contact()->set_thickness_m(nan); }},
      {"commands[17].command.set_self_contact.material_thickness",
       [=](v1::Scene& s) { command(s, 17)->mutable_set_self_contact()->set_material_thickness(true); }},
      {"commands",
       [](v1::Scene& s) {
         for (int i = 0; i < 10'000; ++i) add_command(s, 1).mutable_reset();
       }},
  };
}

inline std::vector<BadScene> bad_scenes() {
  std::vector<BadScene> all = bad_shapes();
  for (BadScene& each : bad_self_contact()) all.push_back(std::move(each));
  for (BadScene& each : bad_outlines()) all.push_back(std::move(each));
  for (BadScene& each : bad_conditions()) all.push_back(std::move(each));
  for (BadScene& each : bad_analyses()) all.push_back(std::move(each));
  for (BadScene& each : bad_numbers()) all.push_back(std::move(each));
  for (BadScene& each : bad_commands()) all.push_back(std::move(each));
  return all;
}

}  // namespace kerf::testing

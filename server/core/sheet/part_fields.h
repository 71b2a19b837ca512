#pragma once

#include <cstddef>
#include <tuple>

#include "server/base/fields.h"
#include "server/core/fem/element/loads.h"
#include "server/core/fem/element/state.h"
#include "server/core/fem/model/tick_cost.h"
#include "server/core/fem/step/softening.h"
#include "server/core/mesh/mesh_editor.h"
#include "server/core/scene/applied_forces.h"
#include "server/core/scene/held_vertices.h"
#include "server/core/sheet/material_setup.h"
#include "server/core/sheet/sheet_conditions.h"

// Members of what a sheet is made of, see sheet_fields.h: mesh, materials, loads.

// --- Mesh
template <>
struct kerf::Fields<kerf::mesh::LatticePoint> {
  static auto of(auto& of) {
    auto& [x, y] = of;
    return std::tie(x, y);
  }
};
template <>
struct kerf::Fields<kerf::mesh::PointRecord> {
  static auto of(auto& of) {
    auto& [at, triangle] = of;
    return std::tie(at, triangle);
  }
};
template <>
struct kerf::Fields<kerf::mesh::VertexRecord> {
  static auto of(auto& of) {
    auto& [point, triangle] = of;
    return std::tie(point, triangle);
  }
};
template <>
struct kerf::Fields<kerf::mesh::TriangleRecord> {
  static auto of(auto& of) {
    auto& [points, neighbours, vertices, locks, region, piece] = of;
    return std::tie(points, neighbours, vertices, locks, region, piece);
  }
};
template <>
struct kerf::Fields<kerf::mesh::TriangleMesh> {
  static auto of(auto& of) {  // hints are those of the sheet as built
    auto& [lattice, bounds, lengths, surface, points, vertices, triangles, num_solid, num_pieces] = of.data_;
    return std::tie(points, vertices, triangles, num_solid, num_pieces);
  }
};
template <>
struct kerf::Fields<kerf::mesh::VertexSource> {
  static auto of(auto& of) {
    auto& [vertex, sources, weights] = of;
    return std::tie(vertex, sources, weights);
  }
};
template <>
struct kerf::Fields<kerf::mesh::MeshEdit> {
  static auto of(auto& of) {
    auto& [added, moved, rewritten, removed, split_from, removed_pieces] = of;
    return std::tie(added, moved, rewritten, removed, split_from, removed_pieces);
  }
};
template <>
struct kerf::Fields<kerf::mesh::UndoLog> {
  static auto of(auto& of) {
    auto& [num_points, num_vertices, num_slots, num_solid, num_pieces, points, vertices, triangles, points_after,
           vertices_after, slots_after] = of;
    return std::tie(num_points, num_vertices, num_slots, num_solid, num_pieces, points, vertices, triangles,
                    points_after, vertices_after, slots_after);
  }
};
template <>
struct kerf::Fields<kerf::mesh::CommittedEdit> {
  static auto of(auto& of) {
    auto& [edit, undo] = of;
    return std::tie(edit, undo);
  }
};

// --- Motion, materials, loads
template <>
struct kerf::Fields<kerf::linear::VertexField> {
  static void visit(auto& visitor, auto& of) {
    const std::size_t count = visitor.count(static_cast<std::size_t>(of.cols()), 3 * sizeof(double));
    if constexpr (kerf::kReads<decltype(visitor)>) of.resize(static_cast<Eigen::Index>(count));
    visitor.plain(of.data(), 3 * count);
  }
};
template <>
struct kerf::Fields<kerf::fem::State> {
  static auto of(auto& of) {
    auto& [x, v] = of;
    return std::tie(x, v);
  }
};
template <>
struct kerf::Fields<kerf::fem::Pin> {
  static auto of(auto& of) {
    auto& [vertex, target, velocity, fixed] = of;
    return std::tie(vertex, target, velocity, fixed);
  }
};
template <>
struct kerf::Fields<kerf::fem::Material> {
  static auto of(auto& of) {
    auto& [e1, e2, nu, g, direction, thickness, density, bending, mass_damping, stiffness_damping, limit, d11, d22, d12,
           d66] = of;
    return std::tie(e1, e2, nu, g, direction, thickness, density, bending, mass_damping, stiffness_damping, limit, d11,
                    d22, d12, d66);
  }
};
template <>
struct kerf::Fields<kerf::fem::Softening> {
  static auto of(auto& of) {
    auto& [factor, is_explicit, cost, budget, expected_error] = of;
    return std::tie(factor, is_explicit, cost, budget, expected_error);
  }
};
template <>
struct kerf::Fields<kerf::fem::SelfContactCounts> {
  static auto of(auto& of) {
    auto& [phases, searches, pairs, contacts, repairs] = of;
    return std::tie(phases, searches, pairs, contacts, repairs);
  }
};
template <>
struct kerf::Fields<kerf::fem::TickCounts> {
  static auto of(auto& of) {
    auto& [blocks, pushes, load_phases, substeps, kicks, is_double, newton, linear, self_contact] = of;
    return std::tie(blocks, pushes, load_phases, substeps, kicks, is_double, newton, linear, self_contact);
  }
};
template <>
struct kerf::Fields<kerf::scene::SheetMaterials> {
  static auto of(auto& of) {
    auto& [entries, region_of, by_region] = of;
    return std::tie(entries, region_of, by_region);
  }
};
template <>
struct kerf::Fields<kerf::sheet::MaterialSetup> {
  static auto of(auto& of) {
    auto& [materials, softening] = of;
    return std::tie(materials, softening);
  }
};
template <>
struct kerf::Fields<kerf::scene::Wind> {
  static auto of(auto& of) {
    auto& [velocity, density, drag] = of;
    return std::tie(velocity, density, drag);
  }
};
template <>
struct kerf::Fields<kerf::scene::SelfContact> {
  static auto of(auto& of) {
    auto& [is_on, friction, thickness] = of;
    return std::tie(is_on, friction, thickness);
  }
};
template <>
struct kerf::Fields<kerf::scene::Instant> {
  static auto of(auto& of) {
    auto& [time, absent] = of;
    return std::tie(time, absent);
  }
};
template <>
struct kerf::Fields<kerf::scene::HeldVertices::Start> {
  static auto of(auto& of) {
    auto& [vertex, material, displacement, x, gradient] = of;
    return std::tie(vertex, material, displacement, x, gradient);
  }
};
template <>
struct kerf::Fields<kerf::scene::HeldVertices> {
  static auto of(auto& of) {
    auto& [config, groups, plane, last_change] = of;
    return std::tie(groups);
  }
};
template <>
struct kerf::Fields<kerf::scene::AppliedForces::Share> {
  static auto of(auto& of) {
    auto& [vertex, force] = of;
    return std::tie(vertex, force);
  }
};
template <>
struct kerf::Fields<kerf::scene::AppliedForces::EdgeShare> {
  static auto of(auto& of) {
    auto& [slot, edge, moment] = of;
    return std::tie(slot, edge, moment);
  }
};
template <>
struct kerf::Fields<kerf::scene::AppliedForces::Shares> {
  static auto of(auto& of) {
    auto& [forces, pressed, moments, place] = of;
    return std::tie(forces, pressed, moments, place);
  }
};
template <>
struct kerf::Fields<kerf::scene::AppliedForces> {
  static auto of(auto& of) {
    auto& [config, shares] = of;
    return std::tie(shares);
  }
};
template <>
struct kerf::Fields<kerf::sheet::ConditionValues> {
  static auto of(auto& of) {
    auto& [wind, gravity, held, forces, now] = of;
    return std::tie(wind, gravity, held, forces, now);
  }
};
template <>
struct kerf::Fields<kerf::sheet::SheetConditions> {
  static auto of(auto& of) {
    auto& [config, values, loads, clamped, is_changed] = of;  // between two steps nothing is changed that is not set
    return std::tie(values);
  }
};

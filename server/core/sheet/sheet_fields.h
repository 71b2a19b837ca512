#pragma once

#include <cstddef>
#include <tuple>

#include "server/base/fields.h"
#include "server/core/sheet/part_fields.h"
#include "server/core/sheet/sheet_impl.h"

// The members of a sheet that decide its future, listed once for Sheet::save(), load() and continuation_hash().
// Bindings name all members of a type. Those left out of the tuple are settings of the scene, or derived from the
// others.

// --- Pins and grabs
template <>
struct kerf::Fields<kerf::sheet::PinSet> {
  static auto of(auto& of) {
    auto& [vertices, holds, version] = of;
    return std::tie(vertices, holds, version);
  }
};
template <>
struct kerf::Fields<kerf::sheet::GrabState> {
  static auto of(auto& of) {
    auto& [id, vertices, weights, material, target, previous, stiffness, is_default] = of;
    return std::tie(id, vertices, weights, material, target, previous, stiffness, is_default);
  }
};
template <>
struct kerf::Fields<kerf::sheet::GrabSet> {
  static auto of(auto& of) {
    auto& [grabs] = of;
    return std::tie(grabs);
  }
};

// --- The stepper
template <>
struct kerf::Fields<kerf::contact::ContactCounters> {
  static auto of(auto& of) {
    auto& [phases, blocks, contacts] = of;
    return std::tie(phases, blocks, contacts);
  }
};
template <>
struct kerf::Fields<kerf::contact::ContactSolver> {
  static auto of(auto& of) { return std::tie(of.counters_); }  // all else is set by each step
};
template <>
struct kerf::Fields<kerf::sheet::ContactBridge> {
  static auto of(auto& of) {  // contact of the sheet with itself keeps nothing from one step to the next
    auto& [solver, self_contact, clusters, settings, before, half_thickness, is_calm, excluded, is_excluded, x_before] =
        of;
    return std::tie(solver, settings, is_calm);
  }
};
template <>
struct kerf::Fields<kerf::sheet::MotionWindow> {
  static void visit(auto& visitor, auto& of) {
    auto& [length, time, num_vertices, start, num_ticks, sums, last, low, high] = of;
    kerf::visit(visitor, time);
    kerf::visit(visitor, num_ticks);
    constexpr std::size_t kFields = 7;
    const std::size_t count = visitor.count(static_cast<std::size_t>(num_vertices), kFields * 3 * sizeof(double));
    const auto columns = static_cast<Eigen::Index>(count);
    if constexpr (kerf::kReads<decltype(visitor)>) {
      of.make_room(columns);
      num_vertices = columns;
    }
    for (auto* field : {&start, &sums[0], &sums[1], &sums[2], &last, &low, &high})
      visitor.plain(field->data(), 3 * count);
  }
};
template <>
struct kerf::Fields<kerf::sheet::RestWatch> {
  static void visit(auto& visitor, auto& of) {
    auto& [size, calm_time, energy, touched, is_calm, is_measuring, is_at_rest, windows, settles] = of;
    kerf::visit(visitor, calm_time);
    kerf::visit(visitor, energy);
    kerf::visit(visitor, touched);
    kerf::visit(visitor, is_calm);
    kerf::visit(visitor, is_measuring);
    kerf::visit(visitor, is_at_rest);
    kerf::visit(visitor, settles);
    if (is_measuring) kerf::visit(visitor, windows);  // they begin when a measurement does
  }
};
template <>
struct kerf::Fields<kerf::sheet::TimeStepper> {
  static auto of(auto& of) {
    auto& [dt, integrator, description, contact, rest, counts, failed_steps, is_frozen, last_good] = of;
    return std::tie(contact, rest, counts, failed_steps, is_frozen);
  }
};

// --- Pieces, cuts and what can be undone
template <>
struct kerf::Fields<kerf::scene::PieceBirth> {
  static auto of(auto& of) {
    auto& [id, parent, cut] = of;
    return std::tie(id, parent, cut);
  }
};
template <>
struct kerf::Fields<kerf::scene::LineageChange> {
  static auto of(auto& of) {
    auto& [before, after, ended, born, given_up] = of;
    return std::tie(before, after, ended, born, given_up);
  }
};
template <>
struct kerf::Fields<kerf::scene::Lineage> {
  static auto of(auto& of) {
    auto& [pieces, next_id] = of;
    return std::tie(pieces, next_id);
  }
};
template <>
struct kerf::Fields<kerf::sheet::DoneCut> {
  static auto of(auto& of) {
    auto& [edit, again, number, lineage, lost_pins, pins_version] = of;
    return std::tie(edit, again, number, lineage, lost_pins, pins_version);
  }
};
template <>
struct kerf::Fields<kerf::sheet::SchedulePlace> {
  static auto of(auto& of) {
    auto& [start_tick, next] = of;
    return std::tie(start_tick, next);
  }
};
template <>
struct kerf::Fields<kerf::sheet::ScenePlace> {
  static auto of(auto& of) {
    auto& [scene_tick, schedule] = of;
    return std::tie(scene_tick, schedule);
  }
};
template <>
struct kerf::Fields<kerf::sheet::SceneClock> {
  static auto of(auto& of) {
    auto& [config, schedule, dt, tick, start_tick, place] = of;
    return std::tie(tick, start_tick, place);
  }
};
template <>
struct kerf::Fields<kerf::sheet::MovingState> {
  static auto of(auto& of) {
    auto& [mesh, state, pins, removed, materials, conditions, self_contact, failed_steps, is_frozen] = of;
    return std::tie(mesh, state, pins, removed, materials, conditions, self_contact, failed_steps, is_frozen);
  }
};
template <>
struct kerf::Fields<kerf::sheet::Checkpoint> {
  static auto of(auto& of) {
    auto& [moving, place, pieces, beginning] = of;
    return std::tie(moving, place, pieces, beginning);
  }
};
template <>
struct kerf::Fields<kerf::sheet::UndoStep> {
  static void visit(auto& visitor, auto& of) {
    auto& [cuts, before_reset, beginning, bytes] = of;
    kerf::visit(visitor, cuts);
    kerf::visit(visitor, before_reset);
    kerf::visit(visitor, beginning);
    if constexpr (kerf::kReads<decltype(visitor)>) bytes = sheet::bytes_of(of);
  }
};
template <>
struct kerf::Fields<kerf::sheet::UndoHistory> {
  static void visit(auto& visitor, auto& of) {
    auto& [done, undone, bytes, forgotten] = of;
    kerf::visit(visitor, done);
    kerf::visit(visitor, undone);
    kerf::visit(visitor, forgotten);
    if constexpr (kerf::kReads<decltype(visitor)>) {
      bytes = 0;
      for (const auto& steps : {done, undone}) {
        for (const auto& step : steps) bytes += step ? step->bytes : 0;
      }
    }
  }
};
template <>
struct kerf::Fields<kerf::sheet::CutLog> {
  static auto of(auto& of) {
    auto& [history, lineage, num_cuts, last_number] = of;
    return std::tie(history, lineage, num_cuts, last_number);
  }
};

// --- The whole
template <>
struct kerf::Fields<kerf::sheet::MovingSheet> {
  static auto of(auto& of) {
    auto& [initial, dt, mesh, state, materials, pins, pins_version, grabs, conditions, removed, model, stepper] = of;
    return std::tie(mesh, state, materials, pins, pins_version, grabs, conditions, removed, stepper);
  }
};
template <>
struct kerf::Fields<kerf::sheet::Sheet::Impl> {
  static auto of(auto& of) {  // viewers get the topology in full
    auto& [clock, moving, cuts, topology, topology_version, settings_version, beginning, last_beginning, scene] = of;
    return std::tie(clock, moving, cuts, topology_version, settings_version, beginning, last_beginning);
  }
};
template <>
struct kerf::Fields<kerf::sheet::Sheet> {
  static void visit(auto& visitor, auto& of) { kerf::visit(visitor, *of.impl_); }
};

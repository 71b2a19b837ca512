#include "server/core/sheet/moving_sheet.h"

#include <numeric>
#include <string>
#include <utility>

#include "server/core/scene/integrator_settings.h"
#include "server/core/scene/region.h"
#include "server/core/sheet/lip_parting.h"

namespace kerf::sheet {

MovingSheet::MovingSheet(std::shared_ptr<const InitialState> initial, IntegratorFactory make_integrator)
    : initial_(std::move(initial)),
      dt_(1.0 / config().tick_rate_hz),
      mesh_(initial_->built.mesh),
      state_{initial_->built.positions, initial_->velocities},
      materials_(initial_->materials),
      conditions_(initial_->config,
                  {config().wind, config().gravity, initial_->held_vertices, initial_->applied_forces, {}}),
      model_(materials_.make_model(config(), mesh_)),
      stepper_(config(), std::move(make_integrator), initial_->built.size()) {
  stepper_.contact().set_half_thickness(materials_.half_thickness());
  pin(initial_->pinned);
  set_conditions(conditions().now, 0.0);
  rebuild();
}

void MovingSheet::set_conditions(const scene::Instant& end, double duration) {
  if (conditions_.set(end, duration, pins_.holds(), mesh_, model_)) stepper_.rebuild_integrator(model_);
}

void MovingSheet::refresh_conditions() {
  if (conditions_.is_changed()) set_conditions(conditions().now, 0.0);
}

void MovingSheet::set_loads(double time) {
  set_conditions({time, 1.0}, dt_);
  stepper_.hold(conditions_.loads().pins);
  grabs_.set(stepper_.integrator(), model_, dt_, conditions_.grabs());
}

StepOutcome MovingSheet::step(const StopConditions& stop, const scene::Instant& before) {
  StepOutcome outcome = stepper_.step(model_, conditions_.loads(), stop, state_);
  if (outcome.stats.interrupted) {
    conditions_.mark_changed();
    set_conditions(before, 0.0);
  } else {
    grabs_.end_step();
  }
  return outcome;
}

void MovingSheet::watch_rest(bool more_to_come, bool touches) {
  if (!grabs_.empty() || more_to_come || stepper_.is_frozen() || conditions_.has_changes_to_come()) {
    stepper_.disturb();
    return;
  }
  const scene::Wind& wind = conditions().wind;
  const bool has_wind = wind.air_density > 0.0 && !wind.velocity.isZero();
  const bool damps = config().rest_damping && !has_wind && (materials_.is_damped() || !stepper_.contact().empty());
  stepper_.watch_rest(model_, {loads().gravity.norm(), dt_, damps, touches}, state_);
}

fem::EquilibriumStats MovingSheet::settle(double load, const fem::EquilibriumOptions& options,
                                          const fem::EquilibriumWatch& watch) {
  set_conditions({load, load}, 0.0);
  conditions_.grabs().clear();
  bend_by_angles();
  fem::EquilibriumSolver solver(options);
  solver.rebuild(model_);
  linear::VertexField x = state_.x;
  const fem::EquilibriumStats stats = solver.solve(model_, loads(), watch, x);
  if (!stats.converged) return stats;
  state_.x = x;
  state_.v.setZero();
  return stats;
}

Status MovingSheet::set_pins(const scene::SetPins& pins) {
  KERF_TRY_ASSIGN(std::vector<mesh::VertexId> found,
                  scene::find_pins(mesh_, initial_->built.components, pins.pins, "set_pins.pins"));
  pin(std::move(found));
  pins_.set_version(++last_pins_version_);
  return Nothing{};
}

void MovingSheet::set_wind(const scene::Wind& value) {
  conditions_.set_wind(value);
  stepper_.forget_counts();
}

Status MovingSheet::set_material(const scene::SetMaterial& change) {
  KERF_TRY_ASSIGN(MaterialSetup changed, materials_.with(change, config(), self_contact().is_on, initial_->built.mesh));
  fem::Model made = changed.make_model(config(), mesh_);
  if (conditions_.has_slopes()) made.set_clamps(mesh_, conditions().held_vertices.clamps(conditions().now));
  KERF_TRY(check_condition(config(), made, "set_material.material"));
  materials_ = std::move(changed);
  model_ = std::move(made);
  stepper_.forget_counts();
  stepper_.contact().set_half_thickness(materials_.half_thickness());
  grabs_.follow_material(mesh_, model_, dt_);
  conditions_.mark_changed();  // edge moments were computed with the old model
  rebuild();
  return Nothing{};
}

Status MovingSheet::set_self_contact(const scene::SetSelfContact& change) {
  const bool was_on = self_contact().is_on;
  const scene::SelfContact changed = with(self_contact(), change);
  if (changed.is_on && !was_on && config().planar) {
    return failed_precondition("SELF_CONTACT_PLANAR",
                               "a planar sheet has no folds that could touch: create it with planar false to turn "
                               "self-contact on",
                               "set_self_contact.mode");
  }
  stepper_.set_self_contact(changed);
  if (changed.is_on == was_on) return Nothing{};
  if (changed.is_on) {
    std::vector<mesh::TriangleId> triangles(static_cast<std::size_t>(mesh_.num_triangle_slots()));
    std::iota(triangles.begin(), triangles.end(), 0);
    part_lips(mesh_, triangles, pins_.vertices(), stepper_.contact().self_thickness(), state_.x);
  }
  rebuild();
  return Nothing{};
}

MovingState MovingSheet::save() const {
  return {.mesh = mesh_,
          .state = state_,
          .pins = pins_,
          .removed = removed_,
          .materials = materials_,
          .conditions = conditions(),
          .self_contact = self_contact(),
          .failed_steps = stepper_.failed_steps(),
          .is_frozen = stepper_.is_frozen()};
}

MovingState MovingSheet::initial_state() const {
  MovingState begun{
      .mesh = initial_->built.mesh,
      .state = {initial_->built.positions, initial_->velocities},
      .pins = {},
      .materials = initial_->materials,
      .conditions = {config().wind, config().gravity, initial_->held_vertices, initial_->applied_forces, {}},
      .self_contact = config().self_contact};
  begun.pins.hold(initial_->pinned, begun.state);
  return begun;
}

void MovingSheet::restore(const MovingState& to) {
  mesh_ = to.mesh;
  state_ = to.state;
  materials_ = to.materials;
  model_ = materials_.make_model(config(), mesh_);
  conditions_.restore(to.conditions);
  grabs_.clear();
  removed_ = to.removed;
  pins_ = to.pins;
  stepper_.contact().set_half_thickness(materials_.half_thickness());
  stepper_.contact().set_vertices(mesh_.num_vertices(), pins_.vertices(), removed_);
  stepper_.set_self_contact(to.self_contact);
  rebuild();
  stepper_.restore(to.failed_steps, to.is_frozen);
}

void MovingSheet::resume() {
  model_ = materials_.make_model(config(), mesh_);
  stepper_.contact().set_half_thickness(materials_.half_thickness());
  stepper_.contact().set_vertices(mesh_.num_vertices(), pins_.vertices(), removed_);
  stepper_.resume();
  conditions_.resume();
  set_conditions(conditions().now, 0.0);
  rebuild();
}

fem::TickCost MovingSheet::expected_cost() const {
  constexpr double kTouchingShare = 0.3;  // -; assumed fraction of vertices that touch bodies, before the first tick
  const double blocks = static_cast<double>(mesh_.num_vertices()) / static_cast<double>(mesh::kVertexLanes);
  const scene::Wind& wind = conditions().wind;
  const bool has_wind = wind.air_density > 0.0 && wind.drag_coefficient > 0.0;
  return stepper_.expected_cost(model_,
                                {.contact_blocks = stepper_.contact().has_bodies() ? kTouchingShare * blocks : 0.0,
                                 .load_phases = has_wind ? 1.0 : 0.0});
}

void MovingSheet::add_to(StateHash& hash) const {
  mesh_.add_to(hash);
  const auto add_vector = [&](const Eigen::Vector3d& value) {
    for (int k = 0; k < 3; ++k) hash.add(value[k]);
  };
  hash.add_span(std::span<const double>(state_.x.data(), static_cast<std::size_t>(state_.x.size())));
  hash.add_span(std::span<const double>(state_.v.data(), static_cast<std::size_t>(state_.v.size())));
  hash.add(static_cast<std::uint64_t>(loads().pins.size()));
  for (const fem::Pin& p : loads().pins) {
    hash.add(p.vertex);
    add_vector(p.target);
  }
  grabs_.add_to(hash);
  add_vector(loads().gravity);
  const scene::Wind& wind = conditions().wind;
  add_vector(wind.velocity);
  hash.add(wind.air_density);
  hash.add(wind.drag_coefficient);
  if (materials_.materials().entries != initial_->materials.materials().entries) {
    scene::add_to(hash, materials_.materials());
  }
  if (self_contact() != config().self_contact) {
    hash.add(static_cast<std::int32_t>(self_contact().is_on));
    hash.add(self_contact().friction);
    hash.add(self_contact().thickness.value_or(0.0));
  }
}

void MovingSheet::pin(std::vector<mesh::VertexId> vertices) {
  pins_.hold(std::move(vertices), state_);
  conditions_.mark_changed();
  stepper_.contact().set_vertices(mesh_.num_vertices(), pins_.vertices(), removed_);
}

void MovingSheet::rebuild() {
  stepper_.contact().set_mesh(mesh_);
  stepper_.rebuild(model_, materials_.softening(), state_.x.cols());
}

}  // namespace kerf::sheet

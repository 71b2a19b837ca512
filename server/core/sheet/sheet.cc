#include "server/core/sheet/sheet.h"

#include <algorithm>
#include <new>
#include <numeric>
#include <utility>

#include "server/base/interruption.h"
#include "server/core/fem/element/follower_loads.h"
#include "server/core/scene/integrator_settings.h"
#include "server/core/scene/material_point.h"
#include "server/core/scene/mesh_source.h"
#include "server/core/scene/region.h"
#include "server/core/sheet/sheet_impl.h"
#include "server/core/sheet/unheld.h"
#include "server/core/sheet/vertex_strains.h"

namespace kerf::sheet {

namespace {

std::vector<std::size_t> order_schedule(const std::vector<ScheduledCommand>& commands) {
  std::vector<std::size_t> order(commands.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::stable_sort(order.begin(), order.end(),
                   [&](std::size_t a, std::size_t b) { return commands[a].tick < commands[b].tick; });
  return order;
}

Eigen::Matrix3Xd initial_velocities(const SheetConfig& config, const BuiltMesh& built,
                                    const std::vector<fem::Material>& materials) {
  const Eigen::Matrix3Xd& x = built.positions;
  Eigen::Matrix3Xd v = Eigen::Matrix3Xd::Zero(3, x.cols());
  if (!config.initial_velocity) return v;
  const InitialVelocity& given = *config.initial_velocity;
  const Eigen::Vector3d centre =
      given.centre ? *given.centre : fem::Model(built.mesh, materials).centre_of_mass(mesh::VertexField(x));
  for (Eigen::Index i = 0; i < x.cols(); ++i) v.col(i) = given.linear + given.angular.cross(x.col(i) - centre);
  return v;
}

bool is_damped(const std::vector<fem::Material>& materials) {
  return std::any_of(materials.begin(), materials.end(), [](const fem::Material& material) {
    return material.mass_damping > 0.0 || material.stiffness_damping > 0.0;
  });
}

}  // namespace

Sheet::Impl::Impl(std::shared_ptr<const SheetConfig> sheet_config, std::shared_ptr<const InitialState> initial_state,
                  IntegratorFactory make_integrator)
    : config(std::move(sheet_config)),
      initial(std::move(initial_state)),
      schedule(order_schedule(config->commands)),
      dt(1.0 / config->tick_rate_hz),
      mesh(initial->built.mesh),
      state{initial->built.positions, initial->velocities},
      materials(initial->materials),
      softening(initial->softening),
      held_vertices(initial->held_vertices),
      applied_forces(initial->applied_forces),
      full_gravity(config->gravity),
      lineage(mesh.num_pieces()),
      rest(mesh.bounding_box().sizes().maxCoeff()),
      model(make_model(*config, mesh, materials->by_region, softening)),
      integrator(std::move(make_integrator), integrator_options(config->integrator, 1.0 / config->tick_rate_hz)) {
  contact.set_colliders(config->colliders);
  contact.set_half_thickness(0.5 * greatest_thickness(materials->by_region));
  set_wind(config->wind);
  loads.grabs.reserve(kMaxGrabs);
  pin(initial->pinned);
  set_conditions(now, 0.0);
  rebuild();
}

TickReport Sheet::Impl::run(std::span<const Command> commands, StageObserver* observer, bool advance,
                            const fem::GoesOn* goes_on, const fem::GoesOn* may_go_on) {
  TickReport report;
  const std::int32_t version_before = topology_version;
  const bool advancing = advance && !frozen;
  drain_commands(commands, observer, advancing, report);
  if (advancing) {
    const Instant before = now;
    {
      const StageScope scope(observer, Stage::kLoads, -1);
      set_loads();
    }
    {
      const StageScope scope(observer, Stage::kIntegrate, -1);
      // A recording has no place for scheduled commands whose tick does not follow.
      integrate(report.scheduled.empty() ? goes_on : nullptr, may_go_on, report);
    }
    if (report.stats.interrupted) {
      conditions_changed = true;
      set_conditions(before, 0.0);
    } else {
      ++tick;
      report.advanced = true;
      watch_rest();
    }
  } else if (conditions_changed) {
    set_conditions(now, 0.0);
  }
  report.topology_changed = topology_version != version_before;
  stamp(report);
  return report;
}

// Fills in the state of the sheet at the end of the report's step.
void Sheet::Impl::stamp(TickReport& report) const {
  report.tick = tick;
  report.frozen = frozen;
  report.at_rest = rest.is_at_rest();
  if (report.replies.empty() && report.scheduled.empty()) return;
  StateHash hash;
  add_shape_to(hash);
  hash.add(tick);
  const auto stamp_reply = [&](Result<CommandReply>& reply) {
    if (!reply.ok()) return;
    reply->tick = tick;
    reply->state_hash = hash.value();
  };
  for (Result<CommandReply>& reply : report.replies) stamp_reply(reply);
  for (ScheduledReply& scheduled : report.scheduled) stamp_reply(scheduled.reply);
}

void Sheet::Impl::drain_commands(std::span<const Command> commands, StageObserver* observer, bool scheduled,
                                 TickReport& report) {
  const std::int32_t version_before = topology_version;
  std::int32_t number = 0;
  if (scheduled) drain_schedule(observer, number, report);
  report.num_scheduled_first = report.scheduled.size();
  report.replies.reserve(commands.size());
  for (const Command& command : commands) {
    report.replies.push_back(do_command(command, {observer, number++}));
  }
  if (scheduled) drain_schedule(observer, number, report);  // of a scene that a Reset has just begun again
  if (topology_version == version_before) return;
  const StageScope scope(observer, Stage::kModelUpdate, -1);
  integrator->prepare();
}

void Sheet::Impl::drain_schedule(StageObserver* observer, std::int32_t& number, TickReport& report) {
  const auto is_due = [this] {
    return schedule_place.next < schedule.size() &&
           config->commands[schedule[schedule_place.next]].tick <= tick + 1 - schedule_place.start_tick;
  };
  while (is_due()) {
    const std::size_t index = schedule[schedule_place.next++];
    const SchedulePlace place = schedule_place;
    report.scheduled.push_back({index, do_command(config->commands[index].command, {observer, number++})});
    schedule_place = place;  // a Reset by the scene itself does not repeat the schedule, which might never end
  }
}

void Sheet::Impl::set_loads() {
  set_conditions({static_cast<double>(tick + 1 - start_tick) * dt, 1.0}, dt);
  loads.grabs.resize(grabs.size());
  for (std::size_t i = 0; i < grabs.size(); ++i) {
    const GrabState& from = grabs[i];
    fem::Grab& to = loads.grabs[i];
    to.vertices = from.vertices;
    to.weights = from.weights;
    to.target = from.target;
    to.velocity = (from.target - from.previous_target) / dt;
    to.stiffness = from.stiffness;
    // Critical damping of the held point's own mass.
    const double mobility = integrator->mobility(model, to);
    to.damping = mobility > 0.0 ? 2.0 * std::sqrt(from.stiffness / mobility) : 0.0;
  }
}

bool Sheet::Impl::step_in_time(const fem::GoesOn* may_go_on, fem::StepStats& stats) {
  try {
    std::optional<InterruptionScope> scope;
    if (may_go_on != nullptr) scope.emplace(*may_go_on);
    stats = integrator->step(model, loads, dt, contact.empty() ? nullptr : &contact, state);
    return true;
  } catch (const std::bad_alloc&) {
    return false;
  } catch (const Interrupted&) {
    return false;
  }
}

void Sheet::Impl::integrate(const fem::GoesOn* goes_on, const fem::GoesOn* may_go_on, TickReport& report) {
  last_good = state;
  model.bend_by_matrix();
  integrator->heed(goes_on);
  const bool touches = last_counts && last_counts->contact_blocks > 0.0;
  contact.set_calm(touches && rest.is_calm());
  const std::int64_t blocks_before = contact.blocks();
  report.gave_up = !step_in_time(may_go_on, report.stats);
  integrator->heed(nullptr);
  if (report.gave_up) {
    state = last_good;
    frozen = true;
    report.stats = {};
    report.stats.interrupted = true;
  }
  if (report.stats.interrupted) return;
  if (!state.x.allFinite() || !state.v.allFinite()) report.stats.flags |= fem::kFrozen;
  report.step_failed = (report.stats.flags & fem::kFrozen) != 0;
  if (report.step_failed) {
    report.stats.simulated = 0.0;
    state = last_good;
    if (++failed_steps >= kMaxFailedSteps) frozen = true;
  } else {
    failed_steps = 0;
    count_tick(report.stats, contact.blocks() - blocks_before);
  }
  for (GrabState& grab : grabs) grab.previous_target = grab.target;
}

void Sheet::Impl::count_tick(const fem::StepStats& stats, std::int64_t contact_blocks) {
  const double substeps = std::max(stats.substeps, 1);
  const fem::TickCost planned = integrator->expected_cost(model, dt, {});
  last_counts = fem::TickCounts{
      .contact_blocks = static_cast<double>(contact_blocks) / substeps,
      .cluster_pushes = stats.cluster_pushes / substeps,
      .load_phases = stats.load_phases / substeps,
      .more_substeps = planned.substeps > 0.0 ? substeps / planned.substeps : 1.0,
      .more_kicks = stats.bending_interval > 0 ? planned.bending_interval / stats.bending_interval : 1.0,
      .is_double = stats.is_double,
      .newton_iterations = static_cast<double>(stats.newton_iterations),
      .linear_iterations = static_cast<double>(stats.linear_iterations)};
}

fem::TickCounts Sheet::Impl::counts() const {
  constexpr double kTouchingShare = 0.3;  // of a sheet that is to fall on bodies
  if (last_counts && contact.is_calm() && !rest.is_calm()) {
    fem::TickCounts counts = *last_counts;
    counts.more_substeps = counts.more_kicks = 1.0;  // as of a sheet that is not calm any more
    return counts;
  }
  if (last_counts) return *last_counts;
  const double blocks = static_cast<double>(mesh.num_vertices()) / static_cast<double>(mesh::kVertexLanes);
  const bool has_wind = wind.air_density > 0.0 && wind.drag_coefficient > 0.0;
  return {.contact_blocks = contact.empty() ? 0.0 : kTouchingShare * blocks, .load_phases = has_wind ? 1.0 : 0.0};
}

bool Sheet::Impl::is_left_alone() const {
  const std::vector<double>& times = config->gravity_history.times;
  const double gravity_change = times.empty() ? -kForever : times.back();
  const bool to_come = now.time < std::max({held_vertices.last_change(), applied_forces.last_change(), gravity_change});
  return grabs.empty() && schedule_place.next == schedule.size() && !frozen && !to_come;
}

void Sheet::Impl::watch_rest() {
  if (is_left_alone()) {
    const bool has_wind = wind.air_density > 0.0 && !wind.velocity.isZero();
    const bool damps = config->rest_damping && !has_wind && (is_damped(materials->by_region) || !contact.empty());
    rest.after_tick(model, {loads.gravity.norm(), dt, damps}, state);
  } else {
    rest.disturb();
  }
}

void Sheet::Impl::add_shape_to(StateHash& hash) const {
  mesh.add_to(hash);
  const auto add_vector = [&](const Eigen::Vector3d& value) {
    for (int k = 0; k < 3; ++k) hash.add(value[k]);
  };
  hash.add_span(std::span<const double>(state.x.data(), static_cast<std::size_t>(state.x.size())));
  hash.add_span(std::span<const double>(state.v.data(), static_cast<std::size_t>(state.v.size())));
  hash.add(static_cast<std::uint64_t>(loads.pins.size()));
  for (const fem::Pin& p : loads.pins) {
    hash.add(p.vertex);
    add_vector(p.target);
  }
  hash.add(static_cast<std::uint64_t>(grabs.size()));
  for (const GrabState& grab : grabs) {
    hash.add_span(std::span<const char>(grab.grab_id));
    for (std::size_t k = 0; k < 3; ++k) hash.add(grab.vertices[k]);
    add_vector(grab.weights);
    add_vector(grab.target);
    add_vector(grab.previous_target);
    hash.add(grab.stiffness);
  }
  add_vector(loads.gravity);
  add_vector(wind.velocity);
  hash.add(wind.air_density);
  hash.add(wind.drag_coefficient);
  if (materials->entries != initial->materials->entries) add_to(hash, *materials);
}

Sheet::Sheet(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
Sheet::Sheet(const Sheet& other) : impl_(std::make_unique<Impl>(*other.impl_)) {
  impl_->integrator->rebuild(impl_->model);
}
Sheet& Sheet::operator=(const Sheet& other) {
  if (this != &other) *this = Sheet(other);
  return *this;
}
Sheet::Sheet(Sheet&&) noexcept = default;
Sheet& Sheet::operator=(Sheet&&) noexcept = default;
Sheet::~Sheet() = default;

Result<Sheet> Sheet::create(SheetConfig config) {
  return create(std::move(config), fem::make_integrator);
}

Result<Sheet> Sheet::create(SheetConfig config, IntegratorFactory make_integrator) {
  KERF_TRY(validate(config));
  KERF_TRY_ASSIGN(BuiltMesh built, build_mesh(config.mesh, config.placement, config.max_vertices));
  if (built.mesh.num_vertices() > config.max_vertices) {
    return resource_exhausted("TOO_MANY_VERTICES", "the sheet has " + std::to_string(built.mesh.num_vertices()) +
                                                       " vertices; its limit is " +
                                                       std::to_string(config.max_vertices));
  }
  KERF_TRY(check_vertex_limit(config.integrator, built.mesh.num_vertices()));
  KERF_TRY_ASSIGN(std::vector<mesh::VertexId> pinned, find_pins(built.mesh, config.pins, "pins"));
  KERF_TRY_ASSIGN(SheetMaterials assigned, assign_materials(config, built.mesh));
  const auto materials = std::make_shared<const SheetMaterials>(std::move(assigned));
  auto shared = std::make_shared<const SheetConfig>(std::move(config));
  KERF_TRY_ASSIGN(HeldVertices held, HeldVertices::create(shared, built));
  KERF_TRY_ASSIGN(AppliedForces applied, AppliedForces::create(shared, built));
  Eigen::Matrix3Xd velocities = initial_velocities(*shared, built, materials->by_region);
  const std::optional<fem::Softening> softening = choose_softening(*shared, built.mesh, materials->by_region);
  auto initial =
      std::make_shared<const InitialState>(InitialState{std::move(built), materials, softening, std::move(velocities),
                                                        std::move(pinned), std::move(held), std::move(applied)});
  Sheet sheet(std::make_unique<Impl>(std::move(shared), std::move(initial), std::move(make_integrator)));
  KERF_TRY(check_condition(*sheet.impl_->config, sheet.model(), "material"));
  return sheet;
}

TickReport Sheet::step(std::span<const Command> commands, StageObserver* observer, const fem::GoesOn* goes_on,
                       const fem::GoesOn* may_go_on) {
  return impl_->run(commands, observer, true, goes_on, may_go_on);
}

fem::EquilibriumStats Sheet::settle(double load, const fem::EquilibriumOptions& options,
                                    const fem::EquilibriumSolver::Watch& watch) {
  return impl_->settle(load, options, watch);
}

void Sheet::bend_by_angles() {
  impl_->model.bend_by_angles(impl_->mesh);
}

std::optional<UnheldPiece> Sheet::find_unheld(double load) {
  impl_->set_conditions({load, load}, 0.0);
  return sheet::find_unheld(impl_->mesh, impl_->model, impl_->loads);
}

TickReport Sheet::begin_load_step() {
  return impl_->begin_load_step();
}

TickReport Sheet::apply(std::span<const Command> commands, StageObserver* observer) {
  return impl_->run(commands, observer, false, nullptr, nullptr);
}

const SheetConfig& Sheet::config() const {
  return *impl_->config;
}
std::shared_ptr<const SheetConfig> Sheet::shared_config() const {
  return impl_->config;
}
std::int64_t Sheet::tick() const {
  return impl_->tick;
}
std::int64_t Sheet::scene_tick() const {
  return impl_->tick - impl_->start_tick;
}
double Sheet::dt() const {
  return impl_->dt;
}
std::int32_t Sheet::topology_version() const {
  return impl_->topology_version;
}
std::int32_t Sheet::settings_version() const {
  return impl_->settings_version;
}
const mesh::TriangleMesh& Sheet::mesh() const {
  return impl_->mesh;
}
const fem::Model& Sheet::model() const {
  return impl_->model;
}
const fem::State& Sheet::state() const {
  return impl_->state;
}
const fem::Loads& Sheet::loads() const {
  return impl_->loads;
}
Eigen::Vector3d Sheet::start_of(const Eigen::Vector2d& material) const {
  const BuiltMesh& built = impl_->initial->built;
  return built.at(material).of(built.positions);
}
const Eigen::Vector3d& Sheet::gravity() const {
  return impl_->full_gravity;
}
const SheetMaterials& Sheet::materials() const {
  return *impl_->materials;
}
const std::optional<fem::Softening>& Sheet::softening() const {
  return impl_->softening;
}
const Wind& Sheet::wind() const {
  return impl_->wind;
}
const std::vector<mesh::VertexId>& Sheet::pinned_vertices() const {
  return impl_->pinned;
}
const std::vector<GrabState>& Sheet::grabs() const {
  return impl_->grabs;
}
std::int64_t Sheet::contact_phases() const {
  return impl_->contact.phases();
}
std::int64_t Sheet::num_cuts() const {
  return impl_->num_cuts;
}
const UndoHistory& Sheet::history() const {
  return impl_->history;
}
std::vector<Piece> Sheet::pieces() const {
  return measure_pieces(impl_->mesh, impl_->lineage.pieces(), impl_->state.x, impl_->materials->by_region);
}
const std::string& Sheet::integrator_description() const {
  return impl_->integrator_description;
}
std::optional<fem::LocalInertiaStats> Sheet::local_inertia() const {
  return impl_->integrator->local_inertia(impl_->dt);
}
fem::TickCost Sheet::expected_cost() const {
  return impl_->integrator->expected_cost(impl_->model, impl_->dt, impl_->counts());
}
bool Sheet::frozen() const {
  return impl_->frozen;
}

bool Sheet::at_rest() const {
  return impl_->rest.is_at_rest();
}

Energies Sheet::energies() const {
  const fem::Energies energies = impl_->model.energies(impl_->state, impl_->loads.gravity);
  const double bending = energies.bending + fem::edge_moment_energy(impl_->loads);
  return {energies.kinetic, energies.membrane, bending, energies.gravity};
}

std::uint64_t Sheet::state_hash() const {
  StateHash hash;
  impl_->add_shape_to(hash);
  hash.add(impl_->tick);
  return hash.value();
}

std::uint64_t Sheet::shape_hash() const {
  StateHash hash;
  impl_->add_shape_to(hash);
  return hash.value();
}

std::shared_ptr<const Snapshot> Sheet::snapshot(const RunStats& stats, bool with_strains) const {
  auto snapshot = std::make_shared<Snapshot>();
  snapshot->tick = impl_->tick;
  snapshot->positions = impl_->state.x;
  // Vertices without material stay where they were when they lost it; viewers get them at the place of a vertex that
  // has some, so that the material alone determines the extent of the sheet.
  if (!impl_->removed.empty()) {
    mesh::TriangleId solid = 0;
    while (!impl_->mesh.is_solid(solid)) ++solid;
    const Eigen::Vector3d at = impl_->state.x.col(impl_->mesh.vertices(solid)[0]);
    for (const mesh::VertexId v : impl_->removed) snapshot->positions.col(v) = at;
  }
  snapshot->topology = impl_->topology.at(impl_->mesh, impl_->topology_version);
  snapshot->stats = stats;
  if (with_strains) snapshot->strains = dominant_strains(impl_->model, impl_->state.x);
  return snapshot;
}

}  // namespace kerf::sheet

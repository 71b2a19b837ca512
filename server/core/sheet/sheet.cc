#include "server/core/sheet/sheet.h"

#include <utility>

#include "server/core/fem/element/follower_loads.h"
#include "server/core/sheet/sheet_impl.h"
#include "server/core/sheet/unheld.h"
#include "server/core/sheet/vertex_strains.h"

namespace kerf::sheet {

Sheet::Sheet(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
Sheet::Sheet(const Sheet& other) : impl_(std::make_unique<Impl>(*other.impl_)) {
  impl_->moving.rebuild_integrator();
}
Sheet& Sheet::operator=(const Sheet& other) {
  if (this != &other) *this = Sheet(other);
  return *this;
}
Sheet::Sheet(Sheet&&) noexcept = default;
Sheet& Sheet::operator=(Sheet&&) noexcept = default;
Sheet::~Sheet() = default;

Result<Sheet> Sheet::create(scene::SheetConfig config) {
  return create(std::move(config), fem::make_integrator);
}

Result<Sheet> Sheet::create(scene::SheetConfig config, IntegratorFactory make_integrator) {
  KERF_TRY_ASSIGN(InitialState initial, make_initial_state(std::move(config)));
  Sheet sheet(
      std::make_unique<Impl>(std::make_shared<const InitialState>(std::move(initial)), std::move(make_integrator)));
  KERF_TRY(check_condition(sheet.config(), sheet.model(), "material"));
  return sheet;
}

TickReport Sheet::step(std::span<const scene::Command> commands, StageObserver* observer, const StopCondition* stop,
                       const StopCondition* give_up) {
  return impl_->run(commands, observer, true, {stop, give_up});
}

fem::EquilibriumStats Sheet::settle(double load, const fem::EquilibriumOptions& options,
                                    const fem::EquilibriumWatch& watch) {
  return impl_->moving.settle(load, options, watch);
}

void Sheet::bend_by_angles() {
  impl_->moving.bend_by_angles();
}

std::optional<UnheldPiece> Sheet::find_unheld(double load) {
  impl_->moving.set_conditions({load, load}, 0.0);
  return sheet::find_unheld(mesh(), model(), loads());
}

TickReport Sheet::begin_load_step() {
  return impl_->begin_load_step();
}

TickReport Sheet::apply(std::span<const scene::Command> commands, StageObserver* observer) {
  return impl_->run(commands, observer, false, {});
}

const scene::SheetConfig& Sheet::config() const {
  return impl_->moving.config();
}
std::shared_ptr<const scene::SheetConfig> Sheet::shared_config() const {
  return impl_->moving.initial().config;
}
const std::vector<scene::ComponentPlace>& Sheet::components() const {
  return impl_->moving.initial().built.components;
}
const std::vector<std::string>& Sheet::mesh_notes() const {
  return impl_->moving.initial().built.notes;
}
std::int64_t Sheet::tick() const {
  return impl_->clock.tick();
}
std::int64_t Sheet::scene_tick() const {
  return impl_->clock.scene_tick();
}
double Sheet::dt() const {
  return impl_->clock.dt();
}
std::int32_t Sheet::topology_version() const {
  return impl_->topology_version;
}
std::int32_t Sheet::settings_version() const {
  return impl_->settings_version;
}
const mesh::TriangleMesh& Sheet::mesh() const {
  return impl_->moving.mesh();
}
const fem::Model& Sheet::model() const {
  return impl_->moving.model();
}
const fem::State& Sheet::state() const {
  return impl_->moving.state();
}
const fem::Loads& Sheet::loads() const {
  return impl_->moving.loads();
}
Eigen::Vector3d Sheet::start_of(const Eigen::Vector2d& material) const {
  const scene::BuiltMesh& built = impl_->moving.initial().built;
  return built.at(material).of(built.positions);
}
const Eigen::Vector3d& Sheet::gravity() const {
  return impl_->moving.conditions().full_gravity;
}
const scene::SheetMaterials& Sheet::materials() const {
  return impl_->moving.materials().materials();
}
const std::optional<fem::Softening>& Sheet::softening() const {
  return impl_->moving.materials().softening();
}
const scene::Wind& Sheet::wind() const {
  return impl_->moving.conditions().wind;
}
const scene::SelfContact& Sheet::self_contact() const {
  return impl_->moving.self_contact();
}
const std::vector<mesh::VertexId>& Sheet::pinned_vertices() const {
  return impl_->moving.pins().vertices();
}
const std::vector<GrabState>& Sheet::grabs() const {
  return impl_->moving.grabs().all();
}
std::int64_t Sheet::contact_phases() const {
  return impl_->moving.stepper().contact().phases();
}
std::int64_t Sheet::num_cuts() const {
  return impl_->cuts.num_cuts();
}
const UndoHistory& Sheet::history() const {
  return impl_->cuts.history();
}
std::vector<scene::Piece> Sheet::pieces() const {
  return scene::measure_pieces(mesh(), impl_->cuts.pieces(), state().x, materials().by_region);
}
const std::string& Sheet::integrator_description() const {
  return impl_->moving.stepper().description();
}
std::optional<fem::LocalInertiaStats> Sheet::local_inertia() const {
  return impl_->moving.stepper().integrator().local_inertia(dt());
}
fem::TickCost Sheet::expected_cost() const {
  return impl_->moving.expected_cost();
}
bool Sheet::frozen() const {
  return impl_->moving.stepper().is_frozen();
}

bool Sheet::at_rest() const {
  return impl_->moving.stepper().is_at_rest();
}

Energies Sheet::energies() const {
  const fem::Energies energies = model().energies(state(), loads().gravity);
  const double bending = energies.bending + fem::edge_moment_energy(loads());
  return {energies.kinetic, energies.membrane, bending, energies.gravity};
}

std::uint64_t Sheet::state_hash() const {
  return impl_->state_hash();
}

std::uint64_t Sheet::shape_hash() const {
  StateHash hash;
  impl_->moving.add_to(hash);
  return hash.value();
}

std::shared_ptr<Snapshot> Sheet::snapshot(const RunStats& stats, bool with_strains) const {
  auto snapshot = std::make_shared<Snapshot>();
  snapshot->tick = tick();
  snapshot->positions = state().x;
  // Vertices without material stay where they were when they lost it. Viewers get them at the place of a vertex with
  // material, so that only material determines the extent of the sheet.
  if (const std::vector<mesh::VertexId>& removed = impl_->moving.removed(); !removed.empty()) {
    mesh::TriangleId solid = 0;
    while (!mesh().is_solid(solid)) ++solid;
    const Eigen::Vector3d at = state().x.col(mesh().vertices(solid)[0]);
    for (const mesh::VertexId v : removed) snapshot->positions.col(v) = at;
  }
  snapshot->topology = impl_->topology.at(mesh(), topology_version());
  snapshot->materials = impl_->moving.materials().shared();
  snapshot->stats = stats;
  if (with_strains) snapshot->strains = dominant_strains(model(), state().x);
  return snapshot;
}

}  // namespace kerf::sheet

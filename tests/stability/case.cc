#include "tests/stability/case.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <map>
#include <numeric>
#include <utility>
#include <variant>

#include "server/base/random.h"
#include "server/core/cut/cut.h"
#include "server/core/mesh/build/grid_mesh.h"
#include "server/core/mesh/build/mesh_import.h"
#include "server/core/mesh/regions.h"
#include "server/core/scene/integrator_settings.h"
#include "tests/support/meshes.h"
#include "tests/support/random_cuts.h"

namespace kerf::stability {
namespace {

constexpr int kSide = 6;  // vertices per side
constexpr std::array<double, 5> kYoungsModuli{1.0, 1e3, 1e6, 1e9, 1e12};
constexpr std::array<double, 5> kSteps{1e-4, 1e-3, 1.0 / 60.0, 0.1, 1.0};
constexpr std::array<double, 4> kAspects{1.0, 1e2, 1e4, 9e5};  // 1e6 is refused: see mesh::kMinFlatness
constexpr std::array<double, 3> kPoissonsRatios{0.3, 0.49, 0.63};

fem::State at_rest(const mesh::TriangleMesh& mesh) {
  fem::State state;
  state.x = Eigen::Matrix3Xd::Zero(3, mesh.num_vertices());
  state.v = Eigen::Matrix3Xd::Zero(3, mesh.num_vertices());
  for (int v = 0; v < mesh.num_vertices(); ++v) state.x.col(v).head<2>() = mesh.rest_position(v);
  return state;
}

Start resting(mesh::TriangleMesh mesh) {
  fem::State state = at_rest(mesh);
  fem::Loads loads;
  loads.gravity.setZero();
  Start start{"", std::move(mesh), std::move(state), std::move(loads)};
  return start;
}

Start resting_grid(double aspect) {
  return resting(test::must(mesh::make_grid({kSide, kSide, 1.0, 1.0 / aspect})));
}

linear::VertexField random_field(std::uint64_t seed, Eigen::Index n, double size) {
  SeededRandom random(seed);
  linear::VertexField field(n);
  for (Eigen::Index i = 0; i < n; ++i) {
    for (Eigen::Index c = 0; c < 3; ++c) field(c, i) = random.uniform(-size, size);
  }
  return field;
}

// Makes a kind of start: the resting grid, changed by `change`.
StartKind shaped(const char* name, std::function<void(fem::State& state)> change) {
  return {name, [change = std::move(change)](double aspect) {
            Start start = resting_grid(aspect);
            change(start.state);
            return start;
          }};
}

StartKind scaled(const char* name, const Eigen::Vector3d& factor) {
  return shaped(name, [factor](fem::State& state) { state.x = factor.asDiagonal() * state.x; });
}

Start pinned(double aspect, int num_pins) {
  Start start = resting_grid(aspect);
  start.loads.gravity = {0.0, 0.0, -9.81};
  for (int v = 0; v < std::min(num_pins, start.mesh.num_vertices()); ++v) {
    start.loads.pins.push_back({v, start.state.x.col(v), Eigen::Vector3d::Zero()});
  }
  return start;
}

// A grid with one row of cells that are about a millionth as high as long.
Start flat_row(double /*aspect*/) {
  mesh::IndexedMesh sheet;
  sheet.rest.resize(2, kSide * kSide);
  sheet.triangles.resize(3, 2 * (kSide - 1) * (kSide - 1));
  constexpr std::array<double, kSide> kHeights{0.0, 0.25, 0.5, 0.5 + 2.2e-7, 0.75, 1.0};
  Eigen::Index t = 0;
  for (int j = 0; j < kSide; ++j) {
    for (int i = 0; i < kSide; ++i) {
      const int a = j * kSide + i;
      sheet.rest.col(a) << static_cast<double>(i) / (kSide - 1), kHeights[static_cast<std::size_t>(j)];
      if (i + 1 == kSide || j + 1 == kSide) continue;
      sheet.triangles.col(t++) = Eigen::Vector3i(a, a + 1, a + kSide + 1);
      sheet.triangles.col(t++) = Eigen::Vector3i(a, a + kSide + 1, a + kSide);
    }
  }
  Start start = resting(test::must(mesh::import_mesh(sheet)));
  start.state.x += random_field(11, start.state.x.cols(), 0.01);
  return start;
}

Start one_triangle(double aspect) {
  mesh::IndexedMesh sheet = test::one_triangle();
  sheet.rest.row(1) /= aspect;
  Start start = resting(test::must(mesh::import_mesh(sheet)));
  start.state.x *= 2.0;
  return start;
}

// A square and, beside it, a small triangle.
Start island(double aspect) {
  mesh::IndexedMesh sheet = test::indexed({{0, 0}, {1, 0}, {1, 1}, {0, 1}, {2, 0}, {2.001, 0}, {2, 0.001}},
                                          {{0, 1, 2}, {0, 2, 3}, {4, 5, 6}});
  sheet.rest.row(1) /= aspect;
  Start start = resting(test::must(mesh::import_mesh(sheet)));
  start.state.x *= 3.0;
  return start;
}

mesh::TriangleMesh cut_often(double aspect) {
  constexpr int kCuts = 200;
  mesh::TriangleMesh mesh = test::must(mesh::make_grid({2 * kSide, 2 * kSide, 1.0, 1.0 / aspect}));
  SeededRandom random(23);
  for (int made = 0; made < kCuts;) {
    cut::Polyline line;
    Eigen::Vector2d at(random.uniform(0.0, 1.0), random.uniform(0.0, 1.0));
    for (int i = 0; i < 3; ++i) {
      line.points.emplace_back(at.x(), at.y() / aspect);
      at += 0.1 * Eigen::Vector2d(random.uniform(-1.0, 1.0), random.uniform(-1.0, 1.0));
    }
    const auto plan = cut::plan(mesh, {line, {}, {}});
    if (plan.ok() && cut::apply(mesh, *plan).ok()) ++made;
  }
  return mesh;
}

Start after_cuts(double aspect) {
  constexpr double kMost = 100.0;  // largest aspect ratio; beyond it most cuts would be refused
  static const mesh::TriangleMesh square = cut_often(1.0);
  static const mesh::TriangleMesh strip = cut_often(kMost);
  Start start = resting(aspect < kMost ? square : strip);
  start.state.x *= 1.5;
  return start;
}

// Returns a sheet of 1 m x 1 m with `count` cuts along cubic curves of about 0.3 m; all is squeezed to the aspect
// ratio.
mesh::TriangleMesh with_curves(int count, double aspect) {
  mesh::TriangleMesh mesh = test::must(mesh::make_grid({2 * kSide, 2 * kSide, 1.0, 1.0 / aspect}));
  SeededRandom random(29);
  for (int made = 0; made < count;) {
    cut::CubicBezier curve = std::get<cut::CubicBezier>(test::random_cubic(random));
    for (Eigen::Vector2d& point : curve.points) point.y() /= aspect;
    const auto plan = cut::plan(mesh, {curve, {}, {}});
    if (plan.ok() && cut::apply(mesh, *plan).ok()) ++made;
  }
  return mesh;
}

// A sheet with many cuts, stretched and moving as a whole and in waves. This releases what tiny triangles between
// strands hold.
StartKind after_curves(const char* name, int count) {
  constexpr double kMost = 100.0;  // as in after_cuts()
  return {name, [count](double aspect) {
            static std::map<std::pair<int, bool>, mesh::TriangleMesh> meshes;
            const bool is_strip = aspect >= kMost;
            auto made = meshes.find({count, is_strip});
            if (made == meshes.end()) {
              made = meshes.emplace(std::pair(count, is_strip), with_curves(count, is_strip ? kMost : 1.0)).first;
            }
            Start start = resting(made->second);
            for (Eigen::Index i = 0; i < start.state.v.cols(); ++i) {
              const Eigen::Vector3d x = start.state.x.col(i);
              start.state.v.col(i) = Eigen::Vector3d(1.0, 0.0, 5.0 * std::sin(9.0 * x.x()) * std::cos(7.0 * x.y()));
            }
            start.state.x *= 1.2;
            return start;
          }};
}

// The lightest and the heaviest material allowed, 1e7 times as heavy, side by side. They are stretched and moving, so
// that they pull at each other.
Start density_jump(double aspect) {
  Start start = resting_grid(aspect);
  std::vector<std::int32_t> regions(static_cast<std::size_t>(start.mesh.num_triangle_slots()), 0);
  for (mesh::TriangleId t = 0; t < start.mesh.num_triangle_slots(); ++t) {
    if (!start.mesh.is_solid(t)) continue;
    const std::array<mesh::VertexId, 3> corner = start.mesh.vertices(t);
    double x = 0.0;
    for (const mesh::VertexId v : corner) x += start.mesh.rest_position(v).x() / 3.0;
    regions[static_cast<std::size_t>(t)] = x > 0.5 ? 1 : 0;
  }
  start.mesh = mesh::with_regions(start.mesh, regions);
  start.densities = {fem::MaterialRanges::kDensity.low, fem::MaterialRanges::kDensity.high};
  start.state.x *= 1.5;
  start.state.v = random_field(3, start.state.x.cols(), 10.0);
  return start;
}

std::vector<StartKind> make_kinds() {
  std::vector<StartKind> kinds;
  kinds.push_back(shaped("random box", [](fem::State& s) { s.x = random_field(1, s.x.cols(), 1.0); }));
  kinds.push_back(scaled("point", {0.0, 0.0, 0.0}));
  kinds.push_back(scaled("line", {1.0, 0.0, 0.0}));
  kinds.push_back(scaled("stretched 5 times", {5.0, 5.0, 5.0}));
  kinds.push_back(scaled("squashed to 0.01", {1.0, 0.01, 1.0}));
  kinds.push_back(shaped("sheared 10 times", [](fem::State& s) { s.x.row(0) += 10.0 * s.x.row(1); }));
  kinds.push_back(shaped("folded flat", [](fem::State& s) { s.x.row(0) = (s.x.row(0).array() - 0.5).abs(); }));
  kinds.push_back(shaped("inverted patch", [](fem::State& s) { s.x(0, s.x.cols() / 2 + 2) += 0.7; }));
  kinds.push_back(shaped("coincident vertices", [](fem::State& s) { s.x.col(8) = s.x.col(9) = s.x.col(14); }));
  kinds.push_back(shaped("1000 rad/s", [](fem::State& s) {
    const Eigen::Vector3d centre = s.x.rowwise().mean();
    for (Eigen::Index i = 0; i < s.x.cols(); ++i) {
      s.v.col(i) = Eigen::Vector3d(0.0, 0.0, 1000.0).cross(s.x.col(i) - centre);
    }
  }));
  kinds.push_back(shaped("1000 m/s at random", [](fem::State& s) { s.v = random_field(2, s.x.cols(), 1000.0); }));
  kinds.push_back({"flat row, aspect ratio 1e6", flat_row});
  kinds.push_back({"pinned at one", [](double aspect) { return pinned(aspect, 1); }});
  kinds.push_back({"pinned at all", [](double aspect) { return pinned(aspect, kSide * kSide); }});
  kinds.push_back({"one triangle", one_triangle});
  kinds.push_back({"after 200 cuts", after_cuts});
  kinds.push_back({"island of one triangle", island});
  kinds.push_back({"density jump of 1e7", density_jump});
  kinds.push_back(after_curves("after 10 curves", 10));
  kinds.push_back(after_curves("after 50 curves", 50));
  kinds.push_back(after_curves("after 200 curves", 200));
  return kinds;
}

fem::Material material(const Case& tested, double density) {
  constexpr double kThickness = 1.0e-3;  // m
  const bool is_isotropic = tested.poissons_ratio <= 0.5;
  fem::Material made =
      fem::isotropic(tested.youngs_modulus, is_isotropic ? tested.poissons_ratio : 0.3, kThickness, density);
  if (!is_isotropic) {
    made.poissons_ratio_12 = tested.poissons_ratio;
    made.shear_modulus = 0.51 / 3.1 * tested.youngs_modulus;  // as in the thesis' table 4.1
  }
  return made;
}

}  // namespace

const std::vector<StartKind>& start_kinds() {
  static const std::vector<StartKind> kinds = make_kinds();
  return kinds;
}

std::string Case::name() const {
  std::array<char, 160> text{};
  std::snprintf(text.data(), text.size(), "%s, E %.0e Pa, nu %.2f, dt %.4g s, aspect %.0e%s", start_kinds()[start].name,
                youngs_modulus, poissons_ratio, dt, aspect, precision == fem::Precision::kDouble ? ", double" : "");
  return text.data();
}

void PrintTo(const Case& tested, std::ostream* out) {
  *out << tested.name();
}

std::vector<Case> matrix(std::size_t per_start) {
  constexpr std::size_t kAll = kYoungsModuli.size() * kSteps.size() * kAspects.size();
  std::vector<Case> cases;
  for (std::size_t start = 0; start < start_kinds().size(); ++start) {
    std::vector<std::size_t> order(kAll);
    std::iota(order.begin(), order.end(), std::size_t{0});
    SeededRandom random(100 + start);
    for (std::size_t i = kAll - 1; i > 0; --i) {
      std::swap(order[i], order[static_cast<std::size_t>(random.uniform(0.0, static_cast<double>(i + 1)))]);
    }
    for (std::size_t i = 0; i < std::min(per_start, kAll); ++i) {
      Case made;
      made.start = start;
      made.youngs_modulus = kYoungsModuli[order[i] % kYoungsModuli.size()];
      made.dt = kSteps[order[i] / kYoungsModuli.size() % kSteps.size()];
      made.aspect = kAspects[order[i] / (kYoungsModuli.size() * kSteps.size())];
      made.poissons_ratio = kPoissonsRatios[i % kPoissonsRatios.size()];
      cases.push_back(made);
    }
  }
  return cases;
}

Outcome run(const Case& tested, int num_steps, const Budget& budget) {
  Start start = start_kinds()[tested.start].make(tested.aspect);
  std::vector<fem::Material> materials;
  for (const double density : start.densities) materials.push_back(material(tested, density));
  const fem::Model model(start.mesh, materials);
  fem::IntegratorOptions options = scene::integrator_options({}, tested.dt);
  options.precision = tested.precision;
  options.kind = tested.kind;
  if (tested.newton_iterations > 0) options.newton_iterations = tested.newton_iterations;
  const std::unique_ptr<fem::Integrator> integrator = fem::make_integrator(options);
  integrator->rebuild(model);

  Outcome outcome;
  outcome.condition = 1.0 + tested.dt * tested.dt * model.stiffness_bound().value();
  outcome.is_explicit = integrator->kind() == fem::IntegratorKind::kExplicit;
  outcome.integrator = std::string(integrator->explanation());
  const fem::Loads& loads = start.loads;
  fem::State& state = start.state;
  const double before = model.energies(state, loads.gravity).total();
  const double scale = std::max(std::abs(before), 9.81 * model.masses().total());
  const Eigen::Vector3d centre = model.centre_of_mass(state.x);
  const Eigen::Vector3d drift_velocity = model.momentum(state).linear / model.masses().total();
  const double size = (state.x.colwise() - centre).norm();
  const long most_steps = std::min<long>(num_steps, budget.vertex_steps / model.num_vertices());
  while (outcome.num_steps < most_steps && outcome.num_substeps < budget.substeps && outcome.finite) {
    const fem::StepStats stats = integrator->step(model, loads, tested.dt, nullptr, state);
    for (std::size_t bit = 0; bit < outcome.flags.size(); ++bit) outcome.flags[bit] += (stats.flags >> bit) & 1U;
    outcome.simulated += stats.simulated;
    ++outcome.num_steps;
    outcome.num_substeps += stats.substeps;
    outcome.finite = fem::is_finite(state);
    outcome.gain = std::max(outcome.gain, (model.energies(state, loads.gravity).total() - before) / scale);
    if (!loads.pins.empty()) continue;
    const Eigen::Vector3d expected = centre + outcome.simulated * drift_velocity;
    outcome.drift = std::max(outcome.drift, (model.centre_of_mass(state.x) - expected).norm() /
                                                (1.0 + size + outcome.simulated * drift_velocity.norm()));
  }
  return outcome;
}

}  // namespace kerf::stability

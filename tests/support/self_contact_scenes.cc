#include "tests/support/self_contact_scenes.h"

#include <cmath>
#include <numbers>
#include <utility>
#include <vector>

#include "server/base/check.h"
#include "server/base/random.h"
#include "server/core/cut/cut.h"
#include "server/core/fem/element/material.h"
#include "server/core/mesh/build/grid_mesh.h"
#include "tests/support/random_cuts.h"

namespace kerf::scenes {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr double kThickness = 5.0e-4;  // m
constexpr double kFriction = 0.3;

scene::SheetConfig cloth() {
  scene::SheetConfig config;
  config.material = fem::isotropic(2.0e6, 0.3, kThickness, 400.0);
  return config;
}

void add_floor(scene::SheetConfig& config) {
  config.colliders = {{contact::Plane{{0.0, 0.0, 0.0}, {0.0, 0.0, 1.0}}, kFriction}};
}

// A mesh of several grids that are not connected, even where they coincide.
class Grids {
 public:
  // Adds a grid. `material(i, j)` and `start(i, j)` are the places of vertex (i, j) in the material plane and in the
  // world, m. Cells are halved from lower left to upper right.
  template <typename Material, typename Start>
  void add(int columns, int rows, const Material& material, const Start& start) {
    const int first = static_cast<int>(material_.size());
    for (int j = 0; j < rows; ++j) {
      for (int i = 0; i < columns; ++i) {
        material_.push_back(material(i, j));
        start_.push_back(start(i, j));
        if (i + 1 == columns || j + 1 == rows) continue;
        const int a = first + j * columns + i;
        const int b = a + 1;
        const int c = b + columns;
        const int d = a + columns;
        triangles_.emplace_back(a, b, c);
        triangles_.emplace_back(a, c, d);
      }
    }
  }
  [[nodiscard]] scene::ArraySource source() const {
    scene::ArraySource source;
    source.material_positions =
        Eigen::Map<const Eigen::Matrix2Xd>(material_.front().data(), 2, static_cast<Eigen::Index>(material_.size()));
    source.positions =
        Eigen::Map<const Eigen::Matrix3Xd>(start_.front().data(), 3, static_cast<Eigen::Index>(start_.size()));
    source.triangles =
        Eigen::Map<const Eigen::Matrix3Xi>(triangles_.front().data(), 3, static_cast<Eigen::Index>(triangles_.size()));
    return source;
  }

 private:
  std::vector<Vector2d> material_;
  std::vector<Vector3d> start_;
  std::vector<Eigen::Vector3i> triangles_;
};

Vector3d on_edge(const Vector2d& material) {
  const double wave = 0.02 * std::sin(2.0 * std::numbers::pi * material.x());
  return {material.x() - 0.5, 0.05 * material.y() + wave, 0.01 + material.y()};
}

// `strips`: of as nearly equal width as whole columns allow.
scene::SheetConfig on_edge_in_strips(std::int32_t side, int strips) {
  const double h = 1.0 / (side - 1);
  Grids grids;
  for (int s = 0; s < strips; ++s) {
    const auto column = [&](int strip) {
      return static_cast<int>(std::lround(static_cast<double>(strip * (side - 1)) / strips));
    };
    const int first = column(s);
    const auto material = [&](int i, int j) { return Vector2d(h * (first + i), h * j); };
    grids.add(column(s + 1) - first + 1, side, material, [&](int i, int j) { return on_edge(material(i, j)); });
  }
  scene::SheetConfig config = cloth();
  config.mesh = grids.source();
  add_floor(config);
  return config;
}

}  // namespace

scene::SheetConfig falls_on_edge(std::int32_t side) {
  return on_edge_in_strips(side, 1);
}

scene::SheetConfig hung_by_corner(std::int32_t side) {
  scene::SheetConfig config = cloth();
  config.mesh = scene::GridSource{side, side, 1.0, 1.0, scene::GridPattern::kUniformDiagonals, 0};
  config.placement.y_axis = {0.0, 1.0, 0.0};
  config.pins = {scene::NearestVertex{{0.0, 1.0}}};
  return config;
}

scene::SheetConfig folded_twice(std::int32_t side) {
  const double h = 1.0 / (side - 1);
  const int fold = side / 2;              // column, and row, of the fold lines
  const double apart = 3.0 * kThickness;  // of neighbouring layers
  const double axis = 1.5 * apart;        // height of the second fold above the lowest layer
  // Distance in the plane that an edge of length h covers while it rises or falls by `rise`.
  const auto run = [&](double rise) { return std::sqrt(h * h - rise * rise); };
  // The first fold: layers at heights 0 and `apart`, with the fold line halfway between. x grows towards the fold line.
  const auto once = [&](int i) {
    const int steps = std::abs(i - fold);
    const double x = steps == 0 ? 0.0 : -run(0.5 * apart) - (steps - 1) * h;
    return Vector2d(x, i < fold ? 0.0 : i == fold ? 0.5 * apart : apart);
  };
  // The second fold turns both layers about an axis above them; the outer one reaches farther.
  const auto twice = [&](int i, int j) {
    const Vector2d below = once(i);
    const double radius = axis - below.y();
    const int steps = std::abs(j - fold);
    const double y = steps == 0 ? radius : radius - run(radius) - (steps - 1) * h;
    const double z = j < fold ? below.y() : j == fold ? axis : 2.0 * axis - below.y();
    return Vector3d(below.x(), y, 0.5 * kThickness + apart + z);
  };
  Grids grids;
  grids.add(
      side, side, [&](int i, int j) { return Vector2d(h * i, h * j); }, twice);
  scene::SheetConfig config = cloth();
  config.mesh = grids.source();
  add_floor(config);
  return config;
}

scene::SheetConfig falls_in_strips(std::int32_t side) {
  return on_edge_in_strips(side, 5);
}

scene::SheetConfig twisted_strip(std::int32_t columns) {
  constexpr double kWidth = 0.04;  // m
  scene::SheetConfig config = cloth();
  config.mesh = scene::GridSource{columns, 5, 1.0, kWidth, scene::GridPattern::kUniformDiagonals, 0};
  config.placement.origin = {-0.5, -0.5 * kWidth, 0.0};
  config.placement.y_axis = {0.0, 1.0, 0.0};
  config.gravity.setZero();
  const double held = 1.5 / (columns - 1);  // m: two columns at each end
  for (const double end : {-1.0, 1.0}) {
    scene::Constraint& constraint = config.constraints.emplace_back();
    constraint.region = end < 0.0 ? scene::MaterialBox{{0.0, 0.0}, {held, kWidth}}
                                  : scene::MaterialBox{{1.0 - held, 0.0}, {1.0, kWidth}};
    constraint.displacement = {-0.125 * end, 0.0, 0.0};
    constraint.rotation = scene::Rotation{{1.0, 0.0, 0.0}, {0.0, 0.0, 0.0}, 4.0 * std::numbers::pi * end};
    constraint.history = {{0.0, 4.0}, {0.0, 1.0}};
  }
  return config;
}

scene::SheetConfig thrown_on_a_layer(std::int32_t side) {
  const double h = 1.0 / (side - 1);
  const int rows = side / 2;
  Grids grids;
  for (const int layer : {0, 1}) {
    const double height = 0.5 * kThickness + 0.05 * layer;
    grids.add(
        side, rows, [&](int i, int j) { return Vector2d(h * i, h * (j + (rows + 1) * layer)); },
        [&](int i, int j) { return Vector3d(h * i, h * j, height); });
  }
  scene::SheetConfig config = cloth();
  config.mesh = grids.source();
  config.initial_velocity = scene::InitialVelocity{{0.0, 0.0, -10.0}, {0.0, 0.0, 0.0}, {}};
  add_floor(config);
  return config;
}

scene::SheetConfig stack_of_ten(std::int32_t side) {
  constexpr double kWidth = 0.3;  // m
  const double h = kWidth / (side - 1);
  Grids grids;
  for (int layer = 0; layer < 10; ++layer) {
    grids.add(
        side, side, [&](int i, int j) { return Vector2d(h * i + 1.2 * kWidth * layer, h * j); },
        [&](int i, int j) { return Vector3d(h * i, h * j, 0.01 * (layer + 1)); });
  }
  scene::SheetConfig config = cloth();
  config.mesh = grids.source();
  add_floor(config);
  return config;
}

scene::SheetConfig cut_in_the_pile(std::int32_t side) {
  scene::SheetConfig config = falls_on_edge(side);
  scene::CutBatch slits;
  for (int k = 1; k <= 4; ++k) {
    scene::Cut& slit = slits.cuts.emplace_back();
    slit.curve = cut::Polyline{{{0.2 * k, 0.2}, {0.2 * k, 0.8}}};
  }
  config.commands.push_back({48, std::move(slits)});
  return config;
}

scene::SheetConfig falls_after_cuts(std::int32_t side, std::uint64_t seed, std::size_t cuts) {
  scene::SheetConfig config;
  config.mesh = scene::GridSource{side, side, 1.0, 1.0, scene::GridPattern::kUniformDiagonals, 0};
  config.material = fem::find_preset("demo").value();
  config.material.youngs_modulus_1 = config.material.youngs_modulus_2 = 1.5e5;  // as in deploy/scenes/demo.json
  config.placement.origin = {-0.5, -0.5, 0.8};
  config.placement.y_axis = {0.0, 1.0, 0.0};
  config.integrator.max_substeps = 100'000;
  add_floor(config);
  // Curves that miss the sheet do not count, so the cuts are tried here.
  Result<mesh::TriangleMesh> mesh = mesh::make_grid({.num_x = side, .num_y = side});
  KERF_CHECK(mesh.ok(), "the grid of a scene is valid");
  SeededRandom random(seed);
  while (config.commands.size() < cuts) {
    scene::Cut cut;
    cut.curve = test::random_cubic(random);
    const Result<cut::CutPlan> planned = cut::plan(*mesh, {cut.curve, cut.options, {}});
    if (!planned.ok()) continue;
    const Result<cut::CutOutcome> done = cut::apply(*mesh, *planned);
    if (done.ok() && done->status == cut::CutStatus::kApplied) config.commands.push_back({1, std::move(cut)});
  }
  return config;
}

scene::SheetConfig swings(std::int32_t side) {
  scene::SheetConfig config = cloth();
  config.mesh = scene::GridSource{side, side, 1.0, 1.0, scene::GridPattern::kUniformDiagonals, 0};
  config.placement.y_axis = {0.0, std::numbers::sqrt2 / 2.0, std::numbers::sqrt2 / 2.0};
  config.pins = {scene::MaterialBox{{0.0, 1.0 - 1e-6}, {1.0, 1.0}}};
  return config;
}

std::span<const SelfContactScene> self_contact_scenes() {
  static constexpr SelfContactScene kScenes[] = {
      {'a', "falls on its edge", 10.0, false, [] { return falls_on_edge(); }, [] { return falls_on_edge(12); }},
      {'b', "hung by a corner", 10.0, false, [] { return hung_by_corner(); }, [] { return hung_by_corner(12); }},
      {'c', "folded twice", 2.0, false, [] { return folded_twice(); }, [] { return folded_twice(12); }},
      {'d', "falls in five strips", 5.0, false, [] { return falls_in_strips(); }, [] { return falls_in_strips(12); }},
      {'e', "strip, twisted", 20.0, false, [] { return twisted_strip(); }, [] { return twisted_strip(26); }},
      {'f', "thrown on a layer", 5.0, true, [] { return thrown_on_a_layer(); }, [] { return thrown_on_a_layer(12); }},
      {'s', "stack of ten", 0.6, true, [] { return stack_of_ten(); }, [] { return stack_of_ten(5); }},
      {'p', "slits cut in the pile", 1.8, false, [] { return cut_in_the_pile(); }, [] { return cut_in_the_pile(12); }},
      {'r', "falls after 50 cuts", 5.0, false, [] { return falls_after_cuts(); }, [] { return falls_after_cuts(12); }},
      {'w', "swings", 1.0, false, [] { return swings(); }, [] { return swings(12); }},
  };
  return kScenes;
}

}  // namespace kerf::scenes

// Lowest vibrations against independent references.
#include <cmath>
#include <numbers>

#include "server/core/fem/element/loads.h"
#include "server/core/fem/model/model.h"
#include "server/core/fem/statics/equilibrium.h"
#include "server/core/fem/statics/modes.h"
#include "server/core/mesh/build/grid_mesh.h"
#include "tests/accuracy/reference.h"

namespace kerf::accuracy {
namespace {

struct Case {
  std::string id;
  bool planar = false;
  int rigid = 0;            // modes that are none
  double prestretch = 0.0;  // of a sheet held along its whole border
  bool is_clamped = false;  // at x = 0
};
void PrintTo(const Case& tested, std::ostream* out) {
  *out << tested.id;
}

class Vibration : public testing::TestWithParam<Case> {};

TEST_P(Vibration, HasTheFrequenciesOfTheReference) {
  const Case& tested = GetParam();
  const Reference reference(tested.id);
  const double width = reference.geometry("a");
  const double height = reference.geometry("b");
  const std::vector<std::vector<double>> rows = reference.rows("eigenfrequencies");
  int cells = 8;
  for (const char* const fineness : {"coarse", "medium", "fine"}) {
    const mesh::TriangleMesh mesh = mesh::make_grid({cells + 1, cells + 1, width, height}).value();
    fem::Model model(mesh, reference.material());
    std::vector<fem::Clamp> clamps;
    fem::Loads loads;
    loads.gravity.setZero();
    linear::VertexField x(mesh.num_vertices());
    for (int v = 0; v < mesh.num_vertices(); ++v) {
      x.col(v) << (1.0 + tested.prestretch) * mesh.rest_position(v), 0.0;
      const int i = v % (cells + 1);
      const int j = v / (cells + 1);
      const bool on_border = i == 0 || j == 0 || i == cells || j == cells;
      if (tested.planar) loads.pins.push_back({v, x.col(v), Eigen::Vector3d::Zero(), {false, false, true}});
      if (tested.is_clamped && i == 0) {
        loads.pins.push_back({v, x.col(v), Eigen::Vector3d::Zero()});
        clamps.push_back({v, Eigen::Matrix<double, 3, 2>::Identity()});
      }
      if (tested.prestretch > 0.0 && on_border) loads.pins.push_back({v, x.col(v), Eigen::Vector3d::Zero()});
    }
    model.set_clamps(mesh, clamps);
    model.bend_by_angles(mesh);
    const fem::Modes modes = fem::find_modes(model, loads, x, tested.rigid + static_cast<int>(rows.size()));
    EXPECT_TRUE(modes.converged);
    for (int i = 0; i < tested.rigid; ++i)
      EXPECT_LT(std::abs(modes.eigenvalues[i]), 1e-9 * model.stiffness_bound().value());
    std::printf("%s, %d cells a side:", tested.id.c_str(), cells);
    for (std::size_t i = 0; i < rows.size(); ++i) {
      const double omega2 = modes.eigenvalues[tested.rigid + static_cast<Eigen::Index>(i)];
      const double frequency = std::sqrt(omega2) / (2.0 * std::numbers::pi);
      std::printf(" %+.2f %%", 100.0 * (frequency / rows[i][0] - 1.0));
      EXPECT_NEAR(frequency, rows[i][0], reference.tolerance(fineness) * rows[i][0]) << i;
    }
    std::printf("\n");
    cells *= 2;
  }
}

INSTANTIATE_TEST_SUITE_P(References, Vibration,
                         testing::Values(Case{"08a_membrane_square", false, 0, 0.01},
                                         Case{"08b_inplane_free_square", true, 3},
                                         Case{"08c_free_square_plate", false, 6},
                                         Case{"08d_cantilever_square_plate", false, 0, 0.0, true},
                                         Case{"08h_cantilever_plate_2_1", false, 0, 0.0, true}),
                         [](const testing::TestParamInfo<Case>& tested) { return tested.param.id.substr(4); });

}  // namespace
}  // namespace kerf::accuracy

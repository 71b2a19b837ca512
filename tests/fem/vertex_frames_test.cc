#include "server/core/fem/element/vertex_frames.h"

#include "tests/fem/fixture.h"

namespace kerf::fem {
namespace {

std::vector<Eigen::Matrix3d> frames_of(const Model& model, const linear::VertexField& x) {
  std::vector<Eigen::Matrix3d> frames(static_cast<std::size_t>(model.num_vertices()));
  find_vertex_frames(model.element_blocks(), x, frames);
  return frames;
}

TEST(VertexFrames, AreRotationsThatTurnWithTheSheet) {
  SeededRandom random(3);
  const mesh::TriangleMesh mesh = jittered_square(9);
  const Model model(mesh, Material{});
  State state = rest_state(mesh);
  for (const Eigen::Matrix3d& frame : frames_of(model, state.x)) {
    EXPECT_LT((frame - Eigen::Matrix3d::Identity()).norm(), 1e-12);
  }
  state.x += random_field(random, state.x.cols(), 0.02);
  const std::vector<Eigen::Matrix3d> before = frames_of(model, state.x);
  const Eigen::Matrix3d turn = random_rotation(random);
  state.x = turn * state.x;
  const std::vector<Eigen::Matrix3d> after = frames_of(model, state.x);
  for (std::size_t i = 0; i < before.size(); ++i) {
    EXPECT_LT((before[i].transpose() * before[i] - Eigen::Matrix3d::Identity()).norm(), 1e-12);
    EXPECT_NEAR(before[i].determinant(), 1.0, 1e-12);
    EXPECT_LT((after[i] - turn * before[i]).norm(), 1e-11);
  }
}

TEST(VertexFrames, OfCollapsedSheetsAreRotationsToo) {
  const mesh::TriangleMesh mesh = square_grid(5);
  const Model model(mesh, Material{});
  State state = rest_state(mesh);
  for (const Eigen::Vector3d& scale : {Eigen::Vector3d(1, 0, 0), Eigen::Vector3d(0, 0, 0), Eigen::Vector3d(-1, 1, 1)}) {
    const linear::VertexField x = scale.asDiagonal() * state.x;
    for (const Eigen::Matrix3d& frame : frames_of(model, x)) {
      EXPECT_LT((frame.transpose() * frame - Eigen::Matrix3d::Identity()).norm(), 1e-12);
      EXPECT_NEAR(frame.determinant(), 1.0, 1e-12);
    }
  }
}

}  // namespace
}  // namespace kerf::fem

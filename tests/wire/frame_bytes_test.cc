// Counts the bytes of frames of real sheets: the targets of the protocol, for sheets that swing, fall on a ball and are
// cut. Counts are the same on every machine.

#include <cstdio>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "kerf/v1/stream.pb.h"
#include "server/core/fem/element/material.h"
#include "server/core/sheet/sheet.h"
#include "server/service/wire/frame_encoder.h"

namespace kerf::wire {
namespace {

constexpr double kDeltaBytesPerVertex = 3.2;
constexpr double kKeyframeBytesPerVertex = 5.2;
constexpr double kIndexBytesPerTriangle = 1.3;
constexpr double kBytesPerNewVertex = 24.0;
constexpr double kBytesPerChangedTriangle = 10.0;
constexpr int kSide = 50;
constexpr int kTicks = 150;

scene::SheetConfig cloth() {
  scene::SheetConfig config;
  scene::GridSource grid;
  grid.columns = kSide;
  grid.rows = kSide;
  config.mesh = grid;
  config.material = fem::find_preset("demo").value();
  config.placement.y_axis = {0.0, 1.0, 0.0};
  return config;
}

sheet::Sheet swinging() {
  scene::SheetConfig config = cloth();
  config.pins.emplace_back(scene::RegionEdge::kTopCorners);
  return sheet::Sheet::create(std::move(config)).value();
}

sheet::Sheet falling() {
  scene::SheetConfig config = cloth();
  config.placement.origin = {-0.5, -0.5, 0.31};
  config.colliders = {{contact::Sphere{{0.0, 0.0, 0.0}, 0.3}, 0.4}};
  return sheet::Sheet::create(std::move(config)).value();
}

struct Sizes {
  double delta = 0.0;     // bytes a vertex, mean; whole bodies, with box and statistics
  double keyframe = 0.0;  // bytes per vertex, mean
};

Sizes measure(sheet::Sheet sheet) {
  std::optional<QuantisedFrame> last;
  double delta_bytes = 0.0;
  double keyframe_bytes = 0.0;
  int num_deltas = 0;
  for (int tick = 0; tick < kTicks; ++tick) {
    sheet.step({});
    QuantisedFrame frame = quantise_frame(*sheet.snapshot(), last ? std::optional(last->box) : std::nullopt);
    const Predictors predictors = make_predictors(*frame.topology);
    keyframe_bytes += static_cast<double>(encode_keyframe_body(frame, predictors).size());
    if (last && last->box == frame.box) {
      delta_bytes += static_cast<double>(encode_delta_body(frame, *last, predictors).size());
      ++num_deltas;
    }
    last = std::move(frame);
  }
  EXPECT_GT(num_deltas, kTicks * 8 / 10);
  return {delta_bytes / num_deltas / (kSide * kSide), keyframe_bytes / kTicks / (kSide * kSide)};
}

TEST(FrameBytes, OfSwingingAndFallingSheetsKeepTheirTargets) {
  for (const auto& [name, sheet] : {std::pair("swinging", &swinging), std::pair("falling", &falling)}) {
    const Sizes sizes = measure(sheet());
    std::printf("%s: %.2f B a vertex as delta, %.2f as keyframe\n", name, sizes.delta, sizes.keyframe);
    EXPECT_LE(sizes.delta, kDeltaBytesPerVertex) << name;
    EXPECT_LE(sizes.keyframe, kKeyframeBytesPerVertex) << name;
  }
}

v1::TopologyPatch patch_of(const sheet::Topology& topology, std::int32_t base_version) {
  const Predictors predictors = make_predictors(topology);
  v1::Frame frame;
  EXPECT_TRUE(frame.ParseFromString(encode_topology(topology, base_version, &predictors).bytes));
  return frame.topology();
}

TEST(FrameBytes, OfTrianglesAndCutsKeepTheirTargets) {
  sheet::Sheet sheet = swinging();
  for (int tick = 0; tick < 30; ++tick) sheet.step({});
  const auto whole = sheet.snapshot();
  const double index = static_cast<double>(patch_of(*whole->topology, -1).triangles().size()) /
                       static_cast<double>(whole->topology->num_triangles);
  std::printf("grid: %.2f B a triangle\n", index);
  EXPECT_LE(index, kIndexBytesPerTriangle);

  scene::Cut cut;
  cut.curve = cut::CubicBezier{{{0.25, 0.5}, {0.4, 0.9}, {0.6, 0.1}, {0.75, 0.5}}};
  const scene::Command command = cut;
  sheet.step(std::span(&command, 1));
  const auto cut_open = sheet.snapshot();
  const v1::TopologyPatch patch = patch_of(*cut_open->topology, whole->topology->version);
  ASSERT_EQ(patch.base_version(), whole->topology->version);
  const auto new_vertices = static_cast<double>(cut_open->positions.cols() - whole->positions.cols());
  const double budget = kBytesPerNewVertex * new_vertices + kBytesPerChangedTriangle * patch.num_listed_slots();
  std::printf("cut: %zu B for %.0f new vertices and %d changed triangles\n", patch.ByteSizeLong(), new_vertices,
              patch.num_listed_slots());
  EXPECT_GT(new_vertices, 20.0);
  EXPECT_LE(static_cast<double>(patch.ByteSizeLong()), budget);
  const double again = static_cast<double>(patch_of(*cut_open->topology, -1).triangles().size()) /
                       static_cast<double>(cut_open->topology->num_triangles);
  std::printf("cut grid: %.2f B a triangle\n", again);
  EXPECT_LE(again, kIndexBytesPerTriangle);
}

}  // namespace
}  // namespace kerf::wire

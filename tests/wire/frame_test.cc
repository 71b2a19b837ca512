// Quantising, frames and topology patches, read back by a decoder of their own.

#include <cmath>
#include <limits>
#include <vector>

#include <gtest/gtest.h>

#include "kerf/v1/render.pb.h"
#include "server/base/random.h"
#include "server/service/wire/frame_encoder.h"
#include "server/service/wire/quantise.h"
#include "server/service/wire/stream_codec.h"
#include "tests/wire/changing_sheet.h"
#include "tests/wire/frame_mirror.h"

namespace kerf::wire {
namespace {

using testing::ChangingSheet;
using testing::FrameMirror;

v1::Frame assemble(std::int64_t sequence, const std::string& body, const std::string& topology = {}) {
  v1::WatchResponse response;
  const std::string bytes = encode_frame_head(sequence, 0, {}, body.size() + topology.size()) + body + topology;
  EXPECT_TRUE(response.ParseFromString(bytes));
  EXPECT_EQ(response.kind_case(), v1::WatchResponse::kFrame);
  return response.frame();
}

void expect_topology(const FrameMirror& mirror, const sheet::Topology& topology) {
  ASSERT_EQ(mirror.triangles.size(), topology.triangles.size());
  for (std::size_t slot = 0; slot < topology.triangles.size(); ++slot) {
    EXPECT_EQ(mirror.triangles[slot], topology.triangles[slot]) << "slot " << slot;
    EXPECT_EQ(mirror.pieces[slot], topology.pieces[slot]) << "slot " << slot;
  }
  ASSERT_EQ(static_cast<Eigen::Index>(mirror.material.size()), topology.material_positions.cols());
  for (std::size_t v = 0; v < mirror.material.size(); ++v) {
    for (std::size_t k = 0; k < 2; ++k) {
      const double exact = topology.material_positions(static_cast<Eigen::Index>(k), static_cast<Eigen::Index>(v));
      EXPECT_EQ(mirror.material[v][k], static_cast<float>(exact)) << "vertex " << v;
    }
  }
}

TEST(Quantise, ErrorStaysWithinHalfAStep) {
  SeededRandom random(1);
  for (int round = 0; round < 200; ++round) {
    const double scale = std::pow(10.0, random.uniform(-6.0, 6.0));
    const double offset = random.uniform(-1.0e5, 1.0e5);
    std::vector<double> positions(3 * (1 + random.below(40)));
    for (double& x : positions) x = offset + random.uniform(-scale, scale);
    const FrameBox box = choose_box(positions, std::nullopt);
    const std::vector<std::uint16_t> q = quantise(positions, box);
    for (std::size_t i = 0; i < positions.size(); ++i) {
      const double size = box.size[i % 3];
      const double back = box.min[i % 3] + q[i] * (size / 65535.0);
      EXPECT_LE(std::abs(back - positions[i]), size / 131070.0 * (1.0 + 1e-9) + 1e-10 * std::abs(offset) * 0x1p-20);
    }
  }
}

TEST(Quantise, BoxIsExactAndHasMargin) {
  SeededRandom random(2);
  for (int round = 0; round < 500; ++round) {
    const double scale = std::pow(10.0, random.uniform(-5.0, 5.0));
    const double offset = random.uniform(-1.0e6, 1.0e6);
    std::vector<double> positions(30);
    for (double& x : positions) x = offset + random.uniform(-scale, scale);
    const FrameBox box = choose_box(positions, std::nullopt);
    for (std::size_t axis = 0; axis < 3; ++axis) {
      EXPECT_EQ(std::exp2(std::round(std::log2(box.size[axis]))), box.size[axis]) << "no power of two";
      const double max = box.min[axis] + box.size[axis];
      EXPECT_EQ(max - box.min[axis], box.size[axis]) << "min + size is rounded";
      for (std::size_t i = axis; i < positions.size(); i += 3) {
        EXPECT_GE(positions[i] - box.min[axis], 0.069 * box.size[axis]);
        EXPECT_GE(max - positions[i], 0.069 * box.size[axis]);
      }
    }
  }
}

TEST(Quantise, BoxStaysWhileTheSheetMovesInItAndGrowsWhenItLeaves) {
  const std::vector<double> start{0.0, 0.0, 0.0, 1.0, 1.0, 0.0};
  const FrameBox box = choose_box(start, std::nullopt);
  EXPECT_EQ(box.size, (std::array<double, 3>{2.0, 2.0, 0.5}));
  EXPECT_EQ(box.min, (std::array<double, 3>{-0.5, -0.5, -0.25}));
  std::vector<double> moved = start;
  moved[0] = box.min[0];  // just on the border
  EXPECT_EQ(choose_box(moved, box), box);
  moved[0] = std::nextafter(box.min[0], -1.0);
  const FrameBox grown = choose_box(moved, box);
  EXPECT_NE(grown, box);
  EXPECT_LT(grown.min[0], moved[0]);
  // Smaller than the box, but not by the factor at which it would be given up.
  const std::vector<double> small{0.0, 0.0, 0.0, 0.3, 0.3, 0.0};
  EXPECT_EQ(choose_box(small, box), box);
  const std::vector<double> tiny{0.0, 0.0, 0.0, 0.1, 0.1, 0.0};
  EXPECT_NE(choose_box(tiny, box), box);
}

TEST(Quantise, HandlesNoAndOneVertex) {
  EXPECT_TRUE(quantise({}, choose_box({}, std::nullopt)).empty());
  const std::vector<double> point{3.0, -4.0, 1.0e6};
  const FrameBox box = choose_box(point, std::nullopt);
  const std::vector<std::uint16_t> q = quantise(point, box);
  for (std::size_t axis = 0; axis < 3; ++axis) {
    EXPECT_NEAR(box.min[axis] + q[axis] * box.size[axis] / 65535.0, point[axis], box.size[axis] / 131070.0);
  }
}

TEST(FrameEncoder, MirrorEqualsQuantisedPositionsThroughCutsSkipsAndNewBoxes) {
  ChangingSheet sheet(3, 60, 100);
  SeededRandom random(4);
  FrameMirror mirror;
  std::optional<QuantisedFrame> last;
  int deltas = 0;
  int new_boxes = 0;
  std::int32_t told = -1;
  for (int tick = 0; tick < 400; ++tick) {
    sheet.move(0.004, tick > 200 ? 0.01 : 0.0);
    if (tick % 37 == 5) sheet.cut(3);
    if (tick == 300) sheet.reset(40, 70);
    if (last && random.uniform() < 0.3) continue;  // this viewer skips the tick
    const QuantisedFrame frame =
        quantise_frame(*sheet.snapshot(), last ? std::optional<FrameBox>(last->box) : std::nullopt);
    const Predictors predictors = make_predictors(*frame.topology);
    std::optional<std::string> delta;
    const bool full_topology = !last || frame.topology->patchable_since > told;
    if (!full_topology && last->box == frame.box && random.uniform() < 0.9) {
      delta = encode_delta_body(frame, *last, predictors);
    }
    new_boxes += last && last->box != frame.box ? 1 : 0;
    deltas += delta.has_value() ? 1 : 0;
    std::string topology;
    if (frame.topology->version != told) topology = encode_topology(*frame.topology, told, &predictors).bytes;
    const auto fault =
        mirror.apply(assemble(mirror.sequence + 1, delta ? *delta : encode_keyframe_body(frame, predictors), topology));
    ASSERT_EQ(fault, std::nullopt) << "tick " << tick;
    ASSERT_EQ(std::vector<std::int32_t>(frame.positions.begin(), frame.positions.end()), mirror.quantised);
    if (frame.topology->version != told) expect_topology(mirror, *frame.topology);
    told = frame.topology->version;
    last = frame;
  }
  EXPECT_GT(deltas, 150);
  EXPECT_GT(new_boxes, 2);
}

TEST(FrameEncoder, UnionPatchFromAnyVersionGivesTheSameAsTheFullTopology) {
  ChangingSheet sheet(5, 300, 500);
  std::vector<FrameMirror> viewers;  // viewer i stopped at the i-th version
  int unions = 0;
  for (int round = 0; round < 12; ++round) {
    if (round == 6) sheet.reset(280, 480);
    if (round > 0) sheet.cut(2);
    const QuantisedFrame frame = quantise_frame(*sheet.snapshot(), std::nullopt);
    FrameMirror fresh;
    const Predictors predictors = make_predictors(*frame.topology);
    const EncodedTopology full = encode_topology(*frame.topology, -1, &predictors);
    ASSERT_TRUE(full.full);
    ASSERT_EQ(fresh.apply(assemble(1, encode_keyframe_body(frame, predictors), full.bytes)), std::nullopt);
    expect_topology(fresh, *frame.topology);
    for (FrameMirror viewer : viewers) {  // a copy: the viewer itself stays behind
      const EncodedTopology patch = encode_topology(*frame.topology, viewer.topology_version, &predictors);
      EXPECT_EQ(patch.full, viewer.topology_version < frame.topology->patchable_since);
      EXPECT_TRUE(patch.full || patch.bytes.size() < full.bytes.size() / 2);
      unions += patch.full ? 0 : 1;
      ASSERT_EQ(viewer.apply(assemble(2, encode_keyframe_body(frame, predictors), patch.bytes)), std::nullopt);
      EXPECT_EQ(viewer.triangles, fresh.triangles);
      EXPECT_EQ(viewer.pieces, fresh.pieces);
      EXPECT_EQ(viewer.material, fresh.material);
    }
    viewers.push_back(fresh);
  }
  EXPECT_EQ(unions, 15 + 15);
}

TEST(QuantisedStrains, AreWithinHalfAStepOfAPowerOfTwo) {
  const std::vector<float> strains{0.0F, 0.03F, -0.011F, 0.0299F};
  const QuantisedStrains quantised = quantise_strains(strains);
  EXPECT_EQ(quantised.scale, 0x1p-5);
  for (std::size_t i = 0; i < strains.size(); ++i) {
    const double share = quantised.values[i] / 127.0;
    // Half a step: the derivative of the square.
    EXPECT_NEAR(share * std::abs(share) * quantised.scale, strains[i],
                (std::abs(share) + 0.5 / 127.0) * quantised.scale / 127.0);
  }
  EXPECT_EQ(quantise_strains(std::vector<float>{0.0F}).scale, 0x1p-20);
  const float infinite = std::numeric_limits<float>::infinity();
  const QuantisedStrains broken =
      quantise_strains(std::vector<float>{infinite, std::numeric_limits<float>::quiet_NaN(), 1.0e9F, -1.0e9F});
  EXPECT_EQ(broken.scale, 0x1p10);
  EXPECT_EQ(broken.values, (std::vector<std::int8_t>{0, 0, 127, -127}));
}

TEST(FrameEncoder, RawFramesGiveTheSameMirrorAsCompactOnes) {
  ChangingSheet sheet(8, 70, 110);
  FrameMirror raw;
  FrameMirror compact;
  std::int32_t told = -1;
  for (int round = 0; round < 20; ++round) {
    sheet.move(0.01);
    if (round % 3 == 1) sheet.cut(2);
    if (round == 12) sheet.reset(50, 90);
    const QuantisedFrame frame = quantise_frame(*sheet.snapshot(), std::nullopt);
    const Predictors predictors = make_predictors(*frame.topology);
    const bool is_new = frame.topology->version != told;
    const EncodedTopology plain = encode_topology(*frame.topology, told, nullptr);
    const EncodedTopology packed = encode_topology(*frame.topology, told, &predictors);
    EXPECT_EQ(plain.full, packed.full);
    ASSERT_EQ(raw.apply(assemble(round + 1, encode_raw_body(frame), is_new ? plain.bytes : "")), std::nullopt);
    ASSERT_EQ(compact.apply(assemble(round + 1, encode_keyframe_body(frame, predictors), is_new ? packed.bytes : "")),
              std::nullopt);
    EXPECT_EQ(raw.quantised, compact.quantised);
    EXPECT_EQ(raw.box_max, compact.box_max);
    EXPECT_EQ(raw.triangles, compact.triangles);
    EXPECT_EQ(raw.pieces, compact.pieces);
    EXPECT_EQ(raw.material, compact.material);
    told = frame.topology->version;
  }
}

TEST(FrameEncoder, PatchThatIsNoSmallerIsSentInFull) {
  ChangingSheet sheet(6, 10, 10);
  sheet.cut(20);
  EXPECT_TRUE(encode_topology(*sheet.snapshot()->topology, 1, nullptr).full);
}

TEST(FrameEncoder, HeadMergesWithSharedStats) {
  ChangingSheet sheet(7, 5, 5);
  auto snapshot = *sheet.snapshot();
  snapshot.stats.overruns = 11;
  snapshot.stats.paused = true;
  snapshot.stats.intersections = 12;
  snapshot.stats.unconfirmed_ms = 1300;
  const std::string body = encode_raw_body(quantise_frame(snapshot, std::nullopt));
  v1::WatchResponse response;
  ASSERT_TRUE(response.ParseFromString(encode_frame_head(9, 4, "abc-1", body.size()) + body));
  EXPECT_EQ(response.frame().sequence(), 9);
  EXPECT_EQ(response.frame().epoch(), "abc-1");
  EXPECT_EQ(response.frame().base_tick(), -1);
  EXPECT_EQ(response.frame().stats().skipped(), 4);
  EXPECT_EQ(response.frame().stats().overruns(), 11);
  EXPECT_TRUE(response.frame().stats().paused());
  EXPECT_EQ(response.frame().stats().intersections(), 12);
  EXPECT_EQ(response.frame().stats().unconfirmed_ms(), 1300);
  EXPECT_EQ(response.frame().stats().pieces(), 3);
}

TEST(StreamCodec, AnImageIsItsHeadAndTheSharedBytes) {
  const std::string picture(300, 'x');
  v1::Image image;
  image.set_sequence(5);
  image.set_key(true);
  image.mutable_camera()->set_vertical_fov_deg(40.0);
  v1::WatchImagesResponse response;
  ASSERT_TRUE(response.ParseFromString(encode_image_head(image, picture.size()) + picture));
  EXPECT_EQ(response.image().data(), picture);
  response.mutable_image()->clear_data();
  EXPECT_EQ(response.image().SerializeAsString(), image.SerializeAsString());
  ASSERT_TRUE(response.ParseFromString(encode_images_ended(EndReason::kSheetDeleted)));
  EXPECT_EQ(response.ended().reason(), v1::Ended::SHEET_DELETED);
}

TEST(FrameEncoder, EndedAndRejectionAreReadable) {
  v1::WatchResponse response;
  ASSERT_TRUE(response.ParseFromString(encode_ended(EndReason::kTooSlow)));
  EXPECT_EQ(response.ended().reason(), v1::Ended::TOO_SLOW);
  EXPECT_NE(response.ended().message().find("acknowledge"), std::string::npos);
  ASSERT_TRUE(response.ParseFromString(encode_rejection("hand", invalid_argument("UNKNOWN_VERTEX", "vertex 9"))));
  EXPECT_EQ(response.rejection().grab_id(), "hand");
  EXPECT_EQ(response.rejection().reason(), "UNKNOWN_VERTEX");
  EXPECT_EQ(response.rejection().message(), "vertex 9");
}

}  // namespace
}  // namespace kerf::wire

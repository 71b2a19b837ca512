#include <memory>
#include <span>
#include <string>
#include <utility>

#include <benchmark/benchmark.h>

#include "server/base/state_hash.h"
#include "server/service/wire/frame_encoder.h"
#include "tests/bench/expected.h"
#include "tests/bench/scenes.h"

namespace kerf::bench {
namespace {

enum class Kind { kKeyframe, kDelta, kCut };

// Two frames in sequence of a sheet in motion; for kCut the second comes after a cut.
struct Frames {
  std::shared_ptr<const sheet::Snapshot> first;
  std::shared_ptr<const sheet::Snapshot> second;
};

Frames frames_of(int side, Kind kind) {
  sheet::Sheet sheet = swinging_cloth(side, scene::IntegratorKind::kExplicitLeapfrog);
  for (int tick = 0; tick < 5; ++tick) sheet.step({});
  Frames frames;
  frames.first = sheet.snapshot();
  const scene::Command command = s_cut();
  sheet.step(kind == Kind::kCut ? std::span(&command, 1) : std::span<const scene::Command>());
  frames.second = sheet.snapshot();
  return frames;
}

void encode(benchmark::State& state, const std::string& name, int side, Kind kind) {
  const Frames frames = frames_of(side, kind);
  const wire::QuantisedFrame base = wire::quantise_frame(*frames.first, {});
  const wire::Predictors known = wire::make_predictors(*frames.first->topology);
  std::string bytes;
  for (auto _ : state) {
    const wire::QuantisedFrame frame = wire::quantise_frame(*frames.second, base.box);
    // Made once a topology.
    const wire::Predictors made = kind == Kind::kCut ? wire::make_predictors(*frame.topology) : wire::Predictors();
    const wire::Predictors& predictors = kind == Kind::kCut ? made : known;
    const bool is_delta = kind != Kind::kKeyframe && frame.box == base.box;
    bytes = is_delta ? wire::encode_delta_body(frame, base, predictors) : wire::encode_keyframe_body(frame, predictors);
    if (kind == Kind::kCut) {
      bytes += wire::encode_topology(*frame.topology, base.topology->version, &predictors).bytes;
    }
  }
  state.counters["bytes"] = static_cast<double>(bytes.size());
  state.counters["bytes/vertex"] =
      static_cast<double>(bytes.size()) / static_cast<double>(frames.second->positions.cols());
  StateHash hash;
  hash.add_span(std::span<const char>(bytes));
  expect_hash(state, name, hash.value());
}

const bool kFrameRegistered = [] {
  for (const auto& [label, kind] :
       {std::pair("keyframe", Kind::kKeyframe), std::pair("delta", Kind::kDelta), std::pair("cut", Kind::kCut)}) {
    for (const int side : kGridSides) {
      const std::string name = std::string("encode/") + label + "/" + std::to_string(side * side);
      const Kind chosen = kind;
      benchmark::RegisterBenchmark(name.c_str(), [name, side, chosen](benchmark::State& state) {
        encode(state, name, side, chosen);
      })->Unit(benchmark::kMicrosecond);
    }
  }
  return true;
}();

}  // namespace
}  // namespace kerf::bench

#include <algorithm>
#include <array>
#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <limits>
#include <mutex>
#include <span>
#include <string>
#include <thread>

#include <benchmark/benchmark.h>

#include "server/base/check.h"
#include "server/base/state_hash.h"
#include "server/core/fem/leapfrog/leapfrog_sweep.h"
#include "server/core/mesh/build/grid_mesh.h"
#include "tests/bench/expected.h"

// Measures the largest possible gain of two threads inside one sheet. It compares substeps of a whole sheet on one
// thread with those of two half sheets on two. The threads work apart, or meet after each step, asleep until the other
// arrives. The further cost of a real division, the seam and the exchange over it, is left out.
namespace kerf::bench {
namespace {

constexpr int kRounds = 5;

// A free sheet of the race's cloth, columns x rows vertices, spacing 1 m / (columns - 1).
class Swinging {
 public:
  Swinging(int columns, int rows)
      : mesh_(mesh::make_grid({.num_x = columns, .num_y = rows, .width = 1.0, .height = (rows - 1.0) / (columns - 1.0)})
                  .value()),
        model_(mesh_, fem::isotropic(2.0e6, 0.3, 5.0e-4, 400.0)) {
    constexpr double kWave = 75.0;  // m/s, at least the speed of waves in it
    h_ = 0.25 / (kWave * (columns - 1));
    terms_.gravity = {0.0, 0.0, -9.81};
    terms_.h = h_;
    layout_.rebuild(model_);
    sweep_.rebuild(model_, layout_, inertia_);
    state_.x = Eigen::Matrix3Xd::Zero(3, mesh_.num_vertices());
    for (int v = 0; v < mesh_.num_vertices(); ++v) state_.x.col(v).head<2>() = mesh_.rest_position(v);
    state_.v = 0.1 * state_.x;
  }

  // Begins from the same state in each round.
  void begin(int substeps) {
    const bool fits = sweep_.begin(model_, loads_, terms_, h_ * substeps, state_);
    KERF_CHECK(fits, "mixed precision refuses the benchmark's sheet");
    substeps_ = 0;
  }
  void substep() {
    constexpr int kBendingInterval = 8;  // substeps, about what its bending allows at 160 x 160
    const double bending = substeps_++ % kBendingInterval == 0 ? kBendingInterval * h_ : 0.0;
    sweep_.substep(model_, terms_, {h_, h_, bending, nullptr});
  }
  [[nodiscard]] std::uint64_t hash() {
    fem::State state = state_;
    sweep_.write(state);
    StateHash hash;
    hash.add_span(std::span<const double>(state.x.data(), static_cast<std::size_t>(state.x.size())));
    return hash.value();
  }

 private:
  mesh::TriangleMesh mesh_;
  fem::Model model_;
  fem::MembraneLayout layout_;
  fem::LocalInertia inertia_;  // none
  fem::LeapfrogSweep<float> sweep_;
  fem::State state_;
  fem::Loads loads_;
  fem::LeapfrogTerms terms_;
  double h_ = 0.0;  // s
  int substeps_ = 0;
};

// Each waits, asleep, until both have come.
class Meeting {
 public:
  void meet() {
    std::unique_lock lock(mutex_);
    const int turn = turns_;
    if (++waiting_ == 2) {
      waiting_ = 0;
      ++turns_;
      come_.notify_one();
      return;
    }
    come_.wait(lock, [&] { return turns_ != turn; });
  }

 private:
  std::mutex mutex_;
  std::condition_variable come_;
  int waiting_ = 0;
  int turns_ = 0;
};

template <typename Work>
double seconds(const Work& work) {
  const auto start = std::chrono::steady_clock::now();
  work();
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

double of_two_threads(std::array<Swinging, 2>& halves, int substeps, bool meets) {
  Meeting meeting;
  const auto run = [&](Swinging& half) {
    for (int i = 0; i < substeps; ++i) {
      half.substep();
      if (meets) meeting.meet();
    }
  };
  for (Swinging& half : halves) half.begin(substeps);
  return seconds([&] {
    std::thread other([&] { run(halves[1]); });
    run(halves[0]);
    other.join();
  });
}

void halves(benchmark::State& state, const std::string& name, int side) {
  const int substeps = 4'000'000 / (side * side);
  Swinging whole(side, side);
  const int rows = side / 2 + 1;  // the seam belongs to both
  std::array<Swinging, 2> parts{Swinging(side, rows), Swinging(side, rows)};
  // The fastest round of each: what else the machine does only adds.
  constexpr double kNone = std::numeric_limits<double>::max();
  double one = kNone;
  double apart = kNone;
  double meeting = kNone;
  for (auto _ : state) {
    whole.begin(substeps);
    one = std::min(one, seconds([&] {
                     for (int i = 0; i < substeps; ++i) whole.substep();
                   }));
    apart = std::min(apart, of_two_threads(parts, substeps, false));
    const double met = of_two_threads(parts, substeps, true);
    meeting = std::min(meeting, met);
    state.SetIterationTime(met);
  }
  state.counters["one_us"] = 1e6 * one / substeps;
  state.counters["two_apart_us"] = 1e6 * apart / substeps;
  state.counters["two_meeting_us"] = 1e6 * meeting / substeps;
  state.counters["speedup_at_most"] = one / meeting;
  if (parts[0].hash() != parts[1].hash()) state.SkipWithError("two equal halves moved differently");
  StateHash both;
  both.add(whole.hash());
  both.add(parts[0].hash());
  expect_hash(state, name, both.value());
}

const bool kHalvesRegistered = [] {
  for (const int side : {50, 81, 160, 320}) {
    const std::string name = "halves/" + std::to_string(side * side);
    benchmark::RegisterBenchmark(name.c_str(), [name, side](benchmark::State& state) { halves(state, name, side); })
        ->Iterations(kRounds)
        ->UseManualTime()
        ->Unit(benchmark::kMillisecond);
  }
  return true;
}();

}  // namespace
}  // namespace kerf::bench

#pragma once

#include <cstdint>
#include <vector>

#include "server/base/random.h"
#include "server/core/fem/element/material.h"
#include "server/core/sheet/sheet.h"

// Sheets of 50 x 50 vertices with random cuts: what kerf_bench and random_cuts_error_bench share.
namespace kerf::bench {

// Seeds: the first 24 decimals of pi, eight each.
inline constexpr std::uint64_t kPiSeeds[] = {14159265, 35897932, 38462643};

enum class CutScene {
  kHung,  // level at first, held by its upper edge
  kBall,  // falls on a ball with friction
};

// Steps explicitly, in mixed precision.
sheet::Sheet cloth_to_cut(const fem::Material& material, CutScene scene);

// CPU time, s.
struct CutTime {
  double cut = 0.0;         // plan, apply, remesh
  double update = 0.0;      // model, state and integrator
  double integrator = 0.0;  // of that, the integrator
};

// Cuts sheets along random cubic curves of about 0.3 m.
class RandomCutter {
 public:
  explicit RandomCutter(std::uint64_t seed) : random_(seed) {}

  // Makes one cut; curves that miss do not count.
  CutTime cut(sheet::Sheet& sheet);

 private:
  SeededRandom random_;
};

double median_of(std::vector<double> values);

}  // namespace kerf::bench

#pragma once

// Trials of random cuts, each of which depends on its seed alone.

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "server/base/random.h"
#include "server/core/cut/cut.h"
#include "tests/audit/audited_cut.h"
#include "tests/property/random_curves.h"
#include "tests/property/random_sheets.h"
#include "tests/support/meshes.h"

namespace kerf::property {

inline constexpr int kCutsOfASequence = 40;
inline constexpr int kSingles = 4;

struct Tally {
  std::int64_t cuts = 0, applied = 0, missed = 0, invalid = 0, stopped = 0, deep = 0, strips = 0;
  std::map<std::string, std::int64_t> refused;  // by reason
  double area_drift = 0.0;    // -; largest relative change of the area since a sheet was made, strips taken aside
  double removed_area = 0.0;  // m^2, of strips taken from the present sheet
};

inline RandomSheet random_sheet(SeededRandom& random) {
  if (random.below(2) == 0) {
    const mesh::GridConfig config = random_grid(random);
    return {
        test::must(random.below(2) == 0 ? mesh::make_grid(config) : mesh::make_jittered_grid(config, random.next())),
        {}};
  }
  const RandomArrays made = random_arrays(random);
  return {test::must(mesh::import_mesh(made.arrays)), made.frame};
}

inline cut::CutOptions random_options(SeededRandom& random) {
  cut::CutOptions options;
  if (random.below(4) == 0) options.min_angle_deg = 0.0;
  if (random.below(4) == 0) options.relax = false;
  if (random.below(8) == 0) options.tolerance = std::pow(10.0, random.uniform(-3.0, -1.0));
  if (random.below(5) == 0) {
    options.method = cut::Method::kElement;
  } else if (random.below(8) == 0) {
    options.tip_edge_length_m = std::pow(10.0, random.uniform(-4.0, 0.0));
    options.tip_grading = random.uniform(1.2, 3.0);
  }
  return options;
}

// m^2, compensated.
inline double total_area(const mesh::TriangleMesh& mesh) {
  double sum = 0.0, rest = 0.0;
  for (mesh::TriangleId t = 0; t < mesh.num_triangle_slots(); ++t) {
    if (!mesh.is_solid(t)) continue;
    const double value = mesh.area(t) - rest;
    const double next = sum + value;
    rest = (next - sum) - value;
    sum = next;
  }
  return sum;
}

// Makes one cut and counts what became of it. What is wrong in words, or nothing. `number`: of the cut; one in 16 is
// checked in depth.
inline audit::Finding count_cut(mesh::TriangleMesh& mesh, const cut::CutRequest& request, std::uint64_t number,
                                Tally& tally) {
  ++tally.cuts;
  audit::Depth depth;
  if (number % 16 == 0) {
    depth = audit::kDeepest;
    if (!request.options.dash.lengths.empty()) depth.curve_samples = 0;  // the gaps of a dashed curve have no lips
    ++tally.deep;
  }
  const audit::AuditedCut done = audit::cut_and_audit(mesh, request, depth);
  switch (done.end) {
    case audit::AuditedCut::End::kApplied:
      ++tally.applied;
      if (done.outcome.report.refinement_stopped) ++tally.stopped;
      if (request.options.width_m) ++tally.strips;
      tally.removed_area += done.outcome.report.removed_area_m2;
      break;
    case audit::AuditedCut::End::kMissed:
      ++tally.missed;
      break;
    case audit::AuditedCut::End::kRefused:
      ++tally.refused[done.reason];
      break;
    case audit::AuditedCut::End::kInvalid:
      ++tally.invalid;
      if (!done.flaw && done.reason != "CURVE_DEGENERATE") return "not a valid request: " + done.reason;
      break;
  }
  return done.flaw;
}

// A few single cuts, each on a copy of one sheet as built (even seeds), or a sequence of cuts (odd ones).
inline audit::Finding run_trial(std::uint64_t seed, Tally& tally) {
  SeededRandom random(seed);
  const auto [built, frame] = random_sheet(random);
  const double area = total_area(built);
  const bool is_sequence = seed % 2 == 1;
  mesh::TriangleMesh mesh = built;
  std::vector<cut::Curve> earlier;
  for (int i = 0; i < (is_sequence ? kCutsOfASequence : kSingles) && mesh.num_triangle_slots() < 4'000; ++i) {
    if (!is_sequence && i > 0) mesh = built;
    if (!is_sequence || i == 0) tally.removed_area = 0.0;
    cut::CutRequest request{random_curve(random, mesh, frame, earlier), random_options(random), {}};
    // Dashes graded to each of a hundred tips take any budget.
    if (random.below(12) == 0 && !request.options.tip_edge_length_m) {
      const auto length = [&] { return frame.scale * random.uniform(0.01, 0.3); };
      request.options.dash = {{length(), length()}, length()};
    }
    if (request.options.method != cut::Method::kElement && random.below(6) == 0) {
      request.options.width_m = frame.scale * std::pow(10.0, random.uniform(-5.0, -0.5));
    }
    if (random.below(4) == 0) request.fixed_vertices = {0, mesh.num_vertices() / 2};
    if (is_sequence) earlier.push_back(request.curve);
    if (audit::Finding flaw = count_cut(mesh, request, seed / 2 + static_cast<std::uint64_t>(i), tally)) return flaw;
    tally.area_drift = std::max(tally.area_drift, std::abs(total_area(mesh) + tally.removed_area - area) / area);
  }
  if (tally.area_drift > 1e-12) return "the area has drifted";
  return std::nullopt;
}

}  // namespace kerf::property

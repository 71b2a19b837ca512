#include "server/core/cut/path_scale.h"

#include <algorithm>
#include <cmath>

namespace kerf::cut {
namespace {

// Least snap distance: twice the clearance of a new point from locked edges, so that a point that did not snap to a lip
// can be inserted. lattice units
constexpr double kLeastSnapUnits = 2.0 * static_cast<double>(mesh::MeshEditor::kLockClearance);

constexpr double kSnapShare = 0.1;  // -; largest fraction of the tolerance that snapping may use
constexpr int kMaxSamples = 4096;   // most samples of the edge length along one segment

}  // namespace

PathScale::PathScale(const mesh::TriangleMesh& mesh, const CutOptions& options, double snap)
    : lengths_(mesh.edge_lengths()), options_(options), snap_(snap), lattice_(mesh.lattice()) {}

double PathScale::tolerance_for(double edge_length) const {
  return options_.tolerance_m.value_or(options_.tolerance * edge_length);
}

double PathScale::snap_for(double edge_length) const {
  double wanted = std::min(snap_ * edge_length, kSnapShare * tolerance_for(edge_length));
  if (options_.width_m) wanted = std::min(wanted, kSnapShare * kToleranceOfWidth * *options_.width_m);
  return std::max(wanted, kLeastSnapUnits * lattice_.spacing);
}

double PathScale::representable_tolerance() const {
  return 4.0 * (kLeastSnapUnits + kRoundingUnits) * lattice_.spacing;
}

double PathScale::flattening_for(double edge_length) const {
  const double tolerance = tolerance_for(edge_length);
  // The snap distance grows with the local edge length. If the tolerance does not grow with it, this reserves the
  // largest fraction that snapping may use.
  const double snap = options_.tolerance_m && !is_uniform() ? kSnapShare * tolerance : snap_for(edge_length);
  return std::max(tolerance - snap, kSnapShare * tolerance);
}

std::vector<double> PathScale::divisions(const Eigen::Vector2d& a, const Eigen::Vector2d& along,
                                         double fraction) const {
  const double length = along.norm();
  // `counted`: number of parts (edge lengths times `fraction`) from the start of the segment to each sample. One sample
  // is enough if the edge length is constant.
  const int samples =
      static_cast<int>(std::clamp(std::ceil(2.0 * length / lengths_.resolution()), 1.0, double{kMaxSamples}));
  std::vector<double> counted{0.0};
  for (int i = 0; i < samples; ++i) {
    const double here = lengths_.at(a + ((i + 0.5) / samples) * along);
    counted.push_back(counted.back() + length / samples / (fraction * here));
  }
  const double parts = std::ceil(counted.back());
  std::vector<double> ends;
  std::size_t sample = 0;
  for (double i = 1.0; i < parts; ++i) {
    const double share = i / parts;
    const double wanted = share * counted.back();
    while (sample + 2 < counted.size() && counted[sample + 1] < wanted) ++sample;
    const double within = (wanted - counted[sample]) / (counted[sample + 1] - counted[sample]);
    ends.push_back(samples == 1 ? share : (static_cast<double>(sample) + within) / samples);
  }
  return ends;
}

}  // namespace kerf::cut

#include "server/core/mesh/build/contour_division.h"

#include <algorithm>
#include <cmath>
#include <cstddef>

namespace kerf::mesh {
namespace {

constexpr double kSnap = 0.1;  // -; a station moves to a contour point within this fraction of an edge length
constexpr int kSteps = 8;      // of integration per edge

// The number of edges, a real number, that the stretch needs up to a station.
struct Count {
  double station = 0.0;
  double edges = 0.0;
};

// Counts the edges that the stretch needs, at stations from its start to its end. Returns an empty list if there are
// more than `most`.
std::vector<Count> count_edges(const Contour& contour, const Stretch& stretch, const SizeField& sizes, double most) {
  std::vector<Count> counts{{stretch.from, 0.0}};
  while (counts.back().station < stretch.to) {
    const double at = counts.back().station;
    const std::size_t i = contour.chord_at(at);
    const double left = std::min(contour.station(i + 1), stretch.to) - at;  // length of the chord that remains
    double step = std::min(left, sizes.at(contour.at(at)) / kSteps);
    if (left < 1.5 * step || at + step <= at) step = left;
    const double turn_of_chord = 0.5 * (contour.turn(i) + contour.turn(i + 1));
    const double turn = turn_of_chord * step / (contour.station(i + 1) - contour.station(i));
    const double edges =
        counts.back().edges + std::max(step / sizes.at(contour.at(at + 0.5 * step)), turn / kMaxTurnOfEdge);
    if (edges > most) return {};
    counts.push_back({step == left ? std::min(contour.station(i + 1), stretch.to) : at + step, edges});
  }
  return counts;
}

}  // namespace

bool divide_stretch(const Contour& contour, const Stretch& stretch, const SizeField& sizes, const EdgeCounts& counts,
                    std::vector<double>& stations) {
  const std::vector<Count> edges = count_edges(contour, stretch, sizes, counts.most);
  if (edges.empty()) return false;
  const double total = edges.back().edges;
  const auto parts = std::max(std::llround(total), std::llround(counts.least));
  auto after = edges.begin() + 1;
  for (long long k = 1; k < parts; ++k) {
    const double wanted = total * static_cast<double>(k) / static_cast<double>(parts);
    while (after + 1 != edges.end() && after->edges < wanted) ++after;
    const Count& before = *(after - 1);
    const double length_of_edge = (after->station - before.station) / (after->edges - before.edges);
    const double station = before.station + (wanted - before.edges) * length_of_edge;
    const double part = length_of_edge * total / static_cast<double>(parts);
    stations.push_back(std::clamp(contour.snapped(station, kSnap * part), stretch.from, stretch.to));
  }
  return true;
}

}  // namespace kerf::mesh

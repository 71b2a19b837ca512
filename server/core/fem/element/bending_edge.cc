#include "server/core/fem/element/bending_edge.h"

#include <algorithm>
#include <cmath>

namespace kerf::fem {
namespace {

bool has_repeated(const std::array<mesh::VertexId, 8>& vertices) {
  bool repeats = false;
  for (std::size_t i = 1; i < vertices.size(); ++i) {
    for (std::size_t k = 0; k < i; ++k) repeats |= vertices[i] == vertices[k] && vertices[i] != mesh::kNone;
  }
  return repeats;
}

}  // namespace

std::array<std::size_t, 6> places_of_second(std::size_t first_edge, std::size_t second_edge) {
  const std::size_t next = (second_edge + 1) % 3;
  const std::size_t last = (second_edge + 2) % 3;
  std::array<std::size_t, 6> places{};
  places[second_edge] = 3 + first_edge;
  places[next] = (first_edge + 2) % 3;
  places[last] = (first_edge + 1) % 3;
  places[3 + second_edge] = first_edge;
  places[3 + next] = 6;
  places[3 + last] = 7;
  return places;
}

bool join_sides(const BendingSide& first, const BendingSide& second, const std::array<std::size_t, 6>& places,
                BendingEdge& made) {
  made.kink.fill(0.0);
  made.load.fill(0.0);
  // Both slopes are outward: the jump from the first side to the second is minus their sum.
  for (std::size_t i = 0; i < 6; ++i) {
    made.kink[i] -= first.slope[i];
    made.load[i] += 0.5 * first.length * first.moment[i];
  }
  for (std::size_t i = 0; i < 6; ++i) {
    made.kink[places[i]] -= second.slope[i];
    made.load[places[i]] += 0.5 * first.length * second.moment[i];
  }
  double largest = 0.0;
  for (const double kink : made.kink) largest = std::max(largest, std::abs(kink));
  if (!(largest * first.length > kNegligibleKink)) return false;
  const double penalty = first.penalty + second.penalty;
  for (std::size_t i = 0; i < 8; ++i) made.load[i] += penalty * made.kink[i];
  // Around an inner vertex of three triangles one vertex lies across two edges.
  for (std::size_t i = has_repeated(made.vertex) ? 7 : 0; i > 0; --i) {
    const auto same = std::find(made.vertex.begin(), made.vertex.end(), made.vertex[i]);
    const auto at = static_cast<std::size_t>(same - made.vertex.begin());
    if (made.vertex[i] == mesh::kNone || at == i) continue;
    made.kink[at] += made.kink[i];
    made.load[at] += made.load[i];
    made.vertex[i] = mesh::kNone;
    made.kink[i] = made.load[i] = 0.0;
  }
  return true;
}

}  // namespace kerf::fem

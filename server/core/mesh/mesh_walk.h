#pragma once

#include <cstdint>

#include "server/core/mesh/mesh_data.h"

namespace kerf::mesh {

// Finds p by the remembering stochastic walk of Devillers, Pion and Teillaud (2001). From slot `start` it steps across
// edges that separate the current slot from p. A hash of slot and step chooses which edge is tried first, so the walk
// is deterministic, and cycles are practically impossible. `View` offers triangle(t), a TriangleRecord, and at(p), a
// LatticePoint. Returns the slot that holds p, or kNone after `max_steps` or on leaving the domain.
template <typename View>
TriangleId walk_to(const View& view, const LatticePoint& p, TriangleId start, std::int64_t max_steps) {
  TriangleId t = start;
  TriangleId previous = kNone;
  for (std::int64_t step = 0; step < max_steps && t != kNone; ++step) {
    const TriangleRecord& record = view.triangle(t);
    std::uint64_t hash = (static_cast<std::uint64_t>(t) * 0x9e3779b97f4a7c15ULL) ^ static_cast<std::uint64_t>(step);
    hash = (hash ^ (hash >> 31)) * 0xbf58476d1ce4e5b9ULL;
    int k = static_cast<int>((hash >> 33) % 3);
    TriangleId next = t;
    for (int tried = 0; tried < 3; ++tried, k = next_corner(k)) {
      if (record.neighbours[k] == previous && previous != kNone) continue;  // p is on this side of it
      const LatticePoint& a = view.at(record.points[next_corner(k)]);
      const LatticePoint& b = view.at(record.points[previous_corner(k)]);
      if (orient2d(a, b, p) < 0) {
        next = record.neighbours[k];
        break;
      }
    }
    if (next == t) return t;
    previous = t;
    t = next;
  }
  return kNone;
}

}  // namespace kerf::mesh

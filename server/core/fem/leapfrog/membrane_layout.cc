#include "server/core/fem/leapfrog/membrane_layout.h"

#include <algorithm>
#include <cstdlib>
#include <utility>

#include "server/base/check.h"

namespace kerf::fem {
namespace {

using mesh::TriangleId;
using mesh::VertexId;

using OffsetPair = std::pair<std::int32_t, std::int32_t>;

bool find_triangle(const Model& model, TriangleId slot, TurnedTriangle& triangle) {
  const auto s = static_cast<std::size_t>(slot);
  const ElementBlock& block = model.element_blocks()[s / kLanes];
  if (block.area[s % kLanes] == 0.0) return false;
  triangle = turned_triangle(block, s % kLanes);
  return true;
}

OffsetPair offsets_of(const TurnedTriangle& triangle) {
  return {triangle.vertices[1] - triangle.vertices[0], triangle.vertices[2] - triangle.vertices[0]};
}

std::size_t vertex_block(VertexId v) {
  return static_cast<std::size_t>(v) / linear::kBlockLanes;
}

constexpr auto kGroup = static_cast<int>(CornerPlaces().size());  // vertices

int group_of(VertexId v) {
  return v / kGroup;
}

}  // namespace

TurnedTriangle turned_triangle(const ElementBlock& block, std::size_t lane) {
  const std::array<VertexId, 3> corner{block.vertex[0][lane], block.vertex[1][lane], block.vertex[2][lane]};
  TurnedTriangle turned;
  if (corner[1] < corner[turned.first]) turned.first = 1;
  if (corner[2] < corner[turned.first]) turned.first = 2;
  for (std::size_t k = 0; k < 3; ++k) turned.vertices[k] = corner[(turned.first + k) % 3];
  return turned;
}

void MembraneLayout::rebuild(const Model& model) {
  places_.clear();
  quad_slots_.clear();
  num_quads_.clear();
  num_corners_.clear();
  lanes_.clear();
  free_lanes_.clear();
  corners_ = {};
  num_vertices_ = 0;
  num_regular_ = {};
  num_solid_ = 0;
  find_pattern(model);
  resize(model);
  for (TriangleId slot = 0; slot < model.num_slots(); ++slot) add(model, slot);
  touched_.clear();
  for (int group = 0; group < corners_.num_rows(); ++group) set_corners(model, group);
}

bool MembraneLayout::follow(const Model& model) {
  changed_quads_.clear();
  changed_lanes_.clear();
  touched_.clear();
  touched_.resize(static_cast<std::size_t>(std::max(num_vertices_, model.num_vertices())));
  if (model.num_vertices() < num_vertices_) touched_.insert(group_of(model.num_vertices()));  // one group shrinks
  const std::span<const TriangleId> changed = model.elements().changed_slots();
  for (const TriangleId slot : changed) remove(slot);
  resize(model);
  for (const TriangleId slot : changed) {
    if (slot < model.num_slots()) add(model, slot);
  }
  num_changes_ += static_cast<std::int64_t>(changed.size());
  // While each of the two pairs of the pattern has more than a third of the triangles, no other pair can have that
  // many.
  const bool is_same = has_pattern() ? 3 * std::min(num_regular_[0], num_regular_[1]) > num_solid_
                                     : 4 * num_changes_ < changes_to_pattern_;
  if (!is_same) {
    rebuild(model);
    return false;
  }
  for (const std::int32_t group : touched_.members()) {
    if (group < corners_.num_rows()) set_corners(model, group);
  }
  return true;
}

void MembraneLayout::find_pattern(const Model& model) {
  std::vector<OffsetPair> all;
  all.reserve(static_cast<std::size_t>(model.num_slots()));
  TurnedTriangle triangle;
  for (TriangleId slot = 0; slot < model.num_slots(); ++slot) {
    if (find_triangle(model, slot, triangle)) all.push_back(offsets_of(triangle));
  }
  std::sort(all.begin(), all.end());
  std::array<std::pair<std::int64_t, OffsetPair>, 2> most{};
  for (auto first = all.begin(); first != all.end();) {
    const auto last = std::upper_bound(first, all.end(), *first);
    const std::pair<std::int64_t, OffsetPair> found{last - first, *first};
    if (found.first > most[1].first) most[1] = found;
    if (most[1].first > most[0].first) std::swap(most[0], most[1]);
    first = last;
  }
  num_changes_ = 0;
  const std::int64_t excess = 3 * most[1].first - static_cast<std::int64_t>(all.size());
  changes_to_pattern_ = std::abs(excess);
  offsets_ = {};
  if (excess <= 0) return;
  // The order of the two pairs must not depend on which of them is more frequent.
  OffsetPair a = std::min(most[0].second, most[1].second);
  OffsetPair b = std::max(most[0].second, most[1].second);
  if (a.second != b.first) std::swap(a, b);
  if (a.second == b.first) offsets_ = {a.first, a.second, b.second};
}

void MembraneLayout::resize(const Model& model) {
  num_vertices_ = model.num_vertices();
  const int num_groups = group_of(num_vertices_ + kGroup - 1);
  for (int group = num_groups; group < corners_.num_rows(); ++group) {
    num_corners_[vertex_block(kGroup * group)] -= count_corners(group);
  }
  const std::size_t num_blocks =
      (static_cast<std::size_t>(num_vertices_) + linear::kBlockLanes - 1) / linear::kBlockLanes;
  places_.resize(static_cast<std::size_t>(model.num_slots()));
  quad_slots_.resize(2 * linear::kBlockLanes * num_blocks, mesh::kNone);
  num_quads_.resize(num_blocks, 0);
  num_corners_.resize(num_blocks, 0);
  corners_.resize(num_groups);
  touched_.resize(static_cast<std::size_t>(num_vertices_));
}

void MembraneLayout::remove(TriangleId slot) {
  if (static_cast<std::size_t>(slot) >= places_.size()) return;
  Place& place = places_[static_cast<std::size_t>(slot)];
  if (place.quad != mesh::kNone) {
    quad_slots_[static_cast<std::size_t>(place.quad)] = mesh::kNone;
    --num_regular_[static_cast<std::size_t>(place.quad % 2)];
    --num_quads_[vertex_block(place.quad / 2)];
    changed_quads_.push_back(place.quad / 2);
    --num_solid_;
  } else if (place.lane != mesh::kNone) {
    lanes_[static_cast<std::size_t>(place.lane)] = mesh::kNone;
    free_lanes_.push_back(place.lane);
    changed_lanes_.push_back(place.lane);
    for (const VertexId v : place.vertices) touched_.insert(group_of(v));
    --num_solid_;
  }
  place = Place();
}

void MembraneLayout::add(const Model& model, TriangleId slot) {
  TurnedTriangle triangle;
  if (!find_triangle(model, slot, triangle)) return;
  ++num_solid_;
  Place& place = places_[static_cast<std::size_t>(slot)];
  place.vertices = triangle.vertices;
  const OffsetPair offsets = offsets_of(triangle);
  for (std::size_t kind = 0; has_pattern() && kind < 2; ++kind) {
    if (offsets != OffsetPair(offsets_[kind], offsets_[kind + 1])) continue;
    place.quad = 2 * triangle.vertices[0] + static_cast<std::int32_t>(kind);
    KERF_DCHECK(quad_slots_[static_cast<std::size_t>(place.quad)] == mesh::kNone, "one triangle on a side of an edge");
    quad_slots_[static_cast<std::size_t>(place.quad)] = slot;
    ++num_regular_[kind];
    ++num_quads_[vertex_block(triangle.vertices[0])];
    changed_quads_.push_back(triangle.vertices[0]);
    return;
  }
  if (free_lanes_.empty()) {
    const auto first = static_cast<std::int32_t>(lanes_.size());
    lanes_.resize(lanes_.size() + 2 * linear::kBlockLanes, mesh::kNone);
    for (auto lane = static_cast<std::int32_t>(lanes_.size()) - 1; lane >= first; --lane) free_lanes_.push_back(lane);
  }
  place.lane = free_lanes_.back();
  free_lanes_.pop_back();
  lanes_[static_cast<std::size_t>(place.lane)] = slot;
  changed_lanes_.push_back(place.lane);
  for (const VertexId v : triangle.vertices) touched_.insert(group_of(v));
}

void MembraneLayout::set_corners(const Model& model, int group) {
  row_.clear();
  std::int32_t change = -count_corners(group);
  for (int i = 0; i < kGroup && kGroup * group + i < num_vertices_; ++i) {
    const VertexId vertex = kGroup * group + i;
    std::size_t count = 0;
    for (const TriangleId slot : model.elements().incident_slots().row(vertex)) {
      const Place& place = places_[static_cast<std::size_t>(slot)];
      if (place.lane == mesh::kNone) continue;
      if (count == row_.size()) row_.push_back({kNoCorner, kNoCorner, kNoCorner, kNoCorner});
      const int corner = (place.vertices[1] == vertex ? 1 : 0) + (place.vertices[2] == vertex ? 2 : 0);
      row_[count++][static_cast<std::size_t>(i)] = 4 * corner_place(place.lane, corner);
    }
    change += static_cast<std::int32_t>(count);
  }
  num_corners_[vertex_block(kGroup * group)] += change;
  corners_.set_row(group, row_);
}

std::int32_t MembraneLayout::count_corners(int group) const {
  std::int32_t count = 0;
  for (const CornerPlaces& places : corners_.row(group)) {
    for (const std::int32_t place : places) count += place != kNoCorner ? 1 : 0;
  }
  return count;
}

}  // namespace kerf::fem

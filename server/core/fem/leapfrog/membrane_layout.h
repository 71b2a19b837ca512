#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "server/core/fem/model/model.h"
#include "server/core/linear/index_set.h"
#include "server/core/linear/lanes16.h"
#include "server/core/linear/row_store.h"
#include "server/core/mesh/ids.h"

namespace kerf::fem {

// Corners 1 and 2 of the two triangles of a quad lie at these distances in vertex ids from its lowest vertex v:
// (v, v + o[0], v + o[1]) and (v, v + o[1], v + o[2]). All 0: none.
using QuadOffsets = std::array<std::int32_t, 3>;

// Place of a corner of an irregular lane among all of them: block by block, corner by corner.
inline std::int32_t corner_place(std::int32_t lane, int corner) {
  constexpr auto kLanes16 = static_cast<std::int32_t>(kBlockLanes);
  return (3 * (lane / kLanes16) + corner) * kLanes16 + lane % kLanes16;
}

// Of four neighbouring vertices one irregular corner each: 4 x corner_place(), or kNoCorner.
using CornerPlaces = std::array<std::int32_t, 4>;
inline constexpr std::int32_t kNoCorner = -4;

// Where the triangles of a model are kept for vector code, each turned so that it begins with its lowest vertex.
//   Regular ones, of the mesh's one pattern of quads: at their lowest vertex, so that the corners of neighbouring lanes
//   are neighbours in memory.
//   All others, as in a Delaunay mesh and along a cut: in lanes of their own, in no order, with lists of the corners
//   around each vertex by ascending slot.
// Which triangles are regular and how those lists are ordered follows from the model alone, not from how it came about,
// and so do sums of forces in that order, bit for bit. Only the lanes of irregular triangles depend on its history, and
// lanes never mix.
class MembraneLayout {
 public:
  void rebuild(const Model& model);
  // After one Model::follow since the call before. False: everything was rebuilt.
  bool follow(const Model& model);

  [[nodiscard]] int num_vertices() const { return num_vertices_; }
  [[nodiscard]] std::int64_t num_triangles() const { return num_solid_; }
  [[nodiscard]] std::size_t num_blocks() const { return num_quads_.size(); }  // of vertices
  [[nodiscard]] const QuadOffsets& offsets() const { return offsets_; }
  // Slot of triangle `kind` (0, 1) of the quad of vertex v, or kNone.
  [[nodiscard]] mesh::TriangleId quad_slot(int kind, mesh::VertexId v) const {
    return quad_slots_[2 * static_cast<std::size_t>(v) + static_cast<std::size_t>(kind)];
  }
  // Regular triangles of each block of vertices.
  [[nodiscard]] std::span<const std::int32_t> num_quads() const { return num_quads_; }
  // Irregular corners of each block of vertices.
  [[nodiscard]] std::span<const std::int32_t> num_corners() const { return num_corners_; }
  // Slot of each irregular lane, or kNone; of an even number of blocks.
  [[nodiscard]] std::span<const mesh::TriangleId> lanes() const { return lanes_; }
  // The irregular triangles around each vertex, by ascending slot; a row for each four vertices, as long as the one
  // with the most of them needs.
  [[nodiscard]] const RowStore<CornerPlaces>& corners() const { return corners_; }

  // Vertices whose quads, and irregular lanes, the last follow() wrote; may repeat.
  [[nodiscard]] std::span<const mesh::VertexId> changed_quads() const { return changed_quads_; }
  [[nodiscard]] std::span<const std::int32_t> changed_lanes() const { return changed_lanes_; }

 private:
  struct Place {
    std::int32_t quad = mesh::kNone;  // 2 x vertex + kind
    std::int32_t lane = mesh::kNone;
    std::array<mesh::VertexId, 3> vertices{mesh::kNone, mesh::kNone, mesh::kNone};
  };

  // The pairs of offsets that more than a third of the triangles have, if there are two and they make a quad.
  void find_pattern(const Model& model);
  [[nodiscard]] bool has_pattern() const { return offsets_[1] != 0; }
  void resize(const Model& model);
  void remove(mesh::TriangleId slot);
  void add(const Model& model, mesh::TriangleId slot);
  // Of four vertices.
  void set_corners(const Model& model, int group);
  [[nodiscard]] std::int32_t count_corners(int group) const;

  int num_vertices_ = 0;
  QuadOffsets offsets_{};
  std::array<std::int64_t, 2> num_regular_{};  // of each kind
  std::int64_t num_solid_ = 0;
  // Four times the changes of slots, since pairs were last counted, that the second most frequent one is short of a
  // third of the triangles, or above it.
  std::int64_t changes_to_pattern_ = 0;
  std::int64_t num_changes_ = 0;  // of slots, since then
  std::vector<Place> places_;     // of the slots
  std::vector<mesh::TriangleId> quad_slots_;
  std::vector<std::int32_t> num_quads_, num_corners_;
  std::vector<mesh::TriangleId> lanes_;
  std::vector<std::int32_t> free_lanes_;
  RowStore<CornerPlaces> corners_;
  std::vector<mesh::VertexId> changed_quads_;
  std::vector<std::int32_t> changed_lanes_;
  IdSet touched_;                  // scratch, of four vertices each, around irregular triangles
  std::vector<CornerPlaces> row_;  // scratch
};

// Of a slot that has material: its corners from the lowest vertex on, and what corner that is in the model.
struct TurnedTriangle {
  std::array<mesh::VertexId, 3> vertices{};
  std::size_t first = 0;
};
TurnedTriangle turned_triangle(const ElementBlock& block, std::size_t lane);

}  // namespace kerf::fem

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

// Pattern of quads, pairs of triangles that share an edge: distances o in vertex ids from a quad's lowest vertex v. Its
// two triangles are (v, v + o[0], v + o[1]) and (v, v + o[1], v + o[2]). If all are 0 there is no pattern.
using QuadOffsets = std::array<std::int32_t, 3>;

// Returns the index of a corner of an irregular lane (see MembraneLayout) among the corners of all such lanes. These
// are ordered by block, then corner, then lane.
inline std::int32_t corner_place(std::int32_t lane, int corner) {
  constexpr auto kLanes16 = static_cast<std::int32_t>(linear::kBlockLanes);
  return (3 * (lane / kLanes16) + corner) * kLanes16 + lane % kLanes16;
}

// One irregular corner for each of four neighbouring vertices: 4 x corner_place(), or kNoCorner.
using CornerPlaces = std::array<std::int32_t, 4>;
inline constexpr std::int32_t kNoCorner = -4;

// Arrangement of a model's triangles for vector code, each turned so that it begins with its lowest vertex.
//   Regular triangles, of the mesh's one pattern of quads, are stored at their lowest vertex. The corners of
//     neighbouring lanes are then neighbours in memory.
//   All others, as in a Delaunay mesh and along a cut, are stored in lanes of their own, in no order. Lists hold the
//     corners around each vertex by ascending slot.
// The set of regular triangles and the order of those lists follow from the model alone, whatever edits led to it. So
// do sums of forces in that order, bit for bit. Only the lanes of irregular triangles depend on the history, and lanes
// never mix.
class MembraneLayout {
 public:
  void rebuild(const Model& model);
  // Updates after exactly one Model::follow since the previous call of rebuild() or follow(). Returns false if it had
  // to call rebuild().
  bool follow(const Model& model);

  [[nodiscard]] int num_vertices() const { return num_vertices_; }
  [[nodiscard]] std::int64_t num_triangles() const { return num_solid_; }
  [[nodiscard]] std::size_t num_blocks() const { return num_quads_.size(); }  // of vertices
  [[nodiscard]] const QuadOffsets& offsets() const { return offsets_; }
  // Slot of triangle `kind` (0, 1) of the quad of vertex v, or kNone.
  [[nodiscard]] mesh::TriangleId quad_slot(int kind, mesh::VertexId v) const {
    return quad_slots_[2 * static_cast<std::size_t>(v) + static_cast<std::size_t>(kind)];
  }
  // Number of regular triangles in each block of vertices.
  [[nodiscard]] std::span<const std::int32_t> num_quads() const { return num_quads_; }
  // Number of irregular corners in each block of vertices.
  [[nodiscard]] std::span<const std::int32_t> num_corners() const { return num_corners_; }
  // Slot of each irregular lane, or kNone. The number of blocks is even.
  [[nodiscard]] std::span<const mesh::TriangleId> lanes() const { return lanes_; }
  // Irregular corners around each vertex, by ascending slot. There is a row for every four vertices, as long as the
  // longest of the four lists.
  [[nodiscard]] const linear::RowStore<CornerPlaces>& corners() const { return corners_; }

  // Vertices whose quads the last follow() wrote, and irregular lanes that it wrote; may repeat.
  [[nodiscard]] std::span<const mesh::VertexId> changed_quads() const { return changed_quads_; }
  [[nodiscard]] std::span<const std::int32_t> changed_lanes() const { return changed_lanes_; }

 private:
  struct Place {
    std::int32_t quad = mesh::kNone;  // 2 x vertex + kind
    std::int32_t lane = mesh::kNone;
    std::array<mesh::VertexId, 3> vertices{mesh::kNone, mesh::kNone, mesh::kNone};
  };

  // Finds the pattern: two pairs of offsets that more than a third of the triangles have each, if they form a quad.
  void find_pattern(const Model& model);
  [[nodiscard]] bool has_pattern() const { return offsets_[1] != 0; }
  void resize(const Model& model);
  void remove(mesh::TriangleId slot);
  void add(const Model& model, mesh::TriangleId slot);
  // Sets the corners of a group of four vertices.
  void set_corners(const Model& model, int group);
  [[nodiscard]] std::int32_t count_corners(int group) const;

  int num_vertices_ = 0;
  QuadOffsets offsets_{};
  std::array<std::int64_t, 2> num_regular_{};  // by kind
  std::int64_t num_solid_ = 0;
  // |3 p - t| when pairs of offsets were last counted: p triangles had the second most frequent pair, of t in all. The
  // pattern cannot change before a quarter of that many slots have changed.
  std::int64_t changes_to_pattern_ = 0;
  std::int64_t num_changes_ = 0;  // changes of slots since pairs were last counted
  std::vector<Place> places_;     // by slot
  std::vector<mesh::TriangleId> quad_slots_;
  std::vector<std::int32_t> num_quads_, num_corners_;
  std::vector<mesh::TriangleId> lanes_;
  std::vector<std::int32_t> free_lanes_;
  linear::RowStore<CornerPlaces> corners_;
  std::vector<mesh::VertexId> changed_quads_;
  std::vector<std::int32_t> changed_lanes_;
  linear::IdSet touched_;          // scratch, groups of four vertices around irregular triangles
  std::vector<CornerPlaces> row_;  // scratch
};

// Corners of a slot with material, turned to begin with the lowest vertex. `first` is the index of that corner in the
// model.
struct TurnedTriangle {
  std::array<mesh::VertexId, 3> vertices{};
  std::size_t first = 0;
};
TurnedTriangle turned_triangle(const ElementBlock& block, std::size_t lane);

}  // namespace kerf::fem

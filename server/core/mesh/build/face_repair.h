#pragma once

#include <cstdint>
#include <functional>
#include <span>
#include <string>
#include <vector>

#include "server/core/mesh/build/mesh_file.h"

namespace kerf::mesh {

// Faces of a file with vertices that are joined where they lie at the same place.
struct FacePolygons {
  struct Polygon {
    std::int32_t first = 0;  // of `vertices` and `file_corners`
    std::int32_t count = 0;
    std::int32_t face = 0;  // of the file
  };
  std::vector<Polygon> polygons;
  std::vector<std::int32_t> vertices;      // of each corner: number of its place
  std::vector<std::int32_t> file_corners;  // of each corner: index into MeshFile::corners

  [[nodiscard]] std::span<const std::int32_t> vertices_of(const Polygon& polygon) const {
    return {vertices.data() + polygon.first, static_cast<std::size_t>(polygon.count)};
  }
};

// Mends what needs no choice, says so in `notes`, and finds what cannot be mended.
class FaceRepair {
 public:
  FaceRepair(const MeshFile& file, FacePolygons& faces, std::vector<std::string>& notes, FaultList& faults)
      : file_(file), faces_(faces), notes_(notes), faults_(faults) {}

  // Adds a face; corners that repeat the one before are left out. `vertices`: the places of its corners.
  void add(std::int32_t face, std::span<const std::int32_t> vertices);
  // Leaves out polygons without area. Corners within one of their sides become corners of the polygons beyond it.
  // `order_on_line`: returns the corners of a polygon (by index) in order along its line, or nothing if it has area.
  using OrderOnLine = std::function<std::vector<std::int32_t>(const FacePolygons::Polygon&)>;
  void leave_out_lines(const OrderOnLine& order_on_line);
  // Leaves out polygons with the same vertices as an earlier one.
  void leave_out_copies();
  // Turns polygons so that neighbours turn alike, as most of their component do. Faults: three polygons at an edge, and
  // a component with one side only, such as a Moebius strip. `hint`: the end of such messages.
  void orient(const std::string& hint);
  // Returns for each corner the number of its fan: corners of a vertex whose polygons are connected by edges there have
  // the same one. Numbers are corners.
  [[nodiscard]] std::vector<std::int32_t> fans() const;

 private:
  // A side of a polygon, from a corner to the next one.
  struct Side {
    std::int32_t low = 0;   // the lower of its two vertices
    std::int32_t high = 0;  // the higher
    std::int32_t polygon = 0;
    std::int32_t corner = 0;  // where it begins, an index into FacePolygons::vertices
    bool is_upward = false;   // from low to high
  };

  [[nodiscard]] std::vector<Side> sorted_sides() const;
  [[nodiscard]] std::int32_t after(const FacePolygons::Polygon& polygon, std::int32_t corner) const;
  void remove(const std::vector<bool>& is_removed, const std::string& why);
  [[nodiscard]] std::string edge_name(const Side& side) const;
  bool refuse_crowded_edges(const std::vector<Side>& sides, const std::string& hint);
  void turn_round(const std::vector<bool>& is_turned);

  const MeshFile& file_;
  FacePolygons& faces_;
  std::vector<std::string>& notes_;
  FaultList& faults_;
  std::vector<std::int32_t> without_corners_;  // faces whose corners lie at fewer than three places
};

}  // namespace kerf::mesh

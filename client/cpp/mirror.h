#pragma once

#include <array>
#include <cmath>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "kerf/v1/stream.pb.h"
#include "server/service/codec/vertex_predictors.h"

namespace kerf::client {

// Keeps a viewer's copy of a sheet up to date by the frames of one Watch stream. It is the reference for every other
// client: after each frame it holds exactly the integers and triangles that the server sent.
class Mirror {
 public:
  // Applies the next frame of the stream. A keyframe with an epoch may have any tick. Returns the fault of a frame that
  // cannot follow (a gap, an index out of range, an array of the wrong size). The mirror is then useless, and the
  // stream should be reopened.
  [[nodiscard]] std::optional<std::string> apply(const v1::Frame& frame);

  [[nodiscard]] std::int64_t tick() const { return tick_; }  // -1 before the first frame
  [[nodiscard]] std::int32_t topology_version() const { return topology_version_; }
  // Returns kerf.v1.Frame.epoch, to which topology_version() belongs. It changes when the sheet goes back to a saved
  // state. Empty before the first frame.
  [[nodiscard]] const std::string& epoch() const { return epoch_; }
  [[nodiscard]] std::int32_t num_vertices() const { return static_cast<std::int32_t>(quantised_.size() / 3); }
  [[nodiscard]] std::int32_t num_slots() const { return static_cast<std::int32_t>(triangles_.size()); }
  [[nodiscard]] std::int32_t num_pieces() const { return num_pieces_; }

  // Returns 3 V numbers, x, y, z interleaved; 0 and 65535 are the two sides of box().
  [[nodiscard]] const std::vector<std::uint16_t>& quantised_positions() const { return quantised_; }
  [[nodiscard]] const v1::Box3& box() const { return box_; }
  // Returns the world position of a vertex in 0..V-1, m.
  [[nodiscard]] std::array<double, 3> position(std::int32_t vertex) const;
  // Returns each slot's vertices, counter-clockwise in material coordinates; three times -1 if the slot has no
  // material.
  [[nodiscard]] const std::vector<std::array<std::int32_t, 3>>& triangles() const { return triangles_; }
  // Returns each slot's piece; -1 if the slot has no material.
  [[nodiscard]] const std::vector<std::int32_t>& pieces() const { return pieces_; }
  // Returns the principal strain of the largest magnitude at a vertex in 0..V-1, -; see kerf.v1.Frame.strains. Valid
  // only if has_strains(), that is if the last frame had strains.
  [[nodiscard]] bool has_strains() const { return !strains_.empty(); }
  [[nodiscard]] double strain(std::int32_t vertex) const {
    const double share = strains_[static_cast<std::size_t>(vertex)] / 127.0;
    return share * std::abs(share) * strain_scale_;
  }
  // Returns the values of the stream's probes at tick(), one for each of probe_columns(). NaN: nothing to measure.
  [[nodiscard]] const std::vector<double>& probe_values() const { return probe_values_; }
  // Returns the names of the values, such as "tip.x"; empty without probes.
  [[nodiscard]] const std::vector<std::string>& probe_columns() const { return probe_columns_; }
  // Returns the material coordinates: 2 V numbers, x, y interleaved, m.
  [[nodiscard]] const std::vector<float>& material_positions() const { return material_positions_; }

 private:
  // Holds the decoded arrays of a TopologyPatch.
  struct Patch {
    std::vector<std::uint32_t> slots;
    std::vector<std::array<std::int32_t, 3>> triangles;  // For `slots`.
    std::vector<std::int32_t> pieces;                    // For `slots`.
    std::vector<std::uint32_t> vertices;
  };

  [[nodiscard]] std::optional<std::string> apply_positions(const v1::Frame& frame);
  [[nodiscard]] std::optional<std::string> apply_strains(const v1::Frame& frame);
  [[nodiscard]] std::optional<std::string> apply_probes(const v1::Frame& frame);
  [[nodiscard]] std::optional<std::string> apply_topology(const v1::Frame& frame);
  [[nodiscard]] std::optional<std::string> apply_triangles(const v1::TopologyPatch& message, const Patch& patch,
                                                           std::int32_t num_vertices);
  [[nodiscard]] std::optional<std::string> apply_materials(const v1::Frame& frame,
                                                           const std::vector<std::uint32_t>& vertices);
  const std::vector<codec::VertexPredictor>& predictors(std::int32_t num_vertices);

  std::int64_t tick_ = -1;
  std::int64_t sequence_ = 0;
  std::int32_t topology_version_ = -1;
  std::string epoch_;
  std::int32_t num_pieces_ = 0;
  v1::Box3 box_;
  std::vector<std::uint16_t> quantised_;
  std::vector<std::array<std::int32_t, 3>> triangles_;
  std::vector<std::int32_t> pieces_;
  std::vector<float> material_positions_;
  std::vector<std::int8_t> strains_;
  double strain_scale_ = 0.0;
  std::vector<double> probe_values_;
  std::vector<std::string> probe_columns_;
  std::optional<std::vector<codec::VertexPredictor>> predictors_;  // For triangles_, once a compact frame has come.
};

}  // namespace kerf::client

#pragma once

#include <cstdint>
#include <vector>

#include "server/core/fem/element/loads.h"
#include "server/core/fem/element/state.h"
#include "server/core/mesh/mesh_edit.h"

namespace kerf {
template <class T>
struct Fields;
}  // namespace kerf

namespace kerf::sheet {

// The pinned vertices of a sheet, and the place at which each is held.
class PinSet {
 public:
  // Holds exactly `vertices` (sorted, unique), each at its position in `state`, and sets their velocities to zero.
  void hold(std::vector<mesh::VertexId> vertices, fem::State& state);
  // Sets the number of the SetPins command that set the pins; 0: the pins are those of the scene.
  void set_version(std::int32_t version) { version_ = version; }

  [[nodiscard]] const std::vector<mesh::VertexId>& vertices() const { return vertices_; }  // sorted, unique
  [[nodiscard]] const std::vector<fem::Pin>& holds() const { return holds_; }              // of vertices(), in order
  [[nodiscard]] std::int32_t version() const { return version_; }
  // Returns the pins of vertices that lose all their material in the edit.
  [[nodiscard]] std::vector<fem::Pin> lost_by(const mesh::MeshEdit& edit) const;

 private:
  friend struct Fields<PinSet>;
  std::vector<mesh::VertexId> vertices_;
  std::vector<fem::Pin> holds_;
  std::int32_t version_ = 0;
};

}  // namespace kerf::sheet

#include "server/core/sheet/topology.h"

#include <utility>

namespace kerf::sheet {

namespace {

constexpr std::array<mesh::VertexId, 3> kVoid{mesh::kNone, mesh::kNone, mesh::kNone};

// Sets everything in `topology` except versions.
void copy_mesh(const mesh::TriangleMesh& mesh, Topology& topology) {
  const auto num_slots = static_cast<std::size_t>(mesh.num_triangle_slots());
  topology.num_triangles = mesh.num_solid_triangles();
  topology.num_pieces = mesh.num_pieces();
  topology.triangles.resize(num_slots);
  topology.pieces.resize(num_slots);
  topology.regions.resize(num_slots);
  for (std::size_t s = 0; s < num_slots; ++s) {
    const auto t = static_cast<mesh::TriangleId>(s);
    const bool solid = mesh.is_solid(t);
    topology.triangles[s] = solid ? mesh.vertices(t) : kVoid;
    topology.pieces[s] = solid ? mesh.piece(t) : mesh::kNone;
    topology.regions[s] = solid ? mesh.region(t) : mesh::kNone;
  }
  topology.material_positions.resize(2, mesh.num_vertices());
  for (mesh::VertexId v = 0; v < mesh.num_vertices(); ++v) topology.material_positions.col(v) = mesh.rest_position(v);
}

}  // namespace

void LazyTopology::add_edits(std::span<const mesh::MeshEdit* const> edits) {
  if (!latest_) return;
  for (const mesh::MeshEdit* edit : edits) {
    rewritten_.insert(rewritten_.end(), edit->rewritten_triangles.begin(), edit->rewritten_triangles.end());
    for (const mesh::VertexSource& moved : edit->moved_vertices) moved_.push_back(moved.vertex);
  }
  // Limits the lists of a sheet without viewers. If they have more than twice as many entries as there are slots, a
  // full topology costs no more than a patch.
  if (rewritten_.size() + moved_.size() > 2 * latest_->triangles.size()) replace();
}

void LazyTopology::replace() {
  latest_.reset();
  rewritten_.clear();
  moved_.clear();
}

std::shared_ptr<const Topology> LazyTopology::at(const mesh::TriangleMesh& mesh, std::int32_t version) const {
  if (latest_ && latest_->version == version) return latest_;
  auto topology = std::make_shared<Topology>();
  topology->version = version;
  topology->patchable_since = latest_ ? latest_->patchable_since : version;
  copy_mesh(mesh, *topology);
  if (latest_) {
    topology->slot_versions = latest_->slot_versions;
    topology->vertex_versions = latest_->vertex_versions;
  }
  topology->slot_versions.resize(topology->triangles.size(), version);
  topology->vertex_versions.resize(static_cast<std::size_t>(mesh.num_vertices()), version);
  for (const mesh::TriangleId t : rewritten_) topology->slot_versions[static_cast<std::size_t>(t)] = version;
  for (const mesh::VertexId v : moved_) topology->vertex_versions[static_cast<std::size_t>(v)] = version;
  for (std::size_t s = 0; latest_ && s < latest_->pieces.size(); ++s) {
    if (latest_->pieces[s] != topology->pieces[s]) topology->slot_versions[s] = version;
  }
  rewritten_.clear();
  moved_.clear();
  latest_ = std::move(topology);
  return latest_;
}

}  // namespace kerf::sheet

#include "server/sheet/topology.h"

#include <utility>

namespace kerf::sheet {

namespace {

constexpr std::array<mesh::VertexId, 3> kVoid{mesh::kNone, mesh::kNone, mesh::kNone};

// Everything but the versions of slots and vertices.
void copy_mesh(const mesh::TriangleMesh& mesh, Topology& topology) {
  const auto num_slots = static_cast<std::size_t>(mesh.num_triangle_slots());
  topology.num_triangles = mesh.num_solid_triangles();
  topology.num_pieces = mesh.num_pieces();
  topology.triangles.resize(num_slots);
  topology.pieces.resize(num_slots);
  for (std::size_t s = 0; s < num_slots; ++s) {
    const auto t = static_cast<mesh::TriangleId>(s);
    const bool solid = mesh.is_solid(t);
    topology.triangles[s] = solid ? mesh.vertices(t) : kVoid;
    topology.pieces[s] = solid ? mesh.piece(t) : mesh::kNone;
  }
  topology.material_positions.resize(2, mesh.num_vertices());
  for (mesh::VertexId v = 0; v < mesh.num_vertices(); ++v) topology.material_positions.col(v) = mesh.rest_position(v);
}

}  // namespace

std::shared_ptr<const Topology> full_topology(const mesh::TriangleMesh& mesh, std::int32_t version) {
  auto topology = std::make_shared<Topology>();
  topology->version = version;
  topology->patchable_since = version;
  copy_mesh(mesh, *topology);
  topology->slot_versions.assign(topology->triangles.size(), version);
  topology->vertex_versions.assign(static_cast<std::size_t>(mesh.num_vertices()), version);
  return topology;
}

std::shared_ptr<const Topology> edited_topology(const Topology& previous, const mesh::TriangleMesh& mesh,
                                                std::span<const mesh::MeshEdit* const> edits, std::int32_t version) {
  auto topology = std::make_shared<Topology>();
  topology->version = version;
  topology->patchable_since = previous.patchable_since;
  copy_mesh(mesh, *topology);
  topology->slot_versions = previous.slot_versions;
  topology->slot_versions.resize(topology->triangles.size(), version);
  topology->vertex_versions = previous.vertex_versions;
  topology->vertex_versions.resize(static_cast<std::size_t>(mesh.num_vertices()), version);
  for (const mesh::MeshEdit* edit : edits) {
    for (const mesh::TriangleId t : edit->rewritten_triangles) {
      topology->slot_versions[static_cast<std::size_t>(t)] = version;
    }
    for (const mesh::VertexSource& moved : edit->moved_vertices) {
      topology->vertex_versions[static_cast<std::size_t>(moved.vertex)] = version;
    }
  }
  for (std::size_t s = 0; s < previous.pieces.size(); ++s) {
    if (previous.pieces[s] != topology->pieces[s]) topology->slot_versions[s] = version;
  }
  return topology;
}

}  // namespace kerf::sheet

// The undo log, and the beginning and end of an edit: begin, commit, rollback, undo.

#include "server/core/mesh/mesh_editor.h"

#include <algorithm>

#include "server/base/check.h"
#include "server/base/interruption.h"

namespace kerf::mesh {

void UndoLog::undo(TriangleMesh& mesh) const {
  KERF_CHECK(mesh.num_points() == num_points_after && mesh.num_vertices() == num_vertices_after &&
                 mesh.num_triangle_slots() == num_triangle_slots_after,
             "edits are undone in the opposite order to that of their making");
  restore(mesh);
}

UndoLog UndoLog::inverse(const TriangleMesh& mesh) const {
  const MeshData& now = mesh.data();
  UndoLog log;
  log.num_points = num_points_after;
  log.num_vertices = num_vertices_after;
  log.num_triangle_slots = num_triangle_slots_after;
  log.num_solid_triangles = now.num_solid_triangles;
  log.num_pieces = now.num_pieces;
  log.num_points_after = num_points;
  log.num_vertices_after = num_vertices;
  log.num_triangle_slots_after = num_triangle_slots;
  const auto keep = [](const auto& overwritten, std::int32_t first_new, const auto& data, auto& kept) {
    const auto end = static_cast<std::int32_t>(data.size());
    kept.reserve(overwritten.size() + static_cast<std::size_t>(end - first_new));
    for (const auto& entry : overwritten) kept.emplace_back(entry.first, data[static_cast<std::size_t>(entry.first)]);
    for (std::int32_t i = first_new; i < end; ++i) kept.emplace_back(i, data[static_cast<std::size_t>(i)]);
  };
  keep(points, num_points, now.points, log.points);
  keep(vertices, num_vertices, now.vertices, log.vertices);
  keep(triangles, num_triangle_slots, now.triangles, log.triangles);
  return log;
}

void UndoLog::restore(TriangleMesh& mesh) const {
  MeshData& data = mesh.data_;
  data.points.resize(static_cast<std::size_t>(num_points));
  data.vertices.resize(static_cast<std::size_t>(num_vertices));
  data.triangles.resize(static_cast<std::size_t>(num_triangle_slots));
  for (const auto& [p, record] : points) data.points[p] = record;
  for (const auto& [v, record] : vertices) data.vertices[v] = record;
  for (const auto& [t, record] : triangles) data.triangles[t] = record;
  data.num_solid_triangles = num_solid_triangles;
  data.num_pieces = num_pieces;
}

MeshEditor::MeshEditor(TriangleMesh& mesh, std::int32_t max_triangle_slots)
    : mesh_(mesh), max_slots_(max_triangle_slots) {
  log_.num_points = mesh.num_points();
  log_.num_vertices = mesh.num_vertices();
  log_.num_triangle_slots = mesh.num_triangle_slots();
  log_.num_solid_triangles = mesh.num_solid_triangles();
  log_.num_pieces = mesh.num_pieces();
}

MeshEditor::~MeshEditor() {
  if (!finished_) rollback();
}

TriangleRecord& MeshEditor::touch_triangle(TriangleId t) {
  TriangleRecord& record = mesh_.data_.triangles[t];
  if (t < log_.num_triangle_slots && triangle_entry_.add(t, static_cast<std::int32_t>(log_.triangles.size()))) {
    log_.triangles.emplace_back(t, record);
  }
  return record;
}

PointRecord& MeshEditor::touch_point(PointId p) {
  PointRecord& record = mesh_.data_.points[p];
  if (p < log_.num_points && point_entry_.add(p, static_cast<std::int32_t>(log_.points.size()))) {
    log_.points.emplace_back(p, record);
  }
  return record;
}

VertexRecord& MeshEditor::touch_vertex(VertexId v) {
  VertexRecord& record = mesh_.data_.vertices[v];
  if (v < log_.num_vertices && vertex_entry_.add(v, static_cast<std::int32_t>(log_.vertices.size()))) {
    log_.vertices.emplace_back(v, record);
  }
  return record;
}

bool MeshEditor::take_slots(std::int32_t count) {
  interruption_point();
  if (max_slots_ - count >= mesh_.num_triangle_slots()) return true;
  budget_exhausted_ = true;
  return false;
}

TriangleId MeshEditor::add_slot(const TriangleRecord& record, TriangleId parent) {
  const TriangleId t = mesh_.num_triangle_slots();
  parents_.push_back(parent_of(parent));
  mesh_.data_.triangles.push_back(record);
  if (record.region != kNone) ++mesh_.data_.num_solid_triangles;
  return t;
}

PointId MeshEditor::add_point(const LatticePoint& p) {
  const PointId id = mesh_.num_points();
  mesh_.data_.points.push_back({p, kNone});
  lips_.emplace_back();
  pending_.push_back(id);
  return id;
}

TriangleId MeshEditor::parent_of(TriangleId t) const {
  return t < log_.num_triangle_slots ? t : parents_[t - log_.num_triangle_slots];
}

const TriangleRecord& MeshEditor::old_record(TriangleId t) const {
  const std::int32_t entry = triangle_entry_.find(t);
  return entry == kNone ? mesh_.record(t) : log_.triangles[static_cast<std::size_t>(entry)].second;
}

const LatticePoint& MeshEditor::old_at(PointId p) const {
  const std::int32_t entry = point_entry_.find(p);
  return entry == kNone ? mesh_.at(p) : log_.points[static_cast<std::size_t>(entry)].second.at;
}

void MeshEditor::clear_edit_locks() {
  const auto clear = [](TriangleRecord& record) {
    for (LockBits& bits : record.locks) bits = static_cast<LockBits>(bits & ~kLocksOfOneEdit);
  };
  for (const auto& entry : log_.triangles) clear(mesh_.data_.triangles[entry.first]);
  for (TriangleId t = log_.num_triangle_slots; t < mesh_.num_triangle_slots(); ++t) clear(mesh_.data_.triangles[t]);
}

CommittedEdit MeshEditor::commit() {
  KERF_CHECK(!finished_, "an edit is committed or rolled back once");
  open();
  clear_edit_locks();
  CommittedEdit done;
  for (const NewVertex& added : new_vertices_) done.edit.added_vertices.push_back(source_of(added));
  done.edit.moved_vertices = moved_sources();
  done.edit.rewritten_triangles = rewritten_triangles();
  done.edit.removed_vertices = std::move(removed_vertices_);
  done.edit.split_from = std::move(split_from_);
  done.edit.removed_pieces = std::move(removed_pieces_);
  finished_ = true;
  log_.num_points_after = mesh_.num_points();
  log_.num_vertices_after = mesh_.num_vertices();
  log_.num_triangle_slots_after = mesh_.num_triangle_slots();
  done.undo = std::move(log_);
#ifdef KERF_VALIDATE
  if (const std::optional<std::string> violation = mesh_.find_violation()) KERF_CHECK(false, violation->c_str());
#endif
  return done;
}

void MeshEditor::rollback() {
  KERF_CHECK(!finished_, "an edit is committed or rolled back once");
  finished_ = true;
  log_.restore(mesh_);
}

}  // namespace kerf::mesh

#include "server/core/sheet/sheet_conditions.h"

#include <algorithm>
#include <utility>

namespace kerf::sheet {

namespace {

// Ratio of tangential to normal drag, that of the default coefficients of fem for cloth.  -
constexpr double kTangentialShare = 1.0 / 60.0;

}  // namespace

SheetConditions::SheetConditions(std::shared_ptr<const scene::SheetConfig> config, ConditionValues values)
    : config_(std::move(config)), values_(std::move(values)) {
  set_wind(values_.wind);
  loads_.grabs.reserve(scene::kMaxGrabs);
}

bool SheetConditions::set(const scene::Instant& end, double duration, const std::vector<fem::Pin>& pins,
                          const mesh::TriangleMesh& mesh, fem::Model& model) {
  scene::HeldVertices& held = values_.held_vertices;
  scene::AppliedForces& applied = values_.applied_forces;
  const bool varies = held.varies() || applied.varies() || !config_->gravity_history.times.empty();
  if (!is_changed_ && !varies && end.absent == values_.now.absent) return false;
  loads_.gravity = config_->gravity_history.at(end.time, 1.0) * values_.full_gravity;
  if (held.empty()) {
    loads_.pins = pins;
  } else {
    held.set(pins, {end.time - duration, end.absent}, end, duration, mesh, loads_.pins);
  }
  values_.now = end;
  const bool other_vertices = has_slopes() && hold_slopes(mesh, model);
  if (!applied.empty()) applied.set(end, mesh, model, loads_);
  is_changed_ = false;
  return other_vertices;
}

bool SheetConditions::hold_slopes(const mesh::TriangleMesh& mesh, fem::Model& model) {
  std::vector<fem::Clamp> clamps = values_.held_vertices.clamps(values_.now);
  std::vector<mesh::VertexId> vertices;
  for (const fem::Clamp& clamp : clamps) vertices.push_back(clamp.vertex);
  model.set_clamps(mesh, std::move(clamps));
  // The integrator's matrix depends on which vertices are clamped; their slopes only change forces.
  if (vertices == clamped_) return false;
  clamped_ = std::move(vertices);
  return true;
}

void SheetConditions::set_gravity(const Eigen::Vector3d& value) {
  values_.full_gravity = value;
  mark_changed();
}

void SheetConditions::set_wind(const scene::Wind& value) {
  values_.wind = value;
  loads_.wind.velocity = value.velocity;
  loads_.wind.air_density = value.air_density;
  loads_.wind.normal_drag = value.drag_coefficient;
  loads_.wind.tangential_drag = kTangentialShare * value.drag_coefficient;
}

void SheetConditions::follow(const mesh::TriangleMesh& mesh, std::span<const mesh::MeshEdit* const> edits,
                             const scene::BuiltMesh& initial) {
  if (!values_.held_vertices.empty()) values_.held_vertices.follow(mesh, edits, initial);
  if (!values_.applied_forces.empty()) values_.applied_forces.follow(mesh, initial);
  mark_changed();
}

void SheetConditions::restore(const ConditionValues& values) {
  values_ = values;
  resume();
}

void SheetConditions::resume() {
  set_wind(values_.wind);
  clamped_.clear();
  mark_changed();
}

bool SheetConditions::has_changes_to_come() const {
  const std::vector<double>& times = config_->gravity_history.times;
  const double gravity_change = times.empty() ? -scene::kForever : times.back();
  return values_.now.time <
         std::max({values_.held_vertices.last_change(), values_.applied_forces.last_change(), gravity_change});
}

}  // namespace kerf::sheet

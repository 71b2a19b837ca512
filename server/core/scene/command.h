#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include <Eigen/Core>

#include "server/base/result.h"
#include "server/core/cut/curve.h"
#include "server/core/cut/cut_types.h"
#include "server/core/fem/element/material.h"
#include "server/core/mesh/ids.h"
#include "server/core/scene/conditions.h"

// Commands to a running sheet, and their replies: kerf.v1.Command without Protocol Buffers. Each takes effect whole at
// a tick boundary, or is refused and changes nothing.
namespace kerf::sheet {

inline constexpr std::size_t kMaxGrabs = 64;
inline constexpr std::size_t kMaxBatchCuts = 4096;  // of one CutBatch
inline constexpr std::size_t kMaxGrabIdBytes = 63;
inline constexpr double kMaxGravity = 1.0e4;         // m/s^2, length
inline constexpr double kMaxWindSpeed = 1.0e3;       // m/s, length
inline constexpr double kMaxAirDensity = 100.0;      // kg/m^3
inline constexpr double kMaxDragCoefficient = 10.0;  // -
inline constexpr double kMaxGrabStiffness = 1.0e6;   // N/m

// Moving air. Force on a triangle: see core/fem/element/loads.h.
struct Wind {
  Eigen::Vector3d velocity{0.0, 0.0, 0.0};  // m/s, |.| <= kMaxWindSpeed
  double air_density = 0.0;                 // kg/m^3, 0..kMaxAirDensity; 0: no air at all
  double drag_coefficient = 1.0;            // -, 0..kMaxDragCoefficient
};

// A cut along a curve, whole or not at all. The range of min_angle_deg, 5..cut::kMaxMinAngle, is narrower than in
// cut::CutOptions.
struct Cut {
  cut::Curve curve;  // m, material coordinates
  cut::CutOptions options;
  std::optional<cut::View> view;     // present: the curve is in pixels of this picture
  std::vector<std::string> remarks;  // on what the curve was made from; the first warnings of the reply
};

// Cuts done one after another as one, with one topology version and one step to undo. If one is refused, none is done;
// a cut that meets no sheet (kNoIntersection) is not refused.
struct CutBatch {
  std::vector<Cut> cuts;  // 1..kMaxBatchCuts
};

// Undoes the last Cut, CutBatch or Reset that is not undone yet.
// A cut: mesh and rest state return bit for bit; what moves keeps moving (see fem::revert_state). Pins that the cut's
// vertices inherited go with them. A vertex that a pinned one joins is pinned. Pins that went with material come back
// with it if no others were set since. A grab of a vertex that goes holds the same material point from then on.
// A Reset: the sheet is as it was before it, bit for bit, without grabs; the tick counts on.
// Errors: kFailedPrecondition NOTHING_TO_UNDO, or UNDO_FORGOTTEN beyond the history kept (see UndoHistory).
struct UndoCut {};

// Repeats what was undone last: of a cut the mesh is what it was before the undo, bit for bit; a Reset is done again.
// An applied cut and a Reset leave nothing to redo: kFailedPrecondition NOTHING_TO_REDO.
struct RedoCut {};

// Ties a point of the sheet to a moving target by a stiff spring. The point stays the same material point through later
// cuts.
struct Grab {
  std::string grab_id;                                  // 1..kMaxGrabIdBytes bytes, unique among the sheet's grabs
  std::variant<mesh::VertexId, Eigen::Vector2d> point;  // an existing vertex, or a material point of the sheet (m)
  std::optional<Eigen::Vector3d> target;                // m, world; absent: where the point is now
  double stiffness = 0.0;                               // N/m, 0..kMaxGrabStiffness; 0: as stiff as stays stable
};

struct Drag {
  std::string grab_id;
  Eigen::Vector3d target{0.0, 0.0, 0.0};  // m, world
};

struct Release {
  std::string grab_id;
};

// Replaces all pins; pinned vertices stay where they are at that moment.
struct SetPins {
  std::vector<Region> pins;  // at most kMaxRegions; empty releases the sheet
};

struct SetGravity {
  Eigen::Vector3d gravity{0.0, 0.0, -9.81};  // m/s^2, |.| <= kMaxGravity
};

struct SetWind {
  Wind wind;
};

// Replaces the material of all of the sheet, or of one part. Positions, velocities, pins, grabs, cuts and the undo
// history stay. Masses, elements, bending and the choice of the integrator follow the new material; so do the springs
// of grabs without a given stiffness. The resistance to bending of a planar sheet stays off. Errors: kInvalidArgument
// SHEET_TOO_STIFF, as when a sheet is made, and those of with_material().
struct SetMaterial {
  static constexpr std::int32_t kOwn = -1;

  fem::Material material;
  std::optional<std::int32_t> part;  // index into SheetConfig::materials; kOwn: the rest; absent: all
};

// Brings the whole scene back: mesh, positions, pins, loads, materials, no grabs; its clock, histories and scheduled
// commands begin again. The tick and the topology version keep counting. UndoCut undoes it.
struct Reset {
  bool repeats = false;  // the scene plays again by itself (SheetConfig::repeat_after): nothing is kept for an undo
};

// Turns the error of a Cut into that of cut number `index` of a CutBatch.
Error in_batch(Error error, std::size_t index);

Status validate(const Wind& wind, const std::string& field);

using Command = std::variant<Cut, Grab, Drag, Release, SetPins, SetGravity, SetWind, Reset, CutBatch, UndoCut, RedoCut,
                             SetMaterial>;

// Checks a command as far as that needs no sheet. Errors are kInvalidArgument with the field named as in
// kerf.v1.Command ("cut.curve.bezier.points[1].x", "cut_batch.cuts[3].curve.circle.radius_m", "grab.stiffness_npm"); a
// Sheet checks the rest.
Status validate(const Command& command);

// Pieces of a sheet have ids of their own, see lineage.h.
struct PieceBirth {
  std::int64_t id = 0;
  std::int64_t parent = 0;  // 0: existed when the sheet was made
  std::int64_t cut = 0;     // number of the cut that made it; 0: existed when the sheet was made
};

// A piece as it is.
struct Piece {
  PieceBirth birth;
  std::int32_t label = 0;  // its number in the mesh, and in frames, now
  std::int32_t num_triangles = 0;
  double area = 0.0;                              // m^2, at rest
  double mass = 0.0;                              // kg
  Eigen::Vector2d centroid{0.0, 0.0};             // m, material coordinates
  Eigen::Vector3d world_centroid{0.0, 0.0, 0.0};  // m, mean position of its material
};

// A piece that fell apart or was removed.
struct SplitPiece {
  std::int64_t id = 0;          // ended with this
  std::vector<Piece> children;  // two or more, by id, or none where all of it was removed; as they are when the whole
                                // command is done. Where a later cut of a batch divided one again: the sum of its
                                // parts, label -1; where one removed it: nothing, label -1
};

// Part of a CommandReply.
struct CutReply {
  cut::CutStatus status = cut::CutStatus::kNoIntersection;
  cut::CutReport report;                 // all zero on kNoIntersection, except `pieces`
  std::vector<std::string> warnings;     // for people: shortfalls against the request, and triangles left out
  std::int64_t number = 0;               // 1, 2, ... for the sheet's applied cuts, never given twice; 0 unless applied
  std::vector<SplitPiece> split_pieces;  // split or removed by the cut, by id
  std::optional<double> removed_mass;    // kg; of an applied cut with a width
};

// Part of a CommandReply: of an UndoCut or RedoCut.
struct UndoReply {
  std::vector<std::int64_t> cuts;  // numbers of the cuts undone or made again, ascending; empty for a Reset
  bool reset = false;              // a Reset was undone, or done again
  std::int32_t pieces = 0;         // of the whole sheet
  std::int32_t undo_steps = 0;     // that can be undone after it
  std::int32_t redo_steps = 0;     // that can be made again after it
};

// The reply to a command that was done. `tick` and `state_hash` name one state: the sheet as it was when the step (or
// apply) in which the command took effect had ended.
struct CommandReply {
  std::int64_t tick = 0;
  std::int32_t topology_version = 0;  // right after the command
  std::uint64_t state_hash = 0;       // Sheet::state_hash() at the end of that tick
  std::optional<CutReply> cut;        // of a Cut
  std::vector<CutReply> batch;        // of a CutBatch, one a cut; `pieces` of each are those of the sheet after it
  std::optional<UndoReply> undone;    // of an UndoCut or RedoCut
  // Number of the run of the scene that the sheet is in then: 0 at first, a new number after each Reset. Undoing a
  // Reset brings the number before it back.
  std::int64_t beginning = 0;
};

}  // namespace kerf::sheet

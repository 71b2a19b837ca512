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

// Commands to a running sheet, and their replies: kerf.v1.Command without Protocol Buffers. A command takes effect
// between two ticks, as a whole, or is refused and changes nothing.
namespace kerf::scene {

inline constexpr std::size_t kMaxGrabs = 64;
inline constexpr std::size_t kMaxBatchCuts = 4096;  // most cuts of one CutBatch
inline constexpr std::size_t kMaxGrabIdBytes = 63;
inline constexpr double kMaxGravity = 1.0e4;         // m/s^2, largest length of the vector
inline constexpr double kMaxWindSpeed = 1.0e3;       // m/s, largest length of the vector
inline constexpr double kMaxAirDensity = 100.0;      // kg/m^3
inline constexpr double kMaxDragCoefficient = 10.0;  // -
inline constexpr double kMaxGrabStiffness = 1.0e6;   // N/m
inline constexpr double kMaxSelfFriction = 10.0;     // -
inline constexpr double kMinSelfThickness = 1.0e-6;  // m
inline constexpr double kMaxSelfThickness = 0.1;     // m
// Bytes per vertex that self-contact holds while nothing is near; up to 1,620 were measured. Lists of pairs come on
// top: 8 kB a vertex in a crumpled pile, 80 kB in a stack of ten layers.
inline constexpr std::int64_t kSelfContactBytes = 2000;

// Moving air. For its force on a triangle see core/fem/element/loads.h.
struct Wind {
  Eigen::Vector3d velocity{0.0, 0.0, 0.0};  // m/s, |.| <= kMaxWindSpeed
  double air_density = 0.0;                 // kg/m^3, 0..kMaxAirDensity; 0: no force
  double drag_coefficient = 1.0;            // -, 0..kMaxDragCoefficient
};

// Contact of folds and pieces of a sheet with each other, in explicit steps.
struct SelfContact {
  bool is_on = false;                    // true: steps must be explicit, and the sheet not planar
  double friction = 0.3;                 // -, Coulomb's coefficient, 0..kMaxSelfFriction
  std::optional<double> thickness = {};  // m, distance that middle surfaces keep, kMinSelfThickness..kMaxSelfThickness;
                                         // absent: the greatest thickness of the sheet's materials

  bool operator==(const SelfContact&) const = default;
};

// A cut along a curve, done as a whole or not at all. min_angle_deg must be in 5..cut::kMaxMinAngle, a narrower range
// than in cut::CutOptions.
struct Cut {
  cut::Curve curve;  // m, material coordinates
  cut::CutOptions options;
  std::optional<cut::View> view;     // present: `curve` is in pixels of this picture instead
  std::vector<std::string> remarks;  // remarks on how the curve was made; they become the first warnings of the reply
  std::string component;             // name: the curve and the fit are in its own coordinates, and it alone is cut;
                                     // empty: they are in the scene's material plane. Not together with a view
};

// Cuts done one after another as a single command, with one topology version and one undo step. If one cut is refused,
// none is done. A cut that misses the sheet (kNoIntersection) is not refused.
struct CutBatch {
  std::vector<Cut> cuts;  // 1..kMaxBatchCuts
};

// Undoes the last Cut, CutBatch or Reset that is not undone yet.
// - A cut: the mesh and the rest state return bit for bit; motion continues (see fem::revert_state). Pins of vertices
//   that the cut made are lost. If the undo joins a pinned vertex and another, the result is pinned. Pins that were
//   lost with removed material return with it, unless pins were set since. A grab of a vertex that no longer exists
//   holds the same material point from then on.
// - A Reset: the sheet becomes what it was before, bit for bit, but without grabs; the tick keeps counting.
//
// Errors: kFailedPrecondition NOTHING_TO_UNDO, or UNDO_FORGOTTEN beyond the history kept (see UndoHistory).
struct UndoCut {};

// Does again what was undone last. For a cut, the mesh becomes what it was before the undo, bit for bit; a Reset is
// done again. After a new cut or Reset nothing is left to redo: kFailedPrecondition NOTHING_TO_REDO.
struct RedoCut {};

// Ties a point of the sheet to a moving target by a stiff spring. The point stays the same material point through later
// cuts.
struct Grab {
  std::string grab_id;                                  // 1..kMaxGrabIdBytes bytes, different from the ids of the
                                                        // sheet's other grabs
  std::variant<mesh::VertexId, Eigen::Vector2d> point;  // an existing vertex, or a material point of the sheet (m)
  std::optional<Eigen::Vector3d> target;                // m, world; absent: where the point is now
  double stiffness = 0.0;                               // N/m, 0..kMaxGrabStiffness; 0: chosen from the mass and the
                                                        // material of the sheet
};

struct Drag {
  std::string grab_id;
  Eigen::Vector3d target{0.0, 0.0, 0.0};  // m, world
};

struct Release {
  std::string grab_id;
};

// Replaces all pins. The vertices of the new pins stay where they are when the command takes effect.
struct SetPins {
  std::vector<Region> pins;  // at most kMaxRegions; without any the sheet is free
};

struct SetGravity {
  Eigen::Vector3d gravity{0.0, 0.0, -9.81};  // m/s^2, |.| <= kMaxGravity
};

struct SetWind {
  Wind wind;
};

// Replaces the material of the whole sheet, or of one part. Positions, velocities, pins, grabs, cuts and the undo
// history do not change. Masses, elements, bending and the choice of the integrator follow the new material, as do
// springs of grabs without a given stiffness. A planar sheet still does not resist bending. Errors: kInvalidArgument
// SHEET_TOO_STIFF, as for Sheet::create(), and those of with_material().
struct SetMaterial {
  static constexpr std::int32_t kOwn = -1;

  fem::Material material;
  std::optional<std::int32_t> part;  // index into SheetConfig::materials; kOwn: the sheet's own material; absent: all
                                     // materials
};

// Replaces those settings that are present. Lips that lie on each other are parted if self-contact is turned on.
// Automatic steps are chosen again when it is turned on or off. Errors when it is turned on: kFailedPrecondition
// SELF_CONTACT_PLANAR if the sheet is planar.
struct SetSelfContact {
  std::optional<bool> is_on;
  std::optional<double> friction;   // -, range as above
  std::optional<double> thickness;  // m, range as above
  bool material_thickness = false;  // true: that of the materials again; refused beside `thickness`
};

// Begins the scene again: mesh, positions, pins, loads, materials and self-contact are those of the start, and there
// are no grabs. Its clock, histories and scheduled commands begin again. The tick and the topology version keep
// counting. UndoCut undoes a Reset.
struct Reset {
  bool repeats = false;  // true if SheetConfig::repeat_after causes it; such a Reset cannot be undone
};

// Returns the error of a Cut as the error of cut number `index` of a CutBatch.
Error in_batch(Error error, std::size_t index);

Status validate(const Wind& wind, const std::string& field);
// Checks the ranges of friction and thickness. Fields are `path` + ".friction" and ".thickness_m". Two choices of the
// thickness are CHOICE_AMBIGUOUS of `path` + ".material_thickness".
Status validate(const SetSelfContact& settings, const std::string& path);

// Returns the settings with those of `change` replaced.
[[nodiscard]] SelfContact with(SelfContact settings, const SetSelfContact& change);

using Command = std::variant<Cut, Grab, Drag, Release, SetPins, SetGravity, SetWind, Reset, CutBatch, UndoCut, RedoCut,
                             SetMaterial, SetSelfContact>;

// Checks everything about a command that can be checked without a sheet. Errors are kInvalidArgument with the field
// named as in kerf.v1.Command ("cut.curve.bezier.points[1].x", "cut_batch.cuts[3].curve.circle.radius_m",
// "grab.stiffness_npm"); a Sheet checks the rest.
Status validate(const Command& command);

// The origin of a piece of a sheet. Its id differs from its number in the mesh, see lineage.h.
struct PieceBirth {
  std::int64_t id = 0;
  std::int64_t parent = 0;  // id of the piece that it was part of; 0: it existed when the sheet was made
  std::int64_t cut = 0;     // number of the cut that made it; 0: it existed when the sheet was made
};

// A piece and its measures at present.
struct Piece {
  PieceBirth birth;
  std::int32_t label = 0;  // its present number in the mesh and in frames
  std::int32_t num_triangles = 0;
  double area = 0.0;                              // m^2, at rest
  double mass = 0.0;                              // kg
  Eigen::Vector2d centroid{0.0, 0.0};             // m, material coordinates
  Eigen::Vector3d world_centroid{0.0, 0.0, 0.0};  // m, mean of the present positions of its material
};

// A piece that fell apart or was removed.
struct SplitPiece {
  std::int64_t id = 0;          // id of the piece, which ended
  std::vector<Piece> children;  // two or more, sorted by id; none if the whole piece was removed. Measured after the
                                // whole command. A child that a later cut of the batch divided: the sum of its parts,
                                // label -1. A child that one removed: all zero, label -1
};

// The part of a CommandReply about one cut.
struct CutReply {
  cut::CutStatus status = cut::CutStatus::kNoIntersection;
  cut::CutReport report;                 // mostly zero on kNoIntersection, see cut::CutReport
  std::vector<std::string> warnings;     // for people: what falls short of the request, and triangles left out
  std::int64_t number = 0;               // 1, 2, ... for the applied cuts of the sheet, never used twice; 0 if not
                                         // applied
  std::vector<SplitPiece> split_pieces;  // pieces that the cut split or removed, sorted by id
  std::optional<double> removed_mass;    // kg; only for an applied cut with a width
};

// The part of a CommandReply about an UndoCut or RedoCut.
struct UndoReply {
  std::vector<std::int64_t> cuts;  // numbers of the cuts that were undone or done again, ascending; empty for a Reset
  bool reset = false;              // true if a Reset was undone or done again
  std::int32_t pieces = 0;         // pieces of the whole sheet afterwards
  std::int32_t undo_steps = 0;     // steps that can be undone afterwards
  std::int32_t redo_steps = 0;     // steps that can be redone afterwards
};

// The reply to a command that was done. `tick` and `state_hash` belong to one state: that at the end of the
// Sheet::step() or apply() in which the command took effect.
struct CommandReply {
  std::int64_t tick = 0;
  std::int32_t topology_version = 0;  // topology version right after the command
  std::uint64_t state_hash = 0;       // Sheet::state_hash() at the end of that tick
  std::optional<CutReply> cut;        // present for a Cut
  std::vector<CutReply> batch;        // for a CutBatch, one per cut; report.pieces counts the pieces after that cut
  std::optional<UndoReply> undone;    // present for an UndoCut or RedoCut
  // Number of the run of the scene, after the command: 0 at first, and a new number after each Reset. When a Reset is
  // undone, the number before it returns.
  std::int64_t beginning = 0;
};

}  // namespace kerf::scene

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <limits>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include <Eigen/Geometry>

#include "server/core/mesh/build/coincidence.h"
#include "server/core/mesh/build/file_places.h"
#include "server/core/mesh/build/sheet_assembly.h"

// Makes meshes of files, and tries again where a choice that was not asked for leaves faults.
namespace kerf::mesh {
namespace {

Result<FileSheet> make_as_asked(const MeshFile& file, const MeshReading& reading, FaultList* faults) {
  const auto import = [&](Result<ImportedSheet> imported) -> Result<FileSheet> {
    if (!imported.ok()) return imported.error();
    ElementNames names;
    if (reading.version != kFirstReader) {
      names.of_triangle = [&](std::int32_t t) {
        return file.face_name(static_cast<std::size_t>(imported->file_faces[t]));
      };
      names.of_vertex = [&](std::int32_t v) {
        return file.vertex_name(static_cast<std::size_t>(imported->file_positions[v]));
      };
    }
    KERF_TRY_ASSIGN(TriangleMesh mesh, import_mesh(imported->sheet, names));
    return FileSheet{std::move(mesh), std::move(imported).value()};
  };
  Result<ImportedSheet> imported = assemble(file, reading, faults);
  const bool may_ignore_chart = imported.ok() && imported->is_charted && reading.version != kFirstReader &&
                                reading.rest_shape != RestShape::kFlat;
  Result<FileSheet> made = import(std::move(imported));
  if (made.ok() || !may_ignore_chart) return made;
  Result<FileSheet> without = import(assemble_without_chart(file, reading, made.error().message, nullptr));
  return without.ok() ? std::move(without) : std::move(made);
}

// Makes the sheet without joining vertices to sides if that spoils it or its chart.
Result<FileSheet> make_with_sides(const MeshFile& file, const MeshReading& reading, FaultList* faults) {
  Result<FileSheet> made = make_as_asked(file, reading, faults);
  if (reading.version <= kSecondReader) return made;
  const bool lacks_chart = made.ok() && !made->imported.is_charted && !file.textures.empty() && !reading.ignore_texture;
  if (made.ok() && !lacks_chart) return made;
  MeshReading without = reading;
  without.version = kSecondReader;
  Result<FileSheet> plain = make_as_asked(file, without, nullptr);
  if (!plain.ok() || (lacks_chart && !plain->imported.is_charted)) return made;
  const std::string& why = lacks_chart ? "the texture coordinates could not be used then" : made.error().message;
  plain->imported.notes.push_back("vertices within sides of other faces are not joined to them: " + why);
  return plain;
}

// Distances that are joined where closer joins leave faults, over the size: programs compute with 7 digits or fewer.
constexpr std::array<double, 3> kWiderJoins{1e-6, 1e-5, 1e-4};
constexpr double kMostOfSides = 0.01;  // -; the longest of these, over the median side

// Counts the places of a file if points at most `distance` apart are one, m.
std::size_t num_places(std::span<const Eigen::Vector3d> points, double distance) {
  const std::vector<std::int32_t> first = first_at_place(points, distance);
  std::size_t count = 0;
  for (std::size_t i = 0; i < first.size(); ++i) count += first[i] == static_cast<std::int32_t>(i) ? 1 : 0;
  return count;
}

// A distance at which more vertices are joined than by closer ones.
struct WiderJoin {
  double distance = 0.0;       // m
  std::size_t num_joined = 0;  // Vertices that are joined beyond those of the file's digits.
};

// Returns distances beyond those of the file's digits, in ascending order.
std::vector<WiderJoin> wider_joins(const MeshFile& file, const MeshReading& reading) {
  Eigen::AlignedBox3d box;
  std::vector<double> sides;
  std::vector<Eigen::Vector3d> points(file.positions.size(),
                                      Eigen::Vector3d::Constant(std::numeric_limits<double>::quiet_NaN()));
  for (const MeshFile::Face& face : file.faces) {
    const std::span<const MeshFile::Corner> corners = file.corners_of(face);
    for (std::size_t i = 0; i < corners.size(); ++i) {
      const auto here = static_cast<std::size_t>(corners[i].first);
      const auto next = static_cast<std::size_t>(corners[(i + 1) % corners.size()].first);
      if (!file.positions[here].allFinite()) return {};
      points[here] = reading.unit_m * file.positions[here];
      box.extend(points[here]);
      sides.push_back(reading.unit_m * (file.positions[next] - file.positions[here]).norm());
    }
  }
  if (sides.empty()) return {};
  const double most = kMostOfSides * median(sides);
  const double size = box.sizes().maxCoeff();
  std::vector<WiderJoin> joins;
  const std::size_t num_places_given =
      num_places(points, std::min(most, reading.unit_m * file.position_precision.resolution()));
  for (const double share : kWiderJoins) {
    const double distance = std::min(share * size, most);
    const std::size_t num_joined = num_places_given - std::min(num_places_given, num_places(points, distance));
    if (num_joined > (joins.empty() ? 0 : joins.back().num_joined)) joins.push_back({distance, num_joined});
  }
  return joins;
}

std::string hint_of(const WiderJoin& join) {
  std::array<char, 32> distance{};
  std::snprintf(distance.data(), distance.size(), "%.3g", 1.01 * join.distance);
  return counted(join.num_joined, "vertex") + " nearly meet others, up to " + length_text(join.distance) +
         " apart, and are not joined; join_m " + distance.data() + " (--join " + distance.data() + ") joins them";
}

}  // namespace

// Tries wider joins if a sheet has faults: of vertices that nearly meet, some may be joined and others not. A sheet
// without faults stays as it is, and gets a note.
Result<FileSheet> make_sheet(const MeshFile& file, const MeshReading& reading, FaultList* faults) {
  Result<FileSheet> made = make_with_sides(file, reading, faults);
  if (reading.version <= kSecondReader || reading.join_m || file.is_kerf_export) return made;
  if (made.ok() && made->mesh.num_pieces() == 1 && made->mesh.num_boundary_loops() == 1) return made;
  const std::vector<WiderJoin> joins = wider_joins(file, reading);
  if (made.ok()) {
    if (!joins.empty()) made->imported.notes.push_back(hint_of(joins.back()));
    return made;
  }
  for (const WiderJoin& join : joins) {
    MeshReading wider = reading;
    wider.join_m = join.distance;
    Result<FileSheet> mended = make_with_sides(file, wider, nullptr);
    if (!mended.ok()) continue;
    mended->imported.notes.push_back("vertices up to " + length_text(join.distance) +
                                     " apart are joined; as closely as the file's numbers are written, there is a "
                                     "fault: " +
                                     made.error().message);
    return mended;
  }
  return made;
}

}  // namespace kerf::mesh

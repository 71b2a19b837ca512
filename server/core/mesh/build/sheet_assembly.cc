#include "server/core/mesh/build/sheet_assembly.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <tuple>
#include <utility>

#include "server/base/interruption.h"
#include "server/base/text_encoding.h"
#include "server/core/mesh/build/face_polygon.h"
#include "server/core/mesh/build/face_repair.h"
#include "server/core/mesh/build/file_places.h"
#include "server/core/mesh/build/first_reader.h"
#include "server/core/mesh/build/rest_plane.h"
#include "server/core/mesh/build/side_joining.h"

namespace kerf::mesh {
namespace {

using Polygon = FacePolygons::Polygon;

// Largest distance from a plane that counts as rounding, over the median edge.  -
constexpr double kMostRounding = 0.02;
constexpr double kMostRoundingAsked = 0.2;  // -; the same for RestShape::kFlat
constexpr double kMostStretch = 0.03;       // -; mean difference of lengths in the chart that is not mentioned
constexpr std::size_t kMostNames = 8;
constexpr std::size_t kMaxNameBytes = 100;  // of each name in a message

// Makes the sheet of a file. A chart that cannot be used is a fault of its own: see chart_fault().
class SheetAssembly {
 public:
  SheetAssembly(const MeshFile& file, const MeshReading& reading, bool ignores_texture, FaultList* all_faults)
      : file_(file),
        reading_(reading),
        ignores_texture_(ignores_texture),
        all_faults_(all_faults),
        repair_(file, faces_, notes_, faults_) {}

  Result<ImportedSheet> run() {
    notes_ = file_.notes;
    KERF_TRY(choose_faces());
    choose_chart();
    places_ = place_file(file_, reading_, chosen_, is_charted_, notes_, faults_);
    if (!faults_.empty()) return faults_.as_error(all_faults_);
    make_polygons();
    repair_.leave_out_lines([this](const Polygon& polygon) { return line_of(polygon); });
    if (!chart_fault_.empty()) return file_.refuse("CHART", chart_fault_);
    repair_.leave_out_copies();
    if (reading_.version > kSecondReader) join_to_sides(file_, places_, faces_, notes_);
    repair_.orient(reading_.join_m == 0.0 ? "" : join_hint());
    if (!faults_.empty()) return faults_.as_error(all_faults_);
    if (faces_.polygons.empty()) return file_.refuse("EMPTY", "no face has an area");
    number_vertices();
    KERF_TRY(make_triangles());
    KERF_TRY(make_rest());
    note_size(imported_.world, notes_);
    imported_.is_charted = is_charted_;
    imported_.notes = std::move(notes_);
    return std::move(imported_);
  }

 private:
  [[nodiscard]] bool rests_in_chart() const { return is_charted_ && reading_.rest_shape != RestShape::kSurface; }
  [[nodiscard]] const MeshFile::Corner& corner(std::int32_t c) const { return file_.corners[faces_.file_corners[c]]; }
  [[nodiscard]] static std::string join_hint() {
    return "; where vertices lie at the same place and must stay apart, set join_m to 0 (--join 0); where they nearly "
           "meet, to more than their distance";
  }

  Status choose_faces() {
    std::vector<bool> is_chosen;
    for (const MeshFile::Part& part : file_.parts) {
      interruption_point();
      is_chosen.push_back(reading_.objects.empty() ||
                          std::any_of(reading_.objects.begin(), reading_.objects.end(), [&](const std::string& name) {
                            return part.object == name ||
                                   std::find(part.groups.begin(), part.groups.end(), name) != part.groups.end();
                          }));
    }
    const std::vector<std::pair<std::string, std::int32_t>> known =
        reading_.objects.empty() ? std::vector<std::pair<std::string, std::int32_t>>() : file_.object_sizes();
    for (const std::string& name : reading_.objects) {
      if (std::any_of(known.begin(), known.end(), [&](const auto& each) { return each.first == name; })) continue;
      std::string list;
      for (std::size_t i = 0; i < std::min(known.size(), kMostNames); ++i)
        list += (i == 0 ? "" : ", ") + shortened(known[i].first, kMaxNameBytes);
      return file_.refuse("OBJECT", "the file has no object or group \"" + name + "\" with faces" +
                                        (known.empty() ? ", and names none" : "; it has " + list) +
                                        (known.size() > kMostNames ? " and others" : ""));
    }
    for (std::size_t f = 0; f < file_.faces.size(); ++f) {
      if (is_chosen[static_cast<std::size_t>(file_.faces[f].part)]) chosen_.push_back(static_cast<std::int32_t>(f));
    }
    return Nothing{};
  }

  void choose_chart() {
    if (ignores_texture_) return;
    std::vector<std::int32_t> without;
    for (const std::int32_t f : chosen_) {
      const std::span<const MeshFile::Corner> corners = file_.corners_of(file_.faces[f]);
      const bool has_all = std::all_of(corners.begin(), corners.end(), [](const auto& c) { return c.second != kNone; });
      if (!has_all) without.push_back(f);
    }
    is_charted_ = without.empty();
    if (is_charted_ || without.size() == chosen_.size()) return;
    notes_.push_back("texture coordinates are not used, as some faces have none: " + file_.face_names(without));
  }

  void make_polygons() {
    std::vector<std::pair<std::int32_t, std::int32_t>> numbers;  // the different places, sorted
    std::vector<std::pair<std::int32_t, std::int32_t>> of_corner;
    for (const std::int32_t f : chosen_) {
      for (const MeshFile::Corner& c : file_.corners_of(file_.faces[f])) {
        of_corner.emplace_back(places_.first_position[c.first], is_charted_ ? places_.first_texture[c.second] : kNone);
      }
    }
    numbers = of_corner;
    std::sort(numbers.begin(), numbers.end());
    numbers.erase(std::unique(numbers.begin(), numbers.end()), numbers.end());
    std::size_t next = 0;
    std::vector<std::int32_t> vertices;
    for (const std::int32_t f : chosen_) {
      interruption_point();
      vertices.clear();
      for (std::int32_t i = 0; i < file_.faces[f].num_corners; ++i) {
        const auto at = std::lower_bound(numbers.begin(), numbers.end(), of_corner[next++]);
        vertices.push_back(static_cast<std::int32_t>(at - numbers.begin()));
      }
      repair_.add(f, vertices);
    }
  }

  // Returns the corners of a polygon without area in order along its line, else nothing. A face with area in space and
  // none in the chart makes the chart useless.
  std::vector<std::int32_t> line_of(const Polygon& polygon) {
    std::vector<Eigen::Vector3d> at;
    for (std::int32_t c = polygon.first; c < polygon.first + polygon.count; ++c) at.push_back(places_.at(corner(c)));
    std::vector<std::int32_t> order = order_on_line(at);
    if (is_charted_) {
      at.clear();
      for (std::int32_t c = polygon.first; c < polygon.first + polygon.count; ++c) {
        at.push_back(places_.in_chart(corner(c)));
      }
      const bool is_line_in_chart = !order_on_line(at).empty();
      if (order.empty() && is_line_in_chart && chart_fault_.empty()) {
        chart_fault_ =
            file_.face_name(static_cast<std::size_t>(polygon.face)) + " has no area in the texture coordinates";
      }
      if (rests_in_chart() && !is_line_in_chart) order.clear();
    }
    for (std::int32_t& c : order) c += polygon.first;
    return order;
  }

  // Gives each fan of faces a vertex: at the place of the lowest position of the file among its corners.
  void number_vertices() {
    const std::vector<std::int32_t> fans = repair_.fans();
    std::vector<MeshFile::Corner> lowest(fans.size(), {kNone, kNone});
    std::vector<bool> is_joined(fans.size());
    const auto for_each_corner = [&](const auto& visit) {
      for (const Polygon& polygon : faces_.polygons) {
        for (std::int32_t c = polygon.first; c < polygon.first + polygon.count; ++c) visit(c);
      }
    };
    for_each_corner([&](std::int32_t c) {
      MeshFile::Corner& low = lowest[fans[c]];
      const MeshFile::Corner here{corner(c).first, is_charted_ ? corner(c).second : kNone};
      if (low.first != kNone && low.first != here.first) is_joined[fans[c]] = true;
      if (low.first == kNone || here < low) low = here;
    });
    std::vector<std::pair<MeshFile::Corner, std::int32_t>> vertices;  // and its fan
    for (std::size_t f = 0; f < fans.size(); ++f) {
      if (lowest[f].first != kNone) vertices.emplace_back(lowest[f], static_cast<std::int32_t>(f));
    }
    std::sort(vertices.begin(), vertices.end());
    std::vector<std::int32_t> number(fans.size(), kNone);
    imported_.world.resize(3, static_cast<Eigen::Index>(vertices.size()));
    if (is_charted_) imported_.sheet.rest.resize(2, static_cast<Eigen::Index>(vertices.size()));
    for (std::size_t v = 0; v < vertices.size(); ++v) {
      const auto& [at, fan] = vertices[v];
      number[fan] = static_cast<std::int32_t>(v);
      imported_.world.col(static_cast<Eigen::Index>(v)) = places_.positions[at.first];
      if (is_charted_) imported_.sheet.rest.col(static_cast<Eigen::Index>(v)) = places_.textures[at.second];
      imported_.file_positions.push_back(at.first);
    }
    vertex_of_.assign(fans.size(), kNone);
    std::vector<std::int32_t> joined;  // positions of the file that share a vertex with others
    for_each_corner([&](std::int32_t c) {
      vertex_of_[c] = number[fans[c]];
      if (is_joined[fans[c]]) joined.push_back(corner(c).first);
    });
    std::sort(joined.begin(), joined.end());
    joined.erase(std::unique(joined.begin(), joined.end()), joined.end());
    note_vertices(vertices, joined.size(), std::count(is_joined.begin(), is_joined.end(), true));
  }

  void note_vertices(const std::vector<std::pair<MeshFile::Corner, std::int32_t>>& vertices, std::size_t num_joined,
                     std::ptrdiff_t num_left) {
    if (num_joined > 0) {
      notes_.push_back("joined " + counted(num_joined, "vertex") + " that lie at the same place, which leaves " +
                       std::to_string(num_left) + "; join_m 0 (--join 0) keeps them apart");
    }
    std::vector<std::int32_t> split;
    for (std::size_t v = 1; v < vertices.size(); ++v) {
      const std::int32_t position = vertices[v].first.first;
      if (vertices[v].first != vertices[v - 1].first) continue;
      if (split.empty() || split.back() != position) split.push_back(position);
    }
    if (split.empty()) return;
    notes_.push_back("faces come apart that meet only at " + file_.vertex_name(static_cast<std::size_t>(split[0])) +
                     (split.size() > 1 ? " or at one of " + counted(split.size() - 1, "other vertex") : ""));
  }

  Status make_triangles() {
    std::vector<std::array<std::int32_t, 3>> triangles;
    std::vector<Eigen::Vector3d> in_space;
    std::vector<Eigen::Vector2d> plane;
    for (const Polygon& polygon : faces_.polygons) {
      interruption_point();
      const auto vertex = [&](std::int32_t i) { return vertex_of_[static_cast<std::size_t>(polygon.first + i)]; };
      TriangulatedPolygon made{PolygonKind::kSound, {{0, 1, 2}}};
      if (polygon.count > 3) {
        in_space.clear();
        plane.clear();
        for (std::int32_t i = 0; i < polygon.count; ++i) {
          if (is_charted_) plane.emplace_back(imported_.sheet.rest.col(vertex(i)));
          if (!is_charted_) in_space.emplace_back(imported_.world.col(vertex(i)));
        }
        made = triangulate_polygon(is_charted_ ? plane : in_own_plane(in_space));
      }
      if (made.kind != PolygonKind::kSound) {
        const std::string crosses = file_.face_name(static_cast<std::size_t>(polygon.face)) +
                                    (is_charted_ ? " crosses itself in the texture coordinates" : " crosses itself");
        if (is_charted_) return file_.refuse("CHART", crosses);
        faults_.add(file_.refuse("FACE", crosses + ": list its corners in order around it"));
      }
      for (const std::array<std::int32_t, 3>& triangle : made.triangles) {
        triangles.push_back({vertex(triangle[0]), vertex(triangle[1]), vertex(triangle[2])});
        imported_.file_faces.push_back(polygon.face);
      }
    }
    if (!faults_.empty()) return faults_.as_error(all_faults_);
    imported_.sheet.triangles.resize(3, static_cast<Eigen::Index>(triangles.size()));
    for (std::size_t t = 0; t < triangles.size(); ++t) {
      for (int k = 0; k < 3; ++k) imported_.sheet.triangles(k, static_cast<Eigen::Index>(t)) = triangles[t][k];
    }
    return Nothing{};
  }

  // Chooses the material coordinates and the rest shape.
  Status make_rest() {
    if (is_charted_) {
      if (!rests_in_chart()) imported_.sheet.surface = imported_.world;
      if (rests_in_chart() && !file_.is_kerf_export) note_stretch();
      return Nothing{};
    }
    PlaneFit fit = fit_plane(imported_.world, imported_.sheet.triangles);
    const double step = reading_.unit_m * file_.position_precision.rounding();
    const bool is_asked = reading_.rest_shape == RestShape::kFlat;
    if (!fit.rest && fit.has_normal && step > 0.0) {
      std::vector<double> lengths = edge_lengths();
      fit = fit_rounded_plane(imported_.world, imported_.sheet.triangles, step,
                              (is_asked ? kMostRoundingAsked : kMostRounding) * median(lengths));
      if (fit.rest) {
        notes_.push_back("taken as flat: all vertices lie within " + length_text(fit.height) +
                         " of a plane, as exactly as the file's numbers are written");
      }
    }
    if (fit.rest) {
      imported_.sheet.rest = std::move(*fit.rest);
      return Nothing{};
    }
    const std::string where =
        fit.has_normal ? file_.vertex_name(static_cast<std::size_t>(imported_.file_positions[fit.farthest])) + " is " +
                             length_text(fit.height) + " out of the plane of the faces"
                       : "the faces do not lie in one plane";
    if (is_asked) {
      return file_.refuse("NOT_PLANAR", where + (fit.has_normal ? "; the limit is " + length_text(fit.allowed) : "") +
                                            "; give the faces texture coordinates as rest shape, or use the curved "
                                            "surface itself (--rest surface)");
    }
    if (reading_.rest_shape == RestShape::kAutomatic) notes_.push_back("the rest shape is curved: " + where);
    imported_.sheet.surface = imported_.world;
    return Nothing{};
  }

  [[nodiscard]] std::vector<double> edge_lengths() const {
    std::vector<double> lengths;
    for (Eigen::Index t = 0; t < imported_.sheet.triangles.cols(); ++t) {
      for (int k = 0; k < 3; ++k) lengths.push_back(side(imported_.world, t, k));
    }
    return lengths;
  }

  // Returns the length of a side of triangle t by some coordinates of the vertices, m.
  template <typename Points>
  [[nodiscard]] double side(const Points& points, Eigen::Index t, int k) const {
    const Eigen::Matrix3Xi& triangles = imported_.sheet.triangles;
    return (points.col(triangles(k, t)) - points.col(triangles((k + 1) % 3, t))).norm();
  }

  // Says where lengths in the chart, which is the rest shape, are not those in space.
  void note_stretch() {
    double in_space = 0.0, difference = 0.0, least = 0.0, most = 0.0;
    for (Eigen::Index t = 0; t < imported_.sheet.triangles.cols(); ++t) {
      for (int k = 0; k < 3; ++k) {
        const double given = side(imported_.world, t, k), rest = side(imported_.sheet.rest, t, k);
        if (!(given > 0.0)) continue;
        least = in_space == 0.0 ? rest / given : std::min(least, rest / given);
        most = std::max(most, rest / given);
        in_space += given;
        difference += std::abs(rest - given);
      }
    }
    if (!(difference > kMostStretch * in_space)) return;
    std::array<char, 64> range{};
    std::snprintf(range.data(), range.size(), "%.3g to %.3g", least, most);
    notes_.push_back(std::string("the texture coordinates are the rest shape, and edges there are ") + range.data() +
                     " times as long as between the vertices; ignore_texture_coordinates (--ignore-texture) takes the "
                     "vertices instead");
  }

  const MeshFile& file_;
  const MeshReading& reading_;
  bool ignores_texture_;
  FaultList* all_faults_;
  std::vector<std::string> notes_;
  FaultList faults_;
  std::string chart_fault_;           // why the chart cannot be used
  std::vector<std::int32_t> chosen_;  // faces of the file
  bool is_charted_ = false;
  FilePlaces places_;
  FacePolygons faces_;
  FaceRepair repair_;
  std::vector<std::int32_t> vertex_of_;  // vertex of each corner of faces_
  ImportedSheet imported_;
};

}  // namespace

Result<ImportedSheet> assemble_without_chart(const MeshFile& file, const MeshReading& reading, const std::string& why,
                                             FaultList* faults) {
  Result<ImportedSheet> made = SheetAssembly(file, reading, true, faults).run();
  if (made.ok()) made->notes.insert(made->notes.begin(), "the texture coordinates cannot be used: " + why);
  return made;
}

Result<ImportedSheet> assemble(const MeshFile& file, const MeshReading& reading, FaultList* faults) {
  if (reading.version == kFirstReader) return assemble_as_first(file, reading.rest_shape);
  Result<ImportedSheet> made = SheetAssembly(file, reading, reading.ignore_texture, faults).run();
  const bool has_choice = reading.rest_shape != RestShape::kFlat;
  if (made.ok() || !made.error().reason.ends_with("_CHART") || !has_choice) return made;
  return assemble_without_chart(file, reading, made.error().message, faults);
}

}  // namespace kerf::mesh

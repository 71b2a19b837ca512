#include "server/core/mesh/build/side_joining.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <tuple>
#include <utility>

#include <Eigen/Core>
#include <Eigen/Geometry>

#include "server/base/interruption.h"
#include "server/base/sort_unique.h"
#include "server/core/mesh/ids.h"
#include "server/core/mesh/refine/box_tree.h"

namespace kerf::mesh {
namespace {

using Polygon = FacePolygons::Polygon;

// Bounds for files whose faces lie over each other many times: sides that are looked at and sides that are split, for
// each vertex of the border.
constexpr std::size_t kMostLooks = 20;
constexpr std::size_t kMostSplits = 4;
constexpr std::size_t kLooksOfAnyFile = 1'000'000;

// Returns how far along a segment a point lies, in its unit; nothing if it is farther than `tolerance` from the segment
// or within that of an end.
std::optional<double> place_along(const Eigen::Vector3d& from, const Eigen::Vector3d& to, const Eigen::Vector3d& at,
                                  double tolerance) {
  const Eigen::Vector3d side = to - from, offset = at - from;
  const double square = side.squaredNorm();
  if (!(side.cross(offset).squaredNorm() <= tolerance * tolerance * square)) return std::nullopt;
  const double length = std::sqrt(square), along = side.dot(offset) / length;
  return along > tolerance && along < length - tolerance ? std::optional(along) : std::nullopt;
}

class SideJoining {
 public:
  SideJoining(const MeshFile& file, const FilePlaces& places, FacePolygons& faces)
      : file_(file), places_(places), faces_(faces), is_charted_(!places.first_texture.empty()) {}

  void run(std::vector<std::string>& notes) {
    find_border();
    if (!find_within()) {
      notes.push_back(
          "vertices within sides of other faces are not joined to them: too many faces lie over each other");
      return;
    }
    if (!within_.empty()) split(notes);
  }

 private:
  // A side of a polygon with no polygon beyond it, from a corner to the next one.
  struct Side {
    std::int32_t low = 0;  // the lower of its two vertices
    std::int32_t high = 0;
    std::int32_t from = 0;  // corners, indices into FacePolygons::vertices
    std::int32_t to = 0;
  };

  // A vertex within a side.
  struct Within {
    std::int32_t side_from = 0;  // the corner where the side begins
    double along = 0.0;          // m, distance from there
    std::int32_t corner = 0;     // any corner at the vertex
  };

  // A vertex that became a corner of a face.
  struct Added {
    std::int32_t vertex = 0;
    std::int32_t corner = 0;  // see Within
    std::int32_t face = 0;    // of the file
  };

  [[nodiscard]] const Eigen::Vector3d& at(std::int32_t corner) const {
    return places_.positions[places_.first_position[file_.corners[faces_.file_corners[corner]].first]];
  }
  [[nodiscard]] Eigen::Vector3d in_chart(std::int32_t corner) const {
    const Eigen::Vector2d& at =
        places_.textures[places_.first_texture[file_.corners[faces_.file_corners[corner]].second]];
    return {at.x(), at.y(), 0.0};
  }

  // Finds the sides that one polygon has alone, and a corner at each of their vertices.
  void find_border() {
    std::vector<Side> sides;
    for (const Polygon& polygon : faces_.polygons) {
      interruption_point();
      for (std::int32_t i = 0; i < polygon.count; ++i) {
        const std::int32_t from = polygon.first + i, to = polygon.first + (i + 1) % polygon.count;
        const auto [low, high] = std::minmax(faces_.vertices[from], faces_.vertices[to]);
        sides.push_back({low, high, from, to});
      }
    }
    std::sort(sides.begin(), sides.end(), [](const Side& a, const Side& b) {
      return std::tie(a.low, a.high, a.from) < std::tie(b.low, b.high, b.from);
    });
    std::vector<std::pair<std::int32_t, std::int32_t>> ends;  // vertex and corner
    for (std::size_t i = 0, j = 0; i < sides.size(); i = j) {
      for (j = i; j < sides.size() && sides[j].low == sides[i].low && sides[j].high == sides[i].high;) ++j;
      if (j - i > 1) continue;
      border_.push_back(sides[i]);
      for (const std::int32_t corner : {sides[i].from, sides[i].to}) ends.emplace_back(faces_.vertices[corner], corner);
    }
    std::sort(ends.begin(), ends.end());
    for (std::size_t i = 0; i < ends.size(); ++i) {
      if (i == 0 || ends[i].first != ends[i - 1].first) border_corners_.push_back(ends[i].second);
    }
  }

  // Finds the vertices within border sides. Returns false if that would take too long.
  [[nodiscard]] bool find_within() {
    Eigen::AlignedBox3d extent;
    for (const std::int32_t corner : border_corners_) extent.extend(at(corner));
    std::array<Eigen::Index, 3> axes{0, 1, 2};  // the longest first
    std::stable_sort(axes.begin(), axes.end(),
                     [&](Eigen::Index a, Eigen::Index b) { return extent.sizes()[a] > extent.sizes()[b]; });
    const auto seen = [&](std::int32_t corner) { return Eigen::Vector2d(at(corner)[axes[0]], at(corner)[axes[1]]); };
    const Eigen::Vector2d margin = Eigen::Vector2d::Constant(2.0 * places_.position_tolerance);
    std::vector<Eigen::AlignedBox2d> boxes;
    boxes.reserve(border_.size());
    for (const Side& side : border_) {
      Eigen::AlignedBox2d box(seen(side.from));
      box.extend(seen(side.to));
      boxes.emplace_back(box.min() - margin, box.max() + margin);
      ends_.push_back({at(side.from), at(side.to)});
    }
    const BoxTree tree(std::move(boxes));
    std::size_t looks_left = kLooksOfAnyFile + kMostLooks * border_corners_.size();
    return std::all_of(border_corners_.begin(), border_corners_.end(), [&](std::int32_t corner) {
      return tree.visit_meeting(Eigen::AlignedBox2d(seen(corner)), [&](std::int32_t side) {
        interruption_point();
        look(corner, at(corner), side);
        return --looks_left > 0 && within_.size() <= kMostSplits * border_corners_.size();
      });
    });
  }

  void look(std::int32_t corner, const Eigen::Vector3d& place, std::int32_t index) {
    const auto along = place_along(ends_[index][0], ends_[index][1], place, places_.position_tolerance);
    if (!along) return;
    const Side& side = border_[index];
    if (faces_.vertices[corner] == side.low || faces_.vertices[corner] == side.high) return;
    const bool is_there = !is_charted_ || place_along(in_chart(side.from), in_chart(side.to), in_chart(corner),
                                                      places_.texture_tolerance);
    if (is_there) within_.push_back({side.from, *along, corner});
  }

  // Makes the polygons again, with the corners within their sides.
  void split(std::vector<std::string>& notes) {
    std::sort(within_.begin(), within_.end(), [](const Within& a, const Within& b) {
      return std::tie(a.side_from, a.along, a.corner) < std::tie(b.side_from, b.along, b.corner);
    });
    const std::int32_t highest = *std::max_element(faces_.vertices.begin(), faces_.vertices.end());
    std::vector<std::int32_t> user(static_cast<std::size_t>(highest) + 1, kNone);  // by vertex: its last polygon
    FacePolygons made;
    auto next = within_.begin();
    for (std::size_t p = 0; p < faces_.polygons.size(); ++p) {
      interruption_point();
      const Polygon& polygon = faces_.polygons[p];
      const std::int32_t end = polygon.first + polygon.count;
      Polygon whole{static_cast<std::int32_t>(made.vertices.size()), 0, polygon.face};
      const auto append = [&](std::int32_t corner) {
        made.vertices.push_back(faces_.vertices[corner]);
        made.file_corners.push_back(faces_.file_corners[corner]);
        user[faces_.vertices[corner]] = static_cast<std::int32_t>(p);
        ++whole.count;
      };
      for (std::int32_t c = polygon.first; c < end; ++c) user[faces_.vertices[c]] = static_cast<std::int32_t>(p);
      std::int32_t first_added = kNone;
      for (std::int32_t c = polygon.first; c < end; ++c) {
        append(c);
        double last = 0.0;  // m, along the side
        for (; next != within_.end() && next->side_from == c; ++next) {
          const bool is_apart = next->along - last > 0.5 * places_.position_tolerance;
          if (!is_apart || user[faces_.vertices[next->corner]] == static_cast<std::int32_t>(p)) continue;
          if (first_added == kNone) first_added = whole.count;
          last = next->along;
          added_.push_back({faces_.vertices[next->corner], next->corner, polygon.face});
          append(next->corner);
        }
      }
      if (whole.count > static_cast<std::int32_t>(kMaxFaceCorners) && whole.count > polygon.count) {
        notes.push_back("vertices within sides of other faces are not joined to them: " +
                        file_.face_name(static_cast<std::size_t>(polygon.face)) + " would have more than " +
                        std::to_string(kMaxFaceCorners) + " corners");
        return;
      }
      if (first_added != kNone) {
        const auto turn = [&](std::vector<std::int32_t>& values) {
          std::rotate(values.begin() + whole.first, values.begin() + whole.first + first_added, values.end());
        };
        turn(made.vertices);
        turn(made.file_corners);
      }
      made.polygons.push_back(whole);
    }
    if (added_.empty()) return;
    note(notes);
    faces_ = std::move(made);
  }

  void note(std::vector<std::string>& notes) const {
    std::vector<std::int32_t> vertices;
    for (const Added& added : added_) vertices.push_back(added.vertex);
    sort_unique(vertices);
    const Added& first = added_.front();
    const std::int32_t position = file_.corners[faces_.file_corners[first.corner]].first;
    const std::string where = file_.vertex_name(static_cast<std::size_t>(position)) + " to " +
                              file_.face_name(static_cast<std::size_t>(first.face));
    const std::string what = vertices.size() == 1 ? where + ", in whose side it lies"
                                                  : counted(vertices.size(), "vertex") +
                                                        " to the faces in whose sides they lie, first " + where;
    notes.push_back("joined " + what + "; join_m 0 (--join 0) keeps them apart");
  }

  const MeshFile& file_;
  const FilePlaces& places_;
  FacePolygons& faces_;
  bool is_charted_;
  std::vector<Side> border_;
  std::vector<std::array<Eigen::Vector3d, 2>> ends_;  // m, of each side of border_, from and to
  std::vector<std::int32_t> border_corners_;          // one for each vertex of the border
  std::vector<Within> within_;
  std::vector<Added> added_;
};

}  // namespace

void join_to_sides(const MeshFile& file, const FilePlaces& places, FacePolygons& faces,
                   std::vector<std::string>& notes) {
  if (places.is_joined) SideJoining(file, places, faces).run(notes);
}

}  // namespace kerf::mesh

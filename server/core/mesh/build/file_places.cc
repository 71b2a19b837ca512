#include "server/core/mesh/build/file_places.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include <Eigen/Geometry>

#include "server/base/interruption.h"
#include "server/core/mesh/build/coincidence.h"
#include "server/core/mesh/build/mesh_import.h"

namespace kerf::mesh {
namespace {

constexpr double kRoundedApart = 1.75;    // steps of rounding between equal places, a little over sqrt(3)
constexpr double kSameInDoubles = 1e-12;  // -; distance of equal places over the size, whatever the digits
constexpr double kMostOfEdges = 0.1;      // -; largest distance that is joined unasked, over the median edge
constexpr double kMostAsked = 0.5;        // -; the same for join_m
constexpr double kLargeSheet = 50.0;      // m; sheets beyond these sizes are mentioned
constexpr double kSmallSheet = 1e-4;      // m

Eigen::Vector3d turned(const Eigen::Vector3d& at, UpAxis up) {
  switch (up) {
    case UpAxis::kY:
      return {at.x(), -at.z(), at.y()};
    case UpAxis::kX:
      return {-at.z(), at.y(), at.x()};
    case UpAxis::kZ:
      break;
  }
  return at;
}

class Placing {
 public:
  Placing(const MeshFile& file, const MeshReading& reading, std::span<const std::int32_t> faces, bool is_charted)
      : file_(file), reading_(reading), faces_(faces), is_charted_(is_charted) {}

  FilePlaces run(std::vector<std::string>& notes, FaultList& faults) {
    convert();
    check_used(notes, faults);
    if (faults.empty()) join(faults);
    return std::move(places_);
  }

 private:
  void convert() {
    places_.positions.reserve(file_.positions.size());
    for (const Eigen::Vector3d& at : file_.positions) {
      places_.positions.push_back(
          turned(reading_.unit_m == 1.0 ? at : Eigen::Vector3d(reading_.unit_m * at), reading_.up_axis));
    }
    if (!is_charted_) return;
    for (const Eigen::Vector2d& at : file_.textures) places_.textures.emplace_back(reading_.unit_m * at);
  }

  static constexpr const char* kUnitHint =
      ", and the limit is 10000 m; if the file is not in metres, choose its unit (--unit mm), else move it to the "
      "origin";

  // Returns the reason why a place cannot be used, or nothing.
  template <typename Vector>
  [[nodiscard]] static std::string fault_of(const Vector& at, const std::string& name) {
    if (!at.allFinite()) return name + " is not finite";
    const double reach = at.cwiseAbs().maxCoeff();
    return reach <= kMaxRestCoordinate ? "" : name + " is " + length_text(reach) + " from the origin" + kUnitHint;
  }

  // Checks the places that faces use, each once, and counts the others.
  void check_used(std::vector<std::string>& notes, FaultList& faults) {
    std::vector<std::int32_t> user(file_.positions.size(), kNone);  // the first face that uses it
    std::vector<std::int32_t> texture_user(places_.textures.size(), kNone);
    const auto name = [](std::int32_t& first, std::int32_t face) { first = first == kNone ? face : first; };
    for (const std::int32_t f : faces_) {
      interruption_point();
      for (const MeshFile::Corner& corner : file_.corners_of(file_.faces[f])) {
        name(user[static_cast<std::size_t>(corner.first)], f);
        if (is_charted_) name(texture_user[static_cast<std::size_t>(corner.second)], f);
      }
    }
    const auto used_by = [&](std::int32_t face) {
      return "; " + file_.face_name(static_cast<std::size_t>(face)) + " uses it";
    };
    for (std::size_t v = 0; v < user.size(); ++v) {
      if (user[v] == kNone) continue;
      const std::string fault = fault_of(places_.positions[v], file_.vertex_name(v));
      if (!fault.empty()) faults.add(file_.refuse_vertex("NUMBER", fault + used_by(user[v]), v));
    }
    for (std::size_t v = 0; v < texture_user.size(); ++v) {
      if (texture_user[v] == kNone) continue;
      const std::string fault = fault_of(places_.textures[v], "a texture coordinate");
      if (!fault.empty()) faults.add(file_.refuse("NUMBER", fault + used_by(texture_user[v])));
    }
    const auto num_unused = static_cast<std::size_t>(std::count(user.begin(), user.end(), kNone));
    if (num_unused > 0 && faces_.size() == file_.faces.size()) {
      notes.push_back("passed over " + counted(num_unused, "vertex") + " that no face uses");
    }
  }

  // Lists the lengths of the faces' sides, in space or in the chart.
  [[nodiscard]] std::vector<double> side_lengths(bool in_chart) const {
    std::vector<double> lengths;
    for (const std::int32_t f : faces_) {
      const std::span<const MeshFile::Corner> corners = file_.corners_of(file_.faces[f]);
      for (std::size_t i = 0; i < corners.size(); ++i) {
        const MeshFile::Corner &a = corners[i], &b = corners[(i + 1) % corners.size()];
        lengths.push_back(in_chart ? (places_.in_chart(a) - places_.in_chart(b)).norm()
                                   : (places_.at(a) - places_.at(b)).norm());
      }
    }
    return lengths;
  }

  // Returns the distance that is joined, m, for numbers of this precision.
  [[nodiscard]] double tolerance(const NumberPrecision& precision, bool in_chart, double size) const {
    std::vector<double> lengths = side_lengths(in_chart);
    const double by_digits = kRoundedApart * precision.resolution() * reading_.unit_m;
    return std::min(std::max(by_digits, kSameInDoubles * size), kMostOfEdges * median(lengths));
  }

  void join(FaultList& faults) {
    places_.first_position.resize(places_.positions.size());
    std::iota(places_.first_position.begin(), places_.first_position.end(), 0);
    places_.first_texture.resize(places_.textures.size());
    std::iota(places_.first_texture.begin(), places_.first_texture.end(), 0);
    if (reading_.join_m ? *reading_.join_m == 0.0 : file_.is_kerf_export) return;
    if (reading_.join_m) {
      std::vector<double> lengths = side_lengths(false);
      const double middle = median(lengths);
      if (*reading_.join_m > kMostAsked * middle) {
        return faults.add(file_.refuse("JOIN", "joining vertices at a distance of " + length_text(*reading_.join_m) +
                                                   " would join most edges, as half of them are shorter than " +
                                                   length_text(middle)));
      }
    }
    places_.is_joined = true;
    join_positions();
    if (is_charted_) join_textures();
  }

  void join_positions() {
    Eigen::AlignedBox3d box;
    std::vector<Eigen::Vector3d> used(places_.positions.size(),
                                      Eigen::Vector3d::Constant(std::numeric_limits<double>::quiet_NaN()));
    for (const std::int32_t f : faces_) {
      for (const MeshFile::Corner& corner : file_.corners_of(file_.faces[f])) {
        used[static_cast<std::size_t>(corner.first)] = places_.at(corner);
        box.extend(places_.at(corner));
      }
    }
    const double size = box.sizes().maxCoeff();
    places_.position_tolerance = reading_.join_m.value_or(tolerance(file_.position_precision, false, size));
    places_.first_position = first_at_place(used, places_.position_tolerance);
  }

  void join_textures() {
    Eigen::AlignedBox3d box;
    std::vector<Eigen::Vector3d> used(places_.textures.size(),
                                      Eigen::Vector3d::Constant(std::numeric_limits<double>::quiet_NaN()));
    for (const std::int32_t f : faces_) {
      for (const MeshFile::Corner& corner : file_.corners_of(file_.faces[f])) {
        used[static_cast<std::size_t>(corner.second)] = places_.in_chart(corner);
        box.extend(places_.in_chart(corner));
      }
    }
    const double size = box.sizes().maxCoeff();
    places_.texture_tolerance = reading_.join_m.value_or(tolerance(file_.texture_precision, true, size));
    places_.first_texture = first_at_place(used, places_.texture_tolerance);
  }

  const MeshFile& file_;
  const MeshReading& reading_;
  std::span<const std::int32_t> faces_;
  bool is_charted_;
  FilePlaces places_;
};

}  // namespace

FilePlaces place_file(const MeshFile& file, const MeshReading& reading, std::span<const std::int32_t> faces,
                      bool is_charted, std::vector<std::string>& notes, FaultList& faults) {
  return Placing(file, reading, faces, is_charted).run(notes, faults);
}

std::vector<std::int32_t> order_on_line(std::span<const Eigen::Vector3d> corners) {
  const auto far_from = [&](const Eigen::Vector3d& from) {
    return *std::max_element(corners.begin(), corners.end(), [&](const Eigen::Vector3d& p, const Eigen::Vector3d& q) {
      return (p - from).squaredNorm() < (q - from).squaredNorm();
    });
  };
  const Eigen::Vector3d a = far_from(corners[0]), b = far_from(a);
  const Eigen::Vector3d along = b - a;
  const double allowed = kMinFlatness * along.squaredNorm();
  for (const Eigen::Vector3d& corner : corners) {
    if (along.cross(corner - a).norm() > allowed) return {};
  }
  std::vector<std::int32_t> order(corners.size());
  std::iota(order.begin(), order.end(), 0);
  std::stable_sort(order.begin(), order.end(),
                   [&](std::int32_t i, std::int32_t j) { return along.dot(corners[i]) < along.dot(corners[j]); });
  return order;
}

void note_size(const Eigen::Matrix3Xd& world, std::vector<std::string>& notes) {
  const Eigen::Vector3d extent = world.rowwise().maxCoeff() - world.rowwise().minCoeff();
  const double size = extent.maxCoeff();
  if (size > kLargeSheet) {
    notes.push_back("the sheet is " + length_text(size) + " large; if the file is in millimetres, pass --unit mm");
  } else if (size < kSmallSheet) {
    notes.push_back("the sheet is only " + length_text(size) + " large; check the unit of the file (--unit)");
  }
}

double median(std::vector<double>& lengths) {
  if (lengths.empty()) return 0.0;
  const auto middle = lengths.begin() + static_cast<std::ptrdiff_t>(lengths.size() / 2);
  std::nth_element(lengths.begin(), middle, lengths.end());
  return *middle;
}

}  // namespace kerf::mesh

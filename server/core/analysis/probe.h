#pragma once

#include <optional>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "server/base/result.h"
#include "server/core/analysis/lips.h"
#include "server/core/analysis/whole_sheet.h"
#include "server/core/linear/vertex_field.h"
#include "server/core/scene/material_point.h"
#include "server/core/scene/sheet_config.h"
#include "server/core/sheet/sheet.h"

namespace kerf::analysis {

// Measures the probes of a scene on its sheet, and follows cuts.
class Probes {
 public:
  // `requests` must be valid. Errors: kInvalidArgument POINT_OUTSIDE, UNKNOWN_VERTEX, REGION_EMPTY, with the field of
  // kerf.v1.Scene. A point of Quantity::kOpening may be on a cut that is not made yet. A region may be empty if cuts
  // are scheduled, which may bring vertices.
  static Result<Probes> create(std::vector<scene::Probe> requests, const sheet::Sheet& sheet);
  // Does the same for a sheet that is used already. If its topology has changed, a place without material is no error:
  // a cut may have removed it, and its values are NaN.
  static Result<Probes> create_live(std::vector<scene::Probe> requests, const sheet::Sheet& sheet);

  // Returns the names of the columns, such as "name.x" or "name[3].xx": one for each number that measure() appends.
  static std::vector<std::string> columns_of(const std::vector<scene::Probe>& requests);
  [[nodiscard]] const std::vector<std::string>& columns() const { return columns_; }

  // Measures the sheet as it is, and appends the values to `row`. `v_before`: velocities dt (s) earlier, 3 x V, m/s.
  // They give the acceleration of held vertices, for reactions; with dt = 0 it counts as zero. A value is NaN if its
  // place has no material any more, or an opening no lips.
  void measure(const sheet::Sheet& sheet, const linear::VertexField& v_before, double dt, std::vector<double>& row);
  // Measures the sheet as it is, with dt = 0.
  void measure(const sheet::Sheet& sheet, std::vector<double>& row);
  // Has the next measurement find all places again. To be called if the sheet is another one from then on, such as a
  // state that was saved earlier.
  void forget_places() { topology_version_ = 0; }

 private:
  // The place of one point of a probe on the present mesh.
  struct Place {
    scene::MaterialPoint point;
    mesh::TriangleId slot = mesh::kNone;              // triangle that holds the point, for strain and stress
    mesh::VertexId vertex = mesh::kNone;              // the vertex at the point, if there is one
    Eigen::Vector3d start = Eigen::Vector3d::Zero();  // m, position at the start in the world
    std::optional<LipPair> lips;
    bool exists = false;
  };
  // A vertex of the probe's region; for strain and stress with Recovery::kMean, a triangle of the region.
  struct Member {
    std::int32_t id = 0;
    double weight = 0.0;                              // weight in Reduce::kMean, relative to the other members
    Eigen::Vector3d start = Eigen::Vector3d::Zero();  // m, position of a vertex at the start in the world
  };
  struct Located {
    std::vector<Place> places;
    std::vector<Member> members;
  };
  struct Context;

  static Result<Probes> create(std::vector<scene::Probe> requests, const sheet::Sheet& sheet, bool may_be_gone);
  static Status check(const sheet::Sheet& sheet, const scene::Probe& probe, const std::string& path, bool may_be_gone);
  void locate(const sheet::Sheet& sheet);
  [[nodiscard]] static Place place_at(const sheet::Sheet& sheet, const scene::Probe& probe, const Eigen::Vector2d& at);
  [[nodiscard]] static std::vector<Member> members_of(const sheet::Sheet& sheet, const scene::Probe& probe);

  std::vector<scene::Probe> requests_;
  std::vector<std::string> columns_;
  std::vector<Located> located_;
  WholeSheet whole_sheet_;
  std::int32_t topology_version_ = 0;
};

}  // namespace kerf::analysis

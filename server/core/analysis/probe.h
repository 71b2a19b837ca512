#pragma once

#include <optional>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "server/base/result.h"
#include "server/core/analysis/lips.h"
#include "server/core/linear/vertex_field.h"
#include "server/core/scene/material_point.h"
#include "server/core/scene/sheet_config.h"
#include "server/core/sheet/sheet.h"

namespace kerf::analysis {

// Measures the probes of a scene on its sheet; follows its cuts.
class Probes {
 public:
  // `requests`: valid. Errors: kInvalidArgument with the field of kerf.v1.Scene: POINT_OUTSIDE, UNKNOWN_VERTEX,
  // REGION_EMPTY. A point of an opening may lie on a cut still to come. A region may get its vertices from a scheduled
  // cut.
  static Result<Probes> create(std::vector<sheet::Probe> requests, const sheet::Sheet& sheet);

  // "name.x", "name[3].xx", ...; as many as measure() appends.
  static std::vector<std::string> columns_of(const std::vector<sheet::Probe>& requests);
  [[nodiscard]] const std::vector<std::string>& columns() const { return columns_; }

  // Appends the values measured on the sheet as it is. v_before: 3 x V, m/s, velocities dt (s) earlier, for the forces
  // that accelerate held vertices; dt 0: without these forces. NaN where a place has no material any more, or an
  // opening no lips.
  void measure(const sheet::Sheet& sheet, const mesh::VertexField& v_before, double dt, std::vector<double>& row);

 private:
  // Location of one point on the mesh of a topology version.
  struct Place {
    sheet::MaterialPoint point;
    mesh::TriangleId slot = mesh::kNone;              // of strain and stress; or
    mesh::VertexId vertex = mesh::kNone;              // where the point is one
    Eigen::Vector3d start = Eigen::Vector3d::Zero();  // m, world
    std::optional<LipPair> lips;
    bool exists = false;
  };
  // Represents a vertex of the probe's region. For strains and stresses with Recovery::kMean it is a triangle of the
  // region instead.
  struct Member {
    std::int32_t id = 0;
    double weight = 0.0;                              // in the mean, relative to the other weights
    Eigen::Vector3d start = Eigen::Vector3d::Zero();  // m, world
  };
  struct Located {
    std::vector<Place> places;
    std::vector<Member> members;
  };
  struct Context;

  static Status check(const sheet::Sheet& sheet, const sheet::Probe& probe, const std::string& path);
  void locate(const sheet::Sheet& sheet);
  [[nodiscard]] static Place place_at(const sheet::Sheet& sheet, const sheet::Probe& probe, const Eigen::Vector2d& at);
  [[nodiscard]] static std::vector<Member> members_of(const sheet::Sheet& sheet, const sheet::Probe& probe);

  std::vector<sheet::Probe> requests_;
  std::vector<std::string> columns_;
  std::vector<Located> located_;
  std::int32_t topology_version_ = 0;
};

}  // namespace kerf::analysis

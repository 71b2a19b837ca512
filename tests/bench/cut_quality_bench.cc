// The tables of tests/bench/notes/cut-quality.md: what each way of cutting leaves of a mesh, pattern by pattern.
//   cut_quality_bench [--json FILE] [--method NAME] [--pattern TEXT]
#include <chrono>
#include <cstdio>
#include <cstring>
#include <ctime>
#include <fstream>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include "server/base/check.h"
#include "server/core/cut/cut.h"
#include "server/core/cut/cut_quality.h"
#include "server/core/mesh/build/grid_mesh.h"
#include "tests/bench/condition_number.h"
#include "tests/support/cut_patterns.h"

namespace kerf::bench {
namespace {

constexpr int kSide = 50;
constexpr double kEdgeLength = 1.0 / (kSide - 1);
constexpr int kRepeats = 5;  // of the timed cut; the least time counts

struct Method {
  const char* name;
  cut::CutOptions options;
};

std::vector<Method> methods() {
  cut::CutOptions fine;
  fine.min_angle_deg = cut::kFineMinAngle;
  cut::CutOptions still;
  still.relax = false;
  cut::CutOptions element;
  element.method = cut::Method::kElement;
  return {{"neighbourhood", {}}, {"fine", fine}, {"no relax", still}, {"element", element}};
}

struct Row {
  std::string method, mesh, pattern;
  int crossed = 0, added = 0;
  cut::CutQuality quality;  // of all that the cuts have made, corners excepted
  int below_contract = 0;   // summed over the cuts
  int corners = 0;
  double condition = 0.0;  // relative to the uncut sheet
  double microseconds = 0.0;
  double deviation = 0.0;  // of the tolerance
};

double cpu_us() {
  return 1e6 * static_cast<double>(std::clock()) / CLOCKS_PER_SEC;
}

// Cuts `mesh` and returns the sum of the reports.
Row cut_all(mesh::TriangleMesh& mesh, const test::CutPattern& pattern, const cut::CutOptions& options) {
  Row row;
  row.pattern = pattern.name;
  const double start = cpu_us();
  for (const cut::Curve& curve : pattern.curves) {
    const Result<cut::CutPlan> plan = cut::plan(mesh, {curve, options, {}});
    KERF_CHECK(plan.ok(), "the bench's cut is refused");
    const Result<cut::CutOutcome> outcome = cut::apply(mesh, *plan);
    KERF_CHECK(outcome.ok(), "the bench's cut is refused");
    const cut::CutReport& report = outcome->report;
    row.crossed += report.crossed_triangles;
    row.added += report.new_triangles;
    row.below_contract += report.quality.triangles_below_contract;
    row.corners += report.quality.num_corners;
    row.deviation = std::max(row.deviation, report.deviation_m / (options.tolerance * mesh.base_edge_length()));
  }
  row.microseconds = cpu_us() - start;
  return row;
}

// Triangles that are not in the sheet as built with the same corners.
std::vector<mesh::TriangleId> made_by_cuts(const mesh::TriangleMesh& before, const mesh::TriangleMesh& after) {
  std::vector<mesh::TriangleId> made;
  for (mesh::TriangleId t = 0; t < after.num_triangle_slots(); ++t) {
    if (!after.is_solid(t)) continue;
    bool same = t < before.num_triangle_slots() && before.points(t) == after.points(t);
    for (int k = 0; k < 3 && same; ++k) same = before.at(before.points(t)[k]) == after.at(after.points(t)[k]);
    if (!same) made.push_back(t);
  }
  return made;
}

Row measure(const mesh::TriangleMesh& sheet, double sheet_condition, const test::CutPattern& pattern,
            const Method& method) {
  mesh::TriangleMesh mesh = sheet;
  Row row = cut_all(mesh, pattern, method.options);
  for (int i = 1; i < kRepeats; ++i) {
    mesh::TriangleMesh again = sheet;
    row.microseconds = std::min(row.microseconds, cut_all(again, pattern, method.options).microseconds);
    KERF_CHECK(again.state_hash() == mesh.state_hash(), "the same cut gives the same mesh");
  }
  row.method = method.name;
  row.quality = cut::measure_quality(mesh, made_by_cuts(sheet, mesh), method.options.min_angle_deg,
                                     cut::strand_widths(mesh, method.options));
  row.condition = condition_number(mesh) / sheet_condition;
  return row;
}

void print(const Row& row) {
  const cut::CutQuality& q = row.quality;
  std::printf("%-13s %-8s %-26s %7d %6.2f %6.1f %5.1f %8.1f %5.2f %8.1f %5.2f %7.4f %5d %5d %5d %7.2f %6.2f %6.2f\n",
              row.method.c_str(), row.mesh.c_str(), row.pattern.c_str(), row.crossed,
              static_cast<double>(row.added) / row.crossed, q.min_angle_deg, q.mean_min_angle_deg, q.max_edge_ratio,
              q.mean_edge_ratio, q.max_aspect, q.mean_aspect, q.min_height_m / kEdgeLength, row.below_contract,
              q.triangles_below_angle, row.corners, row.condition, row.microseconds / row.crossed, row.deviation);
}

nlohmann::json to_json(const Row& row) {
  const cut::CutQuality& q = row.quality;
  return {{"method", row.method},
          {"mesh", row.mesh},
          {"pattern", row.pattern},
          {"crossed_triangles", row.crossed},
          {"new_triangles", row.added},
          {"min_angle_deg", q.min_angle_deg},
          {"mean_min_angle_deg", q.mean_min_angle_deg},
          {"max_edge_ratio", q.max_edge_ratio},
          {"mean_edge_ratio", q.mean_edge_ratio},
          {"max_aspect", q.max_aspect},
          {"mean_aspect", q.mean_aspect},
          {"min_height_of_edge_length", q.min_height_m / kEdgeLength},
          {"below_contract", row.below_contract},
          {"below_angle", q.triangles_below_angle},
          {"corners", row.corners},
          {"condition_of_uncut", row.condition},
          {"cpu_us", row.microseconds},
          {"deviation_of_tolerance", row.deviation}};
}

struct Arguments {
  std::string json, method, pattern;
};

int run(const Arguments& arguments) {
  std::printf("%-13s %-8s %-26s %7s %6s %6s %5s %8s %5s %8s %5s %7s %5s %5s %5s %7s %6s %6s\n", "method", "mesh",
              "pattern", "crossed", "per", "angle", "mean", "lmax/min", "mean", "lmax/h", "mean", "h_min", "miss",
              "<ang", "cornr", "kappa", "us/x", "dev");
  const std::pair<const char*, mesh::TriangleMesh> sheets[] = {
      {"grid", mesh::make_grid({kSide, kSide, 1.0, 1.0}).value()},
      {"jittered", mesh::make_jittered_grid({kSide, kSide, 1.0, 1.0}, 1).value()}};
  nlohmann::json rows = nlohmann::json::array();
  for (const Method& method : methods()) {
    if (!arguments.method.empty() && arguments.method != method.name) continue;
    for (const auto& [name, sheet] : sheets) {
      const double sheet_condition = condition_number(sheet);
      for (const test::CutPattern& pattern : test::cut_patterns(kEdgeLength)) {
        if (pattern.name.find(arguments.pattern) == std::string::npos) continue;
        Row row = measure(sheet, sheet_condition, pattern, method);
        row.mesh = name;
        print(row);
        rows.push_back(to_json(row));
      }
    }
  }
  if (!arguments.json.empty()) std::ofstream(arguments.json) << rows.dump(1) << '\n';
  return 0;
}

}  // namespace
}  // namespace kerf::bench

int main(int argc, char** argv) {
  kerf::bench::Arguments arguments;
  for (int i = 1; i + 1 < argc; i += 2) {
    if (std::strcmp(argv[i], "--json") == 0) arguments.json = argv[i + 1];
    if (std::strcmp(argv[i], "--method") == 0) arguments.method = argv[i + 1];
    if (std::strcmp(argv[i], "--pattern") == 0) arguments.pattern = argv[i + 1];
  }
  return kerf::bench::run(arguments);
}

#include "client/cli/inspect_drawing.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <string>
#include <variant>

#include "client/cli/app.h"
#include "server/base/disk.h"
#include "server/service/offline/files.h"

namespace kerf::cli {
namespace {

constexpr const char* kOwnUnit = "m";  // Default of --unit, with which a drawing keeps its own.

constexpr double kRounding = 1e-9;  // m; shorter lengths are printed as 0

std::string millimetres_of(double metres) {
  std::array<char, 32> text{};
  std::snprintf(text.data(), text.size(), "%.4g", std::abs(metres) < kRounding ? 0.0 : 1e3 * metres);
  return text.data();
}

void print_drawing(const v1::DrawingReport& report) {
  std::printf("%s", report.format().c_str());
  if (report.page_width_m() > 0.0) {
    std::printf(", page %s x %s mm", millimetres_of(report.page_width_m()).c_str(),
                millimetres_of(report.page_height_m()).c_str());
  }
  std::printf("\nto cut: %d %s, %d of them closed, %s mm long", report.lines(), report.lines() == 1 ? "line" : "lines",
              report.closed_lines(), millimetres_of(report.length_m()).c_str());
  if (report.lines() > 0) {
    std::printf("; %s x %s mm, from (%s, %s) mm", millimetres_of(report.max().x() - report.min().x()).c_str(),
                millimetres_of(report.max().y() - report.min().y()).c_str(), millimetres_of(report.min().x()).c_str(),
                millimetres_of(report.min().y()).c_str());
  }
  std::printf("\n");
  if (report.near_ends() > 0) {
    std::printf("ends that nearly meet another line: %d, the closest %s mm away; `kerf cut --join` joins them\n",
                report.near_ends(), millimetres_of(report.nearest_end_m()).c_str());
  }
  if (report.groups_size() > 0) std::printf("--only takes:\n");
  std::size_t width = 0;
  for (const v1::DrawingGroup& group : report.groups()) width = std::max(width, group.selector().size());
  for (const v1::DrawingGroup& group : report.groups()) {
    std::printf("  %-*s  %d %s, %s mm", static_cast<int>(width), group.selector().c_str(), group.shapes(),
                group.shapes() == 1 ? "shape" : "shapes", millimetres_of(group.length_m()).c_str());
    if (group.hidden_shapes() > 0) std::printf(", %d more hidden or not painted", group.hidden_shapes());
    std::printf("\n");
  }
  for (const std::string& warning : report.warnings()) std::printf("note: %s\n", warning.c_str());
}

}  // namespace

int inspect_drawing(const Session& session, const std::string& file, DrawingArguments choice, const std::string& unit) {
  if (unit != kOwnUnit) choice.unit = unit;
  Parsed<v1::DrawingReading> reading = to_reading(choice);
  if (const auto* wrong = std::get_if<UsageError>(&reading)) return misuse(wrong->message);
  RealDisk disk;
  const Result<v1::DrawingReport> report = offline::inspect_drawing(disk, file, std::get<v1::DrawingReading>(reading));
  if (!report.ok()) return refuse(report.error());
  if (session.json) {
    std::printf("%s\n", to_script_json(*report).c_str());
  } else {
    print_drawing(*report);
  }
  return kDone;
}

}  // namespace kerf::cli

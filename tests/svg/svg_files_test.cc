// 300 real drawings (tests/data/clipart) as patterns: each cuts the sheet or is refused with a reason, and the audit
// finds nothing wrong with the mesh after it. Prints what became of them; run one alone, with all checks, by
//   KERF_SVG_FILE=<part of its path> svg_tests --gtest_filter='SvgFiles.*'
#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <map>
#include <set>
#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "server/svg/svg.h"
#include "tests/audit/audited_cut.h"
#include "tests/support/meshes.h"
#include "tests/support/trials.h"

namespace kerf::svg {
namespace {

using audit::AuditedCut;
using ::testing::ElementsAre;
using ::testing::Pair;

namespace fs = std::filesystem;

std::vector<fs::path> drawings() {
  const char* only = std::getenv("KERF_SVG_FILE");
  std::vector<fs::path> files;
  for (const fs::directory_entry& entry : fs::recursive_directory_iterator(KERF_CLIPART)) {
    const std::string name = entry.path().string();
    if (entry.is_regular_file() && (only == nullptr || name.find(only) != std::string::npos)) {
      files.push_back(entry.path());
    }
  }
  std::sort(files.begin(), files.end());
  return files;
}

std::string content_of(const fs::path& file) {
  std::ifstream in(file, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), std::istreambuf_iterator<char>()};
}

struct Tally {
  std::int64_t drawings = 0, applied = 0, stopped = 0, pieces = 0, new_triangles = 0;
  std::map<std::string, int> refused;  // by reason
  std::set<std::string> not_cut;       // kinds, without their counts
};

// "SVG: 3 x text element: not cut" without the number.
std::string kind_of(const std::string& warning) {
  const std::size_t times = warning.find(" x ");
  return times == std::string::npos ? warning : warning.substr(times + 3);
}

// What the server does with the drawing: read, fitted into the sheet, cut. Every eighth is looked at more closely.
audit::Finding cut_drawing(const mesh::TriangleMesh& sheet, const std::string& text, bool closely, Tally& tally) {
  ++tally.drawings;
  Result<Drawing> drawing = read(text);
  if (!drawing.ok()) {
    ++tally.refused[drawing.error().reason];
    return std::nullopt;
  }
  for (const std::string& warning : drawing->not_cut) tally.not_cut.insert(kind_of(warning));
  cut::CutRequest request;
  request.curve = std::move(drawing->path);
  request.options.fit = cut::Fit{};
  mesh::TriangleMesh mesh = sheet;
  const AuditedCut done = cut_and_audit(mesh, request, closely ? audit::kDeepest : audit::Depth{.curve_samples = 8});
  if (done.end == AuditedCut::End::kApplied) {
    ++tally.applied;
    tally.stopped += done.outcome.report.refinement_stopped ? 1 : 0;
    tally.pieces += done.outcome.report.pieces;
    tally.new_triangles += done.outcome.report.new_triangles;
  } else {
    ++tally.refused[done.end == AuditedCut::End::kMissed ? "NO_INTERSECTION" : done.reason];
  }
  return done.flaw;
}

TEST(SvgFiles, EachIsCutOrRefusedAndNoInvariantIsBroken) {
  const std::vector<fs::path> files = drawings();
  const bool all = std::getenv("KERF_SVG_FILE") == nullptr;
  ASSERT_EQ(files.size(), all ? 300U : files.size()) << "in " << KERF_CLIPART;
  const mesh::TriangleMesh sheet = test::must(mesh::make_grid({50, 50, 1.0, 1.0}));
  Tally tally;
  // Sanitizers take one drawing in 15.
  const std::size_t stride = all ? static_cast<std::size_t>(test::num_trials({.few = 15, .usual = 1, .many = 1})) : 1;
  for (std::size_t i = 0; i < files.size(); i += stride) {
    const auto flaw = cut_drawing(sheet, content_of(files[i]), !all || i % (8 * stride) == 0, tally);
    EXPECT_EQ(flaw.value_or(""), "") << "KERF_SVG_FILE=" << files[i].lexically_relative(KERF_CLIPART).string();
  }
  std::printf("%lld drawings: %lld cut into %lld pieces with %lld new triangles, refinement stopped in %lld\n",
              static_cast<long long>(tally.drawings), static_cast<long long>(tally.applied),
              static_cast<long long>(tally.pieces), static_cast<long long>(tally.new_triangles),
              static_cast<long long>(tally.stopped));
  for (const auto& [reason, count] : tally.refused) std::printf("  %3d refused: %s\n", count, reason.c_str());
  for (const std::string& kind : tally.not_cut) std::printf("  told: %s\n", kind.c_str());
  if (!all || stride != 1) return;
  EXPECT_EQ(tally.applied, 292);
  // Five gradients without a shape, one photograph, one page of text; one drawing beyond a path's limit on segments.
  EXPECT_THAT(tally.refused, ElementsAre(Pair("CURVE_TOO_LONG", 1), Pair("SVG_EMPTY", 7)));
  EXPECT_THAT(tally.not_cut, ElementsAre("SVG: it reaches beyond its viewport; nothing was clipped",
                                         "reference to a pattern: not applied", "text element: not cut"));
}

}  // namespace
}  // namespace kerf::svg

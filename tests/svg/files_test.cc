// 300 real drawings (tests/data/clipart) as patterns: each cuts the sheet or is refused with a reason, and the audit
// finds nothing wrong with the mesh after it. Prints what became of them; run one alone, with all checks, by
//   KERF_SVG_FILE=<part of its path> svg_tests --gtest_filter='*SvgFiles.*'
#include <algorithm>
#include <cstdint>
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

#include "server/service/svg/svg.h"
#include "tests/audit/audited_cut.h"
#include "tests/support/meshes.h"
#include "tests/support/paths.h"
#include "tests/support/trials.h"
#include "tests/svg/drawn.h"

namespace kerf::svg {
namespace {

using audit::AuditedCut;
using ::testing::IsSubsetOf;

namespace fs = std::filesystem;

const fs::path kClipart = test::built_path("tests/svg/clipart");

std::vector<fs::path> drawings() {
  const char* only = std::getenv("KERF_SVG_FILE");
  std::vector<fs::path> files;
  for (const fs::directory_entry& entry : fs::recursive_directory_iterator(kClipart)) {
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
  std::map<std::string, std::string> refused;  // the reasons, by path
  std::set<std::string> not_cut;               // kinds, without their counts
};

// "SVG: 3 x text element: not cut" without the number.
std::string kind_of(const std::string& warning) {
  const std::size_t times = warning.find(" x ");
  return times == std::string::npos ? warning : warning.substr(times + 3);
}

// Processes a drawing like the server: read, fitted into the sheet, cut. Every eighth is checked more closely.
audit::Finding cut_drawing(const mesh::TriangleMesh& sheet, const fs::path& file, bool closely, Tally& tally) {
  ++tally.drawings;
  const std::string path = file.lexically_relative(kClipart).string();
  Result<Drawing> drawing = read_all(content_of(file));
  if (!drawing.ok()) {
    tally.refused[path] = drawing.error().reason;
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
    tally.refused[path] = done.end == AuditedCut::End::kMissed ? "NO_INTERSECTION" : done.reason;
  }
  return done.flaw;
}

// Five gradients without a shape, one photograph, one page of text; one drawing beyond a path's limit on segments.
const std::map<std::string, std::string> kRefused = {
    {"animals/birds/duck_yellow_ii_kurt_cagl_.svg", "SVG_EMPTY"},
    {"people/bussiness_woman_donna_i_01.svg", "CURVE_TOO_LONG"},
    {"signs_and_symbols/font_samples_revdoug_01.svg", "SVG_EMPTY"},
    {"special/gradients/gradient-apple-green.svg", "SVG_EMPTY"},
    {"special/gradients/gradient-german-flag.svg", "SVG_EMPTY"},
    {"special/gradients/gradient-navy-blue.svg", "SVG_EMPTY"},
    {"special/gradients/gradient-radial-eyeball-green.svg", "SVG_EMPTY"},
    {"special/gradients/gradient-stripes-solid-four.svg", "SVG_EMPTY"},
};
constexpr const char* kClipped = "SVG: it reaches beyond its viewport; nothing was clipped";
constexpr const char* kNothingPainted = "shape that is hidden or paints nothing: not cut";
constexpr const char* kPattern = "reference to a pattern: not applied";
constexpr const char* kText = "text element: not cut";

constexpr std::size_t kNumShares = 4;
class SvgFiles : public ::testing::TestWithParam<std::size_t> {};  // every fourth drawing, from this one on

TEST_P(SvgFiles, EachIsCutOrRefusedAndNoInvariantIsBroken) {
  const std::vector<fs::path> files = drawings();
  const bool all = std::getenv("KERF_SVG_FILE") == nullptr;
  ASSERT_EQ(files.size(), all ? 300U : files.size()) << "in " << kClipart;
  const mesh::TriangleMesh sheet = test::must(mesh::make_grid({50, 50, 1.0, 1.0}));
  Tally tally;
  std::map<std::string, std::string> to_be_refused;
  // Sanitizers take one drawing in 15.
  const std::size_t stride =
      kNumShares * static_cast<std::size_t>(all ? test::num_trials({.few = 15, .usual = 1, .many = 1}) : 1);
  for (std::size_t i = GetParam(); i < files.size(); i += stride) {
    const auto flaw = cut_drawing(sheet, files[i], !all || i % (8 * stride) == GetParam(), tally);
    EXPECT_EQ(flaw.value_or(""), "") << "KERF_SVG_FILE=" << files[i].lexically_relative(kClipart).string();
    const auto refused = kRefused.find(files[i].lexically_relative(kClipart).string());
    if (refused != kRefused.end()) to_be_refused.insert(*refused);
  }
  std::printf("%lld drawings: %lld cut into %lld pieces with %lld new triangles, refinement stopped in %lld\n",
              static_cast<long long>(tally.drawings), static_cast<long long>(tally.applied),
              static_cast<long long>(tally.pieces), static_cast<long long>(tally.new_triangles),
              static_cast<long long>(tally.stopped));
  for (const std::string& kind : tally.not_cut) std::printf("  told: %s\n", kind.c_str());
  EXPECT_EQ(tally.refused, to_be_refused);
  EXPECT_THAT(tally.not_cut, IsSubsetOf({kClipped, kNothingPainted, kPattern, kText}));
}

INSTANTIATE_TEST_SUITE_P(Share, SvgFiles, testing::Range(std::size_t{0}, kNumShares));

}  // namespace
}  // namespace kerf::svg

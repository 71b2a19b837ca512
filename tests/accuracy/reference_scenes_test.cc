// Every scene of tests/data/scenes/reference, run as `kerf run` does, against the reference it is of.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <exception>
#include <filesystem>
#include <set>

#include <gtest/gtest.h>

#include "server/core/mesh/triangle_mesh.h"
#include "tests/accuracy/expectation.h"
#include "tests/accuracy/scene_file.h"
#include "tests/support/paths.h"

namespace kerf::accuracy {
namespace {

namespace fs = std::filesystem;

fs::path data(const std::string& folder) {
  return test::source_path("tests/data") / folder;
}

std::vector<fs::path> expectations() {
  std::vector<fs::path> files;
  for (const fs::directory_entry& entry : fs::directory_iterator(data("scenes/reference"))) {
    if (entry.path().filename().string().ends_with(".expect.json")) files.push_back(entry.path());
  }
  std::sort(files.begin(), files.end());
  return files;
}

// One row of the table of tests/accuracy/errors.md.
void print(const Expectation& expectation, const CheckedQuantity& checked, int num_vertices) {
  const Comparison& worst = checked.worst();
  std::printf("| %s | %s | %s | %d | %+.2g | %.2g |\n", expectation.scene().stem().c_str(), checked.name.c_str(),
              expectation.mesh().c_str(), num_vertices, worst.error, worst.tolerance);
}

void expect_within_tolerances(const CheckedQuantity& checked) {
  for (const Comparison& one : checked.comparisons) {
    EXPECT_LE(std::abs(one.error), one.tolerance)
        << one.what << ": expected " << one.expected << ", found " << one.found;
  }
}

class ReferenceScene : public testing::TestWithParam<fs::path> {};

TEST_P(ReferenceScene, GivesTheNumbersOfItsReference) try {
  const Expectation expectation(GetParam());
  const auto done = run_scene_file(expectation.scene());
  ASSERT_TRUE(done.ok()) << done.error().field << ": " << done.error().message;
  EXPECT_TRUE(!done->result.has_static_() || done->result.static_().converged());
  EXPECT_TRUE(done->result.flagged_ticks().empty());
  for (const CheckedQuantity& checked : expectation.compare(done->result)) {
    print(expectation, checked, done->result.num_vertices());
    expect_within_tolerances(checked);
  }
} catch (const std::exception& wrong) {
  FAIL() << wrong.what();
}

INSTANTIATE_TEST_SUITE_P(Cases, ReferenceScene, testing::ValuesIn(expectations()),
                         [](const testing::TestParamInfo<fs::path>& tested) {
                           std::string name = tested.param.filename().string();
                           name.erase(name.find(".expect.json"));
                           std::replace(name.begin(), name.end(), '.', '_');
                           return name;
                         });

TEST(ReferenceScenes, ThereIsOneOfEveryReference) {
  std::set<std::string> missing;
  for (const fs::directory_entry& entry : fs::directory_iterator(data("reference"))) {
    missing.insert(entry.path().stem().string());
  }
  for (const fs::path& file : expectations()) missing.erase(Expectation(file).reference());
  EXPECT_EQ(missing, std::set<std::string>{});
}

}  // namespace
}  // namespace kerf::accuracy

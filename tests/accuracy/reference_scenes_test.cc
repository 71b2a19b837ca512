// Every scene of tests/data/scenes/reference, run as `kerf run` does, against the reference it is of.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <exception>
#include <filesystem>
#include <fstream>
#include <set>
#include <sstream>

#include <gtest/gtest.h>

#include "client/cli/scene_run.h"
#include "server/wire/scene_codec.h"
#include "tests/accuracy/expectation.h"

namespace kerf::accuracy {
namespace {

namespace fs = std::filesystem;

fs::path data(const std::string& folder) {
  return fs::path(KERF_SOURCE_DIR) / "tests/data" / folder;
}

std::vector<fs::path> expectations() {
  std::vector<fs::path> files;
  for (const fs::directory_entry& entry : fs::directory_iterator(data("scenes/reference"))) {
    if (entry.path().filename().string().ends_with(".expect.json")) files.push_back(entry.path());
  }
  std::sort(files.begin(), files.end());
  return files;
}

std::string text_of(const fs::path& file) {
  std::stringstream text;
  text << std::ifstream(file).rdbuf();
  return text.str();
}

class ReferenceScene : public testing::TestWithParam<fs::path> {};

TEST_P(ReferenceScene, GivesTheNumbersOfItsReference) try {
  const Expectation expectation(GetParam());
  const auto config = wire::decode_scene_file(text_of(expectation.scene()), [](const std::string& file) {
    return Result<std::string>(invalid_argument("NO_FILES", "a reference scene names no other file", file));
  });
  ASSERT_TRUE(config.ok()) << config.error().field << ": " << config.error().message;
  const auto run = cli::run_scene(*config, {});
  ASSERT_TRUE(run.ok()) << run.error().field << ": " << run.error().message;
  if (run->result.has_static_()) {
    EXPECT_TRUE(run->result.static_().converged()) << run->result.static_().load();
  }
  EXPECT_TRUE(run->result.flagged_ticks().empty());
  for (const CheckedQuantity& checked : expectation.compare(run->result)) {
    const Comparison& worst = checked.worst();
    std::printf("| %s | %s | %s | %d | %+.2g | %.2g |\n", expectation.scene().stem().c_str(), checked.name.c_str(),
                expectation.mesh().c_str(), run->result.num_vertices(), worst.error, worst.tolerance);
    for (const Comparison& one : checked.comparisons) {
      EXPECT_LE(std::abs(one.error), one.tolerance)
          << one.what << ": expected " << one.expected << ", found " << one.found;
    }
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

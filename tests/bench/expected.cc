#include "tests/bench/expected.h"

#include <cstdio>
#include <fstream>
#include <map>

#include <nlohmann/json.hpp>

#include "tests/support/paths.h"

namespace kerf::bench {
namespace {

const std::filesystem::path kFile = test::source_path("tests/bench/expected_hashes.json");

struct Hashes {
  std::map<std::string, std::string> by_name;
  bool update = false;
  bool differed = false;

  Hashes() {
    std::ifstream file(kFile);
    if (file) by_name = nlohmann::json::parse(file).get<std::map<std::string, std::string>>();
  }
};

Hashes& hashes() {
  static Hashes all;
  return all;
}

std::string to_hex(std::uint64_t hash) {
  char text[17];
  std::snprintf(text, sizeof text, "%016llx", static_cast<unsigned long long>(hash));
  return text;
}

}  // namespace

void expect_hash(benchmark::State& state, const std::string& name, std::uint64_t hash) {
  const std::string actual = to_hex(hash);
  if (hashes().update) {
    hashes().by_name[name] = actual;
    return;
  }
  const auto expected = hashes().by_name.find(name);
  if (expected != hashes().by_name.end() && expected->second == actual) return;
  hashes().differed = true;
  const std::string stored = expected == hashes().by_name.end() ? "none" : expected->second;
  state.SkipWithError(("the result's hash is " + actual + ", expected " + stored).c_str());
}

void set_update_mode() {
  hashes().update = true;
}

int finish() {
  if (hashes().update) std::ofstream(kFile) << nlohmann::json(hashes().by_name).dump(2) << '\n';
  return hashes().differed ? 1 : 0;
}

}  // namespace kerf::bench

// Prints the errors of a scene's numbers as JSON: {vertices, triangles, cpu_s, converged, stable, checks: [{name,
// error}]}, with the worst error of every check and its sign.
//   scene_errors EXPECTATION SCENE
// EXPECTATION: a file as in tests/data/scenes/reference; SCENE: its scene, on this mesh or another.
#include <cstdio>
#include <exception>

#include <nlohmann/json.hpp>

#include "tests/accuracy/expectation.h"
#include "tests/accuracy/scene_file.h"

namespace kerf::accuracy {
namespace {

nlohmann::ordered_json to_json(const CheckedQuantity& checked) {
  nlohmann::ordered_json all{{"name", checked.name}, {"error", checked.worst().error}};
  for (const Comparison& one : checked.comparisons) {
    all["expected"].push_back(one.expected);
    all["found"].push_back(one.found);
  }
  return all;
}

nlohmann::ordered_json errors_of(const Expectation& expectation, const v1::RunResult& result) {
  nlohmann::ordered_json all{{"vertices", result.num_vertices()}, {"cpu_s", result.cpu_s()}};
  for (const CheckedQuantity& checked : expectation.compare(result)) all["checks"].push_back(to_json(checked));
  return all;
}

int run(const char* expectation_file, const char* scene_file) try {
  const Expectation expectation(expectation_file);
  const auto done = run_scene_file(scene_file);
  if (!done.ok()) {
    std::fprintf(stderr, "scene_errors: %s: %s\n", done.error().field.c_str(), done.error().message.c_str());
    return 1;
  }
  if (done->result.has_static_() && !done->result.static_().converged()) {
    std::fprintf(stderr, "scene_errors: no equilibrium was found\n");
    return 1;
  }
  std::printf("%s\n", errors_of(expectation, done->result).dump().c_str());
  return 0;
} catch (const std::exception& wrong) {
  std::fprintf(stderr, "scene_errors: %s\n", wrong.what());
  return 1;
}

}  // namespace
}  // namespace kerf::accuracy

int main(int argc, char** argv) {
  if (argc != 3) {
    std::fprintf(stderr, "scene_errors EXPECTATION SCENE\n");
    return 2;
  }
  return kerf::accuracy::run(argv[1], argv[2]);
}

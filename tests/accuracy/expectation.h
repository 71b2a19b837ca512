#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include "kerf/v1/run.pb.h"

// Checks a scene of tests/data/scenes/reference against <scene>.expect.json, see tests/accuracy/README.md.
namespace kerf::accuracy {

// One number of the reference against one that was found.
struct Comparison {
  std::string what;  // quantity, column and row of the reference
  double expected = 0.0;
  double found = 0.0;
  double error = 0.0;      // relative, or as `tolerance` is
  double tolerance = 0.0;  // of |error|
};

// The comparisons of one check: of one quantity, or one column of a table.
struct CheckedQuantity {
  std::string name;
  std::vector<Comparison> comparisons;  // at least one
  [[nodiscard]] const Comparison& worst() const;
};

class Expectation {
 public:
  // Throws nlohmann::json::exception or std::runtime_error with what is wrong with either file.
  explicit Expectation(const std::filesystem::path& file);

  [[nodiscard]] const std::string& reference() const { return reference_id_; }
  [[nodiscard]] const std::string& mesh() const { return mesh_; }
  // The scene file beside it.
  [[nodiscard]] std::filesystem::path scene() const;
  // Throws as the constructor does.
  [[nodiscard]] std::vector<CheckedQuantity> compare(const v1::RunResult& result) const;

 private:
  [[nodiscard]] CheckedQuantity compare_one(const nlohmann::json& check, const v1::RunResult& result) const;
  [[nodiscard]] double tolerance_of(const nlohmann::json& check) const;

  std::filesystem::path file_;
  nlohmann::json json_;       // the expectation
  nlohmann::json reference_;  // the case of tests/data/reference
  std::string reference_id_;
  std::string mesh_;
};

}  // namespace kerf::accuracy

#pragma once

#include <fstream>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "server/core/fem/element/material.h"
#include "tests/support/paths.h"

namespace kerf::accuracy {

// One case of tests/data/reference, schema kerf-accuracy-reference/1: what an independent computation found, with its
// uncertainty, and what a correct code of linear triangles is expected to show on a given mesh.
class Reference {
 public:
  explicit Reference(const std::string& id) {
    std::ifstream file(test::source_path("tests/data/reference") / (id + ".json"));
    if (!file) ADD_FAILURE() << "no reference " << id;
    json_ = nlohmann::json::parse(file);
  }

  [[nodiscard]] double geometry(const std::string& name) const { return json_.at("geometry").at(name).get<double>(); }
  [[nodiscard]] const nlohmann::json& json() const { return json_; }

  [[nodiscard]] fem::Material material() const {
    const nlohmann::json& m = json_.at("material");
    fem::Material material = fem::isotropic(m.at("E").get<double>(), m.at("nu").get<double>(),
                                            m.at("thickness").get<double>(), m.at("density").get<double>());
    material.shear_modulus = m.at("G").get<double>();
    return material;
  }
  // Largest relative error allowed on a mesh: "coarse", "medium" or "fine".
  [[nodiscard]] double tolerance(const std::string& mesh) const {
    return json_.at("tolerance").at(mesh).at("rel_tol").get<double>();
  }
  [[nodiscard]] double value(const std::string& quantity) const { return find(quantity).at("value").get<double>(); }
  [[nodiscard]] std::vector<std::vector<double>> rows(const std::string& quantity) const {
    return find(quantity).at("table").at("rows").get<std::vector<std::vector<double>>>();
  }

 private:
  [[nodiscard]] const nlohmann::json& find(const std::string& quantity) const {
    for (const nlohmann::json& candidate : json_.at("quantities")) {
      if (candidate.at("name") == quantity) return candidate;
    }
    ADD_FAILURE() << "no quantity " << quantity;
    return json_;
  }

  nlohmann::json json_;
};

}  // namespace kerf::accuracy

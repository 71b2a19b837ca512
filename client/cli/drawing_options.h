#pragma once

#include <optional>
#include <string>
#include <vector>

#include <CLI/App.hpp>

#include "client/cli/arguments.h"
#include "kerf/v1/geometry.pb.h"

// Options that choose what of a drawing is read, and how large.
namespace kerf::cli {

struct DrawingArguments {
  std::vector<std::string> only;
  bool all_shapes = false;
  bool true_size = false;
  bool fit_page = false;
  std::optional<std::string> at;
  std::optional<std::string> unit;

  [[nodiscard]] bool any() const {
    return !only.empty() || all_shapes || true_size || fit_page || at.has_value() || unit.has_value();
  }
};

void add_choice_options(CLI::App& command, DrawingArguments& arguments);  // --only, --all-shapes
void add_unit_option(CLI::App& command, DrawingArguments& arguments);     // --unit
void add_place_options(CLI::App& command, DrawingArguments& arguments);   // --true-size, --at, --fit-page

Parsed<v1::DrawingReading> to_reading(const DrawingArguments& arguments);

// Parses a length: "1mm", "0.5cm", "2in", "0.001" (metres).
Parsed<double> parse_length(const std::string& text);

}  // namespace kerf::cli

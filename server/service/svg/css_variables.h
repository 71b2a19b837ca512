#pragma once

#include <cstddef>
#include <map>
#include <memory>
#include <string>

// Custom properties of CSS, such as --line, and var(), which stands for their values.
namespace kerf::svg {

using CustomProperties = std::map<std::string, std::string>;

// The custom properties that an element has: its own, and those of the elements around it.
struct Variables {
  CustomProperties own;  // Without var(); an empty value is invalid.
  std::shared_ptr<const Variables> around;

  // Returns the value; nullptr if there is none or if it is invalid.
  [[nodiscard]] const std::string* find(const std::string& name) const;
};

// Returns the variables of an element that declares `own`, with var() in them resolved. Adds to `steps` what it took.
std::shared_ptr<const Variables> variables_within(const std::shared_ptr<const Variables>& around,
                                                  const CustomProperties& own, std::size_t& steps);

// Replaces var() in a value. Returns false, and an empty value, if a variable without a fallback is missing or invalid.
bool replace_variables(std::string& value, const Variables* variables, std::size_t& steps);

}  // namespace kerf::svg

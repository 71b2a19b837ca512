#pragma once

namespace kerf {

// Joins functions into one overloaded function, for std::visit. Give one function for each alternative of the variant:
// a new alternative then does not compile until it has one.
template <typename... Functions>
struct Overloaded : Functions... {
  using Functions::operator()...;
};
template <typename... Functions>
Overloaded(Functions...) -> Overloaded<Functions...>;

}  // namespace kerf

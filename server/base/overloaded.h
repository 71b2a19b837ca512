#pragma once

namespace kerf {

// Joins functions into one, for std::visit with a function for each alternative of a variant: a new alternative does
// not compile until it has one.
template <typename... Functions>
struct Overloaded : Functions... {
  using Functions::operator()...;
};
template <typename... Functions>
Overloaded(Functions...) -> Overloaded<Functions...>;

}  // namespace kerf

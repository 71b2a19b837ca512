#pragma once

namespace kerf::faults {

// The fault that is switched on, counted from 1; 0 is none.
inline int switched_on = 0;

inline bool active(int number) {
  return switched_on == number;
}

// True every `period`-th time that it is asked.
template <int period>
bool now_and_then() {
  static int count = 0;
  return ++count % period == 0;
}

}  // namespace kerf::faults

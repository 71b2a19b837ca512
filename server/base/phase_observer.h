#pragma once

namespace kerf {

// Receives the phase changes of an operation, so that its caller can time them: the code that does the work reads no
// clock.
class PhaseObserver {
 public:
  virtual ~PhaseObserver() = default;
  // The phase before, if any, has ended. `phase`: a literal, for people.
  virtual void enter(const char* phase) = 0;
};

inline void enter_phase(PhaseObserver* observer, const char* phase) {
  if (observer != nullptr) observer->enter(phase);
}

}  // namespace kerf

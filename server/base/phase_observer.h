#pragma once

namespace kerf {

// Receives the phase changes of an operation, so that its caller can time them. The code that does the work reads no
// clock.
class PhaseObserver {
 public:
  virtual ~PhaseObserver() = default;
  // Begins a phase; the previous one, if any, ends. `phase`: its name for people, a string literal.
  virtual void enter(const char* phase) = 0;
};

inline void enter_phase(PhaseObserver* observer, const char* phase) {
  if (observer != nullptr) observer->enter(phase);
}

}  // namespace kerf

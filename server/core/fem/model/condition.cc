#include "server/core/fem/model/condition.h"

#include <array>
#include <cstdio>

#include "server/core/fem/model/model.h"

namespace kerf::fem {

double condition_number(const Model& model, double dt) {
  return 1.0 + dt * dt * model.stiffness_bound().value();
}

ConditionClass rate_condition(double condition) {
  if (condition <= kMostAccurateCondition) return ConditionClass::kAccurate;
  return condition <= kMostBoundedCondition ? ConditionClass::kBounded : ConditionClass::kRefused;
}

std::string describe_condition(double condition) {
  constexpr std::array<const char*, 3> kClasses{"A (accurate)", "B (bounded, not accurate)",
                                                "C (beyond double precision)"};
  std::array<char, 80> text{};
  std::snprintf(text.data(), text.size(), "condition number %.1e, class %s", condition,
                kClasses[static_cast<std::size_t>(rate_condition(condition))]);
  return text.data();
}

}  // namespace kerf::fem

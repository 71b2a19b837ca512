#pragma once

#include <string>

namespace kerf::fem {

class Model;

// Accuracy that double precision allows for a step. The smallest relative residual that a solver can reach is about
// 1e-18 times the condition number.
enum class ConditionClass {
  kAccurate,  // A: up to kMostAccurateCondition
  kBounded,   // B: up to kMostBoundedCondition; finite and bounded, without digits to rely on
  kRefused,   // C: above kMostBoundedCondition
};
inline constexpr double kMostAccurateCondition = 1e12;  // -
inline constexpr double kMostBoundedCondition = 1e16;   // -

// Returns an upper bound of the condition number of M^-1 (M + dt^2 K), -, with K at rest. It is 1 + dt^2 times the
// StiffnessBound of the largest eigenvalue of M^-1 K. dt: s, > 0.
double condition_number(const Model& model, double dt);

ConditionClass rate_condition(double condition);

// Describes the condition for people: "condition number 3.1e+05, class A (accurate)".
std::string describe_condition(double condition);

}  // namespace kerf::fem

#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <ostream>
#include <string>
#include <vector>

#include "server/fem/condition.h"
#include "server/fem/integrator.h"
#include "server/mesh/triangle_mesh.h"

// The stability matrix: starts that no sheet should be in, times stiffness, step and aspect ratio, each run for many
// steps with the integrator that users get by default.
namespace kerf::stability {

struct Start {
  std::string name;
  mesh::TriangleMesh mesh;
  fem::State state;
  fem::Loads loads;  // with gravity only where something is pinned
};

// By name; `aspect` >= 1: width of the sheet, 1 m, over its height.
struct StartKind {
  const char* name;
  std::function<Start(double aspect)> make;
};
const std::vector<StartKind>& start_kinds();

struct Case {
  std::size_t start = 0;          // into start_kinds()
  double youngs_modulus = 1.0e6;  // Pa
  double poissons_ratio = 0.3;    // -; 0.63 with a shear modulus of its own, else isotropic
  double dt = 1.0 / 60.0;         // s
  double aspect = 1.0;            // -
  fem::Precision precision = fem::IntegratorOptions().precision;

  [[nodiscard]] std::string name() const;
};
void PrintTo(const Case& tested, std::ostream* out);

// kPerStart cases of each start, spread over stiffness {1 .. 1e12 Pa}, dt {1e-4 .. 1 s} and aspect ratio {1 .. 9e5} by
// a fixed shuffle: the first ones of a start are as good a sample as any.
inline constexpr std::size_t kPerStart = 48;
std::vector<Case> matrix(std::size_t per_start = kPerStart);

struct Outcome {
  double condition = 1.0;  // -, 1 + dt^2 lambda_max(M^-1 K), an upper bound
  bool finite = true;      // in every step
  double gain = 0.0;       // -, highest energy over that of the start, less 1; of m g 1 m where the start has none
  double drift = 0.0;      // -, of the centre of mass off its ballistic path, over the size and what it has gone
  std::array<int, fem::kStepFlagNames.size()> flags{};  // steps with each
  bool is_explicit = false;
  std::string integrator;
};
// Ends before num_steps once kMostSubsteps are done, which stiff ticks are divided into, or kMostVertexSteps, which is
// some 30 steps after 200 cuts.
inline constexpr long kMostVertexSteps = 60'000;
inline constexpr long kMostSubsteps = 50'000;
Outcome run(const Case& tested, int num_steps);

}  // namespace kerf::stability

#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <limits>
#include <ostream>
#include <string>
#include <vector>

#include "server/core/fem/element/loads.h"
#include "server/core/fem/element/state.h"
#include "server/core/fem/model/condition.h"
#include "server/core/fem/step/integrator.h"
#include "server/core/mesh/triangle_mesh.h"

// Defines the stability matrix: bad initial states, each combined with stiffness, step and aspect ratio. Each case runs
// for many steps with the integrator that users get by default.
namespace kerf::stability {

struct Start {
  std::string name;
  mesh::TriangleMesh mesh;
  fem::State state;
  fem::Loads loads;                      // with gravity only if something is pinned
  std::vector<double> densities{300.0};  // kg/m^3, by region of the mesh
};

// Makes a start. `aspect` >= 1: width of the sheet, which is 1 m, over its height.
struct StartKind {
  const char* name;
  std::function<Start(double aspect)> make;
};
const std::vector<StartKind>& start_kinds();

struct Case {
  std::size_t start = 0;          // index into start_kinds()
  double youngs_modulus = 1.0e6;  // Pa
  double poissons_ratio = 0.3;    // -; above 0.5 with a separate shear modulus, else isotropic
  double dt = 1.0 / 60.0;         // s
  double aspect = 1.0;            // -
  fem::Precision precision = fem::IntegratorOptions().precision;
  fem::IntegratorKind kind = fem::IntegratorKind::kAutomatic;
  int newton_iterations = 0;  // per solve; 0: as for a new sheet

  [[nodiscard]] std::string name() const;
};
void PrintTo(const Case& tested, std::ostream* out);

// Cases of each start, spread over stiffness {1 .. 1e12 Pa}, dt {1e-4 .. 1 s} and aspect ratio {1 .. 9e5}. Their order
// is a fixed shuffle, so that the first cases of a start are a fair sample.
inline constexpr std::size_t kPerStart = 48;
std::vector<Case> matrix(std::size_t per_start = kPerStart);

struct Outcome {
  double condition = 1.0;  // -, 1 + dt^2 lambda_max(M^-1 K), an upper bound
  bool finite = true;      // true if every step had finite results
  double gain = 0.0;       // -, highest energy minus initial energy, over the larger of the initial energy and m g 1 m
  double drift = 0.0;      // -, distance of the centre of an unpinned sheet from uniform motion, over 1 m + size + path
  std::array<int, fem::kStepFlagNames.size()> flags{};  // number of steps with each flag
  int num_steps = 0;                                    // steps done
  long num_substeps = 0;                                // substeps of these steps
  double simulated = 0.0;                               // s, time by which the steps advanced the sheet
  bool is_explicit = false;
  std::string integrator;
};

// Limits at which a run ends early; Outcome::num_steps has the steps done.
struct Budget {
  long vertex_steps = std::numeric_limits<long>::max();  // number of steps times number of vertices
  long substeps = std::numeric_limits<long>::max();      // of all steps together
};
// Budget of the cases of the matrix: 1,666 steps of a grid, some 30 of a sheet after 200 cuts.
inline constexpr Budget kMatrixBudget{60'000, 50'000};
Outcome run(const Case& tested, int num_steps, const Budget& budget);

}  // namespace kerf::stability

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

// The stability matrix: starts that no sheet should be in, times stiffness, step and aspect ratio. Each case runs for
// many steps with the integrator that users get by default.
namespace kerf::stability {

struct Start {
  std::string name;
  mesh::TriangleMesh mesh;
  fem::State state;
  fem::Loads loads;                      // with gravity only where something is pinned
  std::vector<double> densities{300.0};  // kg/m^3, by region of the mesh
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
  fem::IntegratorKind kind = fem::IntegratorKind::kAutomatic;
  int newton_iterations = 0;  // a solve; 0: as a new sheet has it

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
  double gain = 0.0;       // -, highest energy less that of the start, over the larger of that and m g 1 m
  double drift = 0.0;      // -, of the centre of mass off its ballistic path, over the size and what it has gone
  std::array<int, fem::kStepFlagNames.size()> flags{};  // steps with each
  int num_steps = 0;                                    // done
  long num_substeps = 0;                                // that they were divided into
  double simulated = 0.0;                               // s, that they advanced the sheet by
  bool is_explicit = false;
  std::string integrator;
};

// Limits at which a run ends before its num_steps are done; see Outcome::num_steps.
struct Budget {
  long vertex_steps = std::numeric_limits<long>::max();  // steps times vertices
  long substeps = std::numeric_limits<long>::max();      // that stiff steps are divided into
};
// Budget of the cases of the matrix: 1,666 steps of a grid, some 30 of a sheet after 200 cuts.
inline constexpr Budget kMatrixBudget{60'000, 50'000};
Outcome run(const Case& tested, int num_steps, const Budget& budget);

}  // namespace kerf::stability

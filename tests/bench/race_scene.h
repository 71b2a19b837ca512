#pragma once

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "server/core/fem/element/loads.h"
#include "server/core/fem/element/state.h"
#include "server/core/fem/model/model.h"
#include "server/core/fem/step/integrator.h"
#include "server/core/mesh/triangle_mesh.h"

// The scene of tests/bench/notes/race.md.
namespace kerf::bench {

inline constexpr double kTick = 1.0 / 60.0;  // s

// E h = 1000 N/m, 0.2 kg/m^2; no damping.
fem::Material cloth();

// A square of 1 m, side x side vertices.
mesh::TriangleMesh grid(int side);
// The same with 20 kirigami slits.
mesh::TriangleMesh cut_grid(int side);

// Pinned along the upper edge, at rest; flat, horizontal or hanging.
struct Scene {
  Scene(mesh::TriangleMesh sheet, double drag, bool hangs, fem::MembraneLaw law = fem::MembraneLaw::kCorotational,
        const fem::Material& material = cloth());

  mesh::TriangleMesh mesh;
  double air_drag;  // 1/s, >= 0: the material's mass_damping
  fem::Model model;
  fem::State state;
  fem::Loads loads;
};

// One program, or one setting of it, that carries a sheet on in time.
class Contender {
 public:
  virtual ~Contender() = default;
  virtual void tick() = 0;                                       // by kTick
  [[nodiscard]] virtual Eigen::Matrix3Xd positions() const = 0;  // 3 x V, m
};

struct Entry {
  std::string program;
  std::string setting;
  std::function<std::unique_ptr<Contender>(const Scene& scene)> enter;
};

fem::IntegratorOptions explicit_options(fem::Precision precision);
// In double with a tenth of the stable step, no damping, and bending in each substep.
fem::IntegratorOptions reference_options();
// `newton_iterations`: of a solve, at most; 1 with implicit Euler is the source's scheme.
fem::IntegratorOptions implicit_options(fem::IntegratorKind kind, int newton_iterations,
                                        linear::LinearSolverKind solver);

// Kerf's, with any integrator.
std::unique_ptr<Contender> make_own(const Scene& scene, const fem::IntegratorOptions& options);

}  // namespace kerf::bench

#pragma once

#include <vector>

#include <Eigen/Core>

#include "server/base/stop_condition.h"
#include "server/core/fem/element/loads.h"
#include "server/core/fem/model/model.h"
#include "server/core/fem/model/tangent_matrix.h"
#include "server/core/linear/vertex_field.h"

namespace kerf::fem {

inline constexpr int kMaxModes = 200;

struct Modes {
  // rad^2/s^2, ascending: eigenvalues omega^2 of K u = omega^2 M u. If one is negative the sheet would leave this state
  // by itself (buckling). If one is within 1e-9 of 0, relative to the largest of the model, it belongs to a mechanism
  // or a rigid body motion.
  Eigen::VectorXd eigenvalues;
  Eigen::MatrixXd shapes;  // 3 V x number of modes; column i has x, y, z of all vertices in turn, scaled to shape.M
                           // shape = 1
  bool converged = false;  // true if all modes converged
  bool stopped = false;    // true if `stop` ended the search: there are no modes
};

// Returns the number of components of vertices with material that no pin holds.
int num_free_components(const Model& model, const Loads& loads);

// Finds the lowest `count` vibrations about a state x (3 x V, m), usually an equilibrium. `count` is 1..kMaxModes, and
// at most the free components less one. The stiffness is the exact tangent there, with held components fixed and only
// the symmetric part of pressure and moments. The masses are lumped within the sheet and half consistent across it.
// Frequencies converge with second order, as with the masses of time steps, but are more accurate. Uses the Lanczos
// method on the shifted inverse (Spectra). `stop` is polled once for each Lanczos vector, some milliseconds apart on a
// large sheet.
Modes find_modes(const Model& model, const Loads& loads, const linear::VertexField& x, int count,
                 const StopCondition& stop = {});

}  // namespace kerf::fem

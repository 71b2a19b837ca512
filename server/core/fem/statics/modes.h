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
  // rad^2/s^2, ascending: eigenvalues of K u = omega^2 M u. Negative: the sheet would leave this state by itself
  // (buckling). About 0, within 1e-9 of the largest of the whole model: a mechanism or a rigid body motion.
  Eigen::VectorXd eigenvalues;
  Eigen::MatrixXd shapes;  // 3 V x count, column i has x, y, z of all vertices in turn; shape.M shape = 1
  bool converged = false;  // all modes converged
  bool stopped = false;    // stopped early: there are no modes
};

// Returns the number of components of vertices with material that no pin holds.
int num_free_components(const Model& model, const Loads& loads);

// Finds the lowest `count` vibrations about a state x (3 x V, m), usually an equilibrium. `count` is 1..kMaxModes, and
// at most the free components less one. The stiffness is the exact tangent there, with held components fixed and only
// the symmetric part of pressure and moments. The masses are lumped within the sheet and half consistent across it.
// They are of second order like those of time steps, but more accurate. Uses the Lanczos method on the shifted inverse
// (Spectra). `stop` is polled once for each Lanczos vector, some milliseconds apart on a large sheet.
Modes find_modes(const Model& model, const Loads& loads, const linear::VertexField& x, int count,
                 const StopCondition& stop = {});

}  // namespace kerf::fem

#pragma once

#include <functional>
#include <vector>

#include <Eigen/Core>

#include "server/core/fem/element/loads.h"
#include "server/core/fem/model/model.h"
#include "server/core/fem/model/tangent_matrix.h"
#include "server/core/linear/vertex_field.h"

namespace kerf::fem {

inline constexpr int kMaxModes = 200;

struct Modes {
  // rad^2/s^2, ascending: eigenvalues of K u = omega^2 M u. Negative: the sheet would leave this state by itself
  // (buckling); about 0, within 1e-9 of the largest of the whole model: it moves as a mechanism or a rigid body.
  Eigen::VectorXd eigenvalues;
  Eigen::MatrixXd shapes;  // 3 V x count, column i of x, y, z of all vertices in turn; shape.M shape = 1
  bool converged = false;  // all of them
  bool stopped = false;    // before it was done: there are none
};

// Components of vertices with material that no pin holds.
int num_free_components(const Model& model, const Loads& loads);

// The lowest `count` (1..kMaxModes, at most the free components less one) vibrations about a state x (3 x V, m), most
// often an equilibrium: of the exact tangent stiffness there, with what the pins hold held; of pressure and moments the
// symmetric part. The masses are lumped
// within the sheet and half consistent across it: of second order like those that steps are taken with, but nearer. By
// the Lanczos method on the shifted inverse (Spectra). `goes_on` is asked once a vector of it, some milliseconds on a
// large sheet: false stops the search.
Modes find_modes(const Model& model, const Loads& loads, const mesh::VertexField& x, int count,
                 const std::function<bool()>& goes_on = {});

}  // namespace kerf::fem

#include "tests/bench/race_one_solve.h"

#include "server/core/fem/element/membrane.h"
#include "server/core/fem/element/vertex_frames.h"
#include "server/core/fem/model/tangent_matrix.h"
#include "server/core/linear/linear_solver.h"

namespace kerf::bench {
namespace {

constexpr double kTolerance = 1e-4;  // -, as fem::IntegratorOptions has it
constexpr int kMaxIterations = 10'000;

class OneSolve : public fem::Integrator {
 public:
  explicit OneSolve(linear::LinearSolverKind solver) : solver_(linear::make_linear_solver(solver, kMaxIterations)) {}

  void rebuild(const fem::Model& model) override {
    tangent_.rebuild(model);
    solver_->analyse(tangent_.blocks());
    const auto num_vertices = static_cast<Eigen::Index>(model.mass().size());
    for (linear::VertexField* field : {&force_, &scratch_, &ballistic_, &rhs_, &departure_})
      field->resize(num_vertices);
  }

  fem::StepStats step(const fem::Model& model, const fem::Loads& loads, double dt, fem::ContactConstraint* /*contact*/,
                      fem::State& state) override {
    const fem::MaterialScale scale{dt * dt, dt, {}};
    tangent_.set_mass(model, 1.0, dt);
    tangent_.add_membrane(model, state.x, {}, scale, dt * dt, true);
    tangent_.add_bending(model, scale);
    force_.setZero();
    fem::add_membrane_forces(model.element_blocks(), model.materials(), {}, state.x, state.v, force_);
    model.bending().add_forces(model.element_blocks(), state.x, state.v, {}, scratch_, force_);
    ballistic_ = dt * state.v;
    tangent_.blocks().multiply(ballistic_, rhs_);
    for (Eigen::Index v = 0; v < rhs_.cols(); ++v) {
      const double m = model.mass()[static_cast<std::size_t>(v)];
      rhs_.col(v) = m * (ballistic_.col(v) + dt * dt * loads.gravity) + dt * dt * force_.col(v) - rhs_.col(v);
    }
    departure_.setZero();
    tangent_.constrain(model, loads.pins, 0.0, state.x, rhs_, departure_);
    if (std::vector<Eigen::Matrix3d>* frames = solver_->frames()) {
      frames->resize(model.mass().size());
      fem::find_vertex_frames(model.element_blocks(), state.x, *frames);
    }
    const linear::LinearStats solved = solver_->solve(tangent_.blocks(), rhs_, kTolerance, departure_);
    scratch_ = ballistic_ + departure_;
    state.x += scratch_;
    state.v = scratch_ / dt;

    fem::StepStats stats;
    stats.flags = solved.converged ? fem::kNoFlags : fem::kNotConverged;
    stats.substeps = 1;
    stats.newton_iterations = 1;
    stats.linear_iterations = solved.iterations;
    stats.linear_residual = solved.residual;
    stats.simulated = dt;
    return stats;
  }

  [[nodiscard]] std::string_view explanation() const override { return "implicit Euler with one linear solve a step"; }
  [[nodiscard]] fem::IntegratorKind kind() const override { return fem::IntegratorKind::kImplicitEuler; }

 private:
  std::unique_ptr<linear::LinearSolver> solver_;
  fem::TangentMatrix tangent_;
  linear::VertexField force_, scratch_;              // 3 x V, N; none
  linear::VertexField ballistic_, rhs_, departure_;  // 3 x V, m; kg m; m
};

}  // namespace

std::unique_ptr<fem::Integrator> make_one_solve(linear::LinearSolverKind solver) {
  return std::make_unique<OneSolve>(solver);
}

}  // namespace kerf::bench

#pragma once

#include <memory>
#include <utility>

#include "server/core/fem/step/integrator.h"
#include "server/core/sheet/sheet.h"

namespace kerf::sheet {

// An integrator that can be copied: a copy is a new integrator of the same kind, which must be rebuilt before its first
// step. Integrators keep no history, so nothing is lost.
class OwnedIntegrator {
 public:
  OwnedIntegrator(IntegratorFactory make, const fem::IntegratorOptions& options)
      : make_(std::move(make)), options_(options), integrator_(make_(options)) {}
  OwnedIntegrator(const OwnedIntegrator& other) : OwnedIntegrator(other.make_, other.options_) {}
  OwnedIntegrator& operator=(const OwnedIntegrator& other) = delete;
  OwnedIntegrator(OwnedIntegrator&&) noexcept = default;
  OwnedIntegrator& operator=(OwnedIntegrator&&) noexcept = default;
  ~OwnedIntegrator() = default;

  // Sets whether self-contact is on, see fem::IntegratorOptions. After a change the integrator is a new one, which must
  // be rebuilt before its first step.
  void set_touches_itself(bool touches_itself) {
    if (touches_itself == options_.touches_itself) return;
    options_.touches_itself = touches_itself;
    integrator_ = make_(options_);
  }

  fem::Integrator& operator*() const { return *integrator_; }
  fem::Integrator* operator->() const { return integrator_.get(); }

 private:
  IntegratorFactory make_;
  fem::IntegratorOptions options_;
  std::unique_ptr<fem::Integrator> integrator_;
};

}  // namespace kerf::sheet

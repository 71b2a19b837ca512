#pragma once

#include <memory>
#include <utility>

#include "server/core/fem/step/integrator.h"
#include "server/core/sheet/sheet.h"

namespace kerf::sheet {

// An integrator that is copied by making a new one of the same kind, to be rebuilt before its first step. Nothing is
// lost: integrators keep no history.
class OwnedIntegrator {
 public:
  OwnedIntegrator(IntegratorFactory make, const fem::IntegratorOptions& options)
      : make_(std::move(make)), options_(options), integrator_(make_(options)) {}
  OwnedIntegrator(const OwnedIntegrator& other) : OwnedIntegrator(other.make_, other.options_) {}
  OwnedIntegrator& operator=(const OwnedIntegrator& other) = delete;
  OwnedIntegrator(OwnedIntegrator&&) noexcept = default;
  OwnedIntegrator& operator=(OwnedIntegrator&&) noexcept = default;
  ~OwnedIntegrator() = default;

  fem::Integrator& operator*() const { return *integrator_; }
  fem::Integrator* operator->() const { return integrator_.get(); }

 private:
  IntegratorFactory make_;
  fem::IntegratorOptions options_;
  std::unique_ptr<fem::Integrator> integrator_;
};

}  // namespace kerf::sheet

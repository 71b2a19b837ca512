#pragma once

#include <functional>
#include <memory>
#include <string>
#include <utility>

#include "server/service/host/host.h"
#include "server/service/host/sheet_runner.h"

// Defines Host::on_strand() for the sources of Host.
namespace kerf::host {

template <typename T>
void Host::on_strand(const std::string& id, const Callback<T>& done, std::function<void(SheetRunner&)> work) {
  const std::shared_ptr<SheetRunner> runner = find(id);
  if (!runner) return done(missing(id));
  runner->post(std::move(work), [done](Error error) { done(std::move(error)); });
}

}  // namespace kerf::host

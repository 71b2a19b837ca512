#include <memory>
#include <utility>

#include "server/base/interruption.h"
#include "server/service/api/api.h"
#include "server/service/api/core.h"
#include "server/service/wire/mesh_report_codec.h"

namespace kerf::api {

void Api::inspect_mesh(const v1::InspectMeshRequest& request, Reply<v1::MeshReport> reply, std::stop_token stop) {
  inspect_mesh(v1::InspectMeshRequest(request), std::move(reply), std::move(stop));
}

void Api::inspect_mesh(v1::InspectMeshRequest&& request, Reply<v1::MeshReport> reply, std::stop_token stop) {
  if (core_->stopping) return reply(server_stopping());
  const auto copy = std::make_shared<v1::InspectMeshRequest>(std::move(request));
  const auto work = [core = core_, copy, stop = std::move(stop)]() -> Result<v1::MeshReport> {
    const InterruptionScope scope([&] { return stop.stop_requested() || core->stopping; });
    try {
      return wire::inspect_mesh(std::move(*copy));
    } catch (const Interrupted&) {
      return server_stopping();  // The answer is read by no caller if it was the caller that stopped.
    }
  };
  in_background<v1::MeshReport>(core_->analysis_worker, reply, work, too_many_analyses(*core_));
}

}  // namespace kerf::api

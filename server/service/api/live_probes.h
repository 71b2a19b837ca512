#pragma once

#include <cstddef>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "google/protobuf/repeated_ptr_field.h"
#include "kerf/v1/analysis.pb.h"
#include "server/core/analysis/probe.h"
#include "server/service/api/core.h"
#include "server/service/stream/meter.h"

namespace kerf::api {

// Limits on the probes of one stream or of one call of StepSheets.
inline constexpr std::size_t kMaxLiveValues = 1024;  // Values of all probes together.
inline constexpr std::size_t kMaxLivePoints = 1024;  // Points of all probes together.

// Decodes and validates the probes that measure a live sheet. `path`: begins the fields of errors, such as "start.".
// kInvalidArgument, also TOO_MANY_VALUES, TOO_MANY_POINTS.
Result<std::vector<scene::Probe>> decode_live_probes(const google::protobuf::RepeatedPtrField<v1::Probe>& messages,
                                                     const std::string& path);

// Measures the probes of one stream. Held vertices count as not accelerating.
class LiveProbes final : public stream::Meter {
 public:
  LiveProbes(analysis::Probes probes, std::uint64_t serial) : probes_(std::move(probes)), serial_(serial) {}

  std::vector<double> measure(const sheet::Sheet& sheet, std::uint64_t serial) override;
  [[nodiscard]] const std::vector<std::string>& columns() const override { return probes_.columns(); }

 private:
  analysis::Probes probes_;
  std::uint64_t serial_;
};

// Finds the places of probes on a sheet, between two ticks. Errors: those of Probes::create_live(), with `path` before
// the field; those of the host.
void make_live_probes(const std::shared_ptr<ApiCore>& core, const std::string& sheet_id,
                      std::vector<scene::Probe> probes, const std::string& path,
                      std::function<void(Result<std::shared_ptr<stream::Meter>>)> done);

}  // namespace kerf::api

#include "server/service/api/live_probes.h"

#include <optional>
#include <utility>

#include "server/service/wire/analysis_codec.h"

namespace kerf::api {
namespace {

Error below(const std::string& path, Error error) {
  if (error.code == ErrorCode::kInvalidArgument) error.field = path + error.field;
  return error;
}

Error too_many(const char* reason, std::size_t count, const char* what, std::size_t limit, const std::string& path) {
  return invalid_argument(
      reason,
      "the probes have " + std::to_string(count) + " " + what + " in all; the limit is " + std::to_string(limit),
      path + "probes");
}

}  // namespace

Result<std::vector<scene::Probe>> decode_live_probes(const google::protobuf::RepeatedPtrField<v1::Probe>& messages,
                                                     const std::string& path) {
  Result<std::vector<scene::Probe>> probes = wire::decode_probes(messages);
  if (!probes.ok()) return below(path, probes.error());
  if (const Status valid = scene::validate(*probes); !valid.ok()) return below(path, valid.error());
  std::size_t points = 0;
  for (const scene::Probe& probe : *probes) points += probe.points.size();
  if (points > kMaxLivePoints) return too_many("TOO_MANY_POINTS", points, "points", kMaxLivePoints, path);
  const std::size_t values = analysis::Probes::columns_of(*probes).size();
  if (values > kMaxLiveValues) return too_many("TOO_MANY_VALUES", values, "values", kMaxLiveValues, path);
  return probes;
}

std::vector<double> LiveProbes::measure(const sheet::Sheet& sheet, std::uint64_t serial) {
  if (std::exchange(serial_, serial) != serial) probes_.forget_places();
  std::vector<double> values;
  values.reserve(columns().size());
  probes_.measure(sheet, values);
  return values;
}

void make_live_probes(const std::shared_ptr<ApiCore>& core, const std::string& sheet_id,
                      std::vector<scene::Probe> probes, const std::string& path,
                      std::function<void(Result<std::shared_ptr<stream::Meter>>)> done) {
  using Made = std::shared_ptr<stream::Meter>;
  using Found = std::shared_ptr<Result<Made>>;
  inspect<Found>(
      core, sheet_id,
      [probes = std::move(probes), path](const sheet::Sheet& sheet) -> Found {
        Result<analysis::Probes> located = analysis::Probes::create_live(probes, sheet);
        if (!located.ok()) return std::make_shared<Result<Made>>(below(path, located.error()));
        // The first measurement finds the places again, since no sheet has the serial 0.
        return std::make_shared<Result<Made>>(std::make_shared<LiveProbes>(std::move(*located), 0));
      },
      "",
      [done = std::move(done)](const Result<Found>& found) {
        done(found.ok() ? **found : Result<Made>(found.error()));
      });
}

}  // namespace kerf::api

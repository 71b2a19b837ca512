#include <memory>
#include <utility>
#include <variant>

#include "kerf/v1/sheets.pb.h"
#include "server/base/overloaded.h"
#include "server/core/analysis/analysis.h"
#include "server/core/analysis/probe.h"
#include "server/core/fem/element/state.h"
#include "server/service/api/core.h"
#include "server/service/wire/analysis_codec.h"
#include "server/service/wire/reply_codec.h"

// Implements SheetService.AnalyzeSheet.
namespace kerf::api {
namespace {

constexpr std::int64_t kMaxMeasuredNumbers = 2'000'000;  // Numbers in the table of a dynamic analysis: 16 MB.

struct Request {
  std::string name;
  scene::Analysis analysis;
  std::vector<scene::Probe> probes;
  bool wants_scene_probes = true;
  bool wants_positions = false;
};

Result<Request> decode(const v1::AnalyzeSheetRequest& message) {
  Request request;
  request.name = message.name();
  KERF_TRY_ASSIGN(request.analysis, wire::decode_analysis(message.analysis()));
  if (message.analysis().kind_case() == v1::Analysis::KIND_NOT_SET) {
    return invalid_argument("CHOICE_MISSING", "analysis must be dynamic, static or modes", "analysis.kind");
  }
  KERF_TRY(scene::validate(request.analysis));
  KERF_TRY_ASSIGN(request.probes, wire::decode_probes(message.probes()));
  KERF_TRY(scene::validate(request.probes));
  request.wants_scene_probes = request.probes.empty();
  request.wants_positions = message.positions();
  return request;
}

// Checks that a dynamic analysis is possible and its table small enough to be sent.
Status check(const sheet::Sheet& sheet, const scene::DynamicAnalysis& analysis,
             const std::vector<scene::Probe>& probes) {
  if (sheet.frozen() && analysis.ticks > 0) {
    return failed_precondition("SHEET_FROZEN",
                               "the sheet is frozen at tick " + std::to_string(sheet.tick()) +
                                   ", where no finite step was found: reset it, or request 0 ticks",
                               "name");
  }
  const auto columns = static_cast<std::int64_t>(analysis::Probes::columns_of(probes).size()) + 1;
  const std::int64_t rows = analysis.ticks / analysis.measure_every + 2;
  if (columns == 1 || rows * columns <= kMaxMeasuredNumbers) return Nothing{};
  return resource_exhausted("TABLE_TOO_LARGE",
                            std::to_string(rows) + " rows of " + std::to_string(columns) + " columns exceed the " +
                                std::to_string(kMaxMeasuredNumbers) +
                                " numbers that one answer may have; measure less often, or at fewer points",
                            "analysis.dynamic.measure_every");
}

Result<analysis::Outcome> run(sheet::Sheet& sheet, const Request& request, const analysis::Watch& watch) {
  const std::vector<scene::Probe> probes = request.wants_scene_probes ? sheet.config().probes : request.probes;
  return std::visit(
      Overloaded{
          [&](const scene::DynamicAnalysis& in_time) -> Result<analysis::Outcome> {
            KERF_TRY(check(sheet, in_time, probes));
            return analysis::run_dynamic(sheet, in_time, probes, watch, {}, nullptr);
          },
          [&](const scene::StaticAnalysis& of_loads) { return analysis::run_static(sheet, of_loads, probes, watch); },
          [&](const scene::ModalAnalysis& modes) { return analysis::run_modes(sheet, modes, probes, watch); },
      },
      request.analysis);
}

Result<v1::AnalyzeSheetResponse> analyze(sheet::Sheet& sheet, const Request& request, const analysis::Watch& watch) {
  v1::AnalyzeSheetResponse response;
  response.set_name(request.name);
  response.set_tick(sheet.tick());
  response.set_topology_version(sheet.topology_version());
  KERF_TRY_ASSIGN(const analysis::Outcome outcome, run(sheet, request, watch));
  for (const analysis::Table& table : outcome.tables) *response.add_tables() = wire::encode_table(table);
  if (outcome.statics) *response.mutable_static_() = wire::encode_statics(*outcome.statics);
  if (outcome.dynamics) {
    v1::DynamicResult& dynamic = *response.mutable_dynamic();
    dynamic = wire::encode_dynamics(*outcome.dynamics);
    *dynamic.mutable_energies() = wire::encode_energies(sheet.energies());
    dynamic.set_state_hash(wire::encode_hash(sheet.state_hash()));
  }
  if (request.wants_positions) {
    const linear::VertexField& x = sheet.state().x;
    response.set_positions(x.data(), sizeof(double) * static_cast<std::size_t>(x.size()));
  }
  return response;
}

}  // namespace

void Api::analyze_sheet(const v1::AnalyzeSheetRequest& message, Reply<v1::AnalyzeSheetResponse> reply,
                        std::stop_token stop) {
  const Result<std::string> id = addressed_sheet(*core_, message.name(), "name");
  if (!id.ok()) return reply(id.error());
  Result<Request> request = decode(message);
  if (!request.ok()) return reply(request.error());
  copy_sheet(core_, *id, "name",
             [core = core_, stop = std::move(stop), reply = std::move(reply),
              request = std::make_shared<const Request>(std::move(*request))](
                 const Result<std::shared_ptr<sheet::Sheet>>& copy) {
               if (!copy.ok()) return reply(copy.error());
               const std::shared_ptr<sheet::Sheet> sheet = *copy;
               const auto work = [core, stop, request, sheet]() -> Result<v1::AnalyzeSheetResponse> {
                 const analysis::Watch watch = [&](const analysis::Progress&) {
                   return !stop.stop_requested() && !core->stopping;
                 };
                 Result<v1::AnalyzeSheetResponse> response = analyze(*sheet, *request, watch);
                 if (core->stopping) return server_stopping();
                 return response;
               };
               in_background<v1::AnalyzeSheetResponse>(core->analysis_worker, reply, work, too_many_analyses(*core));
             });
}

}  // namespace kerf::api

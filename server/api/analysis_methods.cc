#include <memory>
#include <utility>
#include <variant>

#include "kerf/v1/sheets.pb.h"
#include "server/analysis/analysis.h"
#include "server/api/core.h"
#include "server/wire/analysis_codec.h"

// SheetService.AnalyzeSheet.
namespace kerf::api {
namespace {

struct Request {
  std::string name;
  sheet::Analysis analysis;
  std::vector<sheet::Probe> probes;
  bool wants_scene_probes = true;
  bool wants_positions = false;
};

Result<Request> decode(const v1::AnalyzeSheetRequest& message) {
  Request request;
  request.name = message.name();
  Result<sheet::Analysis> analysis = wire::decode_analysis(message.analysis());
  if (!analysis) return analysis.error();
  request.analysis = std::move(analysis).value();
  if (std::holds_alternative<sheet::DynamicAnalysis>(request.analysis)) {
    return invalid_argument("CHOICE_MISSING",
                            "analysis must be static or modes; time passes for the sheet itself: see StepSheet",
                            "analysis.kind");
  }
  if (const Status status = sheet::validate(request.analysis); !status.ok()) return status.error();
  Result<std::vector<sheet::Probe>> probes = wire::decode_probes(message.probes());
  if (!probes) return probes.error();
  request.probes = std::move(probes).value();
  if (const Status status = sheet::validate(request.probes); !status.ok()) return status.error();
  request.wants_scene_probes = request.probes.empty();
  request.wants_positions = message.positions();
  return request;
}

Result<v1::AnalyzeSheetResponse> analyze(sheet::Sheet& sheet, const Request& request, const analysis::Watch& watch) {
  v1::AnalyzeSheetResponse response;
  response.set_name(request.name);
  response.set_tick(sheet.tick());
  response.set_topology_version(sheet.topology_version());
  const std::vector<sheet::Probe>& probes = request.wants_scene_probes ? sheet.config().probes : request.probes;
  const auto* of_loads = std::get_if<sheet::StaticAnalysis>(&request.analysis);
  const Result<analysis::Outcome> outcome =
      of_loads != nullptr ? analysis::run_static(sheet, *of_loads, probes, watch)
                          : analysis::run_modes(sheet, std::get<sheet::ModalAnalysis>(request.analysis), probes, watch);
  if (!outcome) return outcome.error();
  for (const analysis::Table& table : outcome->tables) *response.add_tables() = wire::encode_table(table);
  if (outcome->statics) *response.mutable_static_() = wire::encode_statics(*outcome->statics);
  if (request.wants_positions) {
    const mesh::VertexField& x = sheet.state().x;
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
  // Empty: too large to be copied.
  using Copy = std::unique_ptr<sheet::Sheet>;
  const std::int32_t limit = core_->options.limits.max_analyzed_vertices;
  look_at<Copy>(
      core_, *id,
      [limit](const sheet::Sheet& sheet) {
        return sheet.mesh().num_vertices() <= limit ? std::make_unique<sheet::Sheet>(sheet) : nullptr;
      },
      "name",
      [core = core_, limit, stop = std::move(stop), reply = std::move(reply),
       request = std::make_shared<const Request>(std::move(*request))](Result<Copy> copy) {
        if (!copy.ok()) return reply(copy.error());
        if (*copy == nullptr) {
          return reply(Error{ErrorCode::kResourceExhausted, "SHEET_TOO_LARGE",
                             "the sheet has more than the " + std::to_string(limit) +
                                 " vertices that are analysed here; "
                                 "`kerf run` has no such limit",
                             "name"});
        }
        const std::shared_ptr<sheet::Sheet> sheet = std::move(*copy);
        const auto work = [core, stop, reply, request, sheet] {
          const analysis::Watch watch = [&](const analysis::Progress&) {
            return !stop.stop_requested() && !core->stopping;
          };
          Result<v1::AnalyzeSheetResponse> response = analyze(*sheet, *request, watch);
          if (core->stopping) return reply(server_stopping());
          reply(std::move(response));
        };
        in_background(core->analyst, reply, work, too_many_analyses(*core));
      });
}

}  // namespace kerf::api

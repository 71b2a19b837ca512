#include <nlohmann/json.hpp>

#include <cmath>
#include <string>

#include "client/load/metrics.h"
#include "client/load/report.h"

namespace kerf::load {
namespace {

using Json = nlohmann::ordered_json;

Json of(const Histogram& histogram) {
  return {{"count", histogram.count()},        {"mean", histogram.mean()},       {"min", histogram.min()},
          {"p50", histogram.quantile(0.5)},    {"p90", histogram.quantile(0.9)}, {"p99", histogram.quantile(0.99)},
          {"p999", histogram.quantile(0.999)}, {"max", histogram.max()}};
}

Json of(const Plan& plan) {
  return {{"server", plan.server},
          {"http", plan.http},
          {"prefix", plan.prefix},
          {"sheets", plan.sheets},
          {"columns", plan.columns},
          {"rows", plan.rows},
          {"tick_rate_hz", plan.tick_rate_hz},
          {"still", plan.still},
          {"viewers", plan.viewers},
          {"viewer_rate_hz", plan.viewer_rate_hz},
          {"slow_readers", plan.slow_readers},
          {"hold_s", plan.hold_s},
          {"stall_s", plan.stall_s},
          {"stalled_readers", plan.stalled_readers},
          {"image_viewers", plan.image_viewers},
          {"image_width", plan.image_width},
          {"image_height", plan.image_height},
          {"cuts_per_second", plan.cuts_per_second},
          {"cut_kind", name_of(plan.cut_kind)},
          {"keep_cuts", plan.keep_cuts},
          {"way_ms", plan.way_ms},
          {"way_kib_per_s", plan.way_kib_per_s},
          {"transport", plan.transport == Transport::kGrpc ? "grpc" : "ws"},
          {"warm_up_s", plan.warm_up_s},
          {"duration_s", plan.duration_s},
          {"stages", text_of(plan.stages)},
          {"stages_of", plan.staged == Staged::kSheets ? "sheets" : "viewers"},
          {"seed", plan.seed}};
}

Json of(const Probe& probe, Nanoseconds begin) {
  Json json{{"time_s", 1e-9 * static_cast<double>((probe.time - begin).count())},
            {"load", probe.load},
            {"ticks", probe.ticks},
            {"overruns", probe.overruns},
            {"slipped_s", probe.slipped_s},
            {"client_cpu_s", probe.client.cpu_s}};
  if (probe.server) {
    json["server_cpu_s"] = probe.server->cpu_s;
    json["server_resident_bytes"] = probe.server->resident_bytes;
  }
  if (probe.frames_encoded) json["frames_encoded"] = *probe.frames_encoded;
  return json;
}

Json of(const ReaderTotals& totals) {
  return {{"readers", totals.readers},   {"frames", totals.frames},         {"keyframes", totals.keyframes},
          {"bytes", totals.bytes},       {"skipped", totals.skipped},       {"ends", totals.ends},
          {"age_us", of(totals.age_us)}, {"shown_us", of(totals.shown_us)}, {"join_us", of(totals.join_us)}};
}

Json of(const CutTotals& cuts) {
  return {{"sent", cuts.sent},
          {"applied", cuts.applied},
          {"missed", cuts.missed},
          {"undone", cuts.undone},
          {"seen", cuts.seen_us.count()},
          {"seen_without", cuts.seen_without},
          {"unseen", cuts.unseen},
          {"late_us", of(cuts.late_us)},
          {"reply_us", of(cuts.reply_us)},
          {"reply_ticks", of(cuts.reply_ticks)},
          {"seen_us", of(cuts.seen_us)}};
}

Json sheets_of(const Report& report) {
  const Pace pace = pace_of(report);
  Json list = Json::array();
  for (const SheetRun& sheet : report.sheets) {
    list.push_back({{"name", sheet.name},
                    {"run_state", sheet.run_state},
                    {"ticks", sheet.ticks},
                    {"overruns", sheet.overruns},
                    {"slipped_s", sheet.slipped_s},
                    {"real_time_factor", sheet.real_time_factor}});
  }
  return {{"made", report.sheets.size()},
          {"refusals", report.refusals},
          {"first_refusal", report.first_refusal},
          {"creation_s", report.creation_s},
          {"integrator", report.integrator},
          {"ticks", ticks_of(report)},
          {"overruns", overruns_of(report)},
          {"slipped", pace.slipped},
          {"running", pace.running},
          {"real_time_factor", {{"least", pace.least}, {"median", pace.median}, {"most", pace.most}}},
          {"list_pages", report.list_pages},
          {"list_s", report.list_s},
          {"sheets", std::move(list)}};
}

Json metrics_of(const Report& report) {
  Json all = Json::object();
  for (const Metric& metric : metrics()) {
    const Figure figure = metric.figure(report);
    all[metric.name] = {{"value", figure.value ? Json(*figure.value) : Json(nullptr)},
                        {"unit", units_of(metric.unit).front().first},
                        {"samples", figure.samples},
                        {"enough", figure.enough()}};
  }
  return all;
}

Json conditions_of(const Report& report) {
  Json list = Json::array();
  for (const Judgement& judgement : judge(report)) {
    list.push_back({{"condition", judgement.condition.text},
                    {"verdict", name_of(judgement.verdict)},
                    {"value", judgement.figure.value ? Json(*judgement.figure.value) : Json(nullptr)},
                    {"samples", judgement.figure.samples},
                    {"samples_needed", judgement.figure.needed}});
  }
  return list;
}

}  // namespace

std::string to_json(const Report& report) {
  Json json{{"plan", of(report.plan)},
            {"server_version", report.server_version},
            {"server_workers", report.server_workers},
            {"processors", report.processors},
            {"started", report.started},
            {"interrupted", report.interrupted},
            {"measured_s", report.measured_s},
            {"window_s", report.window_s},
            {"sheets", sheets_of(report)}};
  for (const Role role : kRoles) json["readers"][name_of(role)] = of(report.of(role));
  json["cuts"] = of(report.cuts);
  json["control_us"] = of(report.control_us);
  json["server_cores"] = server_cores(report) < 0.0 ? Json(nullptr) : Json(server_cores(report));
  json["client_cores"] = client_cores(report);
  json["metrics"] = metrics_of(report);
  json["fail_if"] = conditions_of(report);
  json["errors"] = errors_of(report);
  json["warnings"] = warnings(report);
  json["probes"] = Json::array();
  for (const Probe& probe : report.probes) json["probes"].push_back(of(probe, report.probes.front().time));
  return json.dump(2) + "\n";
}

}  // namespace kerf::load

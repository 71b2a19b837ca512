#include <algorithm>
#include <array>
#include <cstdarg>
#include <cstdio>
#include <string>
#include <vector>

#include "client/load/metrics.h"
#include "client/load/report.h"

namespace kerf::load {
namespace {

class Text {
 public:
  [[gnu::format(printf, 2, 3)]] void line(const char* form, ...) {
    std::array<char, 600> buffer{};
    va_list arguments;
    va_start(arguments, form);
    std::vsnprintf(buffer.data(), buffer.size(), form, arguments);
    va_end(arguments);
    text_ += buffer.data();
    text_ += '\n';
  }
  [[nodiscard]] std::string take() { return std::move(text_); }

 private:
  std::string text_;
};

long long whole(std::int64_t number) {
  return static_cast<long long>(number);
}

void add_sheets(Text& text, const Report& report) {
  const Pace pace = pace_of(report);
  text.line("sheets     %zu of %d, %d x %d vertices, %.0f Hz, made in %.1f s; %s", report.sheets.size(),
            report.plan.sheets, report.plan.columns, report.plan.rows, report.plan.tick_rate_hz, report.creation_s,
            short_integrator(report).c_str());
  for (const auto& [reason, count] : report.refusals) text.line("  refused  %lld: %s", whole(count), reason.c_str());
  if (!report.first_refusal.empty()) text.line("           \"%s\"", report.first_refusal.c_str());
  if (!report.plan.stages.empty()) {
    text.line("stages     of %s: %s", report.plan.staged == Staged::kSheets ? "sheets" : "viewers",
              text_of(report.plan.stages).c_str());
  }
  text.line("ticks      %lld, %lld after their deadline", whole(ticks_of(report)), whole(overruns_of(report)));
  text.line("real time  %lld running: least %.3f, median %.3f, most %.3f; %lld slipped", whole(pace.running),
            pace.least, pace.median, pace.most, whole(pace.slipped));
}

void add_readers(Text& text, const Report& report) {
  for (const Role role : kRoles) {
    const ReaderTotals& of = report.of(role);
    if (of.readers == 0 && of.ends.empty()) continue;
    const double seconds = std::max(reader_seconds(report, role), 1e-9);
    text.line("%-15s  %d joined; each %.2f frames/s, %.1f kB/s; %lld frames, %lld keyframes, %lld ticks skipped",
              name_of(role), of.readers, static_cast<double>(of.frames) / seconds,
              static_cast<double>(of.bytes) / seconds / 1e3, whole(of.frames), whole(of.keyframes), whole(of.skipped));
    for (const auto& [how, count] : of.ends) text.line("  ended    %lld: %s", whole(count), how.c_str());
  }
}

void add_cuts(Text& text, const Report& report) {
  const CutTotals& cuts = report.cuts;
  if (cuts.sent == 0) return;
  text.line("cuts       %s: %lld sent, %lld applied, %lld missed, %lld undone",
            std::string(name_of(report.plan.cut_kind)).c_str(), whole(cuts.sent), whole(cuts.applied),
            whole(cuts.missed), whole(cuts.undone));
  if (cuts.reply_ticks.count() > 0) {
    text.line("  ticks    from the one shown when sent to the one applied at: p50 %lld, p99 %lld, max %lld (of %lld)",
              whole(cuts.reply_ticks.quantile(0.5)), whole(cuts.reply_ticks.quantile(0.99)),
              whole(cuts.reply_ticks.max()), whole(cuts.reply_ticks.count()));
  }
  text.line("  shown    in the first frame at or after its tick: %lld; without it: %lld; no such frame: %lld",
            whole(cuts.seen_us.count() - cuts.seen_without), whole(cuts.seen_without), whole(cuts.unseen));
}

void add_latencies(Text& text, const Report& report) {
  bool any_few = false;
  text.line("\n%-46s %9s %9s  %9s  %9s  %9s  %9s", "ms", "count", "p50", "p90", "p99", "p99.9", "max");
  for (const Latency& latency : latencies(report)) {
    std::string cells;
    for (const double q : kQuantiles) {
      const bool few = latency.us->count() < values_needed(q);
      any_few = any_few || few;
      std::array<char, 40> cell{};
      std::snprintf(cell.data(), cell.size(), " %9.2f%c", static_cast<double>(latency.us->quantile(q)) / 1e3,
                    few ? '*' : ' ');
      cells += cell.data();
    }
    text.line("%-46s %9lld%s %9.2f", latency.name.c_str(), whole(latency.us->count()), cells.c_str(),
              static_cast<double>(latency.us->max()) / 1e3);
  }
  if (any_few) text.line("%s", kFewValues);
}

void add_machines(Text& text, const Report& report) {
  const double server = server_cores(report);
  const Probe& first = report.probes.front();
  const Probe& last = report.probes.back();
  if (server >= 0.0) {
    text.line("server     %.3f cores, memory %.1f to %.1f MB, load %.2f of %d workers", server,
              static_cast<double>(first.server->resident_bytes) / 1e6,
              static_cast<double>(last.server->resident_bytes) / 1e6, last.load * report.server_workers,
              report.server_workers);
  } else {
    text.line("server     load %.2f of %d workers (give --http or --server-pid for CPU and memory)",
              last.load * report.server_workers, report.server_workers);
  }
  text.line("client     %.3f cores of %d", client_cores(report), report.processors);
}

}  // namespace

std::string to_text(const Report& report) {
  Text text;
  text.line("Kerf %s at %s, measured for %.1f s from %s", report.server_version.c_str(), report.plan.server.c_str(),
            report.measured_s, report.started.c_str());
  add_sheets(text, report);
  add_readers(text, report);
  add_cuts(text, report);
  add_machines(text, report);
  text.line("listing    %d pages in %.1f ms", report.list_pages, 1e3 * report.list_s);
  text.line("errors     %lld", whole(num_errors(report)));
  for (const auto& [reason, count] : errors_of(report)) text.line("  %lld: %s", whole(count), reason.c_str());
  add_latencies(text, report);
  const std::vector<Judgement> judged = judge(report);
  if (!judged.empty()) text.line("\nconditions that fail the run");
  for (const Judgement& judgement : judged) text.line("  %s", describe(judgement).c_str());
  for (const std::string& warning : warnings(report)) text.line("\nNote: %s", warning.c_str());
  return text.take();
}

}  // namespace kerf::load

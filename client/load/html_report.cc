#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdio>
#include <iterator>
#include <string>
#include <vector>

#include "client/load/html_page.h"
#include "client/load/metrics.h"
#include "client/load/report.h"
#include "client/load/svg_plot.h"

namespace kerf::load {
namespace {

constexpr double kMega = 1e6;
constexpr std::ptrdiff_t kColours = 8;  // s0 to s7.
// Shortest interval per point of a plot over time; a shorter interval would hold single frames.
constexpr double kShortest_s = 0.25;

std::string fixed(double value, int digits) {
  std::array<char, 64> text{};
  std::snprintf(text.data(), text.size(), "%.*f", digits, value);
  return text.data();
}

std::string tile(const std::string& value, const std::string& what) {
  return "<div><b>" + escape_html(value) + "</b>" + escape_html(what) + "</div>";
}

std::string tiles(const Report& report) {
  const Pace pace = pace_of(report);
  const ReaderTotals& viewers = report.of(Role::kViewer);
  std::string html = tile(std::to_string(report.sheets.size()) + " of " + std::to_string(report.plan.sheets), "sheets");
  html += tile(std::to_string(ticks_of(report)), "ticks simulated");
  html += tile(std::to_string(overruns_of(report)), "ticks after their deadline");
  html += tile(fixed(pace.least, 3) + " / " + fixed(pace.median, 3),
               "real-time factor, least / median of " + std::to_string(pace.running) + " running sheets");
  if (viewers.readers > 0) {
    const double each = std::max(reader_seconds(report, Role::kViewer), 1e-9);
    html += tile(fixed(static_cast<double>(viewers.frames) / each, 1) + " Hz",
                 "frames, each of " + std::to_string(viewers.readers) + " viewers");
    html += tile(fixed(static_cast<double>(viewers.bytes) / each / 1e3, 1) + " kB/s", "each viewer");
    html += tile(fixed(static_cast<double>(viewers.age_us.quantile(0.5)) / 1e3, 1) + " ms", "age of frames, p50");
  }
  if (report.cuts.sent > 0) {
    html += tile(std::to_string(report.cuts.applied) + " of " + std::to_string(report.cuts.sent), "cuts applied");
  }
  html += tile(std::to_string(num_errors(report)), "errors");
  if (server_cores(report) >= 0.0) html += tile(fixed(server_cores(report), 3), "cores, server");
  html += tile(fixed(client_cores(report), 3), "cores, load tester");
  return "<div class=\"numbers\">" + html + "</div>";
}

std::string latency_table(const Report& report) {
  bool any_few = false;
  std::string html = html_row({"ms", "count", "p50", "p90", "p99", "p99.9", "max"}, "th");
  for (const Latency& latency : latencies(report)) {
    std::vector<std::string> cells{latency.name, std::to_string(latency.us->count())};
    for (const double q : kQuantiles) {
      const bool few = latency.us->count() < values_needed(q);
      any_few = any_few || few;
      cells.push_back(fixed(static_cast<double>(latency.us->quantile(q)) / 1e3, 2) + (few ? " *" : ""));
    }
    cells.push_back(fixed(static_cast<double>(latency.us->max()) / 1e3, 2));
    html += html_row(cells);
  }
  const std::string note = any_few ? "<p class=\"faint\">" + escape_html(kFewValues) + ".</p>" : "";
  return "<div class=\"wide\"><table>" + html + "</table></div>" + note;
}

std::string condition_table(const Report& report) {
  std::string rows;
  for (const Judgement& judgement : judge(report)) {
    const bool passed = judgement.verdict == Judgement::Verdict::kPassed;
    rows += "<p class=\"" + std::string(passed ? "done" : "note") + "\">" + escape_html(describe(judgement)) + "</p>";
  }
  return rows.empty() ? rows : "\n<h2>Conditions that fail the run</h2>" + rows;
}

std::string reader_table(const Report& report) {
  std::string html = html_row({"readers", "joined", "frames", "keyframes", "ticks skipped", "MB", "ended early"}, "th");
  for (const Role role : kRoles) {
    const ReaderTotals& of = report.of(role);
    if (of.readers == 0 && of.ends.empty()) continue;
    std::string ends;
    for (const auto& [how, count] : of.ends) ends += (ends.empty() ? "" : ", ") + std::to_string(count) + " " + how;
    html += html_row({name_of(role), std::to_string(of.readers), std::to_string(of.frames),
                      std::to_string(of.keyframes), std::to_string(of.skipped),
                      fixed(static_cast<double>(of.bytes) / kMega, 2), ends.empty() ? "none" : ends});
  }
  return "<div class=\"wide\"><table>" + html + "</table></div>";
}

// Plots each latency over the share of values above it, from a half to one in 100,000.
std::string percentile_plot(const Report& report) {
  std::vector<PlotSeries> series;
  std::vector<Latency> shown = latencies(report);
  if (std::ssize(shown) > kColours)
    shown.erase(shown.begin() + kColours - 1, shown.end() - 1);  // The control run stays.
  for (const Latency& latency : shown) {
    PlotSeries line{latency.name, {}};
    const auto most = static_cast<double>(latency.us->count());
    for (double above = 0.5; above >= 1e-5 && above * most >= 1.0; above /= 1.25) {
      line.points.emplace_back(1.0 / above, static_cast<double>(latency.us->quantile(1.0 - above)) / 1e3);
    }
    if (!line.points.empty()) series.push_back(std::move(line));
  }
  const PlotAxis share{"percentile", true, {{2, "50"}, {10, "90"}, {100, "99"}, {1000, "99.9"}, {10'000, "99.99"}}};
  return svg_plot("Latencies by percentile", share, {"ms", true, {}}, series);
}

std::string stretch_plots(const Report& report) {
  PlotSeries median{"p50", {}};
  PlotSeries high{"p99", {}};
  PlotSeries bytes{"all viewers", {}};
  const double length = report.plan.duration_s / static_cast<double>(report.stretches.size());
  const auto group = static_cast<std::size_t>(std::max(1.0, std::ceil(kShortest_s / length)));
  // Ignores stretches after an interruption: missing frames there are no stall.
  const auto measured = static_cast<std::size_t>(std::max(report.window_s / length, 0.0));
  for (std::size_t i = 0; i < std::min(measured, report.stretches.size()); i += group) {
    Stretch sum;
    const std::size_t end = std::min(i + group, report.stretches.size());
    for (std::size_t k = i; k < end; ++k) sum.merge(report.stretches[k]);
    const double span = length * static_cast<double>(end - i);
    const double time = length * static_cast<double>(i) + 0.5 * span;
    bytes.points.emplace_back(time, static_cast<double>(sum.bytes) / span / kMega);
    if (sum.frames == 0) continue;  // Without frames there is no age; the plot of bytes shows the gap.
    median.points.emplace_back(time, static_cast<double>(sum.age_us.quantile(0.5)) / 1e3);
    high.points.emplace_back(time, static_cast<double>(sum.age_us.quantile(0.99)) / 1e3);
  }
  return svg_plot("Age of viewers' frames when decoded", {"s", false, {}}, {"ms", false, {}}, {median, high}) +
         svg_plot("Bytes to viewers", {"s", false, {}}, {"MB/s", false, {}}, {bytes});
}

// Plots how many viewers or sheets the stages have; nothing without stages.
std::string stage_plot(const Report& report) {
  if (report.plan.stages.empty()) return {};
  const bool of_sheets = report.plan.staged == Staged::kSheets;
  PlotSeries line{of_sheets ? "running" : "open", {{0.0, 0.0}}};
  for (const Step& step : steps_of(report.plan.stages)) {
    const double time = 1e-9 * static_cast<double>(step.time.count());
    line.points.emplace_back(time, line.points.back().second);
    line.points.emplace_back(time, step.count);
  }
  line.points.emplace_back(report.plan.duration_s, line.points.back().second);
  return svg_plot(of_sheets ? "Sheets of the stages" : "Viewers of the stages", {"s", false, {}}, {"number", false, {}},
                  {line});
}

std::string probe_plots(const Report& report) {
  PlotSeries ticks{"ticks", {}};
  PlotSeries overruns{"after their deadline", {}};
  PlotSeries server{"server", {}};
  PlotSeries client{"load tester", {}};
  PlotSeries memory{"server", {}};
  for (std::size_t i = 1; i < report.probes.size(); ++i) {
    const Probe& from = report.probes[i - 1];
    const Probe& to = report.probes[i];
    const double span = 1e-9 * static_cast<double>((to.time - from.time).count());
    const double time = 1e-9 * static_cast<double>((to.time - report.probes.front().time).count());
    if (span <= 0.0) continue;
    ticks.points.emplace_back(time, static_cast<double>(to.ticks - from.ticks) / span);
    overruns.points.emplace_back(time, static_cast<double>(to.overruns - from.overruns) / span);
    client.points.emplace_back(time, (to.client.cpu_s - from.client.cpu_s) / span);
    if (!from.server || !to.server) continue;
    server.points.emplace_back(time, (to.server->cpu_s - from.server->cpu_s) / span);
    memory.points.emplace_back(time, static_cast<double>(to.server->resident_bytes) / kMega);
  }
  return svg_plot("Ticks of all sheets", {"s", false, {}}, {"1/s", false, {}}, {ticks, overruns}) +
         svg_plot("Processor time", {"s", false, {}}, {"cores", false, {}}, {server, client}) +
         svg_plot("Memory", {"s", false, {}}, {"MB", false, {}}, {memory});
}

std::string pace_plot(const Report& report) {
  std::vector<double> factors;
  for (const SheetRun& sheet : report.sheets) {
    if (sheet.run_state == "RUNNING") factors.push_back(sheet.real_time_factor);
  }
  std::sort(factors.begin(), factors.end());
  PlotSeries line{"running sheets, slowest first", {}};
  for (std::size_t i = 0; i < factors.size(); ++i) line.points.emplace_back(static_cast<double>(i + 1), factors[i]);
  return svg_plot("Real-time factor of each sheet", {"sheet", false, {}}, {"simulated / clock", false, {}}, {line});
}

std::string list_of(const std::string& heading, const std::map<std::string, std::int64_t>& counts) {
  if (counts.empty()) return {};
  std::string html = html_row({heading, "count"}, "th");
  for (const auto& [reason, count] : counts) html += html_row({reason, std::to_string(count)});
  return "<table>" + html + "</table>";
}

}  // namespace

std::string to_html(const Report& report) {
  const Plan& plan = report.plan;
  std::string html = "<p class=\"faint\">" +
                     escape_html("Kerf " + report.server_version + " at " + plan.server + ", " +
                                 std::to_string(report.server_workers) + " workers; " + report.started +
                                 ", measured for " + fixed(report.measured_s, 1) + " s. Sheets of " +
                                 std::to_string(plan.columns) + " x " + std::to_string(plan.rows) + " vertices at " +
                                 fixed(plan.tick_rate_hz, 0) + " Hz (" + short_integrator(report) + ").") +
                     "</p>";
  for (const std::string& warning : warnings(report)) html += "<p class=\"note\">" + escape_html(warning) + "</p>";
  if (!report.first_refusal.empty()) {
    html += "<p class=\"note\">A sheet was refused: " + escape_html(report.first_refusal) + "</p>";
  }
  html += tiles(report) + condition_table(report) + "\n<h2>Latencies</h2>" + latency_table(report);
  html +=
      "<p class=\"faint\">Latencies of cuts count from the time at which each was due, those of frames from the time "
      "of the tick shown, so a stall counts in everything that it delays. The last row is a thread that only sleeps "
      "until fixed times: it shows what this machine itself adds.</p>";
  html += "<div class=\"plots\">" + percentile_plot(report) + stage_plot(report) + stretch_plots(report) +
          probe_plots(report) + pace_plot(report) + "</div>";
  html += "\n<h2>Readers</h2>" + reader_table(report);
  if (report.cuts.sent > 0) {
    const CutTotals& cuts = report.cuts;
    html += "\n<h2>Cuts</h2><p>" + std::to_string(cuts.sent) + " sent, " + std::to_string(cuts.applied) + " applied, " +
            std::to_string(cuts.missed) + " missed. Of those on watched sheets " +
            std::to_string(cuts.seen_us.count() - cuts.seen_without) +
            " were in the first frame at or after their tick, " + std::to_string(cuts.seen_without) + " were not, " +
            std::to_string(cuts.unseen) +
            " had no such frame before the end. Ticks from the one shown when a cut was sent to the one it was applied "
            "at: p50 " +
            std::to_string(cuts.reply_ticks.quantile(0.5)) + ", p99 " +
            std::to_string(cuts.reply_ticks.quantile(0.99)) + ".</p>";
  }
  html += list_of("sheets refused", report.refusals) + list_of("errors", errors_of(report));
  return html_page("Kerf under load", html);
}

}  // namespace kerf::load

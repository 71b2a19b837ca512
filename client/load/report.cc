#include "client/load/report.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <numeric>

namespace kerf::load {
namespace {

constexpr double kClientBusy = 0.7;  // Share of the machine's processors: above it the client measures itself.

// Returns the time between the first and the last probe.
double probed_s(const Report& report) {
  return 1e-9 * static_cast<double>((report.probes.back().time - report.probes.front().time).count());
}

std::int32_t asked(const Plan& plan, Role role) {
  switch (role) {
    case Role::kViewer:
      return plan.viewers;
    case Role::kSlow:
      return plan.slow_readers;
    case Role::kStalled:
      return plan.stalled_readers;
    case Role::kImage:
      return plan.image_viewers;
  }
  return 0;
}

std::int64_t sum(const std::map<std::string, std::int64_t>& counts) {
  return std::accumulate(counts.begin(), counts.end(), std::int64_t{0},
                         [](std::int64_t so_far, const auto& each) { return so_far + each.second; });
}

// Returns the number of readers without a frame. Viewers of stages may close before their first one: only those that
// the server refused count.
std::int32_t num_without_frame(const Report& report, Role role) {
  const bool in_stages = !report.plan.stages.empty() && report.plan.staged == Staged::kViewers;
  if (report.interrupted || (role == Role::kViewer && in_stages)) return 0;
  return asked(report.plan, role) - report.of(role).readers;
}

std::string sentence(const char* form, double a, double b) {
  std::array<char, 300> text{};
  std::snprintf(text.data(), text.size(), form, a, b);
  return text.data();
}

// Adds warnings about readers that are missing from the figures, or from part of the run.
void add_reader_warnings(const Report& report, std::vector<std::string>& found) {
  for (const Role role : kRoles) {
    const ReaderTotals& of = report.of(role);
    const std::int32_t missing = num_without_frame(report, role);
    if (missing > 0) {
      found.push_back(sentence("%.0f of %.0f ", missing, asked(report.plan, role)) + name_of(role) +
                      " never received a frame: the figures cover the others.");
    }
    if (role != Role::kStalled && !of.ends.empty()) {
      found.push_back(std::to_string(sum(of.ends)) + " " + name_of(role) +
                      " ended before the run did: the figures cover those that were left.");
    }
  }
}

}  // namespace

Pace pace_of(const Report& report) {
  Pace pace;
  std::vector<double> factors;
  for (const SheetRun& sheet : report.sheets) {
    if (sheet.slipped_s > 0.0) ++pace.slipped;
    const bool in_stages = report.plan.staged == Staged::kSheets;
    if (in_stages ? sheet.real_time_factor > 0.0 : sheet.run_state == "RUNNING")
      factors.push_back(sheet.real_time_factor);
  }
  if (factors.empty()) return pace;
  std::sort(factors.begin(), factors.end());
  pace.running = static_cast<std::int64_t>(factors.size());
  pace.least = factors.front();
  pace.median = factors[(factors.size() - 1) / 2];
  pace.most = factors.back();
  return pace;
}

std::string short_integrator(const Report& report) {
  return report.integrator.substr(0, report.integrator.find(';'));
}

double num_viewers(const Report& report, double from, double to) {
  const Plan& plan = report.plan;
  if (plan.stages.empty() || plan.staged != Staged::kViewers) return report.of(Role::kViewer).readers;
  return mean_count(plan.stages, from, to);
}

double num_sheets(const Report& report, double from, double to) {
  const auto made = static_cast<double>(report.sheets.size());
  if (report.plan.stages.empty() || report.plan.staged != Staged::kSheets) return made;
  return std::min(made, mean_count(report.plan.stages, from, to));
}

double reader_seconds(const Report& report, Role role) {
  if (role != Role::kViewer || report.window_s <= 0.0) return report.of(role).readers * report.window_s;
  return num_viewers(report, 0.0, report.window_s) * report.window_s;
}

std::int64_t num_refused(const Report& report) {
  return sum(report.refusals);
}

double server_cores(const Report& report) {
  if (report.probes.size() < 2 || !report.probes.front().server || !report.probes.back().server) return -1.0;
  return (report.probes.back().server->cpu_s - report.probes.front().server->cpu_s) / probed_s(report);
}

double client_cores(const Report& report) {
  if (report.probes.size() < 2) return -1.0;
  return (report.probes.back().client.cpu_s - report.probes.front().client.cpu_s) / probed_s(report);
}

std::map<std::string, std::int64_t> errors_of(const Report& report) {
  std::map<std::string, std::int64_t> errors = report.errors;
  for (const Role role : kRoles) {
    const ReaderTotals& of = report.of(role);
    const std::string who = name_of(role);
    const std::int64_t waiting = num_without_frame(report, role) - of.ended_without;
    if (waiting > 0) errors[who + " without a frame"] += waiting;
    if (role == Role::kStalled) continue;
    for (const auto& [how, count] : of.ends) errors[who + " ended: " + how] += count;
  }
  return errors;
}

std::int64_t num_errors(const Report& report) {
  return sum(errors_of(report));
}

bool nobody_joined(const Report& report) {
  std::int64_t wanted = 0;
  std::int64_t joined = 0;
  for (const Role role : kRoles) {
    wanted += asked(report.plan, role);
    joined += report.of(role).readers;
  }
  return wanted > 0 && joined == 0;
}

std::int64_t ticks_of(const Report& report) {
  return std::accumulate(report.sheets.begin(), report.sheets.end(), std::int64_t{0},
                         [](std::int64_t so_far, const SheetRun& sheet) { return so_far + sheet.ticks; });
}

std::int64_t overruns_of(const Report& report) {
  return std::accumulate(report.sheets.begin(), report.sheets.end(), std::int64_t{0},
                         [](std::int64_t so_far, const SheetRun& sheet) { return so_far + sheet.overruns; });
}

std::vector<std::string> warnings(const Report& report) {
  std::vector<std::string> found;
  if (report.interrupted) found.push_back("The run was interrupted: the figures cover its first part.");
  add_reader_warnings(report, found);
  const double client = client_cores(report);
  if (report.processors > 0 && client > kClientBusy * report.processors) {
    found.push_back(
        sentence("The load tester itself used %.2f of %.0f processors: the latencies are partly its own. Run it on "
                 "another machine, or with fewer viewers.",
                 client, report.processors));
  }
  const ReaderTotals& stalled = report.of(Role::kStalled);
  const std::int64_t ended = sum(stalled.ends);
  if (ended < stalled.readers) {
    found.push_back(
        sentence("%.0f of %.0f stalled readers cannot say how they ended: they look after --stall, and the run must "
                 "last longer than that.",
                 static_cast<double>(stalled.readers - ended), stalled.readers));
  }
  const double tick_us = 1.0e6 / report.plan.tick_rate_hz;
  const auto late = static_cast<double>(report.control_us.quantile(0.99));
  if (late > 0.5 * tick_us) {
    found.push_back(
        sentence("A thread that only sleeps woke up to %.1f ms late (p99; a tick is %.1f ms): the machine is "
                 "busy with other work, which adds to all latencies here.",
                 late / 1e3, tick_us / 1e3));
  }
  if (report.cuts.unseen > 0) {
    found.push_back(
        sentence("%.0f cuts were not shown by the end: their latency, which would be the highest, is in no figure.%.0s",
                 static_cast<double>(report.cuts.unseen), 0.0));
  }
  if (report.cuts.seen_without > 0) {
    found.push_back(
        sentence("%.0f frames at or after the tick of a cut came without it: this is an error in the server.%.0s",
                 static_cast<double>(report.cuts.seen_without), 0.0));
  }
  return found;
}

std::vector<Latency> latencies(const Report& report) {
  std::vector<Latency> found;
  const auto add = [&](const std::string& name, const Histogram& us) {
    if (us.count() > 0) found.push_back({name, &us});
  };
  for (const Role role : kRoles) {
    const std::string who = name_of(role);
    add(who + ": age of a frame when decoded", report.of(role).age_us);
    add(who + ": age of what is shown", report.of(role).shown_us);
    add(who + ": join to first frame", report.of(role).join_us);
  }
  add("cut: request to reply", report.cuts.reply_us);
  add("cut: request to frame that shows it", report.cuts.seen_us);
  add("cut: sent late by", report.cuts.late_us);
  add("control: a thread that only sleeps", report.control_us);
  return found;
}

}  // namespace kerf::load

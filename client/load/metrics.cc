#include "client/load/metrics.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>

#include "client/load/report.h"

namespace kerf::load {
namespace {

struct Family {
  const char* name;
  const char* what;
  const Histogram& (*us)(const Report&);
};
constexpr std::array<Family, 8> kFamilies{{
    {"cut", "request to reply of a cut", [](const Report& r) -> const Histogram& { return r.cuts.reply_us; }},
    {"cut_shown", "request to frame that shows the cut",
     [](const Report& r) -> const Histogram& { return r.cuts.seen_us; }},
    {"cut_late", "cut sent later than it was due", [](const Report& r) -> const Histogram& { return r.cuts.late_us; }},
    {"frame_age", "age of a viewer's frame when decoded",
     [](const Report& r) -> const Histogram& { return r.of(Role::kViewer).age_us; }},
    {"shown_age", "age of what a viewer shows",
     [](const Report& r) -> const Histogram& { return r.of(Role::kViewer).shown_us; }},
    {"join", "join of a viewer to its first frame",
     [](const Report& r) -> const Histogram& { return r.of(Role::kViewer).join_us; }},
    {"image_age", "age of a picture when decoded",
     [](const Report& r) -> const Histogram& { return r.of(Role::kImage).age_us; }},
    {"control", "lateness of a thread that only sleeps",
     [](const Report& r) -> const Histogram& { return r.control_us; }},
}};

struct Statistic {
  const char* name;
  double q;  // 1: the largest; negative: the mean.
};
constexpr std::array<Statistic, 7> kStatistics{
    {{"mean", -1.0}, {"p50", 0.5}, {"p90", 0.9}, {"p95", 0.95}, {"p99", 0.99}, {"p999", 0.999}, {"max", 1.0}}};

struct Scalar {
  const char* name;
  const char* what;
  Unit unit;
  Better better;
  std::optional<double> (*value)(const Report&);
};

std::optional<double> if_any(std::int64_t there, double value) {
  return there > 0 ? std::optional(value) : std::nullopt;
}

std::optional<double> per_viewer_second(const Report& report, std::int64_t sum) {
  const double seconds = reader_seconds(report, Role::kViewer);
  return seconds > 0.0 ? std::optional(static_cast<double>(sum) / seconds) : std::nullopt;
}

double as_double(std::int64_t number) {
  return static_cast<double>(number);
}

constexpr std::array<Scalar, 19> kScalars{{
    {"cuts_sent", "cuts sent", Unit::kCount, Better::kNeither,
     [](const Report& r) { return std::optional(as_double(r.cuts.sent)); }},
    {"cuts_applied", "cuts applied", Unit::kCount, Better::kHigh,
     [](const Report& r) { return std::optional(as_double(r.cuts.applied)); }},
    {"cuts_missed", "cuts that missed the sheet", Unit::kCount, Better::kNeither,
     [](const Report& r) { return std::optional(as_double(r.cuts.missed)); }},
    {"cuts_unseen", "cuts that no frame showed by the end", Unit::kCount, Better::kLow,
     [](const Report& r) { return std::optional(as_double(r.cuts.unseen)); }},
    {"errors", "errors of all kinds", Unit::kCount, Better::kLow,
     [](const Report& r) { return std::optional(as_double(num_errors(r))); }},
    {"sheets_refused", "sheets that the server refused", Unit::kCount, Better::kLow,
     [](const Report& r) { return std::optional(as_double(num_refused(r))); }},
    {"sheets_slipped", "sheets that gave up simulated time", Unit::kCount, Better::kLow,
     [](const Report& r) { return std::optional(as_double(pace_of(r).slipped)); }},
    {"real_time_least", "simulated over wall time, slowest sheet", Unit::kFactor, Better::kHigh,
     [](const Report& r) { return if_any(pace_of(r).running, pace_of(r).least); }},
    {"real_time_median", "simulated over wall time, median sheet", Unit::kFactor, Better::kHigh,
     [](const Report& r) { return if_any(pace_of(r).running, pace_of(r).median); }},
    {"ticks", "ticks of all sheets", Unit::kCount, Better::kHigh,
     [](const Report& r) { return std::optional(as_double(ticks_of(r))); }},
    {"overruns", "ticks after their deadline", Unit::kCount, Better::kLow,
     [](const Report& r) { return std::optional(as_double(overruns_of(r))); }},
    {"overrun_share", "share of ticks after their deadline", Unit::kPercent, Better::kLow,
     [](const Report& r) { return if_any(ticks_of(r), 100.0 * as_double(overruns_of(r)) / as_double(ticks_of(r))); }},
    {"frames", "frames of all viewers", Unit::kCount, Better::kHigh,
     [](const Report& r) { return std::optional(as_double(r.of(Role::kViewer).frames)); }},
    {"frame_rate", "frames per second, each viewer", Unit::kHertz, Better::kHigh,
     [](const Report& r) { return per_viewer_second(r, r.of(Role::kViewer).frames); }},
    {"data_rate", "data per second, each viewer", Unit::kKilobytesPerSecond, Better::kLow,
     [](const Report& r) { return per_viewer_second(r, r.of(Role::kViewer).bytes / 1000); }},
    {"skipped", "ticks that viewers were not sent", Unit::kCount, Better::kLow,
     [](const Report& r) { return std::optional(as_double(r.of(Role::kViewer).skipped)); }},
    {"server_cores", "processors that the server used", Unit::kCores, Better::kLow,
     [](const Report& r) { return server_cores(r) < 0.0 ? std::nullopt : std::optional(server_cores(r)); }},
    {"server_memory", "memory of the server at the end", Unit::kMegabytes, Better::kLow,
     [](const Report& r) {
       return r.probes.empty() || !r.probes.back().server
                  ? std::nullopt
                  : std::optional(1e-6 * as_double(r.probes.back().server->resident_bytes));
     }},
    {"client_cores", "processors that the load tester used", Unit::kCores, Better::kNeither,
     [](const Report& r) { return client_cores(r) < 0.0 ? std::nullopt : std::optional(client_cores(r)); }},
}};

Figure figure_of(const Histogram& us, double q) {
  Figure figure{std::nullopt, us.count(), 1};
  if (us.count() == 0) return figure;
  if (q < 0.0) {
    figure.value = 1e-3 * us.mean();
  } else if (q == 1.0) {
    figure.value = 1e-3 * as_double(us.max());
  } else {
    figure.value = 1e-3 * as_double(us.quantile(q));
    figure.needed = values_needed(q);
  }
  return figure;
}

std::vector<Metric> all_metrics() {
  std::vector<Metric> all;
  for (const Family& family : kFamilies) {
    for (const Statistic& statistic : kStatistics) {
      all.push_back({std::string(family.name) + "_" + statistic.name, std::string(family.what) + ", " + statistic.name,
                     Unit::kMilliseconds, Better::kLow,
                     [us = family.us, q = statistic.q](const Report& r) { return figure_of(us(r), q); }});
    }
  }
  for (const Scalar& scalar : kScalars) {
    all.push_back({scalar.name, scalar.what, scalar.unit, scalar.better, [value = scalar.value](const Report& r) {
                     return Figure{value(r), 1, 1};
                   }});
  }
  return all;
}

std::string padded(const char* name, const std::string& text) {
  std::array<char, 200> line{};
  std::snprintf(line.data(), line.size(), "  %-18s%s\n", name, text.c_str());
  return line.data();
}

}  // namespace

const std::vector<std::pair<std::string_view, double>>& units_of(Unit unit) {
  using Units = std::vector<std::pair<std::string_view, double>>;
  static const Units kNone{{"", 1.0}};
  static const Units kPercents{{"%", 1.0}};
  static const Units kTimes{{"ms", 1.0}, {"s", 1e3}, {"us", 1e-3}};
  static const Units kRates{{"Hz", 1.0}, {"/s", 1.0}};
  static const Units kData{{"kB/s", 1.0}, {"MB/s", 1e3}, {"B/s", 1e-3}};
  static const Units kSizes{{"MB", 1.0}, {"GB", 1e3}, {"kB", 1e-3}};
  switch (unit) {
    case Unit::kPercent:
      return kPercents;
    case Unit::kMilliseconds:
      return kTimes;
    case Unit::kHertz:
      return kRates;
    case Unit::kKilobytesPerSecond:
      return kData;
    case Unit::kMegabytes:
      return kSizes;
    case Unit::kCount:
    case Unit::kFactor:
    case Unit::kCores:
      break;
  }
  return kNone;
}

const std::vector<Metric>& metrics() {
  static const std::vector<Metric> kAll = all_metrics();
  return kAll;
}

const Metric* find_metric(const std::string& name) {
  const auto found =
      std::find_if(metrics().begin(), metrics().end(), [&](const Metric& metric) { return metric.name == name; });
  return found == metrics().end() ? nullptr : &*found;
}

std::string list_of_metrics() {
  std::string list =
      "Latencies, in us, ms or s, are one of these names with _mean, _p50, _p90, _p95, _p99, _p999 or _max:\n";
  for (const Family& family : kFamilies) list += padded(family.name, family.what);
  list += "Others, with their units:\n";
  for (const Scalar& scalar : kScalars) {
    const std::string unit(units_of(scalar.unit).front().first);
    list += padded(scalar.name, scalar.what + (unit.empty() ? "" : " (" + unit + ")"));
  }
  return list;
}

std::int64_t values_needed(double q) {
  return std::llround(std::ceil(1.0 / (1.0 - q) - 1e-6));
}

std::vector<Judgement> judge(const Report& report) {
  using Verdict = Judgement::Verdict;
  std::vector<Judgement> judged;
  for (const Condition& condition : report.plan.fail_if) {
    const Metric* metric = find_metric(condition.metric);
    const Figure figure = metric == nullptr ? Figure() : metric->figure(report);
    const bool failed = figure.enough() && condition.holds(*figure.value);
    judged.push_back({condition, figure,
                      !figure.enough() ? Verdict::kUndecided
                      : failed         ? Verdict::kFailed
                                       : Verdict::kPassed});
  }
  return judged;
}

const char* name_of(Judgement::Verdict verdict) {
  switch (verdict) {
    case Judgement::Verdict::kPassed:
      return "passed";
    case Judgement::Verdict::kFailed:
      return "failed";
    case Judgement::Verdict::kUndecided:
      return "undecided";
  }
  return "";
}

std::string describe(const Judgement& judgement) {
  const Figure& figure = judgement.figure;
  const Metric* metric = find_metric(judgement.condition.metric);
  std::string text = judgement.condition.text + ": " + name_of(judgement.verdict);
  if (judgement.condition.of_ratio) {
    if (!figure.value) return text + ", there is no ratio";
    std::array<char, 64> ratio{};
    std::snprintf(ratio.data(), ratio.size(), ", %.4gx", *figure.value);
    return text + ratio.data() + (judgement.verdict == Judgement::Verdict::kUndecided ? " of too few values" : "");
  }
  if (!figure.value || metric == nullptr) return text + ", nothing was measured";
  std::array<char, 64> value{};
  std::snprintf(value.data(), value.size(), ", %.4g %s", *figure.value,
                std::string(units_of(metric->unit).front().first).c_str());
  text += value.data();
  if (text.back() == ' ') text.pop_back();
  if (metric->unit == Unit::kMilliseconds) text += " of " + std::to_string(figure.samples) + " values";
  if (!figure.enough()) text += ", where at least " + std::to_string(figure.needed) + " are needed";
  return text;
}

}  // namespace kerf::load

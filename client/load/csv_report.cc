#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <string>

#include "client/load/metrics.h"
#include "client/load/report.h"

namespace kerf::load {
namespace {

constexpr double kCsvLine_s = 1.0;  // Shortest interval of a line.

std::string csv_number(double value) {
  std::array<char, 40> text{};
  std::snprintf(text.data(), text.size(), "%.6g", value);
  return text.data();
}

// Returns a text with the quotes that CSV asks for.
std::string quoted(const std::string& text) {
  std::string out = "\"";
  for (const char c : text) out += c == '"' ? std::string("\"\"") : std::string(1, c);
  return out + '"';
}

std::string quantile_ms(const Histogram& us, double q) {
  return us.count() == 0 ? std::string() : csv_number(1e-3 * static_cast<double>(us.quantile(q)));
}

// Returns a counter of the probes at `time`, seconds from the beginning, between the probes before and after it.
template <typename Count>
double count_at(const Report& report, double time, Count count) {
  const auto seconds = [&](const Probe& probe) {
    return 1e-9 * static_cast<double>((probe.time - report.begin).count());
  };
  const auto after = std::find_if(report.probes.begin(), report.probes.end(),
                                  [&](const Probe& probe) { return seconds(probe) >= time; });
  if (after == report.probes.begin()) return count(report.probes.front());
  if (after == report.probes.end()) return count(report.probes.back());
  const Probe& before = *(after - 1);
  const double share = (time - seconds(before)) / (seconds(*after) - seconds(before));
  return count(before) + share * (count(*after) - count(before));
}

std::string csv_line(const Report& report, const Stretch& sum, double from, double to) {
  const double span = to - from;
  const auto change = [&](auto count) { return count_at(report, to, count) - count_at(report, from, count); };
  // Rounded where intervals meet, so that the numbers of all lines add up.
  const auto whole_change = [&](auto count) {
    return std::round(count_at(report, to, count)) - std::round(count_at(report, from, count));
  };
  const double ticks = whole_change([](const Probe& probe) { return static_cast<double>(probe.ticks); });
  const double sheets = num_sheets(report, from, to);
  std::string text = csv_number(from) + ',' + csv_number(to) + ',' + csv_number(num_viewers(report, from, to)) + ',' +
                     csv_number(sheets) + ',' + csv_number(ticks) + ',';
  if (sheets > 0.0) text += csv_number(ticks / (report.plan.tick_rate_hz * sheets * span));
  text += ',' + csv_number(whole_change([](const Probe& probe) { return static_cast<double>(probe.overruns); }));
  text += ',' + std::to_string(sum.frames) + ',' + std::to_string(sum.bytes) + ',' + quantile_ms(sum.age_us, 0.5) +
          ',' + quantile_ms(sum.age_us, 0.99) + ',' + std::to_string(sum.cut_us.count()) + ',' +
          quantile_ms(sum.cut_us, 0.5) + ',' + quantile_ms(sum.cut_us, 0.99) + ',' + std::to_string(sum.errors) + ',';
  const bool known = std::all_of(report.probes.begin(), report.probes.end(),
                                 [](const Probe& probe) { return probe.server.has_value(); });
  if (known) text += csv_number(change([](const Probe& probe) { return probe.server->cpu_s; }) / span);
  return text + '\n';
}

}  // namespace

std::string to_interval_csv(const Report& report) {
  std::string text =
      "from_s,to_s,viewers,sheets,ticks,real_time,overruns,frames,bytes,frame_age_p50_ms,frame_age_p99_ms,cuts,"
      "cut_p50_ms,cut_p99_ms,errors,server_cores\n";
  if (report.stretches.empty() || report.probes.empty()) return text;
  const double length = report.plan.duration_s / static_cast<double>(report.stretches.size());
  const auto group = static_cast<std::size_t>(std::max(1.0, std::ceil(kCsvLine_s / length - 1e-9)));
  const auto measured = static_cast<std::size_t>(std::max(report.window_s / length + 1e-9, 0.0));
  const std::size_t count = std::min(measured, report.stretches.size());
  for (std::size_t i = 0; i < count; i += group) {
    const std::size_t end = std::min(i + group, count);
    Stretch sum;
    for (std::size_t k = i; k < end; ++k) sum.merge(report.stretches[k]);
    text += csv_line(report, sum, length * static_cast<double>(i), length * static_cast<double>(end));
  }
  return text;
}

std::string to_summary_csv(const Report& report) {
  std::string text = "metric,value,unit,samples,enough,description\n";
  for (const Metric& metric : metrics()) {
    const Figure figure = metric.figure(report);
    text += metric.name + ',' + (figure.value ? csv_number(*figure.value) : "") + ',' +
            std::string(units_of(metric.unit).front().first) + ',' + std::to_string(figure.samples) + ',' +
            (figure.enough() ? "yes" : "no") + ',' + quoted(metric.what) + '\n';
  }
  return text;
}

}  // namespace kerf::load

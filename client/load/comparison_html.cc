#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <string>

#include "client/load/comparison.h"
#include "client/load/html_page.h"
#include "client/load/svg_plot.h"

namespace kerf::load {
namespace {

constexpr double kSame = 1.05;         // Ratios up to this, and down to its inverse, have no colour.
constexpr double kBarDoublings = 3.0;  // Doublings or halvings that fill half of a bar.

std::string compared_number(double value) {
  std::array<char, 40> text{};
  std::snprintf(text.data(), text.size(), "%.4g", value);
  return text.data();
}

std::string compared_or_dash(const std::optional<double>& value) {
  return value ? compared_number(*value) : "-";
}

const char* tone_of(const ComparedMetric& metric) {
  const std::optional<double> ratio = metric.ratio();
  if (!ratio || !metric.enough || metric.better == Better::kNeither || (*ratio<kSame&& * ratio> 1.0 / kSame))
    return "same";
  return (*ratio > 1.0) == (metric.better == Better::kHigh) ? "better" : "worse";
}

// Returns a bar from the middle to the right for larger values, to the left for smaller ones; each doubling is as long.
std::string ratio_bar(const ComparedMetric& metric) {
  const std::optional<double> ratio = metric.ratio();
  if (!ratio || *ratio <= 0.0) return {};
  const double x = 60.0 + 60.0 * std::clamp(std::log2(*ratio) / kBarDoublings, -1.0, 1.0);
  return "<svg class=\"bar\" viewBox=\"0 0 120 12\" role=\"img\" aria-label=\"" + compared_number(*ratio) +
         " times\"><line class=\"grid\" x1=\"60\" x2=\"60\" y1=\"0\" y2=\"12\"/><line class=\"" + tone_of(metric) +
         "\" x1=\"60\" x2=\"" + compared_number(x) + "\" y1=\"6\" y2=\"6\"/></svg>";
}

std::string html_cell(const std::string& html, const char* kind = "") {
  return *kind == '\0' ? "<td>" + html + "</td>" : "<td class=\"" + std::string(kind) + "\">" + html + "</td>";
}

std::string setting_table(const Comparison& comparison) {
  if (comparison.settings.empty()) return "<p>Both runs had the same settings.</p>";
  std::string html = "\n<h2>Settings that differ</h2><table>" + html_row({"setting", "first", "second"}, "th");
  for (const ChangedSetting& setting : comparison.settings) {
    html += html_row({setting.name, setting.first, setting.second});
  }
  return html + "</table>";
}

}  // namespace

std::string to_html(const Comparison& comparison) {
  std::string html = "<p>First: " + escape_html(comparison.first) + "<br/>Second: " + escape_html(comparison.second) +
                     "</p>" + setting_table(comparison) + "\n<h2>Metrics</h2><div class=\"wide\"><table>" +
                     html_row({"metric", "unit", "first", "second", "second / first", ""}, "th");
  for (const ComparedMetric& metric : comparison.metrics) {
    const std::string mark = metric.enough ? "" : " *";
    html += "<tr>" + html_cell(escape_html(metric.name)) + html_cell(escape_html(metric.unit)) +
            html_cell(compared_or_dash(metric.first)) + html_cell(compared_or_dash(metric.second)) +
            html_cell(compared_or_dash(metric.ratio()) + mark, tone_of(metric)) + html_cell(ratio_bar(metric)) +
            "</tr>\n";
  }
  html += "</table></div><p class=\"faint\">* of too few values in at least one of them. Coloured are ratios beyond " +
          compared_number(kSame) + ", as better or worse.</p>";
  return html_page("Kerf under load, compared", html);
}

}  // namespace kerf::load

#include "client/load/svg_plot.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <limits>

namespace kerf::load {
namespace {

constexpr double kWidth = 640.0;   // SVG units
constexpr double kHeight = 260.0;  // Height without the legend, SVG units.
constexpr double kLeft = 64.0;
constexpr double kRight = 16.0;
constexpr double kTop = 34.0;
constexpr double kBottom = 40.0;  // Room for the labels of the axis.
constexpr double kLegendRow = 16.0;
constexpr int kTicks = 5;

std::string number(double value) {
  std::array<char, 40> text{};
  std::snprintf(text.data(), text.size(), "%.4g", value);
  return text.data();
}

std::string placed(const char* kind, double x, double y, const std::string& text, const char* extra = "") {
  return "<text class=\"" + std::string(kind) + "\" x=\"" + number(x) + "\" y=\"" + number(y) + "\"" + extra + ">" +
         escape_html(text) + "</text>";
}

// Maps a value to its place on an axis, as a share of the axis' length.
class Scale {
 public:
  Scale(const PlotAxis& axis, double least, double most) : log_(axis.logarithmic), ticks_(axis.ticks) {
    if (log_) {
      low_ = std::floor(std::log10(least));
      high_ = std::max(std::ceil(std::log10(most)), low_ + 1.0);
      if (!ticks_.empty()) {
        low_ = std::log10(least);
        high_ = std::max(std::log10(most), low_ + 1e-9);
      }
    } else {
      low_ = std::min(least, 0.0);
      step_ = step_for(std::max(most, low_ + 1e-9) - low_);
      high_ = std::max(low_ + step_, step_ * std::ceil(most / step_ - 1e-9));
    }
    if (ticks_.empty()) choose_ticks();
  }
  [[nodiscard]] double share(double value) const {
    return ((log_ ? std::log10(value) : value) - low_) / (high_ - low_);
  }
  [[nodiscard]] bool shows(double value) const { return !log_ || value > 0.0; }
  [[nodiscard]] const std::vector<std::pair<double, std::string>>& ticks() const { return ticks_; }

 private:
  // Returns the distance between ticks, 1, 2 or 5 times a power of ten, so that about kTicks fit.
  static double step_for(double span) {
    const double power = std::pow(10.0, std::floor(std::log10(span / kTicks)));
    for (const double factor : {1.0, 2.0, 5.0}) {
      if (span / (factor * power) <= kTicks) return factor * power;
    }
    return 10.0 * power;
  }
  void choose_ticks() {
    if (log_) {
      for (double k = low_; k <= high_; k += 1.0) ticks_.emplace_back(std::pow(10.0, k), number(std::pow(10.0, k)));
    } else {
      for (double value = low_; value <= high_ + 0.5 * step_; value += step_) {
        const double shown = std::abs(value) < 1e-9 * step_ ? 0.0 : value;
        ticks_.emplace_back(value, number(shown));
      }
    }
  }

  bool log_;
  std::vector<std::pair<double, std::string>> ticks_;
  double low_ = 0.0;
  double high_ = 1.0;
  double step_ = 1.0;
};

struct Extent {
  double least = std::numeric_limits<double>::infinity();
  double most = -std::numeric_limits<double>::infinity();
  void add(double value) {
    least = std::min(least, value);
    most = std::max(most, value);
  }
};

double place_x(const Scale& scale, double value) {
  return kLeft + scale.share(value) * (kWidth - kLeft - kRight);
}
double place_y(const Scale& scale, double value) {
  return kHeight - kBottom - scale.share(value) * (kHeight - kTop - kBottom);
}

std::string grid_of(const Scale& x, const Scale& y) {
  std::string svg;
  for (const auto& [value, text] : y.ticks()) {
    const std::string at = number(place_y(y, value));
    svg += "<line class=\"grid\" x1=\"" + number(kLeft) + "\" x2=\"" + number(kWidth - kRight) + "\" y1=\"" + at +
           "\" y2=\"" + at + "\"/>";
    svg += placed("tick", kLeft - 6.0, place_y(y, value) + 4.0, text, " text-anchor=\"end\"");
  }
  for (const auto& [value, text] : x.ticks()) {
    const std::string at = number(place_x(x, value));
    svg += "<line class=\"grid\" y1=\"" + number(kTop) + "\" y2=\"" + number(kHeight - kBottom) + "\" x1=\"" + at +
           "\" x2=\"" + at + "\"/>";
    svg += placed("tick", place_x(x, value), kHeight - kBottom + 16.0, text, " text-anchor=\"middle\"");
  }
  return svg;
}

// Appends the legend to `svg`; returns the height including it.
double add_legend(const std::vector<PlotSeries>& series, std::string& svg) {
  double x = kLeft;
  double y = kHeight + kLegendRow - 4.0;
  for (std::size_t i = 0; i < series.size(); ++i) {
    const double wide = 34.0 + 6.3 * static_cast<double>(series[i].name.size());
    if (x + wide > kWidth && x > kLeft) {
      x = kLeft;
      y += kLegendRow;
    }
    svg += "<line class=\"s" + std::to_string(i) + "\" x1=\"" + number(x) + "\" x2=\"" + number(x + 18.0) + "\" y1=\"" +
           number(y - 4.0) + "\" y2=\"" + number(y - 4.0) + "\"/>" + placed("key", x + 24.0, y, series[i].name);
    x += wide;
  }
  return y + 12.0;
}

}  // namespace

std::string escape_html(const std::string& text) {
  std::string escaped;
  for (const char c : text) {
    switch (c) {
      case '<':
        escaped += "&lt;";
        break;
      case '>':
        escaped += "&gt;";
        break;
      case '&':
        escaped += "&amp;";
        break;
      case '"':
        escaped += "&quot;";
        break;
      default:
        escaped += c;
    }
  }
  return escaped;
}

std::string svg_plot(const std::string& title, const PlotAxis& x_axis, const PlotAxis& y_axis,
                     const std::vector<PlotSeries>& series) {
  Extent x_extent;
  Extent y_extent;
  const auto shown = [&](const std::pair<double, double>& p) {
    return (!x_axis.logarithmic || p.first > 0.0) && (!y_axis.logarithmic || p.second > 0.0);
  };
  for (const PlotSeries& one : series) {
    for (const auto& point : one.points) {
      if (!shown(point)) continue;
      x_extent.add(point.first);
      y_extent.add(point.second);
    }
  }
  if (x_extent.least > x_extent.most) return "<p class=\"none\">" + escape_html(title) + ": nothing was measured.</p>";
  for (const auto& tick : x_axis.ticks) x_extent.add(tick.first);
  const Scale x(x_axis, x_extent.least, x_extent.most);
  const Scale y(y_axis, y_extent.least, y_extent.most);

  std::string svg = placed("title", kLeft, 18.0, title + ", " + y_axis.label) + grid_of(x, y);
  svg += placed("label", kWidth - kRight, kHeight - kBottom + 34.0, x_axis.label, " text-anchor=\"end\"");
  for (std::size_t i = 0; i < series.size(); ++i) {
    std::string points;
    for (const auto& point : series[i].points) {
      if (!shown(point)) continue;
      points += number(place_x(x, point.first)) + "," + number(place_y(y, point.second)) + " ";
    }
    svg += "<polyline class=\"s" + std::to_string(i) + "\" points=\"" + points + "\"/>";
  }
  const double height = add_legend(series, svg);
  return "<svg viewBox=\"0 0 640 " + number(height) + "\" role=\"img\" aria-label=\"" + escape_html(title) + "\">" +
         svg + "</svg>";
}

}  // namespace kerf::load

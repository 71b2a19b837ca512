#pragma once

#include <string>
#include <utility>
#include <vector>

namespace kerf::load {

struct PlotSeries {
  std::string name;
  std::vector<std::pair<double, double>> points;  // x ascending.
};

struct PlotAxis {
  std::string label;
  bool logarithmic = false;  // Values must be > 0; others are left out.
  // Positions and texts of the ticks along this axis. If empty, svg_plot() chooses them.
  std::vector<std::pair<double, std::string>> ticks;
};

// Returns a line plot as an <svg> element for an HTML page, 640 units wide: axes, grid, lines and a legend. Colours are
// the classes s0, s1 ... of the page's style sheet. Without any point it returns a sentence instead.
[[nodiscard]] std::string svg_plot(const std::string& title, const PlotAxis& x, const PlotAxis& y,
                                   const std::vector<PlotSeries>& series);

// Escapes text for an HTML page.
[[nodiscard]] std::string escape_html(const std::string& text);

}  // namespace kerf::load

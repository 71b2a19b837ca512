#pragma once

#include <cmath>
#include <functional>
#include <numbers>
#include <string>
#include <utility>
#include <vector>

#include "server/core/cut/curve.h"

// Makes cuts by which the quality of meshes is judged: smooth and cornered ones, tiny and large loops, many at once,
// crossing ones. They are for a unit square whose edges are `h` long.
namespace kerf::test {

struct CutPattern {
  std::string name;
  std::vector<cut::Curve> curves;  // to be cut one after the other
};

// Returns `count` points of the curve `at`, whose parameter is in [0, 1]. If `closed`, the first point is repeated at
// the end.
inline cut::Polyline sampled(int count, bool closed, const std::function<Eigen::Vector2d(double)>& at) {
  cut::Polyline line;
  for (int i = 0; i < count; ++i) line.points.push_back(at(static_cast<double>(i) / (closed ? count : count - 1)));
  if (closed) line.points.push_back(line.points.front());
  return line;
}

inline Eigen::Vector2d polar(const Eigen::Vector2d& centre, double radius, double angle) {
  return centre + radius * Eigen::Vector2d(std::cos(angle), std::sin(angle));
}

// Returns a zigzag from left to right with `teeth` corners of this angle (degrees).
inline cut::Polyline zigzag(int teeth, double corner_deg) {
  const double step = 0.8 / (teeth + 1);
  const double height = 0.5 * step / std::tan(0.5 * corner_deg * std::numbers::pi / 180.0);
  cut::Polyline line;
  for (int i = 0; i <= teeth + 1; ++i) line.points.emplace_back(0.1 + step * i, 0.503 + height * (i % 2 == 0 ? -1 : 1));
  return line;
}

inline std::vector<cut::Curve> kirigami(int rows, int columns) {
  std::vector<cut::Curve> slits;
  for (int row = 0; row < rows; ++row) {
    for (int column = 0; column < columns; ++column) {
      const double pitch = 0.9 / columns;
      const double x = 0.05 + pitch * (column + 0.15 + (row % 2 == 0 ? 0.0 : 0.15));
      const double y = 0.1 + 0.8 * (row + 0.513) / rows;
      slits.emplace_back(cut::Polyline{{{x, y}, {x + 0.6 * pitch, y}}});
    }
  }
  return slits;
}

inline std::vector<CutPattern> cut_patterns(double h) {
  constexpr double kTurn = 2.0 * std::numbers::pi;
  const Eigen::Vector2d centre(0.5037, 0.4971);
  const auto punch = [&centre](double radius) { return std::vector<cut::Curve>{cut::Circle{centre, radius}}; };
  const auto flower = [&](double s) { return polar(centre, 0.3 + 0.09 * std::sin(12.0 * kTurn * s), kTurn * s); };
  const auto wave = [](double s) { return Eigen::Vector2d(0.1 + 0.8 * s, 0.4973 + 0.03 * std::sin(20.0 * kTurn * s)); };
  const auto loops = [&centre](double s) {
    return Eigen::Vector2d(centre +
                           Eigen::Vector2d(0.36 * std::sin(3.0 * kTurn * s), 0.33 * std::sin(4.0 * kTurn * s + 0.4)));
  };
  const auto spiral = [&centre](double s) { return polar(centre, 0.02 + 0.36 * s, 3.0 * kTurn * s); };
  std::vector<cut::Curve> star;
  for (int arm = 0; arm < 7; ++arm) {
    star.emplace_back(cut::Polyline{{centre, polar(centre, 0.33, kTurn * (arm + 0.21) / 7.0)}});
  }
  std::vector<cut::Curve> comb{cut::Polyline{{{0.15, 0.31}, {0.85, 0.334}}}};
  for (int tooth = 0; tooth < 9; ++tooth) {
    const double x = 0.19 + 0.077 * tooth;
    comb.emplace_back(cut::Polyline{{{x, 0.25}, {x + 0.011, 0.71}}});
  }
  return {
      {"straight", {cut::Polyline{{{-0.1, 0.313}, {1.1, 0.687}}}}},
      {"S-curve", {cut::CubicBezier{{{0.1, 0.2}, {0.9, 0.1}, {0.1, 0.95}, {0.9, 0.8}}}}},
      {"zigzag", {zigzag(11, 60.5)}},
      {"zigzag, 15 degree corners", {zigzag(11, 15.0)}},
      {"flower, 12 petals", {sampled(720, true, flower)}},
      {"punch r = 12 h", punch(12.0 * h)},
      {"punch r = 5 h", punch(5.0 * h)},
      {"punch r = 1.5 h", punch(1.5 * h)},
      {"punch r = 0.6 h", punch(0.6 * h)},
      {"punch r = 0.25 h", punch(0.25 * h)},
      {"20 kirigami slits", kirigami(5, 4)},
      {"sinusoid of 20 waves", {sampled(801, false, wave)}},
      {"self-crossing loops", {sampled(601, true, loops)}},
      {"X of two cuts", {cut::Polyline{{{-0.1, 0.213}, {1.1, 0.767}}}, cut::Polyline{{{0.231, -0.1}, {0.702, 1.1}}}}},
      {"spiral", {sampled(400, false, spiral)}},
      {"star of 7 arms", std::move(star)},
      {"comb", std::move(comb)},
      {"border to inside", {cut::CubicBezier{{{-0.05, 0.52}, {0.2, 0.8}, {0.4, 0.2}, {0.61, 0.55}}}}},
  };
}

}  // namespace kerf::test

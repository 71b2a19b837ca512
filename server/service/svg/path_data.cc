#include "server/service/svg/path_data.h"

#include <array>
#include <cctype>
#include <cmath>
#include <numbers>
#include <optional>
#include <utility>

#include "server/service/svg/scanner.h"

namespace kerf::svg {
namespace {

using Eigen::Vector2d;

class PathReader {
 public:
  PathReader(std::string_view text, std::size_t max_segments) : scanner_(text), max_segments_(max_segments) {}

  PathData run() {
    scanner_.skip_blanks();
    // Each iteration consumes at least one character.
    while (result_.error.empty() && !scanner_.at_end() && num_segments_ <= max_segments_) {
      const char letter = scanner_.peek();
      if (!scanner_.accept(letter) || std::string_view("MmLlHhVvCcSsQqTtAaZz").find(letter) == std::string_view::npos) {
        fail(std::string("'") + letter + "' is not a command");
      } else if (!started_ && letter != 'M' && letter != 'm') {
        fail("path data must start with a moveto");
      } else {
        read_command(letter);
      }
      scanner_.skip_blanks();
    }
    finish_subpath();
    return std::move(result_);
  }

 private:
  // Reads a command with all its repetitions.
  void read_command(char letter) {
    relative_ = std::islower(static_cast<unsigned char>(letter)) != 0;
    char command = static_cast<char>(std::toupper(static_cast<unsigned char>(letter)));
    scanner_.skip_blanks();
    if (command == 'Z') return close();
    bool more = true;
    while (more && num_segments_ <= max_segments_) {
      if (!read_one(command)) return fail(std::string("a number is missing after '") + letter + "'");
      if (command == 'M') command = 'L';  // Further pairs of a moveto are linetos.
      const bool comma = scanner_.skip_separator();
      more = scanner_.at_number();
      if (comma && !more) return fail("no number follows a comma");
    }
  }

  // Reads one set of arguments; returns false if one is missing.
  bool read_one(char command) {
    switch (command) {
      case 'M':
        return move();
      case 'H':
        return line_along(0);
      case 'V':
        return line_along(1);
      case 'C':
        return cubic(false);
      case 'S':
        return cubic(true);
      case 'Q':
        return quadratic(false);
      case 'T':
        return quadratic(true);
      case 'A':
        return arc();
      default:
        return line();
    }
  }

  bool move() {
    const std::optional<Vector2d> to = point();
    if (!to) return false;
    finish_subpath();
    start_ = pen_ = *to;
    started_ = true;
    forget_controls();
    return true;
  }
  bool line() {
    const std::optional<Vector2d> to = point();
    if (to) add(cut::LineTo{*to}, *to);
    return to.has_value();
  }
  bool line_along(int axis) {
    const std::optional<double> value = scanner_.number();
    if (!value) return false;
    Vector2d to = pen_;
    to[axis] = relative_ ? pen_[axis] + *value : *value;
    add(cut::LineTo{to}, to);
    return true;
  }
  bool cubic(bool smooth) {
    std::optional<Vector2d> first = smooth ? mirrored(cubic_control_) : point();
    if (!smooth) scanner_.skip_separator();
    const std::optional<Vector2d> second = first ? point() : std::nullopt;
    scanner_.skip_separator();
    const std::optional<Vector2d> to = second ? point() : std::nullopt;
    if (!to) return false;
    add(cut::CubicTo{{*first, *second}, *to}, *to);
    cubic_control_ = second;
    return true;
  }
  bool quadratic(bool smooth) {
    const std::optional<Vector2d> control = smooth ? mirrored(quadratic_control_) : point();
    if (!smooth) scanner_.skip_separator();
    const std::optional<Vector2d> to = control ? point() : std::nullopt;
    if (!to) return false;
    add(cut::QuadraticTo{*control, *to}, *to);
    quadratic_control_ = control;
    return true;
  }
  bool arc() {
    std::array<double, 3> numbers{};  // Semi-axes, then the rotation in degrees.
    for (double& number : numbers) {
      const std::optional<double> value = scanner_.number();
      if (!value) return false;
      number = *value;
      scanner_.skip_separator();
    }
    const std::optional<bool> large = scanner_.flag();
    scanner_.skip_separator();
    const std::optional<bool> sweep = large ? scanner_.flag() : std::nullopt;
    scanner_.skip_separator();
    const std::optional<Vector2d> to = sweep ? point() : std::nullopt;
    if (!to) return false;
    const Vector2d semi_axes(std::abs(numbers[0]), std::abs(numbers[1]));
    if (semi_axes.minCoeff() == 0.0) {  // SVG 1.1, F.6.6
      add(cut::LineTo{*to}, *to);
    } else {
      const double rotation = std::fmod(numbers[2], 360.0) / 180.0 * std::numbers::pi;
      add(cut::ArcTo{semi_axes, rotation, *large, *sweep, *to}, *to);
    }
    return true;
  }

  void close() {
    subpath_.closed = true;
    finish_subpath();
    pen_ = start_;
    forget_controls();
  }

  std::optional<Vector2d> point() {
    const std::optional<double> x = scanner_.number();
    if (!x) return std::nullopt;
    scanner_.skip_separator();
    const std::optional<double> y = scanner_.number();
    if (!y) return std::nullopt;
    const Vector2d value(*x, *y);
    return relative_ ? Vector2d(pen_ + value) : value;
  }
  [[nodiscard]] std::optional<Vector2d> mirrored(const std::optional<Vector2d>& control) const {
    return control ? Vector2d(2.0 * pen_ - *control) : pen_;
  }

  void add(const cut::Segment& segment, const Vector2d& end) {
    if (subpath_.segments.empty()) subpath_.start = pen_;  // Needed also after a closepath without a moveto.
    subpath_.segments.push_back(segment);
    ++num_segments_;
    pen_ = end;
    forget_controls();
  }
  void finish_subpath() {
    if (!subpath_.segments.empty()) result_.subpaths.push_back(std::move(subpath_));
    subpath_ = cut::Subpath{};
  }
  void forget_controls() {
    cubic_control_.reset();
    quadratic_control_.reset();
  }
  void fail(const std::string& what) { result_.error = "byte " + std::to_string(scanner_.position()) + ": " + what; }

  Scanner scanner_;
  std::size_t max_segments_;
  std::size_t num_segments_ = 0;
  PathData result_;
  cut::Subpath subpath_;
  bool started_ = false;
  bool relative_ = false;
  Vector2d start_{0.0, 0.0};
  Vector2d pen_{0.0, 0.0};
  std::optional<Vector2d> cubic_control_;  // The last control point, if the segment just before has one.
  std::optional<Vector2d> quadratic_control_;
};

}  // namespace

PathData parse_path_data(std::string_view text, std::size_t max_segments) {
  return PathReader(text, max_segments).run();
}

}  // namespace kerf::svg

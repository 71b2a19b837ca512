#include "server/core/cut/dash.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>
#include <utility>

namespace kerf::cut {
namespace {

using Eigen::Vector2d;

double length_of(const Stroke& stroke) {
  double length = 0.0;
  for (std::size_t i = 0; i + 1 < stroke.points.size(); ++i) length += (stroke.points[i + 1] - stroke.points[i]).norm();
  return length;
}

// Walks along strokes and keeps the parts that fall on dashes.
class Dasher {
 public:
  Dasher(const std::vector<double>& cycle, double period, double offset) : cycle_(cycle), slack_(1.0e-12 * period) {
    double into = std::fmod(offset, period);
    if (into < 0.0) into += period;
    while (first_ < cycle_.size() && into >= cycle_[first_]) into -= cycle_[first_++];
    if (first_ == cycle_.size()) {  // only by rounding: the end of the cycle is its start
      first_ = 0;
      into = 0.0;
    }
    into_first_ = into;
  }

  void add(const Stroke& stroke) {
    entry_ = first_;
    left_ = cycle_[first_] - into_first_;
    for (std::size_t i = 0; i + 1 < stroke.points.size(); ++i) add_segment(stroke.points[i], stroke.points[i + 1]);
    end_dash();
  }

  [[nodiscard]] double rounding() const { return rounding_; }
  [[nodiscard]] std::vector<Stroke> take() { return std::move(dashes_); }

 private:
  void add_segment(const Vector2d& a, const Vector2d& b) {
    const double length = (b - a).norm();
    double done = 0.0;
    Vector2d at = a;
    // The loop ends: each pass uses up one entry of the pattern, and dashed() has limited their number.
    while (length - done > left_ + slack_) {
      done += left_;
      const Vector2d next = a + done / length * (b - a);
      rounding_ = std::max(rounding_, 8.0 * std::numeric_limits<double>::epsilon() *
                                          std::max(a.cwiseAbs().maxCoeff(), b.cwiseAbs().maxCoeff()));
      add_stretch(at, next);
      end_dash();
      at = next;
      entry_ = (entry_ + 1) % cycle_.size();
      left_ = cycle_[entry_];
    }
    add_stretch(at, b);
    left_ = std::max(0.0, left_ - (length - done));
  }
  void add_stretch(const Vector2d& from, const Vector2d& to) {
    if (entry_ % 2 != 0) return;  // odd entries are gaps
    if (dash_.points.empty()) dash_.points.push_back(from);
    if (dash_.points.back() != to) dash_.points.push_back(to);
  }
  void end_dash() {
    if (dash_.points.size() >= 2) dashes_.push_back(std::move(dash_));
    dash_ = Stroke{};
  }

  const std::vector<double>& cycle_;  // an even number of lengths: cut, gap, cut, ...
  double slack_;                      // m; no dash begins this near to the end of a segment, where only rounding would
                                      // make it
  std::size_t first_ = 0;             // entry of the cycle in which each stroke begins
  double into_first_ = 0.0;           // m, from the start of that entry
  std::size_t entry_ = 0;
  double left_ = 0.0;  // m, remaining length of entry `entry_`
  Stroke dash_;
  std::vector<Stroke> dashes_;
  double rounding_ = 0.0;
};

}  // namespace

Status validate(const DashPattern& pattern) {
  if (pattern.lengths.size() > kMaxDashLengths) {
    return invalid_argument("DASH_TOO_LONG",
                            "the pattern has " + std::to_string(pattern.lengths.size()) + " lengths; the limit is 64",
                            "cut.dash");
  }
  for (std::size_t i = 0; i < pattern.lengths.size(); ++i) {
    if (pattern.lengths[i] >= kMinDashM && pattern.lengths[i] <= kMaxDashM) continue;  // false for NaN
    const std::string field = "cut.dash[" + std::to_string(i) + "]";
    return invalid_argument("DASH_OUT_OF_RANGE",
                            field + " is " + std::to_string(pattern.lengths[i]) + " m; allowed is 1e-6 to 1e4 m",
                            field);
  }
  if (std::abs(pattern.offset) <= kMaxDashM) return Nothing{};
  return invalid_argument("DASH_OUT_OF_RANGE",
                          "cut.dash_offset is " + std::to_string(pattern.offset) + " m; allowed is -1e4 to 1e4 m",
                          "cut.dash_offset");
}

Result<FlatCurve> dashed(const FlatCurve& curve, const DashPattern& pattern) {
  if (pattern.lengths.empty()) return curve;
  std::vector<double> cycle = pattern.lengths;
  if (cycle.size() % 2 != 0) cycle.insert(cycle.end(), pattern.lengths.begin(), pattern.lengths.end());
  double period = 0.0;
  for (const double length : cycle) period += length;
  double dashes = 0.0;
  for (const Stroke& stroke : curve.strokes) {
    dashes += std::ceil(length_of(stroke) / period + 1.0) * static_cast<double>(cycle.size()) / 2.0;
  }
  if (dashes > kMaxDashes) {
    return resource_exhausted("TOO_MANY_DASHES",
                              "the pattern divides the curve into up to " +
                                  std::to_string(static_cast<std::int64_t>(std::min(dashes, 1.0e15))) +
                                  " dashes; the limit is 10000: lengthen the pattern or split the cut",
                              "cut.dash");
  }
  Dasher dasher(cycle, period, pattern.offset);
  for (const Stroke& stroke : curve.strokes) dasher.add(stroke);
  FlatCurve result;
  result.deviation_m = curve.deviation_m + dasher.rounding();
  result.strokes = dasher.take();
  return result;
}

}  // namespace kerf::cut

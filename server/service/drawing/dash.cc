#include "server/service/drawing/dash.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <utility>

#include "server/service/drawing/arc_length.h"
#include "server/service/drawing/drawing.h"

namespace kerf::drawing {
namespace {

using Eigen::Vector2d;

// Finds parameters of a segment by the length from its start.
class LengthTable {
 public:
  LengthTable(const Vector2d& start, const cut::Segment& segment) : start_(start), segment_(segment) {
    const bool is_line = std::holds_alternative<cut::LineTo>(segment);
    const int count = is_line ? 1 : kSteps;
    lengths_.push_back(0.0);
    for (int i = 0; i < count; ++i) {
      const Part part = part_of(start, segment, at(i, count), at(i + 1, count));
      lengths_.push_back(lengths_.back() + length_of(part.start, part.segment));
    }
  }

  [[nodiscard]] double length() const { return lengths_.back(); }

  [[nodiscard]] double parameter(double length) const {
    if (!(length > 0.0)) return 0.0;
    if (length >= lengths_.back()) return 1.0;
    const auto count = static_cast<int>(lengths_.size()) - 1;
    const auto above = std::upper_bound(lengths_.begin(), lengths_.end(), length);
    const int step = std::min(static_cast<int>(above - lengths_.begin()) - 1, count - 1);
    const double before = lengths_[static_cast<std::size_t>(step)];
    double low = at(step, count);
    double high = at(step + 1, count);
    const double first = low;
    double low_length = before;
    double high_length = lengths_[static_cast<std::size_t>(step) + 1];
    // Regula falsi within the step; a step is nearly uniform, so a few suffice.
    for (int i = 0; i < 6 && high_length > low_length && count > 1; ++i) {
      const double t = low + (high - low) * (length - low_length) / (high_length - low_length);
      if (!(t > low && t < high)) break;
      const Part part = part_of(start_, segment_, first, t);
      const double reached = before + length_of(part.start, part.segment);
      (reached < length ? low : high) = t;
      (reached < length ? low_length : high_length) = reached;
    }
    if (!(high_length > low_length)) return low;
    return low + (high - low) * (length - low_length) / (high_length - low_length);
  }

 private:
  static constexpr int kSteps = 16;
  static double at(int i, int count) { return static_cast<double>(i) / count; }

  Vector2d start_;
  cut::Segment segment_;
  std::vector<double> lengths_;
};

// Walks along a line and collects what the pattern draws.
class Dasher {
 public:
  Dasher(const Dashes& dashes, std::size_t most) : pattern_(dashes.lengths), most_(most) {
    if (pattern_.size() % 2 == 1) pattern_.insert(pattern_.end(), dashes.lengths.begin(), dashes.lengths.end());
    const double total = std::accumulate(pattern_.begin(), pattern_.end(), 0.0);  // > 0
    double offset = std::fmod(dashes.offset, total);
    if (offset < 0.0) offset += total;
    while (offset >= pattern_[at_] && offset > 0.0) {
      offset -= pattern_[at_];
      at_ = (at_ + 1) % pattern_.size();
    }
    left_ = pattern_[at_] - offset;
  }

  std::vector<cut::Subpath> run(const cut::Subpath& line) {
    is_start_ = true;
    Vector2d start = line.start;
    for (const cut::Segment& segment : line.segments) {
      add(start, segment);
      start = end_of(segment);
    }
    if (line.closed && start != line.start) add(start, cut::LineTo{line.start});
    finish(false);
    return std::move(result_);
  }

 private:
  void add(const Vector2d& start, const cut::Segment& segment) {
    const LengthTable table(start, segment);
    double done = 0.0;
    while (done < table.length() && num_steps_ <= most_) {
      ++num_steps_;
      const double step = std::min(left_, table.length() - done);
      const bool ends = left_ <= table.length() - done;
      if (at_ % 2 == 0) draw(start, segment, table, done, done + step);
      done += step;
      left_ -= step;
      is_start_ = is_start_ && step == 0.0;
      if (!ends) continue;
      if (at_ % 2 == 0) finish(true);
      at_ = (at_ + 1) % pattern_.size();
      left_ = pattern_[at_];
    }
  }

  void draw(const Vector2d& start, const cut::Segment& segment, const LengthTable& table, double from, double to) {
    const double first = table.parameter(from);
    const double last = table.parameter(to);
    if (!(last > first)) return;
    const Part part = part_of(start, segment, first, last);
    if (open_.segments.empty()) {
      open_.start = part.start;
      keeps_start_ = !is_start_;
    }
    open_.segments.push_back(part.segment);
  }

  // Ends the dash that is being drawn, if there is one.
  void finish(bool keeps_end) {
    if (!open_.segments.empty()) {
      keep_ends(open_, keeps_start_, keeps_end);
      result_.push_back(std::move(open_));
    }
    open_ = {};
  }

  std::vector<double> pattern_;
  std::size_t most_;
  std::size_t at_ = 0;    // Index of the present length; even ones are drawn.
  double left_ = 0.0;     // Rest of the present length.
  bool is_start_ = true;  // Nothing of the line is behind.
  bool keeps_start_ = false;
  cut::Subpath open_;
  std::size_t num_steps_ = 0;
  std::vector<cut::Subpath> result_;
};

}  // namespace

void keep_ends(cut::Subpath& line, bool start, bool end) {
  if (start) line.segments.insert(line.segments.begin(), cut::LineTo{line.start});
  if (end) line.segments.emplace_back(cut::LineTo{end_of(line.segments.back())});
}

double total_length(const Dashes& dashes) {
  return std::accumulate(dashes.lengths.begin(), dashes.lengths.end(), 0.0);
}

std::vector<cut::Subpath> dashed(const cut::Subpath& line, const Dashes& dashes, std::size_t most) {
  return Dasher(dashes, most).run(line);
}

}  // namespace kerf::drawing

#include "server/service/drawing/closing.h"

#include <algorithm>
#include <cstddef>
#include <cstring>
#include <set>
#include <string>
#include <utility>
#include <variant>
#include <vector>

#include "server/base/overloaded.h"
#include "server/core/cut/fit.h"
#include "server/service/drawing/arc_length.h"

namespace kerf::drawing {
namespace {

using Eigen::Vector2d;

constexpr std::size_t kNone = static_cast<std::size_t>(-1);
constexpr std::size_t kMostNear = 8;  // Ends that are compared with each, in the order of x.

bool is_open(const cut::Subpath& line) {
  return !line.closed && !line.segments.empty() && end_of(line.segments.back()) != line.start;
}

// A line that is only a point is a mark of a box, see placing.h.
bool is_mark(const cut::Subpath& line) {
  return line.segments.size() == 1 && end_of(line.segments.front()) == line.start;
}

cut::Subpath reversed(const cut::Subpath& line) {
  cut::Subpath result{line.start, {}, line.closed};
  Vector2d at = line.start;
  for (const cut::Segment& segment : line.segments) {
    result.segments.push_back(
        std::visit(Overloaded{
                       [&](const cut::LineTo&) -> cut::Segment { return cut::LineTo{at}; },
                       [&](const cut::QuadraticTo& each) -> cut::Segment {
                         return cut::QuadraticTo{each.control, at, {each.weights[2], each.weights[1], each.weights[0]}};
                       },
                       [&](const cut::CubicTo& each) -> cut::Segment {
                         return cut::CubicTo{{each.controls[1], each.controls[0]},
                                             at,
                                             {each.weights[3], each.weights[2], each.weights[1], each.weights[0]}};
                       },
                       [&](const cut::ArcTo& each) -> cut::Segment {
                         return cut::ArcTo{each.semi_axes, each.rotation, each.large, !each.counter_clockwise, at};
                       },
                   },
                   segment));
    at = end_of(segment);
  }
  result.start = at;
  std::reverse(result.segments.begin(), result.segments.end());
  return result;
}

// Returns the numbers of a line as bytes, which are the same for the same line in either direction.
std::string bytes_of(const cut::Subpath& line) {
  const auto written = [](const cut::Subpath& one) {
    std::string bytes(1, one.closed ? 'c' : 'o');
    const auto add = [&bytes](const Vector2d& point) {
      const Vector2d positive = point + Vector2d::Zero();  // Zero has one sign.
      bytes.append(reinterpret_cast<const char*>(positive.data()), 2 * sizeof(double));
    };
    add(one.start);
    for (const cut::Segment& segment : one.segments) {
      bytes += static_cast<char>('0' + segment.index());
      if (const auto* quadratic = std::get_if<cut::QuadraticTo>(&segment)) add(quadratic->control);
      if (const auto* cubic = std::get_if<cut::CubicTo>(&segment)) add(cubic->controls[0]), add(cubic->controls[1]);
      add(end_of(segment));
    }
    return bytes;
  };
  return std::min(written(line), written(reversed(line)));
}

void leave_out_copies(std::vector<cut::Subpath>& lines) {
  std::set<std::string> known;
  std::erase_if(lines,
                [&known](const cut::Subpath& line) { return !is_mark(line) && !known.insert(bytes_of(line)).second; });
}

// Pairs the ends of lines. End 2 i is the start of line i, and 2 i + 1 its end.
std::vector<std::size_t> partners_of(const std::vector<cut::Subpath>& lines, double tolerance) {
  struct End {
    Vector2d at;
    std::size_t index = 0;
  };
  std::vector<End> ends;
  for (std::size_t i = 0; i < lines.size(); ++i) {
    if (!is_open(lines[i])) continue;
    ends.push_back({lines[i].start, 2 * i});
    ends.push_back({end_of(lines[i].segments.back()), 2 * i + 1});
  }
  std::sort(ends.begin(), ends.end(), [](const End& a, const End& b) {
    return std::tuple(a.at.x(), a.at.y(), a.index) < std::tuple(b.at.x(), b.at.y(), b.index);
  });
  struct Pair {
    double distance = 0.0;
    std::size_t a = 0;
    std::size_t b = 0;
  };
  std::vector<Pair> pairs;
  for (std::size_t i = 0; i < ends.size(); ++i) {
    std::size_t near = 0;
    for (std::size_t j = i + 1; j < ends.size() && near < kMostNear; ++j) {
      if (ends[j].at.x() - ends[i].at.x() > tolerance) break;
      const double distance = (ends[j].at - ends[i].at).norm();
      if (distance > tolerance) continue;
      ++near;
      pairs.push_back({distance, ends[i].index, ends[j].index});
    }
  }
  std::sort(pairs.begin(), pairs.end(), [](const Pair& a, const Pair& b) {
    return std::tuple(a.distance, a.a, a.b) < std::tuple(b.distance, b.a, b.b);
  });
  std::vector<std::size_t> partners(2 * lines.size(), kNone);
  for (const Pair& pair : pairs) {
    if (partners[pair.a] != kNone || partners[pair.b] != kNone) continue;
    partners[pair.a] = pair.b;
    partners[pair.b] = pair.a;
  }
  return partners;
}

}  // namespace

void close_lines(cut::Path& path) {
  std::vector<cut::Subpath>& lines = path.subpaths;
  leave_out_copies(lines);
  const cut::Box box = cut::extent(cut::Curve(path));
  const std::vector<std::size_t> partners = partners_of(lines, kClosingShare * (box.high - box.low).maxCoeff());
  std::vector<bool> is_taken(lines.size());
  std::vector<cut::Subpath> result;
  for (std::size_t i = 0; i < lines.size(); ++i) {
    if (is_taken[i]) continue;
    // Follows the chain from the end of the line; it is closed if it comes back to its start.
    std::vector<std::size_t> chain;  // Ends at which lines are left.
    std::size_t end = 2 * i + 1;
    bool is_closed = false;
    while (is_open(lines[i]) && chain.size() <= lines.size()) {
      chain.push_back(end);
      const std::size_t next = partners[end];
      if (next == kNone) break;
      is_closed = next == 2 * i;
      if (is_closed) break;
      end = next ^ 1U;
    }
    if (!is_closed) {
      result.push_back(lines[i]);
      continue;
    }
    cut::Subpath closed{lines[i].start, {}, true};
    for (const std::size_t left : chain) {
      is_taken[left / 2] = true;
      const cut::Subpath& line = lines[left / 2];
      const cut::Subpath along = left % 2 == 1 ? line : reversed(line);
      closed.segments.insert(closed.segments.end(), along.segments.begin(), along.segments.end());
    }
    std::visit([&closed](auto& last) { last.end = closed.start; }, closed.segments.back());
    result.push_back(std::move(closed));
  }
  lines = std::move(result);
}

}  // namespace kerf::drawing

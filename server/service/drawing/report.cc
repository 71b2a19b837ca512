#include "server/service/drawing/report.h"

#include <algorithm>
#include <map>
#include <utility>

#include "server/core/cut/fit.h"
#include "server/core/cut/join.h"
#include "server/service/drawing/arc_length.h"
#include "server/service/drawing/colour.h"
#include "server/service/drawing/selector.h"

namespace kerf::drawing {
namespace {

// Adds up the shapes of each selector, in the order in which a drawing has them.
class GroupCounter {
 public:
  explicit GroupCounter(const Drawing& drawing) : drawing_(drawing) {
    for (const Group& group : drawing.groups) of_group_.push_back(index_of(group.selector));
  }

  void add(const Shape& shape) {
    ++stamp_;
    double length = 0.0;
    for (const cut::Subpath& line : shape.lines) length += length_of(line);
    const auto count = [&](std::size_t index) {
      if (stamps_[index] == stamp_) return;  // A group within one of the same name.
      stamps_[index] = stamp_;
      GroupReport& report = reports_[index];
      ++(shape.is_painted ? report.shapes : report.hidden_shapes);
      report.length += length;
    };
    if (shape.stroke) count(index_of("stroke=" + name_of_colour(*shape.stroke)));
    if (shape.fill) count(index_of("fill=" + name_of_colour(*shape.fill)));
    for (int at = shape.group; at != kNoGroup; at = drawing_.groups[static_cast<std::size_t>(at)].parent) {
      count(of_group_[static_cast<std::size_t>(at)]);
    }
  }

  std::vector<GroupReport> take() {
    std::erase_if(reports_, [](const GroupReport& each) { return each.shapes + each.hidden_shapes == 0; });
    std::stable_sort(reports_.begin(), reports_.end(),
                     [](const GroupReport& a, const GroupReport& b) { return rank(a.selector) < rank(b.selector); });
    if (reports_.size() > kMaxReportedGroups) reports_.resize(kMaxReportedGroups);
    return std::move(reports_);
  }

 private:
  static int rank(const std::string& selector) {
    constexpr std::string_view kOrder = "lsf.#";  // layer, stroke, fill, classes, ids
    return static_cast<int>(kOrder.find(selector.front()));
  }

  std::size_t index_of(const std::string& selector) {
    const auto [found, is_new] = indices_.try_emplace(selector, reports_.size());
    if (is_new) {
      reports_.push_back({selector});
      stamps_.push_back(0);
    }
    return found->second;
  }

  const Drawing& drawing_;
  std::map<std::string, std::size_t> indices_;
  std::vector<GroupReport> reports_;
  std::vector<int> stamps_;  // The last shape that counted, by selector.
  std::vector<std::size_t> of_group_;
  int stamp_ = 0;
};

bool is_closed(const cut::Subpath& line) {
  return line.closed || end_of(line.segments.back()) == line.start;
}

std::vector<cut::Stroke> preview_of(const cut::Curve& curve, double size) {
  for (const double accuracy : {1e-3, 4e-3, 1.6e-2}) {
    std::vector<cut::Stroke> strokes = cut::flatten(curve, accuracy * size).strokes;
    std::size_t count = 0;
    for (const cut::Stroke& stroke : strokes) count += stroke.points.size();
    if (count <= kMaxPreviewPoints) return strokes;
  }
  return {};
}

}  // namespace

Result<Report> report_on(const Drawing& drawing, const Reading& reading, const std::string& kind,
                         const std::string& field) {
  Report report;
  report.format = drawing.format;
  if (drawing.page) report.page = drawing.page->high - drawing.page->low;
  GroupCounter counter(drawing);
  for (const Shape& shape : drawing.shapes) counter.add(shape);
  report.groups = counter.take();
  Reading at_true_size = reading;
  at_true_size.true_size = true;
  at_true_size.at.reset();
  at_true_size.fit_page = false;
  Result<Placed> placed = place(drawing, at_true_size, kind, field);
  if (!placed.ok()) {
    if (placed.error().reason.find("SELECTOR_") == 0) return placed.error();
    report.warnings = {placed.error().message};
    return report;
  }
  report.warnings = std::move(placed->notes);
  const cut::Curve curve(std::move(placed->path));
  report.box = cut::extent(curve);
  for (const cut::Subpath& line : std::get<cut::Path>(curve).subpaths) {
    ++report.lines;
    report.closed_lines += is_closed(line) ? 1 : 0;
    report.length += length_of(line);
  }
  const double size = (report.box.high - report.box.low).maxCoeff();
  report.preview = preview_of(curve, size);
  const cut::JoinReport joins =
      cut::near_ends(cut::flatten(curve, 0.1 * kNearEnds * size).strokes, kNearEnds * size, cut::kept_ends(curve));
  report.near_ends = joins.near_ends;
  report.nearest_end = joins.nearest_end_m;
  return report;
}

}  // namespace kerf::drawing

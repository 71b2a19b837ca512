#include "server/service/wire/drawing_codec.h"

#include <utility>

#include "server/service/drawing/report.h"
#include "server/service/dxf/dxf.h"
#include "server/service/svg/svg.h"

namespace kerf::wire {
namespace {

Result<DecodedCurve> placed_curve(const drawing::Drawing& read, const drawing::Reading& reading,
                                  const std::string& kind, const std::string& path) {
  KERF_TRY_ASSIGN(drawing::Placed placed, drawing::place(read, reading, kind, path));
  return DecodedCurve{std::move(placed.path), std::move(placed.notes), true, reading.true_size};
}

void encode_report(const drawing::Report& report, v1::DrawingReport& message) {
  message.set_format(report.format);
  message.set_page_width_m(report.page.x());
  message.set_page_height_m(report.page.y());
  encode_vector(report.box.low, *message.mutable_min());
  encode_vector(report.box.high, *message.mutable_max());
  message.set_lines(report.lines);
  message.set_closed_lines(report.closed_lines);
  message.set_length_m(report.length);
  for (const drawing::GroupReport& group : report.groups) {
    v1::DrawingGroup& to = *message.add_groups();
    to.set_selector(group.selector);
    to.set_shapes(group.shapes);
    to.set_hidden_shapes(group.hidden_shapes);
    to.set_length_m(group.length);
  }
  for (const std::string& warning : report.warnings) message.add_warnings(warning);
  for (const cut::Stroke& stroke : report.preview) {
    v1::Polyline& line = *message.add_preview();
    for (const Eigen::Vector2d& point : stroke.points) encode_vector(point, *line.add_points());
  }
  message.set_near_ends(report.near_ends);
  message.set_nearest_end_m(report.nearest_end);
}

template <typename Message>
Result<v1::DrawingReport> report_of(const Message& message, const std::string& kind, const std::string& path) {
  KERF_TRY_ASSIGN(const drawing::Reading reading, decode_reading(message.reading(), path + ".reading"));
  KERF_TRY_ASSIGN(const drawing::Drawing read, read_drawing(message, reading, path, {}));
  KERF_TRY_ASSIGN(const drawing::Report report, drawing::report_on(read, reading, kind, path));
  v1::DrawingReport result;
  encode_report(report, result);
  return result;
}

}  // namespace

Result<v1::DrawingReport> inspect_drawing(const v1::InspectDrawingRequest& request) {
  switch (request.drawing_case()) {
    case v1::InspectDrawingRequest::kSvg:
      return report_of(request.svg(), "SVG", "svg");
    case v1::InspectDrawingRequest::kDxf:
      return report_of(request.dxf(), "DXF", "dxf");
    case v1::InspectDrawingRequest::DRAWING_NOT_SET:
      break;
  }
  return choice_missing("drawing", "svg or dxf");
}

Result<drawing::Reading> decode_reading(const v1::DrawingReading& message, const std::string& path) {
  drawing::Reading reading;
  reading.only.assign(message.only().begin(), message.only().end());
  reading.all_shapes = message.all_shapes();
  reading.true_size = message.true_size();
  if (message.has_at()) reading.at = decode_vector(message.at());
  reading.fit_page = message.fit_page();
  reading.unit = message.unit_m();
  KERF_TRY(drawing::validate(reading, path));
  return reading;
}

Result<drawing::Drawing> read_drawing(const v1::Svg& message, const drawing::Reading& reading, const std::string& path,
                                      const FileReader& read_file) {
  if (!message.text().empty() && !message.data().empty()) {
    return invalid_argument("SVG_TWICE", path + ".text and " + path + ".data are both given; give one of them",
                            path + ".data");
  }
  const std::string& given = message.data().empty() ? message.text() : message.data();
  const std::string field = message.data().empty() ? "text" : "data";
  KERF_TRY_ASSIGN(const std::string content, read_content({given, message.file(), field}, read_file, "SVG", path));
  return svg::read(content, {reading.unit, reading.dashes});
}

Result<drawing::Drawing> read_drawing(const v1::Dxf& message, const drawing::Reading& reading, const std::string& path,
                                      const FileReader& read_file) {
  KERF_TRY_ASSIGN(const std::string content,
                  read_content({message.data(), message.file(), "data"}, read_file, "DXF", path));
  return dxf::read(content, reading.unit);
}

Result<DecodedCurve> decode_drawing(const v1::Dxf& message, const std::string& path, const FileReader& read_file) {
  KERF_TRY_ASSIGN(const drawing::Reading reading, decode_reading(message.reading(), path + ".reading"));
  KERF_TRY_ASSIGN(const drawing::Drawing read, read_drawing(message, reading, path, read_file));
  return placed_curve(read, reading, "DXF", path);
}

Result<DecodedCurve> decode_drawing(const v1::Svg& message, const std::string& path, const FileReader& read_file,
                                    bool dashes) {
  KERF_TRY_ASSIGN(drawing::Reading reading, decode_reading(message.reading(), path + ".reading"));
  reading.dashes = dashes;
  KERF_TRY_ASSIGN(const drawing::Drawing read, read_drawing(message, reading, path, read_file));
  return placed_curve(read, reading, "SVG", path);
}

}  // namespace kerf::wire

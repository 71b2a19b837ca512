#include "server/service/dxf/dxf.h"

#include <array>
#include <cmath>
#include <string>
#include <vector>

#include "server/base/text_encoding.h"
#include "server/service/drawing/inflate.h"
#include "server/service/dxf/code_page.h"
#include "server/service/dxf/entity.h"
#include "server/service/dxf/walk_blocks.h"

namespace kerf::dxf {
namespace {

constexpr const char* kDxfField = "cut.curve.dxf";
constexpr std::size_t kStartBytes = 1024;  // More than enough to know a DXF by.
constexpr int kInches = 1;                 // The code of $INSUNITS.
constexpr std::string_view kBinary = "AutoCAD Binary DXF";

// Metres of the units of $INSUNITS. The first is that of drawings that name none.
constexpr std::array<double, 21> kMetres{1e-3,
                                         0.0254,
                                         0.3048,
                                         1609.344,
                                         1e-3,
                                         1e-2,
                                         1.0,
                                         1e3,
                                         2.54e-8,
                                         2.54e-5,
                                         0.9144,
                                         1e-10,
                                         1e-9,
                                         1e-6,
                                         0.1,
                                         10.0,
                                         100.0,
                                         1e9,
                                         1.495978707e11,
                                         9.4607304725808e15,
                                         3.0856775814913673e16};

bool is_unit(int units) {
  return units >= 0 && units < static_cast<int>(kMetres.size());
}

// Returns the metres of $INSUNITS; millimetres if it names none.
double metres_of(int units) {
  return is_unit(units) ? kMetres[static_cast<std::size_t>(units)] : kMetres[0];
}

bool is_dwg(std::string_view data) {
  return data.size() > 6 && data.substr(0, 4) == "AC10" && data[4] >= '0' && data[4] <= '9';
}

}  // namespace

bool is_dxf(std::string_view data) {
  if (drawing::is_gzip(data)) {
    const std::string start = drawing::inflated_start(data, 2 * kStartBytes);
    return !drawing::is_gzip(start) && is_dxf(start);
  }
  if (data.substr(0, kBinary.size()) == kBinary || is_dwg(data)) return true;
  if (data.starts_with("\xff\xfe") || data.starts_with("\xfe\xff")) {
    return is_dxf(utf8_text(std::string(data.substr(0, 2 * kStartBytes))));
  }
  const std::string_view text = without_byte_order_mark(data);
  const std::size_t from = text.find_first_not_of(" \t\r\n");
  if (from == std::string_view::npos) return false;
  const std::string_view start = text.substr(from, 8);
  return start.substr(0, 3) == "999" ||
         (start.size() > 1 && (start[0] == '0') && (start[1] == '\r' || start[1] == '\n' || start[1] == ' '));
}

Result<drawing::Drawing> read(std::string_view data, double unit) {
  if (drawing::is_gzip(data)) {
    KERF_TRY_ASSIGN(const std::string unpacked, drawing::inflated(data, "DXF", kDxfField));
    return read(unpacked, unit);
  }
  if (data.size() > kMaxFileBytes) {
    return invalid_argument("DXF_TOO_LARGE",
                            "the drawing has " + std::to_string(data.size()) + " bytes; the limit is 4 MiB", kDxfField);
  }
  if (data.substr(0, kBinary.size()) == kBinary) {
    return invalid_argument("DXF_BINARY", "the drawing is a binary DXF; save it as a DXF of text (ASCII)", kDxfField);
  }
  if (is_dwg(data)) {
    return invalid_argument("DXF_BINARY", "the drawing is a DWG file; save it as a DXF of text (ASCII)", kDxfField);
  }
  if (const std::size_t first = data.find_first_not_of(" \t\r\n");
      first != std::string_view::npos && data[first] == '<') {
    return invalid_argument("DXF_MALFORMED", "the file is XML, such as SVG, and this reads DXF", kDxfField);
  }
  const DecodedText decoded = dxf::decoded(std::string(data));
  KERF_TRY_ASSIGN(const std::vector<Group> groups, groups_of(decoded.text));
  KERF_TRY_ASSIGN(const File file, divided(groups));
  const bool is_in_inches = file.units == 0 && file.measurement == 0;
  BlockWalk walk(file, unit > 0.0 ? unit : metres_of(is_in_inches ? kInches : file.units));
  if (!decoded.unread.empty()) {
    walk.add_note("DXF: code page " + decoded.unread + ": names are taken as ISO-8859-1, and may be wrong");
  }
  if (!(unit > 0.0) && !is_unit(file.units)) {
    walk.add_note("DXF: unit " + std::to_string(file.units) + " ($INSUNITS) is unknown: taken as millimetres");
  }
  if (!(unit > 0.0) && file.units == 0 && file.measurement) {
    walk.add_note(std::string("DXF: it names no unit ($INSUNITS): taken as ") +
                  (is_in_inches ? "inches" : "millimetres") + ", for which $MEASUREMENT stands");
  }
  KERF_TRY(walk.run());
  return walk.take_drawing();
}

}  // namespace kerf::dxf

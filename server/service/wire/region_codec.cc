#include "server/service/wire/region_codec.h"

#include <utility>
#include <variant>

#include "server/base/overloaded.h"
#include "server/service/wire/geometry_codec.h"

namespace kerf::wire {
namespace {

constexpr double kDefaultAirDensity = 1.2;       // kg/m^3
constexpr double kDefaultDragCoefficient = 1.0;  // -

Result<scene::Region> decode_edge(v1::Region::Edge edge, const std::string& path) {
  switch (edge) {
    case v1::Region::TOP:
      return scene::Region(scene::RegionEdge::kTop);
    case v1::Region::BOTTOM:
      return scene::Region(scene::RegionEdge::kBottom);
    case v1::Region::LEFT:
      return scene::Region(scene::RegionEdge::kLeft);
    case v1::Region::RIGHT:
      return scene::Region(scene::RegionEdge::kRight);
    case v1::Region::CORNERS:
      return scene::Region(scene::RegionEdge::kCorners);
    case v1::Region::TOP_CORNERS:
      return scene::Region(scene::RegionEdge::kTopCorners);
    default:
      return unknown_enum(path, static_cast<int>(edge));
  }
}

v1::Region::Edge encode_edge(scene::RegionEdge edge) {
  switch (edge) {
    case scene::RegionEdge::kTop:
      return v1::Region::TOP;
    case scene::RegionEdge::kBottom:
      return v1::Region::BOTTOM;
    case scene::RegionEdge::kLeft:
      return v1::Region::LEFT;
    case scene::RegionEdge::kRight:
      return v1::Region::RIGHT;
    case scene::RegionEdge::kCorners:
      return v1::Region::CORNERS;
    case scene::RegionEdge::kTopCorners:
      return v1::Region::TOP_CORNERS;
  }
  return v1::Region::EDGE_UNSPECIFIED;
}

Result<scene::MaterialLine::Side> decode_side(v1::MaterialLine::Side side, const std::string& path) {
  switch (side) {
    case v1::MaterialLine::SIDE_UNSPECIFIED:
    case v1::MaterialLine::BOTH:
      return scene::MaterialLine::Side::kBoth;
    case v1::MaterialLine::LEFT_OF_LINE:
      return scene::MaterialLine::Side::kLeft;
    case v1::MaterialLine::RIGHT_OF_LINE:
      return scene::MaterialLine::Side::kRight;
    default:
      return unknown_enum(path, static_cast<int>(side));
  }
}

v1::MaterialLine::Side encode_side(scene::MaterialLine::Side side) {
  if (side == scene::MaterialLine::Side::kBoth) return v1::MaterialLine::SIDE_UNSPECIFIED;
  return side == scene::MaterialLine::Side::kLeft ? v1::MaterialLine::LEFT_OF_LINE : v1::MaterialLine::RIGHT_OF_LINE;
}

Result<scene::Region> decode_line(const v1::MaterialLine& message, const std::string& path) {
  KERF_TRY_ASSIGN(const scene::MaterialLine::Side side, decode_side(message.side(), path + ".side"));
  return scene::Region(
      scene::MaterialLine{decode_vector(message.a()), decode_vector(message.b()), message.within_m(), side});
}

Result<scene::Region> decode_along(const v1::MaterialCurve& message, const std::string& path) {
  KERF_TRY_ASSIGN(DecodedCurve curve, decode_curve(message.curve(), path + ".curve", {}));
  KERF_TRY_ASSIGN(const scene::MaterialLine::Side side, decode_side(message.side(), path + ".side"));
  return scene::Region(scene::MaterialCurve{std::move(curve.curve), message.within_m(), side});
}

void encode_line(const scene::MaterialLine& line, v1::MaterialLine& message) {
  encode_vector(line.a, *message.mutable_a());
  encode_vector(line.b, *message.mutable_b());
  message.set_within_m(line.within);
  message.set_side(encode_side(line.side));
}

Result<scene::Region> decode_shape(const v1::Region& region, const std::string& path) {
  switch (region.region_case()) {
    case v1::Region::kEdge:
      return decode_edge(region.edge(), path + ".edge");
    case v1::Region::kBox:
      return scene::Region(scene::MaterialBox{decode_vector(region.box().min()), decode_vector(region.box().max())});
    case v1::Region::kVertices:
      return scene::Region(
          std::vector<mesh::VertexId>(region.vertices().vertices().begin(), region.vertices().vertices().end()));
    case v1::Region::kLine:
      return decode_line(region.line(), path + ".line");
    case v1::Region::kNearest:
      return scene::Region(scene::NearestVertex{decode_vector(region.nearest())});
    case v1::Region::kCurve:
      return decode_along(region.curve(), path + ".curve");
    case v1::Region::kBorder:
      return scene::Region(scene::NearestBorder{decode_vector(region.border())});
    case v1::Region::kAll:
      if (region.all()) return scene::Region(scene::WholeSheet{});
      break;
    case v1::Region::REGION_NOT_SET:
      break;
  }
  return choice_missing(path + ".region", "edge, box, vertices, line, nearest, all, curve or border");
}

}  // namespace

Result<scene::Region> decode_region(const v1::Region& region, const std::string& path) {
  Result<scene::Region> decoded = decode_shape(region, path);
  if (decoded.ok()) decoded->component = region.component();
  return decoded;
}

Result<std::vector<scene::Region>> decode_pins(const RegionMessages& pins, const std::string& path) {
  std::vector<scene::Region> decoded;
  for (int i = 0; i < pins.size(); ++i) {
    KERF_TRY_ASSIGN(scene::Region pin, decode_region(pins[i], path + "[" + std::to_string(i) + "]"));
    decoded.push_back(std::move(pin));
  }
  return decoded;
}

void encode_region(const scene::Region& region, v1::Region& message) {
  message.set_component(region.component);
  std::visit(
      Overloaded{
          [&message](scene::RegionEdge edge) { message.set_edge(encode_edge(edge)); },
          [&message](const scene::MaterialBox& box) {
            encode_vector(box.min, *message.mutable_box()->mutable_min());
            encode_vector(box.max, *message.mutable_box()->mutable_max());
          },
          [&message](const std::vector<mesh::VertexId>& ids) {
            message.mutable_vertices()->mutable_vertices()->Assign(ids.begin(), ids.end());
          },
          [&message](const scene::MaterialLine& line) { encode_line(line, *message.mutable_line()); },
          [&message](const scene::NearestVertex& nearest) { encode_vector(nearest.point, *message.mutable_nearest()); },
          [&message](const scene::WholeSheet& /*whole*/) { message.set_all(true); },
          [&message](const scene::MaterialCurve& curve) {
            encode_curve(curve.curve, *message.mutable_curve()->mutable_curve());
            message.mutable_curve()->set_within_m(curve.within);
            message.mutable_curve()->set_side(encode_side(curve.side));
          },
          [&message](const scene::NearestBorder& border) { encode_vector(border.point, *message.mutable_border()); },
      },
      region.shape);
}

void encode_pins(const std::vector<scene::Region>& pins, RegionMessages& messages) {
  for (const scene::Region& pin : pins) encode_region(pin, *messages.Add());
}

scene::Wind decode_wind(const v1::Wind& wind) {
  scene::Wind decoded;
  decoded.velocity = decode_vector(wind.velocity_mps());
  decoded.air_density = wind.air_density_kgpm3() == 0.0 ? kDefaultAirDensity : wind.air_density_kgpm3();
  decoded.drag_coefficient = wind.drag_coefficient() == 0.0 ? kDefaultDragCoefficient : wind.drag_coefficient();
  return decoded;
}

void encode_wind(const scene::Wind& wind, v1::Wind& message) {
  encode_vector(wind.velocity, *message.mutable_velocity_mps());
  message.set_air_density_kgpm3(wind.air_density);
  message.set_drag_coefficient(wind.drag_coefficient);
}

}  // namespace kerf::wire

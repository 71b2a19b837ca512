#include "server/wire/pin_codec.h"

#include <utility>
#include <variant>

#include "server/wire/geometry_codec.h"

namespace kerf::wire {
namespace {

constexpr double kDefaultAirDensity = 1.2;       // kg/m^3
constexpr double kDefaultDragCoefficient = 1.0;  // -

Result<sheet::PinRegion> decode_edge(v1::PinRegion::Edge edge, const std::string& path) {
  switch (edge) {
    case v1::PinRegion::TOP:
      return sheet::PinRegion(sheet::PinEdge::kTop);
    case v1::PinRegion::BOTTOM:
      return sheet::PinRegion(sheet::PinEdge::kBottom);
    case v1::PinRegion::LEFT:
      return sheet::PinRegion(sheet::PinEdge::kLeft);
    case v1::PinRegion::RIGHT:
      return sheet::PinRegion(sheet::PinEdge::kRight);
    case v1::PinRegion::CORNERS:
      return sheet::PinRegion(sheet::PinEdge::kCorners);
    case v1::PinRegion::TOP_CORNERS:
      return sheet::PinRegion(sheet::PinEdge::kTopCorners);
    default:
      return unknown_enum(path, static_cast<int>(edge));
  }
}

v1::PinRegion::Edge encode_edge(sheet::PinEdge edge) {
  switch (edge) {
    case sheet::PinEdge::kTop:
      return v1::PinRegion::TOP;
    case sheet::PinEdge::kBottom:
      return v1::PinRegion::BOTTOM;
    case sheet::PinEdge::kLeft:
      return v1::PinRegion::LEFT;
    case sheet::PinEdge::kRight:
      return v1::PinRegion::RIGHT;
    case sheet::PinEdge::kCorners:
      return v1::PinRegion::CORNERS;
    case sheet::PinEdge::kTopCorners:
      return v1::PinRegion::TOP_CORNERS;
  }
  return v1::PinRegion::EDGE_UNSPECIFIED;
}

Result<sheet::PinRegion> decode_pin(const v1::PinRegion& pin, const std::string& path) {
  switch (pin.region_case()) {
    case v1::PinRegion::kEdge:
      return decode_edge(pin.edge(), path + ".edge");
    case v1::PinRegion::kBox:
      return sheet::PinRegion(sheet::MaterialBox{decode_vector(pin.box().min()), decode_vector(pin.box().max())});
    case v1::PinRegion::kVertices:
      return sheet::PinRegion(
          std::vector<mesh::VertexId>(pin.vertices().vertices().begin(), pin.vertices().vertices().end()));
    case v1::PinRegion::REGION_NOT_SET:
      break;
  }
  return choice_missing(path + ".region", "edge, box or vertices");
}

}  // namespace

Result<std::vector<sheet::PinRegion>> decode_pins(const PinRegionMessages& pins, const std::string& path) {
  std::vector<sheet::PinRegion> decoded;
  for (int i = 0; i < pins.size(); ++i) {
    Result<sheet::PinRegion> pin = decode_pin(pins[i], path + "[" + std::to_string(i) + "]");
    if (!pin.ok()) return pin.error();
    decoded.push_back(std::move(*pin));
  }
  return decoded;
}

void encode_pins(const std::vector<sheet::PinRegion>& pins, PinRegionMessages& messages) {
  for (const sheet::PinRegion& pin : pins) {
    v1::PinRegion& message = *messages.Add();
    if (const auto* edge = std::get_if<sheet::PinEdge>(&pin)) {
      message.set_edge(encode_edge(*edge));
    } else if (const auto* box = std::get_if<sheet::MaterialBox>(&pin)) {
      encode_vector(box->min, *message.mutable_box()->mutable_min());
      encode_vector(box->max, *message.mutable_box()->mutable_max());
    } else {
      const auto& vertices = std::get<std::vector<mesh::VertexId>>(pin);
      message.mutable_vertices()->mutable_vertices()->Assign(vertices.begin(), vertices.end());
    }
  }
}

sheet::Wind decode_wind(const v1::Wind& wind) {
  sheet::Wind decoded;
  decoded.velocity = decode_vector(wind.velocity_mps());
  decoded.air_density = wind.air_density_kgpm3() == 0.0 ? kDefaultAirDensity : wind.air_density_kgpm3();
  decoded.drag_coefficient = wind.drag_coefficient() == 0.0 ? kDefaultDragCoefficient : wind.drag_coefficient();
  return decoded;
}

void encode_wind(const sheet::Wind& wind, v1::Wind& message) {
  encode_vector(wind.velocity, *message.mutable_velocity_mps());
  message.set_air_density_kgpm3(wind.air_density);
  message.set_drag_coefficient(wind.drag_coefficient);
}

}  // namespace kerf::wire

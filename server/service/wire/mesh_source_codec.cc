#include "server/service/wire/mesh_source_codec.h"

#include <array>
#include <string>
#include <utility>
#include <variant>

#include "server/base/overloaded.h"
#include "server/base/text_encoding.h"
#include "server/service/drawing/closing.h"
#include "server/service/drawing/inflate.h"
#include "server/service/wire/choices.h"
#include "server/service/wire/geometry_codec.h"

namespace kerf::wire {
namespace {

Result<scene::MeshSource> decode_grid(const v1::GridMesh& message) {
  scene::GridSource grid;
  grid.columns = message.columns();
  grid.rows = message.rows();
  grid.width = message.width_m();
  grid.height = message.height_m();
  grid.seed = message.seed();
  switch (message.pattern()) {
    case v1::GridMesh::PATTERN_UNSPECIFIED:
    case v1::GridMesh::UNIFORM_DIAGONALS:
      grid.pattern = scene::GridPattern::kUniformDiagonals;
      break;
    case v1::GridMesh::JITTERED_DELAUNAY:
      grid.pattern = scene::GridPattern::kJitteredDelaunay;
      break;
    default:
      return unknown_enum("grid.pattern", static_cast<int>(message.pattern()));
  }
  return scene::MeshSource(grid);
}

constexpr std::array<std::pair<v1::RestShape, scene::RestShape>, 3> kRestShapes{{
    {v1::REST_SHAPE_UNSPECIFIED, scene::RestShape::kAutomatic},
    {v1::REST_SHAPE_FLAT, scene::RestShape::kFlat},
    {v1::REST_SHAPE_SURFACE, scene::RestShape::kSurface},
}};
constexpr std::array<std::pair<v1::MeshReading::UpAxis, mesh::UpAxis>, 4> kUpAxes{{
    {v1::MeshReading::UP_AXIS_UNSPECIFIED, mesh::UpAxis::kZ},
    {v1::MeshReading::Z_UP, mesh::UpAxis::kZ},
    {v1::MeshReading::Y_UP, mesh::UpAxis::kY},
    {v1::MeshReading::X_UP, mesh::UpAxis::kX},
}};

Result<mesh::MeshReading> decode_reading(v1::RestShape rest_shape, const v1::MeshReading& message,
                                         const std::string& path) {
  mesh::MeshReading reading;
  KERF_TRY(decode_choice(kRestShapes, rest_shape, path + ".rest_shape", reading.rest_shape));
  KERF_TRY(decode_choice(kUpAxes, message.up_axis(), path + ".reading.up_axis", reading.up_axis));
  if (message.unit_m() != 0.0) reading.unit_m = message.unit_m();
  if (message.has_join_m()) reading.join_m = message.join_m();
  reading.ignore_texture = message.ignore_texture_coordinates();
  reading.objects.assign(message.objects().begin(), message.objects().end());
  if (message.reader_version() != 0) reading.version = message.reader_version();
  return reading;
}

// Encodes how a file is read. Fields that have their default are left out, except the version.
void encode_reading(const mesh::MeshReading& reading, v1::MeshReading& message) {
  if (reading.unit_m != 1.0) message.set_unit_m(reading.unit_m);
  if (reading.up_axis != mesh::UpAxis::kZ) message.set_up_axis(encode_choice(kUpAxes, reading.up_axis));
  if (reading.join_m) message.set_join_m(*reading.join_m);
  message.set_ignore_texture_coordinates(reading.ignore_texture);
  for (const std::string& name : reading.objects) message.add_objects(name);
  message.set_reader_version(reading.version);
}

Result<scene::MeshSource> decode_obj(v1::ObjMesh& message, const FileReader& read_file) {
  KERF_TRY_ASSIGN(std::string text,
                  read_content({std::move(*message.mutable_text()), message.file()}, read_file, "OBJ", "obj"));
  if (!message.file().empty()) {
    KERF_TRY_ASSIGN(text, unpacked_mesh(std::move(text), "OBJ", "obj.file"));
  }
  KERF_TRY_ASSIGN(mesh::MeshReading reading, decode_reading(message.rest_shape(), message.reading(), "obj"));
  return scene::MeshSource(scene::ObjSource{obj_text(std::move(text)), std::move(reading)});
}

Result<scene::MeshSource> decode_ply(v1::PlyMesh& message, const FileReader& read_file) {
  KERF_TRY_ASSIGN(std::string data,
                  read_content({std::move(*message.mutable_data()), message.file(), "data"}, read_file, "PLY", "ply"));
  if (!message.file().empty()) {
    KERF_TRY_ASSIGN(data, unpacked_mesh(std::move(data), "PLY", "ply.file"));
  }
  if (drawing::is_gzip(data)) {  // Its size when decompressed is beyond the limit of requests.
    return invalid_argument("PLY_MALFORMED", "the file is compressed by gzip; decompress it before it is sent",
                            "ply.data");
  }
  KERF_TRY_ASSIGN(mesh::MeshReading reading, decode_reading(message.rest_shape(), message.reading(), "ply"));
  return scene::MeshSource(scene::PlySource{std::move(data), std::move(reading)});
}

Status check_length(int length, int multiple, const std::string& path) {
  if (length % multiple == 0) return Nothing{};
  return invalid_argument(
      "LENGTH_MISMATCH",
      path + " has " + std::to_string(length) + " numbers; must be a multiple of " + std::to_string(multiple), path);
}

Result<scene::MeshSource> decode_inline(const v1::InlineMesh& message) {
  KERF_TRY(check_length(message.material_positions_size(), 2, "inline.material_positions"));
  KERF_TRY(check_length(message.triangles_size(), 3, "inline.triangles"));
  KERF_TRY(check_length(message.positions_size(), 3, "inline.positions"));
  KERF_TRY(check_length(message.rest_positions_size(), 3, "inline.rest_positions"));
  scene::ArraySource arrays;
  arrays.material_positions =
      Eigen::Map<const Eigen::Matrix2Xd>(message.material_positions().data(), 2, message.material_positions_size() / 2);
  arrays.triangles = Eigen::Map<const Eigen::Matrix3Xi>(message.triangles().data(), 3, message.triangles_size() / 3);
  arrays.positions = Eigen::Map<const Eigen::Matrix3Xd>(message.positions().data(), 3, message.positions_size() / 3);
  arrays.rest_positions =
      Eigen::Map<const Eigen::Matrix3Xd>(message.rest_positions().data(), 3, message.rest_positions_size() / 3);
  return scene::MeshSource(std::move(arrays));
}

Result<scene::OutlineSizing> decode_sizing(const v1::EdgeLength& message, const std::string& path,
                                           const FileReader& read_file) {
  scene::OutlineSizing sizing;
  switch (message.place_case()) {
    case v1::EdgeLength::kPoint:
      sizing.place = decode_vector(message.point());
      break;
    case v1::EdgeLength::kCurve: {
      KERF_TRY_ASSIGN(DecodedCurve curve, decode_curve(message.curve(), path + ".curve", read_file));
      sizing.place = std::move(curve.curve);
      break;
    }
    case v1::EdgeLength::PLACE_NOT_SET:
      return choice_missing(path + ".place", "point or curve");
  }
  sizing.edge_length = message.edge_length_m();
  if (message.growth() != 0.0) sizing.growth = message.growth();
  return sizing;
}

// Decodes a border or a hole. The lines of a drawing are closed where their ends meet.
Result<cut::Curve> decode_closed_curve(const v1::Curve& message, const std::string& path, const FileReader& read_file) {
  KERF_TRY_ASSIGN(DecodedCurve decoded, decode_curve(message, path, read_file));
  auto* const lines = std::get_if<cut::Path>(&decoded.curve);
  if (lines != nullptr && (message.has_svg() || message.has_dxf())) drawing::close_lines(*lines);
  return std::move(decoded.curve);
}

Result<scene::MeshSource> decode_outline(const v1::OutlineMesh& message, const FileReader& read_file) {
  scene::OutlineSource outline;
  if (!message.has_boundary()) return missing("outline.boundary");
  KERF_TRY_ASSIGN(outline.boundary, decode_closed_curve(message.boundary(), "outline.boundary", read_file));
  for (int i = 0; i < message.holes_size(); ++i) {
    KERF_TRY_ASSIGN(cut::Curve hole,
                    decode_closed_curve(message.holes(i), "outline.holes[" + std::to_string(i) + "]", read_file));
    outline.holes.push_back(std::move(hole));
  }
  outline.edge_length = message.edge_length_m();
  for (int i = 0; i < message.sizes_size(); ++i) {
    KERF_TRY_ASSIGN(scene::OutlineSizing sizing,
                    decode_sizing(message.sizes(i), "outline.sizes[" + std::to_string(i) + "]", read_file));
    outline.sizes.push_back(std::move(sizing));
  }
  if (message.min_angle_deg() != 0.0) outline.min_angle_deg = message.min_angle_deg();
  return scene::MeshSource(std::move(outline));
}

void encode_source(const scene::GridSource& grid, v1::GridMesh& message) {
  message.set_columns(grid.columns);
  message.set_rows(grid.rows);
  message.set_width_m(grid.width);
  message.set_height_m(grid.height);
  message.set_pattern(grid.pattern == scene::GridPattern::kJitteredDelaunay ? v1::GridMesh::JITTERED_DELAUNAY
                                                                            : v1::GridMesh::UNIFORM_DIAGONALS);
  message.set_seed(grid.seed);
}

void encode_source(const scene::ObjSource& obj, v1::ObjMesh& message) {
  message.set_text(obj.text);
  message.set_rest_shape(encode_choice(kRestShapes, obj.reading.rest_shape));
  encode_reading(obj.reading, *message.mutable_reading());
}

void encode_source(const scene::PlySource& ply, v1::PlyMesh& message) {
  message.set_data(ply.data);
  message.set_rest_shape(encode_choice(kRestShapes, ply.reading.rest_shape));
  encode_reading(ply.reading, *message.mutable_reading());
}

void encode_source(const scene::ArraySource& arrays, v1::InlineMesh& message) {
  message.mutable_material_positions()->Add(arrays.material_positions.data(),
                                            arrays.material_positions.data() + arrays.material_positions.size());
  message.mutable_triangles()->Add(arrays.triangles.data(), arrays.triangles.data() + arrays.triangles.size());
  message.mutable_positions()->Add(arrays.positions.data(), arrays.positions.data() + arrays.positions.size());
  message.mutable_rest_positions()->Add(arrays.rest_positions.data(),
                                        arrays.rest_positions.data() + arrays.rest_positions.size());
}

void encode_source(const scene::OutlineSource& outline, v1::OutlineMesh& message) {
  encode_curve(outline.boundary, *message.mutable_boundary());
  for (const cut::Curve& hole : outline.holes) encode_curve(hole, *message.add_holes());
  message.set_edge_length_m(outline.edge_length);
  for (const scene::OutlineSizing& sizing : outline.sizes) {
    v1::EdgeLength& to = *message.add_sizes();
    if (const auto* point = std::get_if<Eigen::Vector2d>(&sizing.place)) {
      encode_vector(*point, *to.mutable_point());
    } else {
      encode_curve(std::get<cut::Curve>(sizing.place), *to.mutable_curve());
    }
    to.set_edge_length_m(sizing.edge_length);
    to.set_growth(sizing.growth);
  }
  message.set_min_angle_deg(outline.min_angle_deg);
}

// Decodes the mesh of a Scene or a Component, `Owner`.
template <typename Owner>
Result<scene::MeshSource> decode_mesh(Owner& owner, const FileReader& read_file) {
  switch (owner.mesh_case()) {
    case Owner::kGrid:
      return decode_grid(owner.grid());
    case Owner::kObj:
      return decode_obj(*owner.mutable_obj(), read_file);
    case Owner::kPly:
      return decode_ply(*owner.mutable_ply(), read_file);
    case Owner::kInline:
      return decode_inline(owner.inline_());
    case Owner::kOutline:
      return decode_outline(owner.outline(), read_file);
    case Owner::MESH_NOT_SET:
      break;
  }
  return choice_missing("mesh", "grid, obj, ply, inline or outline");
}

template <typename Owner>
void encode_mesh(const scene::MeshSource& mesh, Owner& owner) {
  std::visit(Overloaded{
                 [&owner](const scene::GridSource& grid) { encode_source(grid, *owner.mutable_grid()); },
                 [&owner](const scene::ObjSource& obj) { encode_source(obj, *owner.mutable_obj()); },
                 [&owner](const scene::PlySource& ply) { encode_source(ply, *owner.mutable_ply()); },
                 [&owner](const scene::ArraySource& arrays) { encode_source(arrays, *owner.mutable_inline_()); },
                 [&owner](const scene::OutlineSource& outline) { encode_source(outline, *owner.mutable_outline()); },
             },
             mesh);
}

}  // namespace

Result<scene::MeshSource> decode_mesh_source(v1::Scene& scene, const FileReader& read_file) {
  return decode_mesh(scene, read_file);
}

Result<scene::MeshSource> decode_mesh_source(v1::Component& component, const FileReader& read_file) {
  return decode_mesh(component, read_file);
}

Result<std::string> unpacked_mesh(std::string file, const std::string& kind, const std::string& field) {
  if (!drawing::is_gzip(file)) return file;
  return drawing::inflated(file, kind, field, scene::kMaxMeshFileBytes);
}

std::string obj_text(std::string file) {
  return utf8_text(std::move(file));
}

void name_first_reader(v1::Scene& scene) {
  const auto name_in = [](auto& owner) {
    if (owner.has_obj() && owner.obj().reading().reader_version() == 0) {
      owner.mutable_obj()->mutable_reading()->set_reader_version(mesh::kFirstReader);
    }
    if (owner.has_ply() && owner.ply().reading().reader_version() == 0) {
      owner.mutable_ply()->mutable_reading()->set_reader_version(mesh::kFirstReader);
    }
  };
  name_in(scene);
  for (v1::Component& component : *scene.mutable_components()) name_in(component);
}

void encode_mesh_source(const scene::MeshSource& mesh, v1::Scene& scene) {
  encode_mesh(mesh, scene);
}

void encode_mesh_source(const scene::MeshSource& mesh, v1::Component& component) {
  encode_mesh(mesh, component);
}

}  // namespace kerf::wire

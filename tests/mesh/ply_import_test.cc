// Import from PLY files of all three formats, and what is refused.

#include "server/core/mesh/build/ply_import.h"

#include <cmath>
#include <limits>
#include <string>

#include <gtest/gtest.h>

#include "server/base/random.h"
#include "server/core/mesh/build/obj_import.h"
#include "tests/support/mesh_files.h"
#include "tests/support/meshes.h"

namespace kerf::mesh {
namespace {

using test::kPlyKinds;
using test::PlyBody;
using test::PlyKind;

ImportedSheet read(const std::string& file) {
  Result<ImportedSheet> ply = parse_ply(file);
  EXPECT_TRUE(ply.ok()) << ply.error().message;
  return ply.ok() ? std::move(ply).value() : ImportedSheet{};
}

// A square of four vertices, given as it stands in the header, and one face.
std::string square(const std::string& faces) {
  return "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\nproperty float z\n"
         "element face 1\nproperty list uchar int vertex_indices\nend_header\n0 0 0\n1 0 0\n1 1 0\n0 1 0\n" +
         faces;
}
constexpr int kFirstVertexLine = 10;  // of square()
constexpr int kFaceLine = 14;

void expect_refused(const std::string& file, const std::string& reason, const std::string& field,
                    const std::string& says = "") {
  const Result<ImportedSheet> ply = parse_ply(file);
  ASSERT_FALSE(ply.ok()) << file.substr(0, 500);
  EXPECT_EQ(ply.error().code, ErrorCode::kInvalidArgument);
  EXPECT_EQ(ply.error().reason, reason) << ply.error().message;
  EXPECT_EQ(ply.error().field, field) << ply.error().message;
  EXPECT_NE(ply.error().message.find(says), std::string::npos) << ply.error().message;
}

// square() with a part of it replaced.
std::string changed(const std::string& from, const std::string& to) {
  std::string file = square("4 0 1 2 3\n");
  const std::size_t at = file.find(from);
  EXPECT_NE(at, std::string::npos) << from;
  return file.replace(at, from.size(), to);
}

// The zoo has a panel with a hole, several components, slits, and components that touch.
TEST(Ply, EverySheetOfTheZooComesAsItWentInAllFormats) {
  for (const test::ZooMesh& each : test::zoo()) {
    const ImportedSheet obj = parse_obj(test::write_obj(each.sheet, 0.5)).value();
    for (const PlyKind kind : kPlyKinds) {
      const ImportedSheet ply = read(test::write_ply(each.sheet, kind, 0.5));
      EXPECT_EQ(ply.sheet.rest, each.sheet.rest) << each.name;
      EXPECT_EQ(ply.sheet.triangles, each.sheet.triangles) << each.name;
      EXPECT_EQ(ply.world.row(2), Eigen::RowVectorXd::Constant(ply.world.cols(), 0.5)) << each.name;
      EXPECT_EQ(ply.sheet.rest, obj.sheet.rest) << each.name;
      EXPECT_EQ(ply.world, obj.world) << each.name;
      const TriangleMesh mesh = test::must(import_mesh(ply.sheet));
      EXPECT_EQ(mesh.find_violation(), std::nullopt) << each.name;
      EXPECT_EQ(mesh.num_pieces(), each.pieces) << each.name;
      EXPECT_EQ(mesh.num_boundary_loops(), each.loops) << each.name;
    }
  }
}

template <typename Coordinate, typename Count, typename Index>
void expect_types(const std::string& coordinate, const std::string& count, const std::string& index) {
  for (const PlyKind kind : kPlyKinds) {
    PlyBody body(kind);
    for (const auto& [x, y] : {std::array{-3, -4}, std::array{100, 0}, std::array{0, 100}}) {
      body.add(static_cast<Coordinate>(x)).add(static_cast<Coordinate>(y)).add(Coordinate{7}).end();
    }
    body.add(Count{3}).add(Index{0}).add(Index{1}).add(Index{2}).end();
    std::string file = test::ply_start(kind) + "element vertex 3\n";
    for (const char axis : {'x', 'y', 'z'}) file += "property " + coordinate + " " + axis + "\n";
    file += "element face 1\nproperty list " + count + " " + index + " vertex_index\nend_header\n" + body.text();
    const ImportedSheet ply = read(file);
    ASSERT_EQ(ply.world.cols(), 3) << coordinate;
    EXPECT_EQ(ply.world.col(0), Eigen::Vector3d(-3, -4, 7)) << coordinate;
    EXPECT_EQ(ply.world.col(1), Eigen::Vector3d(100, 0, 7)) << coordinate;
    EXPECT_EQ(ply.sheet.triangles.col(0), Eigen::Vector3i(0, 1, 2)) << count << " " << index;
  }
}

TEST(Ply, NumbersMayBeOfAnyType) {
  expect_types<std::int8_t, std::uint8_t, std::int32_t>("char", "uchar", "int");
  expect_types<std::int8_t, std::int8_t, std::uint8_t>("int8", "int8", "uint8");
  expect_types<std::int16_t, std::uint16_t, std::int16_t>("short", "ushort", "short");
  expect_types<std::int16_t, std::int16_t, std::uint16_t>("int16", "int16", "uint16");
  expect_types<std::int32_t, std::uint32_t, std::uint32_t>("int", "uint", "uint32");
  expect_types<std::int32_t, std::int32_t, std::int8_t>("int32", "int32", "char");
  expect_types<float, std::uint8_t, std::uint16_t>("float", "uint8", "ushort");
  expect_types<float, std::uint8_t, std::uint8_t>("float32", "uchar", "uchar");
  expect_types<double, std::uint8_t, std::int32_t>("double", "uchar", "int32");
  expect_types<double, std::uint8_t, std::uint32_t>("float64", "uchar", "uint");
}

TEST(Ply, DoublesKeepAllTheirBits) {
  const mesh::IndexedMesh sheet = test::indexed({{0.1, 1.0 / 3.0}, {4096.000000000001, 0}, {2e-3, 5e3}}, {{0, 1, 2}});
  for (const PlyKind kind : kPlyKinds) EXPECT_EQ(read(test::write_ply(sheet, kind)).sheet.rest, sheet.rest);
}

TEST(Ply, OtherElementsAndPropertiesArePassedOver) {
  for (const PlyKind kind : kPlyKinds) {
    PlyBody body(kind);
    body.add(std::uint8_t{2}).add(1.5).add(2.5).add(9.0F).end().add(std::uint8_t{0}).add(9.0F).end();  // two "strip"
    body.add(std::uint16_t{4}).add(std::int32_t{0}).add(std::int32_t{1}).add(std::int32_t{3}).add(std::int32_t{2});
    body.add(std::uint8_t{1}).add(0.25F).end();  // the face, before its vertices
    for (const auto& [x, y] :
         {std::array{0.0F, 0.0F}, std::array{1.0F, 0.0F}, std::array{0.0F, 1.0F}, std::array{1.0F, 1.0F}}) {
      body.add(std::uint8_t{200}).add(x).add(std::int8_t{1}).add(std::int16_t{-5}).add(y).add(2.0F).end();
    }
    const ImportedSheet ply = read(
        test::ply_start(kind) +
        "comment made by hand\nobj_info of nothing\nelement strip 2\nproperty list uchar double weights\n"
        "property float mass\nelement nothing 4000000000\nelement face 1\nproperty list ushort int vertex_indices\n"
        "property list uchar float texcoord\nelement vertex 4\nproperty uchar red\nproperty float x\n"
        "property list char short tags\nproperty float y\nproperty float z\nend_header\n" +
        body.text());
    ASSERT_EQ(ply.sheet.triangles.cols(), 2);
    EXPECT_EQ(ply.sheet.triangles.col(0), Eigen::Vector3i(0, 1, 3));
    EXPECT_EQ(ply.sheet.triangles.col(1), Eigen::Vector3i(0, 3, 2));
    EXPECT_EQ(ply.world.col(3), Eigen::Vector3d(1, 1, 2));
  }
}

TEST(Ply, LinesEndInEveryWayAndBlankOnesDoNotCount) {
  const std::string unix_file = square("\n4 0 1 2 3\n\n");
  for (const std::string end : {"\r\n", "\r"}) {
    std::string file;
    for (const char c : unix_file) file += c == '\n' ? end : std::string(1, c);
    EXPECT_EQ(read(file).sheet.triangles.cols(), 2);
  }
  // Binary: with CR alone the first byte of the data may be a line feed.
  std::string file = test::write_ply(test::one_triangle(), PlyKind::kLittleEndian);
  const std::size_t body = file.find("end_header\n") + 11;
  std::replace(file.begin(), file.begin() + static_cast<std::ptrdiff_t>(body), '\n', '\r');
  file[body] = '\n';  // the lowest byte of the first x
  EXPECT_NEAR(read(file).world(0, 0), 0.0, 1e-300);
  EXPECT_EQ(read(file + "\n").world.cols(), 3);
}

TEST(Ply, TextureCoordinatesAreTheRestShape) {
  for (const auto& [x, y] : {std::array<std::string, 2>{"s", "t"}, {"u", "v"}, {"texture_u", "texture_v"}}) {
    const std::string file = "ply\nformat ascii 1.0\nelement vertex 4\nproperty float " + y +
                             "\nproperty float x\nproperty float y\nproperty float z\nproperty double " + x +
                             "\nelement face 1\nproperty list uchar int vertex_indices\nend_header\n"
                             "0 0 0 1 0\n0 1 0 2 0.5\n9 9 9 9 9\n0.5 1 1 3 0.5\n3 0 1 3\n";
    const ImportedSheet ply = read(file);
    ASSERT_EQ(ply.sheet.rest.cols(), 3);  // the vertex without a face is dropped
    EXPECT_EQ(ply.file_positions, (std::vector<std::int32_t>{0, 1, 3}));
    EXPECT_EQ(ply.sheet.rest.col(1), Eigen::Vector2d(0.5, 0));
    EXPECT_EQ(ply.sheet.rest.col(2), Eigen::Vector2d(0.5, 0.5));
    EXPECT_EQ(ply.world.col(2), Eigen::Vector3d(1, 1, 3));  // not flat, as the rest shape is given
  }
}

// Two equal squares of one plane, one seen from behind: their area vectors cancel.
TEST(Ply, ComponentsOfAPlaneNeedNotBeOrientedAlike) {
  mesh::IndexedMesh sheet = test::two_components();
  sheet.triangles.col(2) = Eigen::Vector3i(4, 6, 5);
  sheet.triangles.col(3) = Eigen::Vector3i(4, 7, 6);
  for (const std::string& file : {test::write_ply(sheet, PlyKind::kAscii), test::write_obj(sheet)}) {
    const Result<ImportedSheet> read_back = file[0] == 'p' ? parse_ply(file) : parse_obj(file);
    ASSERT_TRUE(read_back.ok()) << read_back.error().message;
    const TriangleMesh mesh = test::must(import_mesh(read_back->sheet));
    EXPECT_EQ(mesh.find_violation(), std::nullopt);
    EXPECT_EQ(mesh.num_pieces(), 2);
  }
}

TEST(Ply, EdgesOfThreeFacesAreRefusedWithTheirNames) {
  const mesh::IndexedMesh sheet =
      test::indexed({{0, 0}, {1, 0}, {0, 1}, {1, 1}, {0, -1}}, {{0, 1, 2}, {0, 1, 3}, {1, 0, 4}});
  for (const PlyKind kind : kPlyKinds) {
    const Result<ImportedSheet> read = parse_ply(test::write_ply(sheet, kind));
    ASSERT_FALSE(read.ok());
    EXPECT_EQ(read.error().reason, "MESH_NON_MANIFOLD_EDGE");
    const bool has_lines = kind == PlyKind::kAscii;
    const std::string& said = read.error().message;
    EXPECT_NE(said.find(has_lines ? "faces 0 (line 16), 1 (line 17) and 2 (line 18)" : "faces 0, 1 and 2"),
              std::string::npos)
        << said;
  }
}

TEST(Ply, RefusalsOfTheHeaderNameTheLine) {
  expect_refused("", "PLY_HEADER", "ply:1");
  expect_refused("plyx\n", "PLY_HEADER", "ply:1");
  expect_refused("ply\n", "PLY_HEADER", "ply:2", "before end_header");
  expect_refused("ply\nend_header\n", "PLY_HEADER", "ply:2", "format");
  expect_refused(changed("ascii 1.0", "ascii 1.1"), "PLY_HEADER", "ply:2", "version");
  expect_refused(changed("ascii", "text"), "PLY_HEADER", "ply:2", "\"text\"");
  expect_refused(changed("1.0\n", "1.0 now\n"), "PLY_HEADER", "ply:2", "\"now\"");
  expect_refused(changed("element vertex", "format ascii 1.0\nelement vertex"), "PLY_HEADER", "ply:3", "twice");
  expect_refused(changed("element vertex", "size \xff\nelement vertex"), "PLY_HEADER", "ply:3", "\"size\"");
  expect_refused(changed("element vertex 4", "element vertex"), "PLY_HEADER", "ply:3");
  expect_refused(changed("element vertex 4", "element vertex -1"), "PLY_HEADER", "ply:3");
  expect_refused(changed("element vertex 4", "element vertex 4.0"), "PLY_HEADER", "ply:3");
  expect_refused(changed("element vertex 4", "element vertex 99999999999999999999"), "PLY_HEADER", "ply:3");
  expect_refused(changed("element face 1", "element vertex 1"), "PLY_HEADER", "ply:7", "twice");
  expect_refused(changed("float y", "float x"), "PLY_HEADER", "ply:5", "twice");
  expect_refused(changed("float y", "real y"), "PLY_HEADER", "ply:5", "\"real\"");
  expect_refused(changed("float y", "float"), "PLY_HEADER", "ply:5", "name");
  expect_refused(changed("element vertex 4", "property float x\nelement vertex 4"), "PLY_HEADER", "ply:3");
  expect_refused(changed("float y", "float w"), "PLY_HEADER", "ply:9", "must have x, y");
  expect_refused(changed("property float z", "property list uchar float z"), "PLY_HEADER", "ply:9", "z: a number each");
  expect_refused(changed("element vertex", "element point"), "PLY_HEADER", "ply:9", "vertex");
  expect_refused(changed("element face", "element polyline"), "PLY_HEADER", "ply:9", "cloud of points");
  expect_refused(changed("vertex_indices", "corners"), "PLY_HEADER", "ply:9", "vertex_indices");
  expect_refused(changed("uchar int vertex_indices", "bool int vertex_indices"), "PLY_HEADER", "ply:8", "integer");
  expect_refused(changed("list uchar int", "int"), "PLY_HEADER", "ply:9", "list");
  expect_refused(changed("end_header", "property list uchar int vertex_index\nend_header"), "PLY_HEADER", "ply:10");
  expect_refused(
      changed("element face", "property float s\nproperty float t\nproperty float u\nproperty float v\nelement face"),
      "PLY_HEADER", "ply:13", "twice");
  expect_refused(square("").substr(0, square("").find("end_header")), "PLY_HEADER", "ply:9", "before end_header");
}

TEST(Ply, RefusalsOfTextNameTheLine) {
  const std::string face = "ply:" + std::to_string(kFaceLine);
  const std::string first = "ply:" + std::to_string(kFirstVertexLine);
  expect_refused(changed("0 0 0\n", "0 0\n"), "PLY_VALUES", first, "line 10 (vertex 0): ");
  expect_refused(changed("0 0 0\n", "0 0 0 0\n"), "PLY_VALUES", first, "more values");
  expect_refused(changed("0 0 0\n", "0 0 1x\n"), "PLY_NUMBER", first, "\"1x\"");
  expect_refused(changed("0 0 0\n", "0 0 nan\n"), "PLY_NUMBER", first);
  expect_refused(changed("0 0 0\n", "0 0 1e400\n"), "PLY_NUMBER", first);
  expect_refused(changed("0 0 0\n", "0 0 10000.1\n"), "PLY_NUMBER", first, "10000 m");
  expect_refused(square(""), "PLY_TRUNCATED", "ply:13");
  expect_refused(square("\n\n"), "PLY_TRUNCATED", "ply:15", "promises 1");
  expect_refused(square("4 0 1 2\n"), "PLY_VALUES", face, "(face 0)");
  expect_refused(square("3 0 1 2 3\n"), "PLY_VALUES", face);
  expect_refused(square("-1\n"), "PLY_VALUES", face, "length");
  expect_refused(square("2.5 0 1 2\n"), "PLY_VALUES", face, "length");
  expect_refused(square("3 0 1 4\n"), "PLY_INDEX", face, "one of the 4 vertices");
  expect_refused(square("3 0 1 -1\n"), "PLY_INDEX", face);
  expect_refused(square("3 0 1 1.5\n"), "PLY_INDEX", face);
  expect_refused(square("2 0 1\n"), "PLY_FACE", face);
  expect_refused(square("0\n"), "PLY_FACE", face);
  expect_refused(square("4 0 1 2 3\n3 0 1 2\n"), "PLY_TRAILING", "ply", "8 bytes");
  expect_refused(changed("element face 1", "element face 0").substr(0, square("").size()), "PLY_EMPTY", "ply");
}

TEST(Ply, TheSurfaceIsTheRestShapeWhereItIsBent) {
  const std::string bent = square("4 0 1 2 3\n").replace(square("").find("1 1 0\n"), 6, "1 1 0.1\n");
  EXPECT_EQ(parse_ply(bent).value().sheet.surface.cols(), 4);
  EXPECT_EQ(parse_ply(bent, {.rest_shape = RestShape::kSurface}).value().sheet.surface.cols(), 4);
  const Result<ImportedSheet> flat = parse_ply(bent, {.rest_shape = RestShape::kFlat});
  ASSERT_FALSE(flat.ok());
  EXPECT_EQ(flat.error().reason, "PLY_NOT_PLANAR");
  EXPECT_EQ(flat.error().field, "ply");
  EXPECT_NE(flat.error().message.find("texture coordinates"), std::string::npos) << flat.error().message;
}

TEST(Ply, RefusalsOfBinaryFilesNameTheElement) {
  for (const PlyKind kind : {PlyKind::kLittleEndian, PlyKind::kBigEndian}) {
    const std::string file = test::write_ply(test::two_components(), kind);
    const std::size_t body = file.find("end_header\n") + 11;
    const auto cut = [&](std::size_t bytes) { return file.substr(0, body + bytes); };
    expect_refused(cut(0), "PLY_TRUNCATED", "ply:vertex[0]", "promises 8");
    expect_refused(cut(8 * 24 - 1), "PLY_TRUNCATED", "ply:vertex[7]");
    expect_refused(cut(8 * 24), "PLY_TRUNCATED", "ply:face[0]");
    expect_refused(cut(8 * 24 + 3 * 13 + 12), "PLY_TRUNCATED", "ply:face[3]", "promises 4");
    expect_refused(file + "\1", "PLY_TRAILING", "ply");
    std::string far = file;
    PlyBody nan(kind);
    far.replace(body + 2 * 24, 8, nan.add(std::numeric_limits<double>::quiet_NaN()).text());
    expect_refused(far, "PLY_NUMBER", "ply:vertex[2]", "vertex 2 is not finite; face 0 uses it");
    std::string odd = file;
    PlyBody index(kind);
    odd.replace(body + 8 * 24 + 13 + 1, 4, index.add(std::int32_t{8}).text());
    expect_refused(odd, "PLY_INDEX", "ply:face[1]");
    odd = file;
    odd[body + 8 * 24 + 13] = 2;
    expect_refused(odd, "PLY_FACE", "ply:face[1]");
    // A list longer than any file is refused before it is walked.
    PlyBody list(kind);
    list.add(std::uint32_t{4294967295});
    expect_refused(test::ply_start(kind) +
                       "element other 1\nproperty list uint double all\nelement vertex 0\n"
                       "property float x\nproperty float y\nproperty float z\nelement face 0\n"
                       "property list uchar int vertex_index\nend_header\n" +
                       list.text(),
                   "PLY_TRUNCATED", "ply:\"other\"[0]");
  }
}

TEST(Ply, LimitsHoldAtTheirEdges) {
  // Lines of the header besides comments, of which square() has 9, and their length.
  const auto with_elements = [](std::size_t lines, const std::string& blanks) {
    std::string elements;
    for (std::size_t i = 0; i < lines; ++i) elements += "element e" + std::to_string(i) + " 0" + blanks + "\n";
    return changed("element vertex", elements + "element vertex");
  };
  read(with_elements(kMaxPlyHeaderLines - 9, ""));
  expect_refused(with_elements(kMaxPlyHeaderLines - 8, ""), "PLY_HEADER", "ply:1001", "1000 lines");
  read(with_elements(1, std::string(kMaxPlyHeaderLineBytes - 12, ' ')));
  expect_refused(with_elements(1, std::string(kMaxPlyHeaderLineBytes - 11, ' ')), "PLY_HEADER", "ply:3", "4096 bytes");
  // Comments, however many and long.
  std::string comments;
  for (std::size_t i = 0; i < 2 * kMaxPlyHeaderLines; ++i) comments += "comment\nobj_info by hand\n";
  read(changed("element vertex", comments + "comment " + std::string(6000, '-') + "\nelement vertex"));
  // Vertices: their number is refused where it is promised, and taken where it is kept.
  expect_refused(changed("vertex 4", "vertex " + std::to_string(kMaxVertices + 1)), "PLY_TOO_LARGE", "ply:3", "500000");
  expect_refused(changed("vertex 4", "vertex " + std::to_string(kMaxVertices)), "PLY_VALUES", "ply:14");
  // Triangles: the same one again and again, which import_mesh would refuse next.
  constexpr int kTriangles = 2 * kMaxVertices;
  std::string file = test::write_ply(test::one_triangle(), PlyKind::kLittleEndian);
  const std::string face = file.substr(file.size() - 13);
  file.replace(file.find("element face 1"), 14, "element face " + std::to_string(kTriangles + 1));
  file.resize(file.size() - 13);
  for (int i = 0; i < kTriangles; ++i) file += face;
  expect_refused(file, "PLY_TRUNCATED", "ply:face[" + std::to_string(kTriangles) + "]");
  expect_refused(file + face, "PLY_TOO_LARGE", "ply:face[" + std::to_string(kTriangles) + "]", "1000000 triangles");
  // Bytes of the file.
  std::string large = square("4 0 1 2 3\n");
  large.resize(kMaxMeshFileBytes, '\n');
  EXPECT_EQ(read(large).sheet.triangles.cols(), 2);
  expect_refused(large + "\n", "PLY_TOO_LARGE", "ply", std::to_string(kMaxMeshFileBytes));
}

// Whatever bytes come: a typed refusal, or arrays of matching sizes.
TEST(Ply, DamagedFilesAreRefusedOrRead) {
  SeededRandom random(9);
  int num_read = 0;
  for (int i = 0; i < 30000; ++i) {
    std::string file = test::write_ply(test::square_with_hole(), kPlyKinds[random.below(3)]);
    for (std::uint64_t left = 1 + random.below(4); left > 0; --left) {
      file[random.below(file.size())] =
          static_cast<char>(random.below(4) == 0 ? random.below(256) : '0' + random.below(10));
    }
    if (random.below(4) == 0) file.resize(random.below(file.size()));
    const Result<ImportedSheet> ply = parse_ply(file);
    if (!ply.ok()) {
      ASSERT_EQ(ply.error().code, ErrorCode::kInvalidArgument);
      ASSERT_TRUE(ply.error().field.starts_with("ply"));
      for (const char c : ply.error().message) ASSERT_TRUE(c >= ' ' && c <= '~') << i;
      continue;
    }
    ++num_read;
    ASSERT_EQ(std::max(ply->sheet.rest.cols(), ply->sheet.surface.cols()), ply->world.cols());
    if (const Result<TriangleMesh> built = import_mesh(ply->sheet); built.ok()) {
      ASSERT_EQ(built->find_violation(), std::nullopt);
    }
  }
  EXPECT_GT(num_read, 1000);
}

}  // namespace
}  // namespace kerf::mesh

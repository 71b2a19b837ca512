// PLY files beside the plain ones: strips, types that some programs add, byte order marks.

#include "server/core/mesh/build/ply_import.h"

#include <string>
#include <utility>

#include <gtest/gtest.h>

#include "tests/support/mesh_files.h"
#include "tests/support/meshes.h"

namespace kerf::mesh {
namespace {

using test::kPlyKinds;
using test::PlyBody;
using test::PlyKind;

ImportedSheet read_variety(const std::string& file) {
  Result<ImportedSheet> ply = parse_ply(file);
  EXPECT_TRUE(ply.ok()) << ply.error().message;
  return ply.ok() ? std::move(ply).value() : ImportedSheet{};
}

std::string joined_notes(const ImportedSheet& sheet) {
  std::string all;
  for (const std::string& note : sheet.notes) all += note + "\n";
  return all;
}

TEST(Ply, StripsOfTrianglesAreRead) {
  for (const PlyKind kind : kPlyKinds) {
    PlyBody body(kind);
    for (int i = 0; i < 8; ++i) body.add(0.5 * (i / 2)).add(static_cast<double>(i % 2)).add(0.0).end();
    // Two strips; the first begins with a repeated corner, as strips do that were led here.
    body.add(std::uint8_t{11});
    for (const int index : {0, 0, 1, 2, 3, 4, 5, -1, 5, 4, 6}) body.add(static_cast<std::int32_t>(index));
    body.end();
    const std::string head = test::ply_start(kind) +
                             "element vertex 8\nproperty double x\nproperty double y\nproperty double z\n"
                             "element tristrips 1\nproperty list uchar int vertex_indices\n";
    const ImportedSheet strips = read_variety(head + "end_header\n" + body.text());
    EXPECT_EQ(strips.sheet.triangles.cols(), 5);
    EXPECT_EQ(joined_notes(strips), "passed over 1 vertex that no face uses\n");
    EXPECT_EQ(test::must(import_mesh(strips.sheet)).num_pieces(), 1);
    // Faces beside strips are read, too.
    PlyBody face(kind);
    face.add(std::uint8_t{3});
    for (const int index : {5, 7, 6}) face.add(static_cast<std::int32_t>(index));
    face.end();
    const std::string faces = "element face 1\nproperty list uchar int vertex_index\n";
    EXPECT_EQ(read_variety(head + faces + "end_header\n" + body.text() + face.text()).sheet.triangles.cols(), 6);
  }
}

TEST(Ply, HeadersWithBlanksIndicesOfAnyTypeAndEndsOfTextAreTaken) {
  const std::string body = "0 0 0\n1.0D+00 0 0\n1 10d-1 0\n0 1 0\n4 0 1 2 3\n";
  const auto file = [&](const std::string& type) {
    return "ply \t\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\nproperty float z\nelement "
           "face "
           "1\nproperty list uchar " +
           type + " vertex_indices\nend_header\n" + body;
  };
  for (const std::string type : {"int", "float", "double"}) {
    const ImportedSheet sheet = read_variety(file(type) + std::string("\x1a\0\n", 3));
    ASSERT_EQ(sheet.world.cols(), 4) << type;
    EXPECT_EQ(sheet.world.col(2), Eigen::Vector3d(1, 1, 0));
    EXPECT_EQ(sheet.sheet.triangles.cols(), 2);
  }
  std::string half = file("float");
  half.replace(half.find("4 0 1 2 3"), 9, "4 0 1 2.5 3");
  EXPECT_EQ(parse_ply(half).error().reason, "PLY_INDEX");
  EXPECT_EQ(parse_ply(file("int") + "x").error().reason, "PLY_TRAILING");
  EXPECT_EQ(parse_ply(file("int").replace(0, 5, "ply 1")).error().reason, "PLY_HEADER");
}

TEST(Ply, LineEndsThatWereConvertedTwiceAreRead) {
  std::string text =
      "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\nelement face 1\n"
      "property list uchar int vertex_indices\nend_header\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n";
  for (std::size_t at = text.find('\n'); at != std::string::npos; at = text.find('\n', at + 3)) text.insert(at, "\r\r");
  EXPECT_EQ(read_variety(text).sheet.triangles.cols(), 1);
}

TEST(Ply, VerticesWithoutZLieInAPlane) {
  for (const PlyKind kind : kPlyKinds) {
    PlyBody body(kind);
    for (const auto& [x, y] : {std::pair{0.0, 0.0}, {1.0, 0.0}, {0.0, 2.0}}) body.add(x).add(y).end();
    body.add(std::uint8_t{3});
    for (const int index : {0, 1, 2}) body.add(static_cast<std::int32_t>(index));
    body.end();
    const std::string head = test::ply_start(kind) + "element vertex 3\nproperty double x\nproperty double y\n";
    const std::string faces = "element face 1\nproperty list uchar int vertex_indices\nend_header\n";
    const ImportedSheet sheet = read_variety(head + faces + body.text());
    ASSERT_EQ(sheet.world.cols(), 3);
    EXPECT_EQ(sheet.world.col(2), Eigen::Vector3d(0, 2, 0));
    EXPECT_EQ(joined_notes(sheet), "vertices have no z: it is taken as 0\n");
  }
  EXPECT_EQ(parse_ply("ply\nformat ascii 1.0\nelement vertex 0\nproperty float x\nelement face 0\nend_header\n")
                .error()
                .reason,
            "PLY_HEADER");
}

TEST(Ply, UnusedPropertiesMayBeOfAnyTypeAndMarksArePassedOver) {
  const std::string text =
      "\xEF\xBB\xBFply\nformat ascii 1.0\nelement face 1\nproperty string name\n"
      "property list uchar int vertex_indices\nproperty list float half weights\nelement vertex 3\n"
      "property bool is_seam\nproperty float x\nproperty float y\nproperty float z\nproperty float x2\n"
      "property float x2\nend_header\nfront 3 0 1 2 2 0.5 0.5\n1 0 0 0 7 7\n0 1 0 0 7 7\n1 0 1 0 nan nan\n";
  EXPECT_EQ(read_variety(text).sheet.triangles.cols(), 1);
  const std::string binary = test::ply_start(PlyKind::kLittleEndian) +
                             "element vertex 3\nproperty float16 x\nproperty int64 id\nproperty float y\n"
                             "property uint64 z\nelement face 1\nproperty list uchar int vertex_indices\nend_header\n";
  PlyBody body(PlyKind::kLittleEndian);
  for (const auto& [half, y] : {std::pair{0, 0.0F}, {0x3c00, 0.0F}, {0xc200, 1.0F}}) {  // 0, 1 and -3
    body.add(static_cast<std::uint16_t>(half)).add(std::int64_t{-1}).add(y).add(std::uint64_t{2});
  }
  body.add(std::uint8_t{3}).add(std::int32_t{0}).add(std::int32_t{1}).add(std::int32_t{2});
  EXPECT_EQ(read_variety(binary + body.text()).world.col(2), Eigen::Vector3d(-3, 1, 2));
  const Result<ImportedSheet> refused =
      parse_ply(test::ply_start(PlyKind::kLittleEndian) + "element vertex 3\nproperty long id\n");
  ASSERT_FALSE(refused.ok());
  EXPECT_EQ(refused.error().code, ErrorCode::kInvalidArgument);
  EXPECT_EQ(refused.error().reason, "PLY_HEADER");
  EXPECT_EQ(refused.error().field, "ply:4");
  EXPECT_NE(refused.error().message.find("\"long\" is not a type"), std::string::npos);
}

}  // namespace
}  // namespace kerf::mesh

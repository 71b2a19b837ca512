// Import from OBJ text, and what is refused.

#include "server/core/mesh/build/obj_import.h"

#include <string>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "server/base/random.h"
#include "tests/mesh/measures.h"
#include "tests/support/meshes.h"

namespace kerf::mesh {
namespace {

void expect_obj_refused(const std::string& text, const std::string& reason, const std::string& field) {
  const Result<ImportedSheet> obj = parse_obj(text);
  ASSERT_FALSE(obj.ok()) << text;
  EXPECT_EQ(obj.error().reason, reason) << obj.error().message;
  EXPECT_EQ(obj.error().field, field) << obj.error().message;
}

TEST(Obj, ReadsEveryFormOfAFace) {
  const std::string text =
      "# a sheet\nmtllib x.mtl\nv 0 0 0\nv 1 0 0 # right\r\nv +1 1 0 0.5 0.5 0.5\nv 0 1 0\n\n"
      "vn 0 0 1\no sheet\nf 1//1 2//1 3//1\nf -4 -2 -1\n";
  const Result<ImportedSheet> obj = parse_obj(text);
  ASSERT_TRUE(obj.ok()) << obj.error().message;
  EXPECT_EQ(obj->sheet.rest.cols(), 4);
  ASSERT_EQ(obj->sheet.triangles.cols(), 2);
  EXPECT_EQ(obj->sheet.triangles.col(1), Eigen::Vector3i(0, 2, 3));
  EXPECT_EQ(obj->world.col(2), Eigen::Vector3d(1, 1, 0));
  EXPECT_EQ(test::must(import_mesh(obj->sheet)).find_violation(), std::nullopt);
}

TEST(Obj, MarksLineEndsContinuationsAndCommentsAreTakenAsTheyCome) {
  const std::string plain = "v .2 0 0\nv .4 0 0\nv .4 .1 0\nv .2 .1 0\nf 1 2 3 4\n";
  const Eigen::Matrix3Xd world = parse_obj(plain).value().world;
  ASSERT_EQ(world.cols(), 4);
  const auto with_ends = [&](const std::string& end) {
    std::string text;
    for (const char c : plain) text += c == '\n' ? end : std::string(1, c);
    return text;
  };
  const std::string long_comment = "# " + std::string(100000, '-') + "\n";
  const std::vector<std::string> all{"\xEF\xBB\xBF" + plain,
                                     with_ends("\r"),
                                     with_ends("\r\n"),
                                     with_ends("\n\n"),
                                     with_ends(" # a comment that ends with \\\n"),
                                     with_ends(std::string(9000, ' ') + "\n"),
                                     long_comment + plain + long_comment,
                                     "v .2 \\\n 0 0\nv .4 0 \\ \r\n0\nv .4 .1 0\nv .2 .1 0\nf 1 2 \\\n3 \\\n4",
                                     "f 1 2 3 4\n" + plain.substr(0, plain.find('f')),
                                     plain.substr(0, plain.find('f')) + "fo 1 2 3 4\nl 1 2\np 3\n"};
  for (const std::string& text : all) {
    const Result<ImportedSheet> obj = parse_obj(text);
    ASSERT_TRUE(obj.ok()) << text.substr(0, 60) << obj.error().message;
    EXPECT_EQ(obj->world, world) << text.substr(0, 60);
    EXPECT_EQ(obj->sheet.triangles.cols(), 2);
  }
  // Lines are counted as editors do, and a statement of several lines has the number of its first.
  expect_obj_refused("# one\r\nv 0 0 0\r\n\r\nv 1 \\\r\n x 0\r\n", "OBJ_NUMBER", "obj:4");
}

TEST(Obj, AFileWithoutFacesSaysWhatItHas) {
  EXPECT_EQ(parse_obj("v 0 0 0\nv 1 0 0\nl 1 2\n").error().message,
            "no face: the file has 2 positions, lines or points, and a sheet needs faces (lines that begin with f)");
  EXPECT_NE(parse_obj("v 0 0 0\nsurf 0 1 0 1 1\n").error().message.find("free-form surfaces"), std::string::npos);
}

TEST(Obj, OtherFormatsAreNamed) {
  const std::vector<std::pair<std::string, std::string>> cases{{"solid x\nfacet normal 0 0 1\n", "an STL file"},
                                                               {"BZh91AY", "a compressed file"},
                                                               {"\xc3\xbd"
                                                                "7zXZ",
                                                                "a compressed file"},
                                                               {"(\xc2\xb5/\xc3\xbd", "a compressed file"},
                                                               {"PK\x03\x04", "a ZIP archive"},
                                                               {"OFF\n3 1 0\n", "an OFF file"},
                                                               {"{\"asset\":{\"version\":\"2.0\"}}", "a glTF file"},
                                                               {"ply\nformat ascii 1.0\n", "a PLY file"},
                                                               {"\n<svg/>", "an XML file"},
                                                               {std::string("v\0 \0", 4), "not text"}};
  for (const auto& [text, format] : cases) {
    EXPECT_NE(parse_obj(text).error().message.find("the file is " + format), std::string::npos) << text;
  }
}

TEST(Obj, MarksAndBlanksBeyondAsciiSwallowNoVertex) {
  const std::string square = "v 0 0 0\nv 1.D+0 0 0\nv 1 1 0\nv 0 1 0\nf 1 2 3 4\n";
  // A file that was appended to another brings its mark along.
  const Result<ImportedSheet> both = parse_obj("v 9 9 9\n\xEF\xBB\xBF" + square + "f 2 3 4 5\n");
  ASSERT_TRUE(both.ok()) << both.error().message;
  EXPECT_EQ(both->world.col(1), Eigen::Vector3d(0, 0, 0));
  expect_obj_refused(
      "v 0 0 0\nv\xC2\xA0"
      "1 0 0\n" +
          square,
      "OBJ_NUMBER", "obj:2");
}

TEST(Obj, AFaceThatLeadsThereAndBackIsNamedAlone) {
  const Result<ImportedSheet> obj = parse_obj("v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nf 1 2 3\nf 1 3 4 3\n");
  ASSERT_FALSE(obj.ok());
  EXPECT_NE(obj.error().message.find("face 2 (line 6) passes more than once along"), std::string::npos)
      << obj.error().message;
}

TEST(Obj, TheFirstReaderSplitsPolygonsAsFans) {
  const std::string text = "v 0 0 0\nv 2 0 0\nv 3 1 0\nv 1 2 0\nv -1 1 0\nf 1 2 3 4 5\n";
  const Result<ImportedSheet> obj = parse_obj(text, {.version = kFirstReader});
  ASSERT_TRUE(obj.ok());
  ASSERT_EQ(obj->sheet.triangles.cols(), 3);
  EXPECT_EQ(obj->sheet.triangles.col(2), Eigen::Vector3i(0, 3, 4));
}

TEST(Obj, TextureCoordinatesAreTheRestShapeAndSeamsSplitVertices) {
  // Two triangles that share an edge in space and lie apart in the texture.
  const std::string text =
      "v 0 0 0\nv 1 0 0\nv 1 1 2\nv 0 1 3\nvt 0 0\nvt 0.5 0\nvt 0.5 0.5\nvt 1 1\nvt 1.5 1.5\nvt 1 1.5\n"
      "f 1/1 2/2/9 3/3\nf 1/4 3/5 4/6\n";
  const Result<ImportedSheet> obj = parse_obj(text);
  ASSERT_TRUE(obj.ok()) << obj.error().message;
  ASSERT_EQ(obj->sheet.rest.cols(), 6);
  EXPECT_EQ(obj->file_positions, (std::vector<std::int32_t>{0, 0, 1, 2, 2, 3}));
  EXPECT_EQ(obj->sheet.rest.col(1), Eigen::Vector2d(1, 1));
  EXPECT_EQ(obj->world.col(4), Eigen::Vector3d(1, 1, 2));
  const TriangleMesh mesh = test::must(import_mesh(obj->sheet));
  EXPECT_EQ(mesh.num_pieces(), 2);
}

TEST(Obj, APlaneInSpaceGivesTheRestShape) {
  // A rectangle of 3 x 4 in a tilted plane.
  const Result<ImportedSheet> obj = parse_obj("v 1 1 1\nv 4 1 1\nv 4 3.4 4.2\nv 1 3.4 4.2\nf 1 2 3 4\n");
  ASSERT_TRUE(obj.ok()) << obj.error().message;
  const TriangleMesh mesh = test::must(import_mesh(obj->sheet));
  EXPECT_NEAR(total_area(mesh), 12.0, 1e-12);
  for (int i = 0; i < 4; ++i) {
    for (int j = 0; j < 4; ++j) {
      EXPECT_NEAR((obj->sheet.rest.col(i) - obj->sheet.rest.col(j)).norm(),
                  (obj->world.col(i) - obj->world.col(j)).norm(), 1e-12);
    }
  }
}

TEST(Obj, RefusalsNameTheLine) {
  const std::string square = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\n";
  expect_obj_refused("", "OBJ_EMPTY", "obj");
  expect_obj_refused(square, "OBJ_EMPTY", "obj");
  expect_obj_refused("v 0 0\n", "OBJ_NUMBER", "obj:1");
  expect_obj_refused("v 0 0 nan\n", "OBJ_EMPTY", "obj");
  for (const char* const far : {"nan", "1e400", "-inf", "1.#QNAN", "2e4"}) {
    expect_obj_refused("v 0 0 0\nv 1 0 0\nv 0 1 " + std::string(far) + "\nf 1 2 3\n", "OBJ_NUMBER", "obj:3");
  }
  expect_obj_refused("\n\nv 0 0 1x\n", "OBJ_NUMBER", "obj:3");
  expect_obj_refused("vt one 2\n", "OBJ_NUMBER", "obj:1");
  expect_obj_refused(square + "f 1 2 5\n", "OBJ_INDEX", "obj:5");
  expect_obj_refused(square + "f 1 2 0\n", "OBJ_INDEX", "obj:5");
  expect_obj_refused(square + "f 1 2 -5\n", "OBJ_INDEX", "obj:5");
  expect_obj_refused(square + "f 1 2 99999999999\n", "OBJ_INDEX", "obj:5");
  expect_obj_refused(square + "f 1/1 2/1 3/1\n", "OBJ_INDEX", "obj:5");
  expect_obj_refused(square + "f / / /\n", "OBJ_INDEX", "obj:5");
  expect_obj_refused(square + "f 1 2\n", "OBJ_FACE", "obj:5");
  std::string many = square + "f";
  for (std::size_t i = 0; i <= kMaxFaceCorners; ++i) many += " 1";
  expect_obj_refused(many, "OBJ_FACE", "obj:5");
  for (const char* const bent : {"v 0 0 0\nv 1 0 0\nv 1 1 0.1\nv 0 1 0\nf 1 2 3 4\n",  //
                                 "v 0 0 0\nv 1 0 0\nv 2 0 0\nf 1 2 3\n"}) {
    const Result<ImportedSheet> flat = parse_obj(bent, {.rest_shape = RestShape::kFlat});
    ASSERT_FALSE(flat.ok());
    EXPECT_EQ(flat.error().reason, bent[4] == '0' && flat.error().message.find("area") == std::string::npos
                                       ? "OBJ_NOT_PLANAR"
                                       : "OBJ_EMPTY");
    EXPECT_EQ(flat.error().field, "obj");
  }
}

TEST(Obj, TheSurfaceIsTheRestShapeWhereItIsBentOrAskedFor) {
  const std::string bent = "v 0 0 0\nv 1 0 0\nv 1 1 0.1\nv 0 1 0\n";
  const std::string flat = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\n";
  const std::string chart = "vt 0 0\nvt 2 0\nvt 2 3\nvt 0 3\n";
  const std::string face = "f 1 2 3 4\n";
  const std::string charted = "f 1/1 2/2 3/3 4/4\n";
  const auto surface_of = [](const std::string& text, RestShape rest_shape) {
    return parse_obj(text, {.rest_shape = rest_shape}).value().sheet.surface.cols();
  };
  EXPECT_EQ(surface_of(bent + face, RestShape::kAutomatic), 4);
  EXPECT_EQ(surface_of(flat + face, RestShape::kAutomatic), 0);
  EXPECT_EQ(surface_of(flat + face, RestShape::kSurface), 0);  // which is flat
  EXPECT_EQ(surface_of(bent + chart + charted, RestShape::kAutomatic), 0);
  EXPECT_EQ(surface_of(bent + chart + charted, RestShape::kSurface), 4);
  const TriangleMesh mesh =
      import_mesh(parse_obj(bent + chart + charted, {.rest_shape = RestShape::kSurface}).value().sheet).value();
  EXPECT_TRUE(mesh.is_curved());
  EXPECT_EQ(mesh.rest_position(2), Eigen::Vector2d(2.0, 3.0));
  EXPECT_NEAR(mesh.area(0), 0.5 * std::sqrt(1.01), 1e-15);
  EXPECT_NEAR(mesh.material_area(0), 3.0, 1e-15);
}

// Whatever bytes come: a typed refusal, or arrays of matching sizes.
TEST(Obj, DamagedTextIsRefusedOrRead) {
  const std::string sound = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nvt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\nf 1/1 2/2 3/3 -1/-1\n";
  constexpr char kAlphabet[] = "0123456789-+./# \n\t\rvtfneINa\0\xff";
  const std::string alphabet(kAlphabet, sizeof kAlphabet);  // zero bytes included
  SeededRandom random(8);
  int num_read = 0;
  for (int i = 0; i < 20000; ++i) {
    std::string text = sound;
    for (std::uint64_t left = 1 + random.below(4); left > 0; --left) {
      text[random.below(text.size())] = alphabet[random.below(alphabet.size())];
    }
    if (random.below(4) == 0) text.resize(random.below(text.size()));
    const Result<ImportedSheet> obj = parse_obj(text);
    if (!obj.ok()) {
      ASSERT_EQ(obj.error().code, ErrorCode::kInvalidArgument);
      ASSERT_TRUE(obj.error().field.starts_with("obj"));
      continue;
    }
    ++num_read;
    ASSERT_EQ(std::max(obj->sheet.rest.cols(), obj->sheet.surface.cols()), obj->world.cols());
    if (const Result<TriangleMesh> built = import_mesh(obj->sheet); built.ok()) {
      ASSERT_EQ(built->find_violation(), std::nullopt);
    }
  }
  EXPECT_GT(num_read, 1000);
}

}  // namespace
}  // namespace kerf::mesh

// Mesh files that are mended: joined places, turned and left out faces, rounded planes, charts, units; and what is said
// about them.

#include "server/core/mesh/build/sheet_assembly.h"

#include <array>
#include <cmath>
#include <cstdio>
#include <functional>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "server/base/elementary.h"
#include "server/base/interruption.h"
#include "server/core/mesh/build/obj_import.h"
#include "server/core/mesh/build/ply_import.h"
#include "tests/mesh/measures.h"
#include "tests/mesh/side_joining_files.h"
#include "tests/support/mesh_files.h"

namespace kerf::mesh {
namespace {

using Map = std::function<Eigen::Vector3d(double, double)>;

// A grid of quads, 8 x 6 cells of 0.05 m, mapped into space.
std::string grid(const Map& map, const char* format = "%.17g") {
  std::string text;
  for (int j = 0; j <= 6; ++j) {
    for (int i = 0; i <= 8; ++i) text += vertex_line(map(0.05 * i, 0.05 * j), format);
  }
  for (int j = 0; j < 6; ++j) {
    for (int i = 0; i < 8; ++i) {
      const int a = 9 * j + i + 1;
      text += "f " + std::to_string(a) + " " + std::to_string(a + 1) + " " + std::to_string(a + 10) + " " +
              std::to_string(a + 9) + "\n";
    }
  }
  return text;
}

// The same grid with corners of its own for each triangle.
std::string soup(const Map& map, const char* format = "%.17g") {
  std::string text;
  for (int j = 0; j < 6; ++j) {
    for (int i = 0; i < 8; ++i) {
      const auto corner = [&](int di, int dj) { text += vertex_line(map(0.05 * (i + di), 0.05 * (j + dj)), format); };
      corner(0, 0), corner(1, 0), corner(1, 1);
      text += "f -3 -2 -1\n";
      corner(0, 0), corner(1, 1), corner(0, 1);
      text += "f -3 -2 -1\n";
    }
  }
  return text;
}

Eigen::Vector3d plain(double x, double y) {
  return {x, y, 0.0};
}
Eigen::Vector3d tilted(double x, double y) {
  const double c = cosine(0.35), s = sine(0.35);
  return {c * x - s * 0.6 * y, s * x + c * 0.6 * y, 0.8 * y};
}
Eigen::Vector3d arched(double x, double y) {
  return {x, y, 0.02 * sine(8.0 * x)};
}

FileSheet sheet_of(const std::string& text, const MeshReading& reading = {}) {
  Result<MeshFile> file = text.starts_with("ply") ? read_ply(text) : read_obj(text, reading.version);
  EXPECT_TRUE(file.ok()) << file.error().message;
  Result<FileSheet> made = make_sheet(*file, reading);
  EXPECT_TRUE(made.ok()) << made.error().message;
  EXPECT_EQ(made->mesh.find_violation(), std::nullopt);
  return std::move(made).value();
}

Error refusal(const std::string& text, const MeshReading& reading = {}) {
  const Result<MeshFile> file = text.starts_with("ply") ? read_ply(text) : read_obj(text, reading.version);
  if (!file.ok()) return file.error();
  const Result<FileSheet> made = make_sheet(*file, reading);
  EXPECT_FALSE(made.ok()) << text.substr(0, 400);
  return made.ok() ? Error{} : made.error();
}

std::string joined(const std::vector<std::string>& notes) {
  std::string all;
  for (const std::string& note : notes) all += note + "\n";
  return all;
}

void expect_note(const FileSheet& sheet, const std::string& part) {
  EXPECT_NE(joined(sheet.imported.notes).find(part), std::string::npos) << joined(sheet.imported.notes);
}

void expect_says(const Error& error, const std::string& reason, const std::vector<std::string>& parts) {
  EXPECT_EQ(error.reason, reason) << error.message;
  for (const std::string& part : parts) EXPECT_NE(error.message.find(part), std::string::npos) << error.message;
}

TEST(Assembly, APlainGridNeedsNoWord) {
  const FileSheet sheet = sheet_of(grid(plain));
  EXPECT_EQ(joined(sheet.imported.notes), "");
  EXPECT_EQ(sheet.mesh.num_vertices(), 63);
  EXPECT_NEAR(total_area(sheet.mesh), 0.12, 1e-15);
}

TEST(Assembly, EqualPlacesAreJoinedAsExactlyAsTheFileIsWritten) {
  for (const Map& map : {Map(plain), Map(tilted), Map(arched)}) {
    for (const char* const format : {"%.17g", "%.6f", "%g", "%.9e"}) {
      const FileSheet sheet = sheet_of(soup(map, format));
      EXPECT_EQ(sheet.mesh.num_vertices(), 63) << format;
      EXPECT_EQ(sheet.mesh.num_pieces(), 1);
      EXPECT_EQ(sheet.mesh.num_boundary_loops(), 1);
      expect_note(sheet, "joined 286 vertices that lie at the same place, which leaves 61");
    }
  }
  const FileSheet apart = sheet_of(soup(plain), {.join_m = 0.0});
  EXPECT_EQ(apart.mesh.num_pieces(), 96);
  EXPECT_EQ(joined(apart.imported.notes), "");
}

// The last digit may differ where places were computed twice.
TEST(Assembly, PlacesThatRoundingSetApartAreJoined) {
  const std::string twice =
      "v 0 0 0\nv 0.333333 0 0\nv 0 0.333333 0\nv 0.333334 0 0.000001\nv 0.333333 0.333333 0\n"
      "v 0 0.333334 0\nf 1 2 3\nf 4 5 6\n";
  EXPECT_EQ(sheet_of(twice).mesh.num_pieces(), 1);
  EXPECT_EQ(sheet_of(twice, {.join_m = 0.0}).mesh.num_pieces(), 2);
  // Numbers of few digits may be exact, so a gap of the last digit stays.
  const std::string gap = "v 0 0 0\nv 0.3 0 0\nv 0 0.3 0\nv 0.4 0 0\nv 0.4 0.3 0\nv 0 0.4 0\nf 1 2 3\nf 4 5 6\n";
  EXPECT_EQ(sheet_of(gap).mesh.num_pieces(), 2);
  expect_says(refusal(gap, {.join_m = 0.25}), "OBJ_JOIN", {"0.25 m", "shorter than 0.412 m"});
  EXPECT_EQ(sheet_of(gap, {.join_m = 0.11}).mesh.num_pieces(), 1);
}

TEST(Assembly, SingleNumbersOfBinaryFilesAreJoinedToTheirPrecision) {
  const std::string header = test::ply_start(test::PlyKind::kLittleEndian) +
                             "element vertex 6\nproperty float x\nproperty float y\nproperty float z\nelement face 2\n"
                             "property list uchar int vertex_indices\nend_header\n";
  test::PlyBody floats(test::PlyKind::kLittleEndian);
  const float a = 0.1F, b = std::nextafter(0.1F, 1.0F);
  for (const float value : {0.0F, 0.0F, 0.0F, a, 0.0F, 0.0F, 0.0F, a, 0.0F, b, 0.0F, 0.0F, b, b, 0.0F, 0.0F, b, 0.0F}) {
    floats.add(value);
  }
  for (const int first : {0, 3}) {
    floats.add(std::uint8_t{3});
    for (const int k : {0, 1, 2}) floats.add(static_cast<std::int32_t>(first + k));
  }
  EXPECT_EQ(sheet_of(header + floats.text()).mesh.num_pieces(), 1);
  EXPECT_EQ(sheet_of(header + floats.text(), {.join_m = 0.0}).mesh.num_pieces(), 2);
}

TEST(Assembly, LipsOfAKerfExportStayApart) {
  const std::string slit = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 0 0\nv 1 1 0\nv 0 1 0\nf 1 2 3\nf 4 5 6\n";
  EXPECT_EQ(sheet_of(slit).mesh.num_pieces(), 1);
  EXPECT_EQ(sheet_of("# Kerf: metres\n" + slit).mesh.num_pieces(), 2);
  EXPECT_EQ(sheet_of("# Kerf: metres\n" + slit, {.join_m = 1e-6}).mesh.num_pieces(), 1);
}

TEST(Assembly, ComponentsThatTouchAtAPointStayComponents) {
  const std::string touching = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 1 1 0\nv 2 1 0\nv 2 2 0\nf 1 2 3\nf 4 5 6\n";
  const FileSheet sheet = sheet_of(touching);
  EXPECT_EQ(sheet.mesh.num_vertices(), 6);
  EXPECT_EQ(sheet.imported.file_positions, (std::vector<std::int32_t>{0, 1, 2, 3, 4, 5}));
  EXPECT_EQ(joined(sheet.imported.notes), "");
  // The file itself may use one vertex for both.
  const FileSheet bow_tie = sheet_of("v 0 0 0\nv 1 0 0\nv 1 1 0\nv 2 1 0\nv 2 2 0\nf 1 2 3\nf 3 4 5\n");
  EXPECT_EQ(bow_tie.mesh.num_vertices(), 6);
  expect_note(bow_tie, "faces come apart that meet only at vertex 3 (line 3)");
}

TEST(Assembly, ARoundedPlaneIsFlat) {
  for (const char* const format : {"%.17g", "%.9g", "%.6f", "%.5f", "%.4f", "%g", "%.6e"}) {
    const FileSheet sheet = sheet_of(grid(tilted, format));
    EXPECT_FALSE(sheet.mesh.is_curved()) << format;
    EXPECT_NEAR(total_area(sheet.mesh), 0.12, 2e-4) << format;
  }
  expect_note(sheet_of(grid(tilted, "%.5f")), "taken as flat: all vertices lie within ");
  // Three decimals are too coarse for cells of 5 cm to be called flat unasked.
  EXPECT_FALSE(sheet_of(grid(tilted, "%.3f"), {.rest_shape = RestShape::kFlat}).mesh.is_curved());
  EXPECT_TRUE(sheet_of(grid(tilted, "%.5f"), {.version = kFirstReader}).mesh.is_curved());
}

TEST(Assembly, AGentleBendIsNoRounding) {
  for (const double height : {1e-5, 1e-4, 1e-3}) {
    const Map bent = [height](double x, double y) -> Eigen::Vector3d {
      return tilted(x, y) + Eigen::Vector3d(0, 0, height * sine(10.0 * x));
    };
    EXPECT_TRUE(sheet_of(grid(bent, "%.6f")).mesh.is_curved()) << height;
    const Error error = refusal(grid(bent, "%.6f"), {.rest_shape = RestShape::kFlat});
    expect_says(error, "OBJ_NOT_PLANAR", {"out of the plane of the faces; the limit is ", " um", "(line "});
    EXPECT_EQ(error.message.find("0.000000"), std::string::npos) << error.message;
  }
  // Exact numbers of few digits are taken at their word.
  EXPECT_TRUE(sheet_of("v 0 0 0\nv 1 0 0\nv 1 1 0.1\nv 0 1 0\nf 1 2 3 4\n").mesh.is_curved());
}

TEST(Assembly, FacesAreTurnedAsTheirNeighboursAre) {
  for (const Map& map : {Map(plain), Map(tilted), Map(arched)}) {
    std::string text = grid(map);
    const std::size_t at = text.find("f 12 13 22 21\n");
    ASSERT_NE(at, std::string::npos);
    text.replace(at, 14, "f 21 22 13 12\n");
    const FileSheet sheet = sheet_of(text);
    EXPECT_EQ(sheet.mesh.num_pieces(), 1);
    expect_note(sheet, "turned round face 11 (line 74), to face as its neighbours do");
  }
  // A component that is clockwise throughout is as good.
  EXPECT_EQ(joined(sheet_of("v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nf 1 3 2\nf 1 4 3\n").imported.notes), "");
}

TEST(Assembly, FacesWithoutAreaAndCopiesAreLeftOut) {
  const std::string square = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv .5 0 0\n";
  const FileSheet sheet = sheet_of(square + "f 1 2 2\nf 1 2 3 3 4\nf 4 3 2 1\nf 1 1 1\nf 1 5 2\n");
  EXPECT_EQ(sheet.mesh.num_pieces(), 1);
  EXPECT_NEAR(total_area(sheet.mesh), 1.0, 1e-15);
  expect_note(sheet, "left out faces 1 (line 6), 4 (line 9) and 5 (line 10): no area");
  expect_note(sheet, "left out face 3 (line 8): the same corners as another face");
  expect_says(refusal(square + "f 1 2 2\n"), "OBJ_EMPTY", {"no face has an area"});
}

// Its middle corner becomes one of the neighbour beyond its long side.
TEST(Assembly, AFaceOnALineJoinsItsNeighbours) {
  const FileSheet sheet =
      sheet_of("v 0 0 0\nv .5 0 0\nv 1 0 0\nv .5 1 0\nv .5 -1 0\nf 1 2 3\nf 1 3 4\nf 1 5 2\nf 2 5 3\n");
  EXPECT_EQ(sheet.mesh.num_pieces(), 1);
  EXPECT_EQ(sheet.mesh.num_boundary_loops(), 1);
  EXPECT_EQ(sheet.mesh.num_solid_triangles(), 4);
}

TEST(Assembly, FaultsNameLinesAndFaces) {
  const std::string square = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv .5 -1 0\n";
  expect_says(refusal(square + "f 1 2 3\nf 1 2 4\n\nf 2 1 5\n"), "MESH_NON_MANIFOLD_EDGE",
              {"vertex 1 (line 1) and vertex 2 (line 2)", "faces 1 (line 6), 2 (line 7) and 3 (line 9)"});
  expect_says(refusal(square + "f 1 3 2 4\n"), "OBJ_FACE", {"face 1 (line 6) crosses itself"});
  expect_says(refusal(square + "v .2 .2 0\nv .2 1.2 0\nf 1 2 4\nf 3 7 6\n"), "MESH_OVERLAP",
              {"face 1 (line 8)", "face 2 (line 9)"});
  // A fold of a plane sheet.
  expect_says(refusal("v 0 0 0\nv 1 0 0\nv 0 1 0\nv .3 .1 0\nf 1 2 3\nf 3 2 4\n"), "MESH_INCONSISTENT_ORIENTATION",
              {"face 1 (line 5) and face 2 (line 6)", "vertex 2 (line 2) and vertex 3 (line 3)"});
}

TEST(Assembly, ASurfaceOfOneSideIsRefused) {
  std::string strip;
  for (int i = 0; i < 12; ++i) {
    const double around = 6.283185307179586 * i / 12, turn = 0.5 * around;
    for (const double side : {-0.3, 0.3}) {
      const double radius = 1.0 + side * cosine(turn);
      strip += vertex_line({radius * cosine(around), radius * sine(around), side * sine(turn)}, "%.9f");
    }
  }
  for (int i = 0; i < 12; ++i) {
    const int a = 2 * i + 1, b = a + 1, c = i < 11 ? a + 2 : 2, d = i < 11 ? a + 3 : 1;
    strip +=
        "f " + std::to_string(a) + " " + std::to_string(b) + " " + std::to_string(d) + " " + std::to_string(c) + "\n";
  }
  expect_says(refusal(strip), "MESH_INCONSISTENT_ORIENTATION", {"one side only", "(line "});
}

TEST(Assembly, SeveralFaultsAreListedAndTheRestCounted) {
  std::string text = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 one 0\n";
  for (int i = 0; i < 7; ++i) text += "f 1 2 " + std::to_string(10 + i) + "\n";
  expect_says(refusal(text), "OBJ_NUMBER",
              {"line 4: a position is three numbers; \"one\" is no number", "line 5: \"10\"", "line 8: \"13\"",
               "and 3 more faults"});
  expect_says(refusal("v 0,5 0 0\n"), "OBJ_NUMBER", {"decimals follow a point, not a comma"});
}

TEST(Assembly, UnusedVerticesArePassedOver) {
  const FileSheet sheet = sheet_of("v nan 0 0\nv 0 0 0\nv 1 0 0\nv 1e9 0 0\nv 0 1 0\nf 2 3 5\n");
  EXPECT_EQ(sheet.mesh.num_vertices(), 3);
  expect_note(sheet, "passed over 2 vertices that no face uses");
}

std::string charted(double width, double height, const std::string& lacking = "") {
  std::string text = "v 0 0 0\nv 2 0 0\nv 2 3 0\nv 0 3 0\n";
  for (const auto& [u, v] : {std::pair{0.0, 0.0}, {width, 0.0}, {width, height}, {0.0, height}}) {
    text += "vt " + std::to_string(u) + " " + std::to_string(v) + "\n";
  }
  return text + "f 1/1 2/2 3/3\n" + (lacking.empty() ? "f 1/1 3/3 4/4\n" : lacking);
}

TEST(Assembly, AChartOfOtherLengthsIsMentioned) {
  const FileSheet crushed = sheet_of(charted(1, 1));
  EXPECT_NEAR(total_area(crushed.mesh), 1.0, 1e-15);
  expect_note(crushed, "edges there are 0.333 to 0.5 times as long");
  EXPECT_EQ(joined(sheet_of(charted(2.02, 3.02)).imported.notes), "");
  expect_note(sheet_of(charted(2.2, 3.3)), "edges there are 1.1 to 1.1 times as long");
  for (const MeshReading& reading :
       {MeshReading{.ignore_texture = true}, MeshReading{.rest_shape = RestShape::kSurface}}) {
    const FileSheet sheet = sheet_of(charted(1, 1), reading);
    EXPECT_NEAR(total_area(sheet.mesh), 6.0, 1e-12);
    EXPECT_EQ(joined(sheet.imported.notes), "");
  }
}

TEST(Assembly, AChartOfSomeFacesIsNotUsed) {
  for (const char* const lacking : {"f 1 3 4\n", "f 1/1 3/3 4\n"}) {
    for (const RestShape rest_shape : {RestShape::kAutomatic, RestShape::kFlat, RestShape::kSurface}) {
      const FileSheet sheet = sheet_of(charted(1, 1, lacking), {.rest_shape = rest_shape});
      EXPECT_NEAR(total_area(sheet.mesh), 6.0, 1e-12);
      EXPECT_EQ(sheet.mesh.num_pieces(), 1);
      expect_note(sheet, "texture coordinates are not used, as some faces have none: face 2 (line 10)");
    }
  }
}

TEST(Assembly, AChartThatCannotBeUsedIsReplacedAndMentioned) {
  const std::string folded =
      "v 0 0 0\nv 1 0 0\nv 1 1 0.5\nv 0 1 0\nvt 0 0\nvt 1 0\nvt 1 1\nvt 1 0.2\n"
      "f 1/1 2/2 3/3\nf 1/1 3/3 4/4\n";
  const std::string pointed = "v 0 0 0\nv 1 0 0\nv 1 1 0.5\nv 0 1 0\nvt 0 0\nf 1/1 2/1 3/1 4/1\n";
  for (const std::string& text : {folded, pointed}) {
    for (const RestShape rest_shape : {RestShape::kAutomatic, RestShape::kSurface}) {
      const FileSheet sheet = sheet_of(text, {.rest_shape = rest_shape});
      EXPECT_TRUE(sheet.mesh.is_curved());
      expect_note(sheet, "the texture coordinates cannot be used: ");
    }
    EXPECT_NE(refusal(text, {.rest_shape = RestShape::kFlat}).reason, "");
  }
  expect_says(refusal(folded, {.rest_shape = RestShape::kFlat}), "MESH_INCONSISTENT_ORIENTATION",
              {"face 1 (line 9) and face 2 (line 10)"});
}

TEST(Assembly, UnitsAndAxesAreThoseOfTheFile) {
  const std::string text = "v 0 0 0\nv 400 0 0\nv 400 0 -300\nv 0 0 -300\nf 1 2 3 4\n";
  const FileSheet sheet = sheet_of(text, {.unit_m = 1e-3, .up_axis = UpAxis::kY});
  EXPECT_EQ(sheet.imported.world.col(2), Eigen::Vector3d(0.4, 0.3, 0.0));
  EXPECT_NEAR(total_area(sheet.mesh), 0.12, 1e-15);
  EXPECT_EQ(sheet_of(text, {.up_axis = UpAxis::kX}).imported.world.col(2), Eigen::Vector3d(300, 0, 400));
  expect_note(sheet_of(text), "400 m large; if the file is in millimetres, pass --unit mm");
  expect_note(sheet_of(text, {.unit_m = 1e-7}), "only 40 um large");
  const std::string far = "v 0 0 0\nv 40000 0 0\nv 0 40000 0\nf 1 2 3\n";
  expect_says(refusal(far), "OBJ_NUMBER",
              {"vertex 2 (line 2) is 40000 m from the origin", "--unit mm", "face 1 (line 4)"});
  EXPECT_NEAR(total_area(sheet_of(far, {.unit_m = 1e-3}).mesh), 800.0, 1e-9);
}

TEST(Assembly, ObjectsAreChosenByName) {
  const std::string text =
      "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 2 0 0\nv 3 0 0\nv 2 1 0\no left part\nf 1 2 3\n"
      "o right\ng a b\nf 4 5 6\n";
  EXPECT_EQ(sheet_of(text).mesh.num_pieces(), 2);
  for (const char* const name : {"right", "a", "b"}) {
    const FileSheet sheet = sheet_of(text, {.objects = {name}});
    EXPECT_EQ(sheet.imported.world(0, 0), 2.0) << name;
    EXPECT_EQ(sheet.mesh.num_vertices(), 3);
    EXPECT_EQ(joined(sheet.imported.notes), "");
  }
  EXPECT_EQ(sheet_of(text, {.objects = {"left part", "a"}}).mesh.num_pieces(), 2);
  expect_says(refusal(text, {.objects = {"top"}}), "OBJ_OBJECT", {"\"top\"", "it has left part, right, a, b"});
  EXPECT_EQ(read_obj(text).value().object_sizes(),
            (std::vector<std::pair<std::string, std::int32_t>>{{"left part", 1}, {"right", 1}, {"a", 1}, {"b", 1}}));
}

TEST(Assembly, ManyNamesAreCountedUnlessThatIsInterrupted) {
  std::string text = "v 0 0 0\nv 1 0 0\nv 0 1 0\ng";
  for (int i = 0; i < 100'000; ++i) text += " n" + std::to_string(i);
  const MeshFile file = read_obj(text + "\nf 1 2 3\n").value();
  EXPECT_EQ(file.object_sizes().size(), 100'000U);
  const InterruptionScope leaving([] { return true; });
  EXPECT_THROW(static_cast<void>(file.object_sizes()), Interrupted);
}

}  // namespace
}  // namespace kerf::mesh

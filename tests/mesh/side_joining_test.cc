// Mesh files with vertices within sides of other faces: which are joined, what is said, and that the sheet is whole.

#include <algorithm>
#include <cmath>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "server/base/random.h"
#include "server/core/mesh/build/sheet_assembly.h"
#include "tests/mesh/measures.h"
#include "tests/mesh/side_joining_files.h"
#include "tests/support/trials.h"

namespace kerf::mesh {
namespace {

// Returns the least height of a triangle over its longest edge, -.
double least_flatness(const TriangleMesh& mesh) {
  double least = 1.0;
  for (TriangleId t = 0; t < mesh.num_solid_triangles(); ++t) {
    const Eigen::Matrix2d edges = mesh.rest_edges(t);
    const double longest = std::max({edges.col(0).norm(), edges.col(1).norm(), (edges.col(0) - edges.col(1)).norm()});
    least = std::min(least, 2.0 * mesh.area(t) / (longest * longest));
  }
  return least;
}

int euler_characteristic(const TriangleMesh& mesh) {
  std::set<std::pair<VertexId, VertexId>> edges;
  for (TriangleId t = 0; t < mesh.num_solid_triangles(); ++t) {
    for (int k = 0; k < 3; ++k) edges.insert(std::minmax(mesh.vertices(t)[k], mesh.vertices(t)[(k + 1) % 3]));
  }
  return mesh.num_vertices() - static_cast<int>(edges.size()) + mesh.num_solid_triangles();
}

void expect_disc(const FileSheet& sheet, int num_vertices, double area, double tolerance) {
  EXPECT_EQ(sheet.mesh.num_vertices(), num_vertices) << all_notes(sheet);
  EXPECT_EQ(sheet.mesh.num_pieces(), 1);
  EXPECT_EQ(sheet.mesh.num_boundary_loops(), 1);
  EXPECT_EQ(euler_characteristic(sheet.mesh), 1);
  EXPECT_NEAR(total_area(sheet.mesh), area, tolerance);
}

// A triangle above two others that meet within its side, at vertex 4.
const FlatDrawing kThree{{{0, 0}, {1, 0}, {0.5, 1}, {0.375, 0}, {0.5, -1}}, {{0, 1, 2}, {0, 4, 3}, {3, 4, 1}}};
// Faces of three to six corners on both sides of the line y = 0, with vertices there at other places.
const FlatDrawing kSeam{{{0, 0},
                         {0.3125, 0},
                         {1, 0},
                         {1, 1},
                         {0.6, 1.25},
                         {0.3125, 1},
                         {0, 1},
                         {0.5, 0},
                         {0.75, 0},
                         {0, -1},
                         {0.5, -1},
                         {0.75, -0.5},
                         {1, -1}},
                        {{0, 1, 5, 6}, {1, 2, 3, 4, 5}, {0, 9, 10, 7}, {7, 10, 12, 11, 8}, {8, 11, 2}, {11, 12, 2}}};
constexpr double kSeamArea = 1.0 + 0.0859375 + 1.0;

TEST(SideJoining, AVertexWithinASideIsJoined) {
  for (const Placing& placing : {Placing(level), Placing(oblique), Placing(folded)}) {
    const FileSheet sheet = whole_sheet(obj_of(kThree, placing));
    expect_disc(sheet, 5, 1.0, 1e-12);
    EXPECT_EQ(sheet.mesh.num_solid_triangles(), 4);
    EXPECT_GT(least_flatness(sheet.mesh), 0.1);
    EXPECT_EQ(sheet.imported.notes.front(),
              "joined vertex 4 (line 4) to face 1 (line 6), in whose side it lies; join_m 0 (--join 0) keeps them "
              "apart");
    EXPECT_EQ(sheet.imported.file_faces, (std::vector<std::int32_t>{0, 0, 1, 2}));
  }
}

TEST(SideJoining, ReadersOfBeforeDoNotJoin) {
  for (const MeshReading& reading :
       {MeshReading{.version = kFirstReader}, MeshReading{.version = kSecondReader}, MeshReading{.join_m = 0.0}}) {
    const Result<FileSheet> flat = try_sheet(obj_of(kThree, level), reading);
    ASSERT_FALSE(flat.ok());
    const bool is_first = reading.version == kFirstReader;  // it lets no faces come apart at a vertex
    EXPECT_EQ(flat.error().reason, is_first ? "MESH_NON_MANIFOLD_VERTEX" : "MESH_OVERLAP");
  }
  EXPECT_FALSE(try_sheet("# Kerf: metres\n" + obj_of(kThree, level)).ok());
  // A gap below the file's precision.
  FlatDrawing gap = kThree;
  gap.points[3].y() = -1e-6;
  const FileSheet before = whole_sheet(obj_of(gap, level, "%.6f"), {.version = kSecondReader});
  EXPECT_EQ(before.mesh.num_boundary_loops(), 2);
  EXPECT_EQ(all_notes(before).find("joined"), std::string::npos);
  expect_disc(whole_sheet(obj_of(gap, level, "%.6f")), 5, 1.0, 2e-6);
}

TEST(SideJoining, BothSidesOfASeamAreSplit) {
  for (const Placing& placing : {Placing(level), Placing(oblique), Placing(folded)}) {
    for (const char* const format : {"%.17g", "%.9f", "%.6f", "%.5f"}) {
      const FileSheet sheet = whole_sheet(obj_of(kSeam, placing, format));
      expect_disc(sheet, 13, kSeamArea, 1e-4);
      EXPECT_GT(least_flatness(sheet.mesh), 0.05) << format;
      EXPECT_NE(all_notes(sheet).find("joined 3 vertices to the faces in whose sides they lie, first vertex 8 (line 8) "
                                      "to face 2 (line 15)"),
                std::string::npos)
          << all_notes(sheet);
    }
  }
}

TEST(SideJoining, NoSliverComesOfAVertexBesideTheLine) {
  for (const double beside : {1e-6, -1e-6}) {
    FlatDrawing drawing = kThree;
    drawing.points[3].y() = beside;
    for (const std::vector<int>& first : {std::vector<int>{0, 1, 2}, {1, 2, 0}, {2, 0, 1}}) {
      drawing.faces[0] = first;
      const FileSheet sheet = whole_sheet(obj_of(drawing, level, "%.6f"));
      expect_disc(sheet, 5, 1.0, 1e-6);
      EXPECT_GT(least_flatness(sheet.mesh), 0.1);
    }
  }
}

TEST(SideJoining, ManyVerticesLieInOneSide) {
  constexpr int kMany = 500;
  FlatDrawing comb{{{0, 0}, {1, 0}, {1, 1}, {0, 1}, {0.5, -0.5}}, {{0, 1, 2, 3}}};
  int last = 0;
  for (int i = 1; i <= kMany; ++i) {
    const int next = i < kMany ? static_cast<int>(comb.points.size()) : 1;
    if (i < kMany) comb.points.emplace_back(static_cast<double>(i) / kMany, 0.0);
    comb.faces.push_back({last, 4, next});
    last = next;
  }
  for (const Placing& placing : {Placing(level), Placing(oblique), Placing(folded)}) {
    const FileSheet sheet = whole_sheet(obj_of(comb, placing));
    expect_disc(sheet, kMany + 4, 1.25, 1e-9);
    EXPECT_NE(all_notes(sheet).find("joined 499 vertices to the faces"), std::string::npos) << all_notes(sheet);
  }
}

TEST(SideJoining, NeighboursBeyondASplitSideTurnFaces) {
  FlatDrawing drawing = kThree;
  drawing.faces[2] = {3, 1, 4};
  const FileSheet sheet = whole_sheet(obj_of(drawing, folded));
  expect_disc(sheet, 5, 1.0, 1e-12);
  EXPECT_NE(all_notes(sheet).find("turned round face 3 (line 8)"), std::string::npos) << all_notes(sheet);
}

TEST(SideJoining, VerticesNearASideStayApart) {
  FlatDrawing near = kThree;
  near.points[3].y() = -1e-4;
  for (const Placing& placing : {Placing(level), Placing(oblique)}) {
    const FileSheet sheet = whole_sheet(obj_of(near, placing, "%.6f"));
    EXPECT_EQ(sheet.mesh.num_boundary_loops(), 2);
    EXPECT_EQ(all_notes(sheet).find("joined"), std::string::npos) << all_notes(sheet);
    expect_disc(whole_sheet(obj_of(near, placing, "%.6f"), {.join_m = 2e-4}), 5, 1.0, 1e-3);
  }
}

// A face stands on the middle of a sheet: on an edge of two faces, or with a border through a vertex inside.
TEST(SideJoining, OnlyBordersAreJoined) {
  const std::string square = "v 0 0 0\nv 2 0 0\nv 2 2 0\nv 0 2 0\n";
  const std::string touches = square + "v 1 1 0\nv 1.5 1 1\nv 1 1.5 1\nf 1 2 3\nf 1 3 4\nf 5 6 7\n";
  const std::string passes =
      square + "v 1 1 0\nv 1 1 -1\nv 1 1 1\nv 1 2 1\nf 1 2 5\nf 2 3 5\nf 3 4 5\nf 4 1 5\nf 6 7 8\n";
  for (const std::string& text : {touches, passes}) {
    const FileSheet sheet = whole_sheet(text);
    EXPECT_EQ(sheet.mesh.num_pieces(), 2);
    EXPECT_EQ(all_notes(sheet).find("joined"), std::string::npos) << all_notes(sheet);
  }
}

TEST(SideJoining, FacesThatTouchAtAPointComeApart) {
  const FileSheet sheet = whole_sheet("v 0 0 0\nv 1 0 0\nv 0.5 1 0\nv 0.5 0 0\nv 0 -1 0\nv 1 -1 0\nf 1 2 3\nf 4 5 6\n");
  EXPECT_EQ(sheet.mesh.num_pieces(), 2);
  EXPECT_EQ(sheet.mesh.num_vertices(), 7);
  EXPECT_NE(all_notes(sheet).find("come apart that meet only at vertex 4 (line 4)"), std::string::npos)
      << all_notes(sheet);
}

TEST(SideJoining, AThirdFaceAtTheSeamIsNotJoined) {
  // Three pages of a book, each with other vertices at its back.
  const std::string book =
      "v 0 0 0\nv 0 1 0\nv 0 0.25 0\nv 0 0.75 0\nv 1 0 0\nv -1 0 0\nv 0 0 1\n"
      "f 1 5 2\nf 1 3 6\nf 3 2 6\nf 1 4 7\nf 4 2 7\n";
  const FileSheet sheet = whole_sheet(book);
  EXPECT_EQ(sheet.mesh, whole_sheet(book, {.version = kSecondReader}).mesh);
  EXPECT_NE(all_notes(sheet).find("vertices within sides of other faces are not joined to them: 3 faces meet at"),
            std::string::npos)
      << all_notes(sheet);
}

TEST(SideJoining, FacesOverEachOtherAreNotSearchedForEver) {
  SeededRandom random(3);
  std::string text;
  for (int i = 0; i < 1500; ++i) {
    text += vertex_line({0.01 * random.uniform(), 0.01 * random.uniform(), 0.0}, "%.9f") +
            vertex_line({1.0 + random.uniform(), 1.0 + random.uniform(), 0.0}, "%.9f") +
            vertex_line({random.uniform(), random.uniform(), 1.0}, "%.9f") + "f -3 -2 -1\n";
  }
  const FileSheet sheet = whole_sheet(text);
  EXPECT_EQ(sheet.mesh.num_pieces(), 1500);
  EXPECT_NE(all_notes(sheet).find("too many faces lie over each other"), std::string::npos) << all_notes(sheet);
}

TEST(SideJoining, TheChartHasItsSay) {
  const std::string places = "v 0 0 0\nv 1 0 0\nv .5 1 0\nv .25 0 0\nv .5 -1 0\n";
  const std::string same = "vt 0 0\nvt 1 0\nvt .5 1\nvt .25 0\nvt .5 -1\n";
  const std::string moved = same + "vt 0 -5\nvt 1 -5\nvt .25 -5\nvt .5 -6\n";
  const FileSheet joined = whole_sheet(places + same + "f 1/1 2/2 3/3\nf 1/1 5/5 4/4\nf 4/4 5/5 2/2\n");
  EXPECT_TRUE(joined.imported.is_charted);
  expect_disc(joined, 5, 1.0, 1e-12);
  const FileSheet apart = whole_sheet(places + moved + "f 1/1 2/2 3/3\nf 1/6 5/9 4/8\nf 4/8 5/9 2/7\n");
  EXPECT_TRUE(apart.imported.is_charted);
  EXPECT_EQ(apart.mesh.num_pieces(), 2);
  EXPECT_EQ(apart.imported.notes, std::vector<std::string>());
}

// The first face is so flat in the chart that it would cross itself with the vertex as a corner.
TEST(SideJoining, AChartIsWorthMoreThanAJoint) {
  const std::string text =
      "v 0 0 0\nv 1 0 0\nv .5 1 0\nv .3 -.01 0\nv .1 -1 0\nv .6 -1 0\n"
      "vt 0 0\nvt 1 0\nvt .5 .04\nvt .3 .03\nvt .1 .5\nvt .6 .5\nf 1/1 2/2 3/3\nf 4/4 6/6 5/5\n";
  const FileSheet sheet = whole_sheet(text, {.join_m = 0.05});
  EXPECT_TRUE(sheet.imported.is_charted);
  EXPECT_EQ(sheet.mesh, whole_sheet(text, {.join_m = 0.05, .version = kSecondReader}).mesh);
  EXPECT_NE(all_notes(sheet).find("the texture coordinates could not be used then"), std::string::npos)
      << all_notes(sheet);
}

// A wall with more vertices at its foot than a face may have corners stands at a side.
TEST(SideJoining, AFaceHasNoMoreCornersThanAFileMayGiveIt) {
  constexpr int kTooMany = static_cast<int>(kMaxFaceCorners) - 2;
  std::string text = "v 0 0 0\nv 1 0 0\nv 0.5 1 0\nf 1 2 3\n";
  for (int i = 1; i <= kTooMany; ++i) {
    const double x = static_cast<double>(i) / (kTooMany + 1);
    text += vertex_line({x, 0.0, 0.0}, "%.9f") + vertex_line({x, 0.0, 1.0}, "%.9f");
    if (i > 1) text += "f -4 -2 -1 -3\n";
  }
  const FileSheet sheet = whole_sheet(text);
  EXPECT_EQ(sheet.mesh.num_pieces(), 2);
  EXPECT_NE(all_notes(sheet).find("face 1 (line 4) would have more than 20000 corners"), std::string::npos)
      << all_notes(sheet).substr(0, 1000);
}

// Divides a rectangle again and again by lines across it, at multiples of 1/64. Returns the place of the first line.
double divide(FlatDrawing& drawing, SeededRandom& random, const Eigen::Vector2i& low, const Eigen::Vector2i& high,
              int depth) {
  const Eigen::Vector2i size = high - low;
  const int axis = depth == 0 || size.x() > size.y() ? 0 : 1;
  if (depth == 7 || size[axis] < 8 || (depth > 2 && random.below(5) == 0)) {
    std::vector<int> face;
    for (const Eigen::Vector2i& corner :
         {low, Eigen::Vector2i(high.x(), low.y()), high, Eigen::Vector2i(low.x(), high.y())}) {
      const Eigen::Vector2d at = corner.cast<double>() / 64.0;
      const auto found = std::find(drawing.points.begin(), drawing.points.end(), at);
      face.push_back(static_cast<int>(found - drawing.points.begin()));
      if (found == drawing.points.end()) drawing.points.push_back(at);
    }
    drawing.faces.push_back(face);
    return 0.0;
  }
  const int line = low[axis] + 3 + static_cast<int>(random.below(static_cast<std::uint64_t>(size[axis] - 5)));
  Eigen::Vector2i middle_high = high, middle_low = low;
  middle_high[axis] = middle_low[axis] = line;
  divide(drawing, random, low, middle_high, depth + 1);
  divide(drawing, random, middle_low, high, depth + 1);
  return line / 64.0;
}

TEST(SideJoining, RandomDivisionsOfARectangleAreWhole) {
  const int num_trials = test::num_trials({.few = 10, .usual = 60, .many = 1000});
  std::size_t num_within = 0;
  for (int i = 0; i < num_trials; ++i) {
    const std::uint64_t seed = test::first_seed() + static_cast<std::uint64_t>(i);
    SCOPED_TRACE("seed " + std::to_string(seed));
    SeededRandom random(seed);
    FlatDrawing drawing;
    const double line = divide(drawing, random, {0, 0}, {96, 64}, 0);
    const Placing bent = [line](const Eigen::Vector2d& at) {
      return Eigen::Vector3d(oblique(at) + std::max(0.0, at.x() - line) * Eigen::Vector3d(0.3, -0.6, 0.2));
    };
    const Eigen::Vector3d along = bent({1.5, 0}) - bent({line, 0}), across = bent({line, 1}) - bent({line, 0});
    const double bent_area = line + along.cross(across).norm();
    num_within += drawing.points.size() - 4;
    for (const char* const format : {"%.17g", "%.7f"}) {
      for (const Placing& placing : {Placing(level), Placing(oblique), bent}) {
        const bool is_soup = random.below(2) == 0;
        const FileSheet sheet =
            whole_sheet(is_soup ? soup_of(drawing, placing, format) : obj_of(drawing, placing, format));
        const bool is_bent = sheet.mesh.is_curved();
        expect_disc(sheet, static_cast<int>(drawing.points.size()), is_bent ? bent_area : 1.5, 1e-5);
        EXPECT_GT(least_flatness(sheet.mesh), 1e-3);
      }
    }
  }
  EXPECT_GT(num_within, static_cast<std::size_t>(10 * num_trials));
}

// Whatever was a sheet for the reader of before is one still.
TEST(SideJoining, RandomFacesAreRefusedForAReasonOrSound) {
  SeededRandom random(11);
  int num_made = 0, num_joined = 0;
  for (int i = 0; i < 4000; ++i) {
    SCOPED_TRACE("trial " + std::to_string(i));
    const bool is_flat = random.below(2) == 0;
    std::string text;
    const int num_faces = 2 + static_cast<int>(random.below(3));
    for (int f = 0; f < num_faces; ++f) {
      const int num_corners = 3 + static_cast<int>(random.below(3));
      for (int k = 0; k < num_corners; ++k) {
        const double height = is_flat ? 0.0 : static_cast<double>(random.below(2));
        text += vertex_line({static_cast<double>(random.below(5)), static_cast<double>(random.below(5)), height}, "%g");
      }
      text += num_corners == 3 ? "f -3 -2 -1\n" : num_corners == 4 ? "f -4 -3 -2 -1\n" : "f -5 -4 -3 -2 -1\n";
    }
    MeshReading reading;
    if (random.below(3) == 0) reading.join_m = 0.5 * random.uniform();
    const Result<FileSheet> made = try_sheet(text, reading);
    reading.version = kSecondReader;
    if (!made.ok()) {
      ASSERT_FALSE(made.error().reason.empty());
      ASSERT_FALSE(try_sheet(text, reading).ok()) << text;
      continue;
    }
    ASSERT_EQ(made->mesh.find_violation(), std::nullopt) << text;
    ++num_made;
    const bool is_joined = all_notes(*made).find("in whose side") != std::string::npos;
    num_joined += is_joined ? 1 : 0;
    if (is_joined) continue;
    ASSERT_EQ(made->mesh, whole_sheet(text, reading).mesh) << text;
  }
  EXPECT_GT(num_made, 400);
  EXPECT_GT(num_joined, 100);
}

}  // namespace
}  // namespace kerf::mesh

// Mesh files whose vertices nearly meet, to more than the numbers of the file are written.

#include <array>
#include <cstdint>
#include <cstdio>
#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "server/base/random.h"
#include "server/core/mesh/build/obj_import.h"
#include "server/core/mesh/build/sheet_assembly.h"

namespace kerf::mesh {
namespace {

using ::testing::Contains;
using ::testing::HasSubstr;

constexpr int kCells = 10;  // of a square of 1 m, along a side

// Triangles of a plane square with corners of their own, which lie at most `noise` (m) from their places on each axis.
std::string noisy_triangles(double noise, const char* format = "v %.9g %.9g %.9g\n", const std::string& start = "") {
  SeededRandom random(7);
  const auto moved = [&](double at) {
    return at + noise * (1e-6 * static_cast<double>(random.below(2'000'001)) - 1.0);
  };
  std::string text = start;
  for (int j = 0; j < kCells; ++j) {
    for (int i = 0; i < kCells; ++i) {
      for (const auto& [di, dj] : {std::array{0, 0}, {1, 0}, {1, 1}, {0, 0}, {1, 1}, {0, 1}}) {
        std::array<char, 96> line{};
        const double x = moved(1.0 * (i + di) / kCells), y = moved(1.0 * (j + dj) / kCells), z = moved(0.0);
        std::snprintf(line.data(), line.size(), format, x, y, z);
        text += line.data();
      }
      text += "f -6 -5 -4\nf -3 -2 -1\n";
    }
  }
  return text;
}

Result<FileSheet> sheet_of(const std::string& text, const MeshReading& reading = {}) {
  const Result<MeshFile> file = read_obj(text, reading.version);
  EXPECT_TRUE(file.ok());
  return make_sheet(*file, reading);
}

TEST(FileSheet, NoiseOfSingleNumbersIsJoinedWhereItLeavesFaults) {
  for (const char* const format : {"v %.9g %.9g %.9g\n", "v %.17g %.17g %.17g\n"}) {
    for (const double noise : {1e-9, 1e-8, 1e-7}) {
      const Result<FileSheet> made = sheet_of(noisy_triangles(noise, format));
      ASSERT_TRUE(made.ok()) << noise << ": " << made.error().message;
      EXPECT_EQ(made->mesh.num_vertices(), (kCells + 1) * (kCells + 1));
      EXPECT_EQ(made->mesh.num_pieces(), 1);
      EXPECT_FALSE(made->mesh.is_curved());
    }
  }
  const Result<FileSheet> made = sheet_of(noisy_triangles(1e-7));
  EXPECT_THAT(made->imported.notes, Contains(HasSubstr("vertices up to 1 um apart are joined; as closely")));
}

TEST(FileSheet, VerticesThatNearlyMeetAndStayApartAreMentioned) {
  const std::string text = noisy_triangles(1e-5);
  const Result<FileSheet> made = sheet_of(text);
  ASSERT_TRUE(made.ok()) << made.error().message;
  EXPECT_GT(made->mesh.num_pieces(), 1);
  EXPECT_THAT(made->imported.notes, Contains(HasSubstr("479 vertices nearly meet others, up to 0.1 mm apart")));
  const Result<FileSheet> joined = sheet_of(text, {.join_m = 1.01e-4});
  ASSERT_TRUE(joined.ok()) << joined.error().message;
  EXPECT_EQ(joined->mesh.num_pieces(), 1);
}

TEST(FileSheet, JoinsThatWereAskedForAndEarlierReadersStayAsTheyWere) {
  EXPECT_FALSE(sheet_of(noisy_triangles(1e-7), {.join_m = 1e-8}).ok());
  EXPECT_FALSE(sheet_of(noisy_triangles(1e-7), {.version = kSecondReader}).ok());
  EXPECT_FALSE(sheet_of(noisy_triangles(1e-7, "v %.9g %.9g %.9g\n", "# Kerf: a sheet\n")).ok());
}

TEST(FileSheet, FaultsThatNoJoinMendsStay) {
  // Three faces at an edge, beside two vertices that nearly meet.
  const Result<FileSheet> made = sheet_of(
      "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 -1 0\nv 0 0 1\nv 0.0000011 1 0\nv 1 1 0\nv 0 2 0\nf 1 2 3\nf 2 1 4\nf 1 2 5\n"
      "f 6 7 8\n");
  ASSERT_FALSE(made.ok());
  EXPECT_EQ(made.error().reason, "MESH_NON_MANIFOLD_EDGE");
}

}  // namespace
}  // namespace kerf::mesh

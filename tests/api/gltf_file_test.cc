// The binary glTF file of a sheet, read back.
#include <array>
#include <cstdint>
#include <cstring>
#include <set>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "server/service/api/gltf_file.h"
#include "tests/sheet/calls.h"

namespace kerf::api {
namespace {

using Json = nlohmann::json;

// A .glb taken apart as the specification says.
struct Glb {
  explicit Glb(const std::string& file) {
    const std::array<std::uint32_t, 3> header = at<std::array<std::uint32_t, 3>>(file, 0);
    EXPECT_EQ(file.substr(0, 4), "glTF");
    EXPECT_EQ(header[1], 2U);
    EXPECT_EQ(header[2], file.size());
    const auto json_bytes = at<std::uint32_t>(file, 12);
    EXPECT_EQ(file.substr(16, 4), "JSON");
    EXPECT_EQ(json_bytes % 4, 0U);
    json = Json::parse(file.substr(20, json_bytes));
    const auto binary_bytes = at<std::uint32_t>(file, 20 + json_bytes);
    EXPECT_EQ(file.substr(24 + json_bytes, 4), std::string("BIN\0", 4));
    binary = file.substr(28 + json_bytes, binary_bytes);
    EXPECT_EQ(28 + json_bytes + binary_bytes, file.size());
    EXPECT_EQ(json["buffers"][0]["byteLength"], binary.size());
  }

  template <typename T>
  static T at(const std::string& bytes, std::size_t offset) {
    T value{};
    EXPECT_LE(offset + sizeof(T), bytes.size());
    std::memcpy(&value, bytes.data() + offset, sizeof(T));
    return value;
  }

  // The elements of an accessor.
  template <typename T>
  std::vector<T> read(int accessor) const {
    const Json& which = json["accessors"][static_cast<std::size_t>(accessor)];
    const Json& view = json["bufferViews"][which["bufferView"].get<std::size_t>()];
    const auto offset = view["byteOffset"].get<std::size_t>();
    EXPECT_EQ(offset % 4, 0U);
    EXPECT_EQ(which["count"].get<std::size_t>() * sizeof(T), view["byteLength"].get<std::size_t>());
    std::vector<T> values;
    for (std::size_t i = 0; i < which["count"].get<std::size_t>(); ++i) {
      values.push_back(at<T>(binary, offset + i * sizeof(T)));
    }
    return values;
  }

  int attribute(const char* name) const { return json["meshes"][0]["primitives"][0]["attributes"][name]; }

  Json json;
  std::string binary;
};

using Point = std::array<float, 3>;

Eigen::Vector3d in_world(const Point& p) {
  return {p[0], -p[2], p[1]};
}

TEST(GltfFile, HoldsTheCutSheetAsItIs) {
  sheet::Sheet sheet = sheet::make(scenes::hanging(9));
  sheet::run(sheet, 20);
  for (scene::Cut& cut : scenes::three_cuts()) ASSERT_TRUE(sheet::apply(sheet, std::move(cut)).ok());
  scene::Cut strip = scenes::line_cut({0.1, 0.15}, {0.4, 0.15});
  strip.options.width_m = 0.02;  // leaves slots without material
  ASSERT_TRUE(sheet::apply(sheet, strip).ok());
  sheet::run(sheet, 20);
  const std::shared_ptr<const sheet::Snapshot> snapshot = sheet.snapshot();
  const sheet::Topology& topology = *snapshot->topology;
  const Glb file(encode_gltf(*snapshot));
  EXPECT_EQ(file.json["asset"]["version"], "2.0");
  const auto positions = file.read<Point>(file.attribute("POSITION"));
  const auto normals = file.read<Point>(file.attribute("NORMAL"));
  const auto texture = file.read<std::array<float, 2>>(file.attribute("TEXCOORD_0"));
  const auto colours = file.read<std::array<std::uint8_t, 4>>(file.attribute("COLOR_0"));
  const auto indices = file.read<std::uint32_t>(file.json["meshes"][0]["primitives"][0]["indices"]);
  ASSERT_EQ(positions.size(), texture.size());
  ASSERT_EQ(positions.size(), normals.size());
  ASSERT_EQ(positions.size(), colours.size());
  ASSERT_EQ(indices.size(), 3U * static_cast<std::size_t>(topology.num_triangles));

  std::size_t corner = 0;
  std::set<std::uint32_t> used;
  std::vector<std::set<std::array<std::uint8_t, 4>>> colours_of(static_cast<std::size_t>(topology.num_pieces));
  for (std::size_t slot = 0; slot < topology.triangles.size(); ++slot) {
    if (topology.triangles[slot][0] == mesh::kNone) continue;
    std::array<Eigen::Vector3d, 3> at;
    for (std::size_t k = 0; k < 3; ++k) {
      const std::uint32_t index = indices.at(corner++);
      ASSERT_LT(index, positions.size());
      used.insert(index);
      at[k] = in_world(positions[index]);
      const mesh::VertexId vertex = topology.triangles[slot][k];
      EXPECT_LT((at[k] - snapshot->positions.col(vertex)).norm(), 1e-6);
      EXPECT_NEAR(texture[index][0], topology.material_positions(0, vertex), 1e-7);
      EXPECT_NEAR(texture[index][1], topology.material_positions(1, vertex), 1e-7);
      EXPECT_NEAR(in_world(normals[index]).norm(), 1.0, 1e-6);
      colours_of[static_cast<std::size_t>(topology.pieces[slot])].insert(colours[index]);
    }
    const Eigen::Vector3d across = (at[1] - at[0]).cross(at[2] - at[0]);
    EXPECT_GT(across.normalized().dot(in_world(normals[indices[corner - 3]])), 0.0) << "same side up";
  }
  EXPECT_EQ(used.size(), positions.size()) << "no vertex without a triangle";
  std::set<std::array<std::uint8_t, 4>> all;
  for (const auto& of_piece : colours_of) {
    ASSERT_EQ(of_piece.size(), 1U);
    all.insert(*of_piece.begin());
  }
  EXPECT_EQ(all.size(), colours_of.size()) << "each piece has its own";
  EXPECT_GT(colours_of.size(), 2U);
}

TEST(GltfFile, BoundsAreThoseOfThePositions) {
  sheet::Sheet sheet = sheet::make(scenes::draped_over_sphere(7));
  sheet::run(sheet, 30);
  const Glb file(encode_gltf(*sheet.snapshot()));
  const auto positions = file.read<Point>(file.attribute("POSITION"));
  const Json& accessor = file.json["accessors"][static_cast<std::size_t>(file.attribute("POSITION"))];
  EXPECT_EQ(accessor["type"], "VEC3");
  EXPECT_EQ(accessor["componentType"], 5126);
  Point low = positions[0], high = positions[0];
  for (const Point& p : positions) {
    for (std::size_t k = 0; k < 3; ++k) {
      low[k] = std::min(low[k], p[k]);
      high[k] = std::max(high[k], p[k]);
    }
  }
  EXPECT_EQ(accessor["min"].get<Point>(), low);
  EXPECT_EQ(accessor["max"].get<Point>(), high);
  EXPECT_LT(low[1], high[1]);
}

TEST(GltfFile, IsTheSameForTheSameSheet) {
  const sheet::Sheet sheet = sheet::make(scenes::hanging(5));
  EXPECT_EQ(encode_gltf(*sheet.snapshot()), encode_gltf(*sheet.snapshot()));
}

}  // namespace
}  // namespace kerf::api

#include "server/service/api/gltf_file.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <limits>
#include <span>
#include <utility>
#include <vector>

#include <Eigen/Geometry>

#include "render/colours.h"
#include "server/service/api/used_vertices.h"

namespace kerf::api {
namespace {

constexpr std::uint32_t kGlbMagic = 0x46546C67;  // "glTF"
constexpr std::uint32_t kGlbVersion = 2;
constexpr std::uint32_t kJsonChunk = 0x4E4F534A;
constexpr std::uint32_t kBinaryChunk = 0x004E4942;

// Values of componentType and target in glTF's schema.
constexpr int kUnsignedByte = 5121;
constexpr int kUnsignedInt = 5125;
constexpr int kFloat = 5126;
constexpr int kVertexBuffer = 34962;
constexpr int kIndexBuffer = 34963;

// Holds the arrays of the one mesh, V vertices and T triangles.
struct GltfMesh {
  std::vector<float> positions;        // 3 V
  std::vector<float> normals;          // 3 V
  std::vector<float> texture;          // 2 V
  std::vector<std::uint8_t> colours;   // 4 V, RGBA
  std::vector<std::uint32_t> indices;  // 3 T

  [[nodiscard]] std::size_t num_vertices() const { return texture.size() / 2; }
};

// Returns the colour used in pictures and the viewer, in linear light as glTF requires for vertices.
std::array<std::uint8_t, 4> colour_of(std::int32_t piece) {
  const auto [red, green, blue] = render::piece_colour(piece + 1);
  const render::Vec3 light = render::linear({red / 255.0, green / 255.0, blue / 255.0});
  const auto byte = [](double share) { return static_cast<std::uint8_t>(std::lround(255.0 * share)); };
  return {byte(light.x), byte(light.y), byte(light.z), 255};
}

// Returns sums of the normals of the triangles around each vertex, twice their areas long, m^2; 3 x V of the snapshot.
Eigen::Matrix3Xd summed_normals(const sheet::Snapshot& snapshot) {
  Eigen::Matrix3Xd sums = Eigen::Matrix3Xd::Zero(3, snapshot.positions.cols());
  for (const auto& [a, b, c] : snapshot.topology->triangles) {
    if (a == mesh::kNone) continue;
    const Eigen::Vector3d origin = snapshot.positions.col(a);
    const Eigen::Vector3d along = snapshot.positions.col(b) - origin;
    const Eigen::Vector3d normal = along.cross(Eigen::Vector3d(snapshot.positions.col(c) - origin));
    for (const mesh::VertexId v : {a, b, c}) sums.col(v) += normal;
  }
  return sums;
}

void append_in_gltf_axes(const Eigen::Vector3d& world, std::vector<float>& to) {
  for (const double value : {world.x(), world.z(), -world.y()}) to.push_back(static_cast<float>(value));
}

GltfMesh gather(const sheet::Snapshot& snapshot) {
  const sheet::Topology& topology = *snapshot.topology;
  const std::vector<std::int32_t> numbers = number_used_vertices(topology);
  std::vector<std::int32_t> pieces(numbers.size(), 0);
  GltfMesh gathered;
  for (std::size_t slot = 0; slot < topology.triangles.size(); ++slot) {
    if (!has_material(topology.triangles[slot])) continue;
    for (const mesh::VertexId vertex : topology.triangles[slot]) {
      const auto v = static_cast<std::size_t>(vertex);
      pieces[v] = topology.pieces[slot];
      gathered.indices.push_back(static_cast<std::uint32_t>(numbers[v] - 1));
    }
  }
  const Eigen::Matrix3Xd normals = summed_normals(snapshot);
  for (std::size_t v = 0; v < numbers.size(); ++v) {
    if (numbers[v] == 0) continue;
    const auto column = static_cast<Eigen::Index>(v);
    append_in_gltf_axes(snapshot.positions.col(column), gathered.positions);
    const double length = normals.col(column).norm();
    // Uses +z for a vertex whose triangles have collapsed, since glTF requires length 1.
    append_in_gltf_axes(length > 0.0 ? Eigen::Vector3d(normals.col(column) / length) : Eigen::Vector3d::UnitZ(),
                        gathered.normals);
    for (int k = 0; k < 2; ++k) gathered.texture.push_back(static_cast<float>(topology.material_positions(k, column)));
    for (const std::uint8_t channel : colour_of(pieces[v])) gathered.colours.push_back(channel);
  }
  return gathered;
}

// Builds the binary chunk, and the JSON of its views and accessors.
class Buffers {
 public:
  // Adds an array of a multiple of 4 bytes, as glTF's alignment requires. `more`: extra members of the accessor.
  template <typename T>
  void add(std::span<const T> values, int components, int component_type, int target, const std::string& more = {}) {
    static constexpr const char* kTypes[] = {"", "SCALAR", "VEC2", "VEC3", "VEC4"};
    const std::size_t offset = bytes_.size();
    bytes_.resize(offset + values.size_bytes());
    if (!values.empty()) std::memcpy(bytes_.data() + offset, values.data(), values.size_bytes());
    const std::string comma = views_.empty() ? "" : ",";
    views_ += comma + "{\"buffer\":0,\"byteOffset\":" + std::to_string(offset) +
              ",\"byteLength\":" + std::to_string(values.size_bytes()) + ",\"target\":" + std::to_string(target) + "}";
    accessors_ += comma + "{\"bufferView\":" + std::to_string(num_) +
                  ",\"componentType\":" + std::to_string(component_type) +
                  ",\"count\":" + std::to_string(values.size() / static_cast<std::size_t>(components)) +
                  ",\"type\":\"" + kTypes[components] + "\"" + more + "}";
    ++num_;
  }

  [[nodiscard]] const std::string& bytes() const { return bytes_; }
  [[nodiscard]] const std::string& views() const { return views_; }
  [[nodiscard]] const std::string& accessors() const { return accessors_; }

 private:
  std::string bytes_;
  std::string views_;
  std::string accessors_;
  int num_ = 0;
};

// Returns ,"min":[...],"max":[...] of points.
std::string bounds(const std::vector<float>& points) {
  std::array<float, 3> low{}, high{};
  low.fill(std::numeric_limits<float>::max());
  high.fill(std::numeric_limits<float>::lowest());
  for (std::size_t i = 0; i < points.size(); ++i) {
    low[i % 3] = std::min(low[i % 3], points[i]);
    high[i % 3] = std::max(high[i % 3], points[i]);
  }
  std::string json;
  for (const auto& [name, corner] : {std::pair("min", low), std::pair("max", high)}) {
    json += std::string(",\"") + name + "\":[";
    for (std::size_t k = 0; k < 3; ++k) {
      if (k > 0) json += ',';
      append_number(corner[k], json);
    }
    json += ']';
  }
  return json;
}

void append_word(std::uint32_t word, std::string& bytes) {
  for (int shift = 0; shift < 32; shift += 8) bytes.push_back(static_cast<char>(word >> shift & 0xffU));
}

void append_chunk(std::uint32_t kind, std::string content, char padding, std::string& file) {
  content.resize((content.size() + 3) / 4 * 4, padding);
  append_word(static_cast<std::uint32_t>(content.size()), file);
  append_word(kind, file);
  file += content;
}

}  // namespace

std::string encode_gltf(const sheet::Snapshot& snapshot) {
  const GltfMesh mesh = gather(snapshot);
  Buffers buffers;
  buffers.add(std::span<const float>(mesh.positions), 3, kFloat, kVertexBuffer, bounds(mesh.positions));
  buffers.add(std::span<const float>(mesh.normals), 3, kFloat, kVertexBuffer);
  buffers.add(std::span<const float>(mesh.texture), 2, kFloat, kVertexBuffer);
  buffers.add(std::span<const std::uint8_t>(mesh.colours), 4, kUnsignedByte, kVertexBuffer, ",\"normalized\":true");
  buffers.add(std::span<const std::uint32_t>(mesh.indices), 1, kUnsignedInt, kIndexBuffer);
  const std::string json =
      R"({"asset":{"version":"2.0","generator":"Kerf"},"scene":0,"scenes":[{"nodes":[0]}],)"
      R"("nodes":[{"mesh":0,"name":"sheet"}],"meshes":[{"primitives":[{"attributes":{"POSITION":0,"NORMAL":1,)"
      R"("TEXCOORD_0":2,"COLOR_0":3},"indices":4,"material":0}]}],"materials":[{"doubleSided":true,)"
      R"("pbrMetallicRoughness":{"metallicFactor":0,"roughnessFactor":0.8}}],"bufferViews":[)" +
      buffers.views() + "],\"accessors\":[" + buffers.accessors() +
      "],\"buffers\":[{\"byteLength\":" + std::to_string(buffers.bytes().size()) + "}]}";
  std::string chunks;
  append_chunk(kJsonChunk, json, ' ', chunks);
  append_chunk(kBinaryChunk, buffers.bytes(), '\0', chunks);
  constexpr std::size_t kHeaderBytes = 12;
  std::string file;
  append_word(kGlbMagic, file);
  append_word(kGlbVersion, file);
  append_word(static_cast<std::uint32_t>(kHeaderBytes + chunks.size()), file);
  return file + chunks;
}

}  // namespace kerf::api
